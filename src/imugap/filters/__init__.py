"""Building blocks of navigation filters: error state, sensor states, smoother, innovation tests, zero velocity.

May import interchange, model, effects, kinematics and what lies below.
"""

"""Parts of navigation filters: error state, sensor states, smoother, innovation gate, zero velocity, alignment.

May import interchange, model, effects, kinematics and what lies below.
"""

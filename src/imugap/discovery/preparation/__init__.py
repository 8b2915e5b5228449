"""From a log to evenly spaced sequences: integrity effects taken out, gaps filled, rounding and temperature described.

May import effects, integrity and what lies below.
"""

"""What a file of a user's device holds: names of columns, units, time, frame.

May import formats, integrity, log, units.
"""

"""Earth, site and strapdown navigation equations; drift of a free inertial navigator.

May import integrity, log, units, numerics.
"""

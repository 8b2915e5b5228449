"""Navigation filters: attitude, planar, pedestrian, vehicle; and tests of their innovations for sensor errors.

May import filters, estimation, interchange and what lies below.
"""

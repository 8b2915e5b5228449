"""Navigation filters: attitude, planar, pedestrian, vehicle; and tests of what their innovations show.

May import filters, estimation, interchange and what lies below.
"""

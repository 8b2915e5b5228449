"""Several runs of one device: compared, and fitted together.

May import checks, unnamed, search and what lies below.
"""

"""Walks with the device on a foot: the filter, tests of its innovations, and physics before it is run.

May import filters and what lies below.
"""

"""Drives of a vehicle with device and receiver: alignment, the filter, and what may be wrong, by name.

May import filters and what lies below.
"""

"""Signals that are no effect of the catalogue: wandering lines, chirps, tone bursts, periodic terms, hysteresis.

May import search, views, fit and preparation.
"""

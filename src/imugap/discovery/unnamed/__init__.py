"""What is seen and has no name: wandering lines, chirps, tone bursts, periodic terms, hysteresis.

May import search, views, fit and preparation.
"""

"""Numerical methods without sensors: rotations, small matrices, state spaces, band-limited interpolation, bootstrap.

May import nothing of the library but units, atomic and stream.
"""

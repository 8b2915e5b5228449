"""Fitting: optimisers, limits of profiles, bootstrap, straight lines.

May import nothing but its neighbours in :mod:`imugap.numerics`.
"""

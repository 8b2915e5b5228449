"""Baselines: programs to compare with, one module each, whose function ``report`` answers a case.

Each uses what is common practice or a well-kept library, with the settings of its source and without any tuning to
cases. Some need the extra ``baselines`` of this package.
"""

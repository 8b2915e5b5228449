"""Questions on drives: parts of the quality control, recorded drives.

May import its neighbours in :mod:`imugap.study` and what lies below.
"""

"""Questions on walks: the protocol of a published table, settings, compensation, names of hidden errors.

May import its neighbours in :mod:`imugap.study` and what lies below.
"""

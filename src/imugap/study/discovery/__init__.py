"""Questions on discovery: sealed cases, injections, unseen runs, the oracle, device models.

May import its neighbours in :mod:`imugap.study` and what lies below.
"""

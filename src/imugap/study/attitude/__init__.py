"""Questions on attitude: schemes of the error model, and scores.

May import its neighbours in :mod:`imugap.study` and what lies below.
"""

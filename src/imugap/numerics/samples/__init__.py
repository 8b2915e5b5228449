"""Laws of samples: tails, mixtures, runs of states, repeats, lost samples.

May import nothing but its neighbours in :mod:`imugap.numerics`.
"""

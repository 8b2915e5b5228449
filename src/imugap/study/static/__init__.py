"""Questions on static logs: published indices and models, five trials, Monte Carlo of estimators.

May import its neighbours in :mod:`imugap.study` and what lies below.
"""

"""Generalised method of wavelet moments (Guerrier et al. 2013): moments, estimator, quasi-likelihood, intervals.

May import estimation and what lies below.
"""

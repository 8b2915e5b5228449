"""Estimation of error models from a log at rest: Allan and wavelet variance, likelihood, GMWM, selection, fit.

Disturbed samples are found first (``screening``) and left out (``gap_draws``). May import interchange, model, effects,
io and what lies below.
"""

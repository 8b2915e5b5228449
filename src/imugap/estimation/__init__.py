"""Estimation of error models from a log at rest: Allan and wavelet variance, likelihood, GMWM, selection, fit.

May import interchange, model, effects, io and what lies below.
"""

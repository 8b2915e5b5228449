"""Allan and wavelet variance of a log, and what a model implies for them.

May import :mod:`imugap.estimation.screening`, its result and what lies below.
"""

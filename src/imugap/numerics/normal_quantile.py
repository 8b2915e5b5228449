"""Quantile of the normal law that the 95 % intervals of the library share."""

NORMAL_QUANTILE = 1.959963984540054
"""Half width of a two-sided 95 % interval in standard deviations: the quantile at 97.5 %."""

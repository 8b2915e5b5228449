"""The course of a signal between its samples, band-limited but for little: a spline of high degree.

A cubic spline takes a quarter off the slope of a line at 0.36 of the sampling rate, one of degree 11 three thousandths.
At its ends such a spline swings; so the signal goes on there, mirrored about its first and its last value.
"""

import numpy as np
from scipy.interpolate import BSpline, make_interp_spline

DEGREE = 11
BEYOND = 30
"""Samples by which the signal goes on at either end: the swings have died away by then."""


def course(time: np.ndarray, values: np.ndarray) -> BSpline:
    """Return the spline through values, shape (n,) or (n, m), at ``time`` [s], shape (n,), n > 1."""
    count = min(BEYOND, len(time) - 1)
    return make_interp_spline(_mirrored(time, count), _mirrored(values, count), k=min(DEGREE, 2 * count + 1))


def _mirrored(values: np.ndarray, count: int) -> np.ndarray:
    before, after = 2 * values[0] - values[count:0:-1], 2 * values[-1] - values[-2 : -count - 2 : -1]
    return np.concatenate([before, values, after])

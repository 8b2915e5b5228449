"""The course of a signal between its samples, band-limited but for little.

A cubic spline takes a quarter off the slope of a line at 0.36 of the sampling rate, a spline of degree 11 three
thousandths. At its ends such a spline swings; there the course is that of the cubic one. As a spline of high degree is
slow to evaluate, it gives values and slopes at the samples and half way, and cubic pieces lie between: their error is a
thousandth of a line at a quarter of the rate.
"""

import numpy as np
from scipy.interpolate import CubicHermiteSpline, CubicSpline, make_interp_spline

DEGREE = 11
END = 30
"""Samples at either end of cubic course, and by which the spline of high degree goes on mirrored: swings die away."""


def interpolate(time: np.ndarray, values: np.ndarray) -> CubicHermiteSpline:
    """Return the course through values, shape (n,) or (n, m), at ``time`` [s], shape (n,), n > 1."""
    count = min(END, len(time) - 1)
    rise = _mirrored(values - values[0], count)  # a constant has no slope at all, not even by rounding
    inner = make_interp_spline(_mirrored(time, count), rise, k=min(DEGREE, 2 * count + 1))
    outer, nodes = CubicSpline(time, values), _halved(time)
    inside = (nodes > time[count]) & (nodes < time[-1 - count])
    heights, slopes = outer(nodes), outer(nodes, 1)
    heights[inside], slopes[inside] = values[0] + inner(nodes[inside]), inner(nodes[inside], 1)
    return CubicHermiteSpline(nodes, heights, slopes)


def _mirrored(values: np.ndarray, count: int) -> np.ndarray:
    """Return the values with ``count`` more at either end, mirrored about the first and the last."""
    before, after = 2 * values[0] - values[count:0:-1], 2 * values[-1] - values[-2 : -count - 2 : -1]
    return np.concatenate([before, values, after])


def _halved(time: np.ndarray) -> np.ndarray:
    """Return the times and those half way between them."""
    nodes = np.empty(2 * len(time) - 1)
    nodes[::2], nodes[1::2] = time, (time[1:] + time[:-1]) / 2
    return nodes

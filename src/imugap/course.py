"""The course of a signal between its samples, band-limited but for little.

A cubic spline takes a quarter off the slope of a line at 0.36 of the sampling rate, a spline of degree 11 three
thousandths. At its ends such a spline swings; there the course is that of the cubic one.
"""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import BSpline, CubicSpline, make_interp_spline

DEGREE = 11
END = 30
"""Samples at either end of cubic course, and by which the spline of high degree goes on mirrored: swings die away."""


@dataclass(frozen=True, eq=False)
class Course:
    """A signal at any time between its first and its last sample.

    Attributes
    ----------
    inner, outer
        Splines of high and of low degree.
    begin, end
        Times between which the inner one is the course [s].
    """

    inner: BSpline
    outer: CubicSpline
    begin: float
    end: float

    def __call__(self, time: np.ndarray, derivative: int = 0) -> np.ndarray:
        """Return the signal or a derivative of it at ``time`` [s], shape (n,), as (n,) or (n, m)."""
        values, inside = self.outer(time, derivative), (time > self.begin) & (time < self.end)
        values[inside] = self.inner(time[inside], derivative)
        return values


def course(time: np.ndarray, values: np.ndarray) -> Course:
    """Return the course through values, shape (n,) or (n, m), at ``time`` [s], shape (n,), n > 1."""
    count = min(END, len(time) - 1)
    inner = make_interp_spline(_mirrored(time, count), _mirrored(values, count), k=min(DEGREE, 2 * count + 1))
    return Course(inner, CubicSpline(time, values), float(time[count]), float(time[-1 - count]))


def _mirrored(values: np.ndarray, count: int) -> np.ndarray:
    """Return the values with ``count`` more at either end, mirrored about the first and the last."""
    before, after = 2 * values[0] - values[count:0:-1], 2 * values[-1] - values[-2 : -count - 2 : -1]
    return np.concatenate([before, values, after])

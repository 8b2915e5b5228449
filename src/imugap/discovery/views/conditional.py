"""Views of the residual over conditions: temperature, its rate, and in motion the error-free input."""

from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations

import numpy as np
import pandas as pd
from scipy.fft import idct
from scipy.ndimage import uniform_filter1d

from imugap import log
from imugap.discovery.fit.axis_fit import AxisFit
from imugap.discovery.preparation.sequence import AxisSequence
from imugap.discovery.views.curve import Curve, window_ranges, window_sums, windows

CELLS = 24
"""Number of cells, of equal numbers of samples."""
SMOOTHING_RATIO = 200
"""Length of the log over the length of the running mean of the temperature before differentiation."""
FULL_SCALE_CELLS = 10
"""Number of cells towards full scale, each with half the samples of the previous one."""
USES_OWN_AXIS = {"time_shift": True, "full_scale": True, "angular_acceleration": False, "jerk": False}
"""Whether a view uses the input of the residual's own axis, or those of the others."""


@dataclass(frozen=True, eq=False)
class Binning:
    """Samples of a log sorted into cells of a quantity.

    Attributes
    ----------
    view, source
        Name of the view, and of the axes whose input the quantity is; empty for none.
    unit
        Unit of the quantity.
    low, high
        Range of each cell, shape (m,).
    index
        Cell of each sample, shape (n,).
    sign
        Sign applied to the residual, shape (n,), or 1.
    """

    view: str
    source: str
    unit: str
    low: np.ndarray
    high: np.ndarray
    index: np.ndarray
    sign: np.ndarray | float = 1.0

    @cached_property
    def number(self) -> np.ndarray:
        """Return the number of samples in each window of cells."""
        return window_sums(np.bincount(self.index, minlength=len(self.low)))

    def applies_to(self, axis: str) -> bool:
        """Return whether the view applies to the residual of ``axis``."""
        return self.view not in USES_OWN_AXIS or USES_OWN_AXIS[self.view] == (self.source == axis)

    def curve(self, axis: str, score: np.ndarray, scale: float) -> Curve:
        """Return the sums of an axis' score in windows of cells, normalised for independent samples."""
        total = window_sums(np.bincount(self.index, score * self.sign, minlength=len(self.low)))
        names = axis if self.source in ("", axis) else f"{axis},{self.source}"
        low, high = window_ranges(self.low, self.high)
        statistic = total / (scale * np.sqrt(self.number))
        return Curve(self.view, names, low, high, self.unit, statistic, windows=windows(len(self.low)))


def binned(
    view: str, source: str, unit: str, values: np.ndarray, shares: np.ndarray, sign: np.ndarray | float = 1.0
) -> Binning | None:
    """Bin samples at quantiles of their values; return None if all values are equal."""
    edges = np.unique(np.quantile(values, shares))
    inner = edges[1:-1]
    index = np.searchsorted(inner, values, side="right")
    used = np.unique(index)
    if len(used) < 2:
        return None
    low, high = np.r_[edges[0], inner][used], np.r_[inner, edges[-1]][used]
    return Binning(view, source, unit, low, high, np.searchsorted(used, index), sign)


def binnings(sequence: AxisSequence) -> tuple[Binning, ...]:
    """Return the binnings of a log: over temperature, the error-free inputs and their products."""
    conditions, found = sequence.conditions, []
    shares = np.linspace(0, 1, CELLS + 1)
    if conditions.temperature is not None:
        smooth = uniform_filter1d(conditions.temperature, max(len(conditions) // SMOOTHING_RATIO, 1), mode="nearest")
        found.append(binned("temperature", "", "degC", conditions.temperature, shares))
        found.append(binned("temperature_rate", "", "degC/s", np.gradient(smooth, conditions.interval), shares))
    if conditions.ideal is not None:
        for axis in log.axes(conditions.ideal):
            found += _inputs(axis, conditions.ideal[axis].to_numpy(float), conditions.interval, shares)
        found += _products(conditions.ideal, shares)
    return tuple(item for item in found if item is not None)


def _inputs(axis: str, values: np.ndarray, interval: float, shares: np.ndarray) -> list[Binning | None]:
    """Return the binnings over an axis' input, its derivative, and its magnitude towards full scale."""
    gyro = axis in log.GYRO
    view, unit = ("rate", "rad/s") if gyro else ("specific_force", "m/s^2")
    derivative, slower = ("angular_acceleration", "rad/s^2") if gyro else ("jerk", "m/s^3")
    change = binned(derivative, axis, slower, np.gradient(values, interval), shares)
    top = np.r_[0.0, 1 - 0.5 ** np.arange(1, FULL_SCALE_CELLS), 1.0]
    return [
        binned(view, axis, unit, values, shares),
        change,
        None if change is None else replace(change, view="time_shift"),
        binned("full_scale", axis, unit, np.abs(values), top, np.sign(values)),
    ]


def _products(ideal: pd.DataFrame, shares: np.ndarray) -> list[Binning | None]:
    """Return the binnings over the products of two inputs of a triad."""
    triads = ("rate_product", "rad^2/s^2", log.GYRO), ("force_product", "m^2/s^4", log.ACCEL)
    return [
        binned(view, f"{one},{other}", unit, (ideal[one] * ideal[other]).to_numpy(float), shares)
        for view, unit, triad in triads
        for one, other in combinations([axis for axis in triad if axis in ideal], 2)
    ]


def of_conditions(fit: AxisFit, over: tuple[Binning, ...]) -> list[Curve]:
    """Return the score of the mean in each cell: the sum of the residual multiplied by the noise's precision."""
    root = np.sqrt(fit.variance)
    score = idct(np.r_[0.0, fit.coefficients / root], norm="ortho")
    scale = float(np.sqrt(np.mean(1 / fit.variance)))
    return [item.curve(fit.sequence.conditions.axis, score, scale) for item in over]

"""Overlapping Allan deviation of rate data, its confidence intervals, and the coefficients read from its tangents."""

from dataclasses import dataclass

import numpy as np
import pandas as pd
from allantools import ci
from numba import njit
from scipy.stats import chi2

from imugap.effects.bias_instability import FLOOR

POINTS_PER_DECADE = 10
SLOPE_TOLERANCE = 0.02
"""Largest distance of the local slope from the nominal one, or two standard errors, at which a tangent is read."""
SLOPE_ERROR = 0.1
"""Largest standard error of a local slope that still tells one law from another."""
REGION_DECADES = 0.5
"""Shortest range of tau over which the slope must hold."""
ITERATIONS = 3
"""Rounds of weighting by the fitted variance."""
SHORTEST = 256
"""Fewest samples of a curve: below, no slope is known at any tau."""
WINDOW = 3
"""Half width, in points, of the window over which a local slope is taken."""


def factors(count: int, points_per_decade: int = POINTS_PER_DECADE) -> np.ndarray:
    """Return averaging factors n, evenly spaced on a log axis from 1 to count/4, each integer once."""
    decades = np.log10(max(count // 4, 1))
    grid = np.logspace(0, decades, int(decades * points_per_decade) + 1)
    return np.unique(np.rint(grid).astype(np.int64))


def variance(sequence: np.ndarray, averaging: np.ndarray) -> np.ndarray:
    """Return the overlapping Allan variance of rate samples (Farrell et al. 2022, eqs. 12-13; IEEE 952).

    Parameters
    ----------
    sequence
        Samples (means over their interval), shape (n,).
    averaging
        Averaging factors, shape (m,), each at most n/2.
    """
    angle = np.zeros(len(sequence) + 1)
    np.cumsum(sequence - sequence.mean(), out=angle[1:])
    return np.array([_second_differences(angle, n) for n in averaging])


@njit(cache=True, fastmath=True)
def _second_differences(angle, n):
    late, middle, early = angle[2 * n :], angle[n:-n], angle[: -2 * n]  # slices let the compiler use vector registers
    total = 0.0
    for k in range(len(early)):
        difference = late[k] - 2 * middle[k] + early[k]
        total += difference * difference
    return total / (2.0 * n * n * len(early))


def curve(sequence: np.ndarray, interval: float, level: float = 0.95) -> pd.DataFrame:
    """Return the Allan deviation with chi-square intervals.

    The equivalent degrees of freedom are those of Greenhall and Riley (2003), for the power law that the local slope
    of the curve itself shows; where the slope is too uncertain to show one, the last law that was shown goes on.

    Returns
    -------
    pandas.DataFrame
        Index ``tau`` [s]; columns ``deviation``, ``low``, ``high`` [unit of the sequence], ``error`` (relative
        standard deviation of the estimate, Farrell et al. 2022, eq. 15), ``slope`` (local d log sigma/d log tau),
        ``edf``.
    """
    if len(sequence) < SHORTEST:
        raise ValueError(f"Allan deviation: expected at least {SHORTEST} samples; found {len(sequence)}")
    averaging = factors(len(sequence))
    deviation = np.sqrt(variance(np.asarray(sequence, float), averaging))
    if not deviation.all():
        raise ValueError("Allan deviation: expected samples that vary; found a constant sequence")
    slope = local_slope(averaging, deviation)
    error = np.sqrt(0.5 / (len(sequence) / averaging - 1))
    exponent = pd.Series(np.clip(np.rint(-1 - 2 * slope), -2, 2))
    exponent = exponent.where(_slope_error(pd.Series(error)) < SLOPE_ERROR).ffill().astype(int)
    edf = np.array([_edf(a, n, len(sequence)) for a, n in zip(exponent, averaging, strict=True)])
    low, high = (deviation * np.sqrt(edf / chi2.ppf(p, edf)) for p in ((1 + level) / 2, (1 - level) / 2))
    columns = {
        "deviation": deviation,
        "low": low,
        "high": high,
        "error": error,
        "slope": slope,
        "edf": edf,
    }
    return pd.DataFrame(columns, index=pd.Index(averaging * interval, name="tau"))


def local_slope(tau: np.ndarray, deviation: np.ndarray) -> np.ndarray:
    """Return d log sigma/d log tau at each tau: least squares over a window of neighbouring points."""
    x, y = np.log(tau), np.log(deviation)
    spans = [slice(max(i - WINDOW, 0), i + WINDOW + 1) for i in range(len(x))]
    return np.array([np.polyfit(x[span], y[span], 1)[0] for span in spans])


def _edf(exponent: int, averaging: int, count: int) -> float:
    return float(ci.edf_greenhall(alpha=exponent, d=2, m=int(averaging), N=count + 1, overlapping=True))


@dataclass(frozen=True)
class Law:
    """A power law of the Allan deviation: sigma(tau) = coefficient x gain x tau^slope."""

    symbol: str
    slope: float
    gain: float
    unit: str

    def deviation(self, coefficient: float, tau: np.ndarray) -> np.ndarray:
        """Return sigma(tau)."""
        return coefficient * self.gain * np.asarray(tau, float) ** self.slope


LAWS = {
    law.symbol: law
    for law in (
        Law("N", -0.5, 1.0, "{u}/sqrt(Hz)"),
        Law("B", 0.0, float(FLOOR), "{u}"),
        Law("K", 0.5, 3**-0.5, "{u}/s/sqrt(Hz)"),
    )
}
"""White noise, bias instability and random walk (Farrell et al. 2022, section on parameter extraction; IEEE 952)."""


@dataclass(frozen=True)
class Tangent:
    """A coefficient read from an Allan deviation curve.

    Attributes
    ----------
    value, low, high
        Coefficient with its interval, SI.
    tau_low, tau_high
        Range over which it was read [s].
    holds
        Whether the law's slope holds there. If not, the law has an upper bound only: its line may not lie above the
        curve anywhere. It is read at the one ``tau``, among those where the curve is known well enough to tell a
        slope, at which the curve's upper limit is lowest in terms of the law (beyond, the lowest of many uncertain
        limits would be too low).
        ``value`` is what the curve itself allows there, ``high`` its upper limit, ``low`` is 0.
    """

    value: float
    low: float
    high: float
    tau_low: float
    tau_high: float
    holds: bool


def tangent(asd: pd.DataFrame, law: Law, level: float = 0.95) -> Tangent:
    """Read the coefficient of ``law`` from a curve of :func:`curve`, on the longest range where its slope holds."""
    coefficient = asd["deviation"] / law.deviation(1.0, asd.index)
    error = _slope_error(asd["error"])
    near = (np.abs(asd["slope"] - law.slope) < np.maximum(SLOPE_TOLERANCE, 2 * error)) & (error < SLOPE_ERROR)
    region = _longest(asd.index.to_numpy(), near.to_numpy())
    if region is None:
        limit = (asd["high"] / law.deviation(1.0, asd.index))[error < SLOPE_ERROR]
        touch = limit.idxmin()
        return Tangent(float(coefficient[touch]), 0.0, float(limit[touch]), touch, touch, False)
    value, inflation = _separated(asd[region], law)
    edf = asd["edf"][region].max()
    low, high = (value * (_limit(1.0, edf, p)) ** inflation for p in ((1 + level) / 2, (1 - level) / 2))
    return Tangent(value, low, high, asd.index[region][0], asd.index[region][-1], True)


def _separated(asd: pd.DataFrame, law: Law) -> tuple[float, float]:
    """Return the coefficient of ``law`` where it dominates, freed from what the other laws add there.

    Least squares of the Allan variance, which is linear in the squared coefficients, with weights from the degrees of
    freedom and the fitted variance; and the factor by which not knowing the other laws widens the relative standard
    error.
    """
    laws = [law, *(other for other in LAWS.values() if other is not law)]
    shares = np.array([other.deviation(1.0, asd.index) ** 2 for other in laws]).T
    observed, weight = asd["deviation"].to_numpy() ** 2, np.sqrt(asd["edf"].to_numpy())
    expected = observed
    for _ in range(ITERATIONS):
        design = shares * (weight / expected)[:, None]
        scale = np.linalg.norm(design, axis=0)
        squares = np.linalg.lstsq(design / scale, observed * weight / expected)[0] / scale
        expected = np.where(shares @ squares > 0, shares @ squares, observed)
    normal = (design / scale).T @ (design / scale)
    return float(np.sqrt(max(squares[0], 0.0))), float(np.sqrt(np.linalg.inv(normal)[0, 0]))


def _slope_error(error: pd.Series) -> pd.Series:
    """Return the standard error of the local slopes from the relative errors of the curve.

    Centre and far end of the window are taken as independent: neighbouring points share most of their data, so the
    points between them add little.
    """
    ends = np.hypot(error, error.shift(-WINDOW, fill_value=np.inf))
    return ends * POINTS_PER_DECADE / (2 * WINDOW * np.log(10))


def _longest(tau: np.ndarray, holds: np.ndarray) -> slice | None:
    """Return the longest run of true points, or None if it covers less than the shortest range."""
    edges = np.flatnonzero(np.diff(np.r_[False, holds, False]))
    runs = [slice(a, b) for a, b in zip(edges[::2], edges[1::2], strict=True)]
    span = {run.start: np.log10(tau[run.stop - 1] / tau[run.start]) for run in runs}
    best = max(runs, key=lambda run: span[run.start], default=None)
    return best if best and span[best.start] >= REGION_DECADES else None


def _limit(value: float, edf: float, probability: float) -> float:
    return float(value * np.sqrt(edf / chi2.ppf(probability, edf)))

"""Overlapping Allan deviation of rate data, its confidence intervals, and the coefficients of its slopes."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
from numba import njit
from scipy.optimize import nnls
from scipy.special import chdtri

from imugap.effects.bias_instability import FLOOR
from imugap.estimation.screening import information
from imugap.numerics.samples.runs import runs_of
from imugap.numerics.spectra.allan_freedom import degrees_of_freedom

POINTS_PER_DECADE = 10
SLOPE_TOLERANCE = 0.02
"""Largest difference of the local slope from the nominal one (or two standard errors) in the range of a law."""
SLOPE_ERROR = 0.1
"""Largest standard error of a local slope that separates one power law from another."""
REGION_DECADES = 0.5
"""Shortest range of tau over which the slope must be nominal."""
FEWEST = 2.0
"""Fewest degrees of freedom of a coefficient: with fewer, its square scatters by more than its value."""
ITERATIONS = 3
"""Iterations of weighting by the fitted variance."""
SHORTEST = 256
"""Fewest samples of a curve: with fewer, no slope is known at any tau."""
STEEP = 0.75
"""Local slope half-way between those of N and Q, or of K and R: beyond, Q or R dominates."""
TINY = 1e-12
"""Relative variance below which noise is neglected."""
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
    angle = _angle(sequence)
    return np.array([
        sum_second_differences(angle[2 * n :], angle[n:-n], angle[: -2 * n]) / (2.0 * n * n * (len(angle) - 2 * n))
        for n in averaging
    ])  # fmt: skip


def _angle(sequence: np.ndarray) -> np.ndarray:
    """Return the integral of the samples less their mean, in intervals, from zero: one value more than samples."""
    angle = np.zeros(len(sequence) + 1)
    np.cumsum(sequence - sequence.mean(), out=angle[1:])
    return angle


@njit(cache=True, fastmath=True)
def sum_second_differences(late, middle, early):
    """Return the sum of the squared second differences of three arrays; slices let the compiler vectorise."""
    total = 0.0
    for k in range(len(late)):
        difference = late[k] - 2 * middle[k] + early[k]
        total += difference * difference
    return total


def curve(sequence: np.ndarray, interval: float, level: float = 0.95, lost: np.ndarray | None = None) -> pd.DataFrame:
    """Return the Allan deviation with chi-square intervals.

    ``lost``, shape (n,), marks samples that were drawn given the others; they count as information at no averaging time
    up to the length of their gap.

    The equivalent degrees of freedom are those of Greenhall and Riley (2003) for the power law of the local slope;
    where the slope is too uncertain, for the last law that was identified. Where Q or R dominates a part of the curve,
    they are those of a sum of laws.

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
    share = 1.0 if lost is None or not lost.any() else _information(lost, averaging)
    error = np.sqrt(0.5 / (len(sequence) / averaging - 1) / share)
    known = pd.Series(slope).where(_slope_error(pd.Series(error)) < SLOPE_ERROR).ffill().to_numpy()
    if np.isnan(known).any():
        found = f"{100 * float(np.mean(lost)):.0f} % lost of {len(sequence)}"
        raise ValueError(f"Allan deviation: expected samples enough for a slope; found {found}")
    if np.abs(known).max() > STEEP:
        edf = _degrees_of_sum(sequence, averaging, deviation, error)
    else:
        edf = _degrees(known, averaging, len(sequence))
    edf = share * edf
    low, high = deviation_limits(deviation, edf, level)
    columns = {
        "deviation": deviation,
        "low": low,
        "high": high,
        "error": error,
        "slope": slope,
        "edf": edf,
    }
    return pd.DataFrame(columns, index=pd.Index(averaging * interval, name="tau"))


def _information(lost: np.ndarray, averaging: np.ndarray) -> np.ndarray:
    """Return the share of the information that is left at averaging factors, shape (m,), without lost samples (n,)."""
    gaps = np.diff(runs_of(lost))[:, 0]
    return np.array([information(1 - gaps[gaps >= n].sum() / len(lost)) for n in averaging])


def deviation_limits(deviation: np.ndarray, freedom: np.ndarray, level: float = 0.95) -> tuple:
    """Return the chi-square limits of deviations with given degrees of freedom, of the same shape."""
    low, high = (deviation * np.sqrt(freedom / chdtri(freedom, 1 - p)) for p in ((1 + level) / 2, (1 - level) / 2))
    return low, high


def local_slope(tau: np.ndarray, deviation: np.ndarray) -> np.ndarray:
    """Return d log sigma/d log tau at each tau: least squares over a window of neighbouring points."""
    x, y = np.log(tau), np.log(deviation)
    spans = [slice(max(i - WINDOW, 0), i + WINDOW + 1) for i in range(len(x))]
    return np.array([np.polyfit(x[span], y[span], 1)[0] for span in spans])


def _degrees(slope: np.ndarray, averaging: np.ndarray, count: int) -> np.ndarray:
    """Return the degrees of freedom of N, B or K, by the nearest slope, shape (m,)."""
    exponent = np.clip(np.rint(-1 - 2 * slope), -2, 0).astype(int)
    return np.array([degrees_of_freedom(int(a), int(n), count) for a, n in zip(exponent, averaging, strict=True)])


def _degrees_of_sum(
    sequence: np.ndarray, averaging: np.ndarray, deviation: np.ndarray, error: np.ndarray
) -> np.ndarray:
    """Return the degrees of freedom of a curve with Q or R: those of the fitted sum of Q, N, K and R.

    The ramp is D, the mean difference of neighbouring means. About it, non-negative least squares separates
    Q, N and K. Relative to its square, a sum of noises scatters with the sum over lags of its squared correlation over
    M = count - 2n + 1: of Q, with -2/3 and 1/6 at lags n and 2n, 35/18 - n/M (Greenhall and Riley 2003) less
    3/5 - n/(3M), because rounding errors are uniform (kurtosis 9/5); of Q times another, nearly 5/3 - 2n/(3M). The
    ramp multiplies the variance of D, which is the share ``mean`` of that of a difference.
    """
    number = len(sequence) - 2 * averaging + 1
    ratio = averaging / number
    sums = np.r_[0.0, np.cumsum(_angle(sequence))]
    late, middle, early = (sums[n + number] - sums[n] for n in (2 * averaging, averaging, 0 * averaging))
    ramp = ((late - 2 * middle + early) / (averaging * number)) ** 2 / 2
    mean = np.array([2 / 3 * ratio / number, 2 / 3 * ratio**2, 3 / 2 * ratio - 7 / 10 * ratio**2])
    unit = np.array([LAWS[symbol].deviation(1.0, averaging) ** 2 for symbol in ("Q", "N", "K")])
    about = np.maximum(deviation**2 - ramp, TINY * deviation**2)
    design = unit * (1 - mean) / (about * error)
    scale = design.max(axis=1, keepdims=True)
    noise = nnls((design / scale).T, 1 / error)[0][:, None] / scale * unit
    relative = np.minimum(noise / deviation**2, noise / noise.sum(axis=0))
    rounding, white, walk = relative
    slow = white + walk
    slope = walk / np.maximum(slow, TINY) - 0.5
    within = (rounding**2 * (121 / 90 - 2 / 3 * ratio) + 2 * rounding * slow * (5 / 3 - 2 / 3 * ratio)) / number
    within += slow**2 / _degrees(slope, averaging, len(sequence))
    with_ramp = 2 * (1 - relative.sum(axis=0)) * (relative * mean).sum(axis=0)
    return 1 / np.maximum(within + with_ramp, TINY)


@dataclass(frozen=True)
class Law:
    """Power law of the Allan deviation: sigma(tau) = coefficient x gain x tau^slope.

    Attributes
    ----------
    memory
        Decades h of averaging time over which the correlation of the errors of the curve, 1/(1 + (log10(n/m)/h)^2) by
        simulation, falls to one half where the law dominates. Infinite where the errors are nearly one random number:
        the mean square of the rounding errors (Q), the mean slope of the noise (R).
    """

    symbol: str
    slope: float
    gain: float
    unit: str
    memory: float

    def deviation(self, coefficient: float, tau: np.ndarray) -> np.ndarray:
        """Return sigma(tau)."""
        return coefficient * self.gain * np.asarray(tau, float) ** self.slope


LAWS = {
    law.symbol: law
    for law in (
        Law("Q", -1.0, 3**0.5, "{u}*s", memory=np.inf),
        Law("N", -0.5, 1.0, "{u}/sqrt(Hz)", memory=0.32),
        Law("B", 0.0, float(FLOOR), "{u}", memory=0.44),
        Law("K", 0.5, 3**-0.5, "{u}/s/sqrt(Hz)", memory=0.93),
        Law("R", 1.0, 2**-0.5, "{u}/s", memory=np.inf),
    )
}
"""Quantization, white noise, bias instability, random walk and ramp (Farrell et al. 2022, figure 3; IEEE 952)."""


@dataclass(frozen=True)
class Tangent:
    """Coefficient of a power law, read from an Allan deviation curve.

    Attributes
    ----------
    value, low, high
        Coefficient with its interval, SI.
    tau_low, tau_high
        Range over which it was read [s].
    holds
        Whether the curve has the slope of the law there, and no sum of other laws explains it as well. If not, the law
        has an upper bound only: its line must not exceed the curve. It is read at the ``tau``, among those with a known
        local slope, at which the upper limit of the curve gives the smallest coefficient (at longer ones the smallest
        of many uncertain limits would be too small). ``value`` is that of the curve there, ``high`` that of its upper
        limit, ``low`` is 0.
    """

    value: float
    low: float
    high: float
    tau_low: float
    tau_high: float
    holds: bool


def tangent(asd: pd.DataFrame, law: Law, level: float = 0.95) -> Tangent:
    """Read the coefficient of ``law`` from a curve of :func:`curve`, on the longest range with its slope."""
    region = _region(asd, law)
    value, edf = 0.0, 0.0
    if region is not None:
        value, edf = _separated(asd[region], [law, *(other for other in _present(asd) if other is not law)])
    if edf < FEWEST or not value:
        known = asd[_slope_error(asd["error"]) < SLOPE_ERROR]
        unit = law.deviation(1.0, known.index)
        touch = int(np.argmin(known["high"] / unit))
        value, limit = (float(known[column].iloc[touch] / unit[touch]) for column in ("deviation", "high"))
        return Tangent(value, 0.0, limit, known.index[touch], known.index[touch], False)
    low, high = deviation_limits(value, edf, level)
    return Tangent(value, float(low), float(high), asd.index[region][0], asd.index[region][-1], True)


def _present(asd: pd.DataFrame) -> list[Law]:
    """Return N, B and K, which every device is assumed to have, and Q and R where they dominate a part of the curve."""
    slope = asd["slope"][_slope_error(asd["error"]) < SLOPE_ERROR]
    shown = {"Q": slope.min() < -STEEP, "R": slope.max() > STEEP}
    return [law for law in LAWS.values() if shown.get(law.symbol, True)]


def _region(asd: pd.DataFrame, law: Law) -> slice | None:
    """Return the longest range of points with the slope of ``law``, or None.

    The slope of a sum of power laws never decreases with the averaging time. Where it decreases after a range that has
    the slope of B, K or R, the range is a flank or the peak of a correlated process. (It may decrease before a range:
    the output filter of a device reduces the noise at the shortest times.)
    """
    error = _slope_error(asd["error"])
    near = (np.abs(asd["slope"] - law.slope) < np.maximum(SLOPE_TOLERANCE, 2 * error)) & (error < SLOPE_ERROR)
    region = _longest(asd.index.to_numpy(), near.to_numpy())
    if region is None or law.slope < 0:
        return region
    below = law.slope - asd["slope"] > np.maximum(SLOPE_ERROR, 3 * error)
    return None if (below & (error < SLOPE_ERROR))[region.stop :].any() else region


def _separated(asd: pd.DataFrame, laws: Sequence[Law]) -> tuple[float, float]:
    """Return the coefficient of the first law, separated from the contributions of the others, and its edf.

    Non-negative least squares of the Allan variance, which is linear in the squared coefficients, with weights from the
    degrees of freedom and the fitted variance. The degrees of freedom are those of least squares without the sign,
    which scatter more; where the errors of all points are one random number, the smallest edf of the points.
    """
    shares = np.array([law.deviation(1.0, asd.index) ** 2 for law in laws]).T
    observed, weight = asd["deviation"].to_numpy() ** 2, np.sqrt(asd["edf"].to_numpy() / 2)
    expected = observed
    for _ in range(ITERATIONS):
        design = shares * (weight / expected)[:, None]
        scale = np.linalg.norm(design, axis=0)
        squares = nnls(design / scale, observed * weight / expected)[0] / scale
        expected = np.where(shares @ squares > 0, shares @ squares, observed)
    if np.isinf(laws[0].memory):
        return float(np.sqrt(squares[0])), float(asd["edf"].min())
    row = np.linalg.pinv(design / scale)[0] / scale[0]
    decades = np.log10(asd.index.to_numpy())
    correlation = 1 / (1 + (np.subtract.outer(decades, decades) / laws[0].memory) ** 2)
    return float(np.sqrt(squares[0])), float(2 * squares[0] ** 2 / (row @ correlation @ row))


def _slope_error(error: pd.Series) -> pd.Series:
    """Return the standard error of the local slopes from the relative errors of the curve.

    Centre and far end of the window are taken as independent; the points between them share most of their data.
    """
    ends = np.hypot(error, error.shift(-WINDOW, fill_value=np.inf))
    return ends * POINTS_PER_DECADE / (2 * WINDOW * np.log(10))


def _longest(tau: np.ndarray, holds: np.ndarray) -> slice | None:
    """Return the longest run of true points, or None if it is shorter than :data:`REGION_DECADES`."""
    runs = [slice(first, end) for first, end in runs_of(holds)]
    span = {run.start: np.log10(tau[run.stop - 1] / tau[run.start]) for run in runs}
    best = max(runs, key=lambda run: span[run.start], default=None)
    return best if best and span[best.start] >= REGION_DECADES else None

"""Classical estimates from an Allan curve: slopes of power laws, and the peak of a Gauss-Markov process.

Each process is read from its own range of the curve (Farrell et al. 2022, sections on the models of N, K and B; IEEE
952), with the contributions of the other processes subtracted where they are known.
"""

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np
import pandas as pd
from scipy.special import ndtri

from imugap.effects import BiasInstability, GaussMarkov, Quantization, RandomWalk, RateRamp, WhiteNoise
from imugap.effects.effect import AxisModel
from imugap.effects.gauss_markov import FLAT_TOP
from imugap.estimation.result import Fit, ParameterEstimate, identifiability
from imugap.estimation.variances import allan
from imugap.estimation.variances.allan import LAWS, Tangent

SYMBOLS = {Quantization: "Q", WhiteNoise: "N", BiasInstability: "B", RandomWalk: "K", RateRamp: "R"}
"""Power law of each process of one parameter."""
PEAK_RATIO = float(np.sqrt(GaussMarkov(1.0, 1.0).allan_variance(FLAT_TOP)))
"""Allan deviation at the peak of a Gauss-Markov process over its std: 0.4365 sqrt(2) (Farrell et al. 2022, eq. 37)."""
NEIGHBOURS = 3
"""Points on either side that a local maximum or minimum exceeds, as many as a local slope is fitted to."""
PARABOLA = 4
"""Points on either side of the maximum to which the parabola of a peak is fitted."""
FAINTEST = 1e-12
"""Smallest share of the curve that may remain after subtraction of the power laws."""


def fit(
    sequence: np.ndarray, interval: float, kinds: Sequence[type], level: float = 0.95, separated: bool = True
) -> Fit:
    """Estimate a sum of processes from the Allan curve of an error sequence.

    A process without a range of its slope, or a Gauss-Markov process without a peak, gets zero with an upper bound. The
    objective is NaN: no criterion is optimised. The interval of a standard deviation is that of the curve at the peak,
    which is selected as a maximum: the coverage of a 95 % interval is nine logs of ten. That of T is conservative.

    Parameters
    ----------
    sequence, interval
        Samples, shape (n,), and sampling interval [s].
    kinds
        Types of the processes, each once: any of :data:`SYMBOLS`, and :class:`~imugap.effects.GaussMarkov`. A ramp has
        no sign here.
    level
        Confidence level of the intervals.
    separated
        Whether the power laws are subtracted before the peak is searched. If not, the peak is that of the curve itself:
        biased to shorter tau and higher, since white noise adds to it.
    """
    _check(kinds)
    asd = allan.curve(sequence, interval, level)
    tangents = {kind: allan.tangent(asd, LAWS[SYMBOLS[kind]], level) for kind in kinds if kind is not GaussMarkov}
    top = _peak(asd, tangents, separated) if GaussMarkov in kinds else None
    white = tangents.get(WhiteNoise)
    if top is not None and white is not None and white.holds and white.tau_low > top.tau:
        tangents = tangents | {WhiteNoise: _without_flank(white, top)}
    estimates, effects = [], []
    for kind, found in tangents.items():
        value = found.value if found.holds else 0.0
        estimates.append(_estimate(kind.name, fields(kind)[0].name, value, found.low, found.high, level))
        effects.append(kind(value))
    if GaussMarkov in kinds:
        rows = _bound(asd, level) if top is None else _of_peak(top, level)
        estimates += rows
        effects.append(GaussMarkov(rows[0].value, rows[1].value))
    return Fit(AxisModel(tuple(effects)), tuple(estimates), float("nan"), True)


def _check(kinds: Sequence[type]) -> None:
    for kind in kinds:
        if (kind is not GaussMarkov and kind not in SYMBOLS) or list(kinds).count(kind) > 1:
            names = ", ".join(known.__name__ for known in (*SYMBOLS, GaussMarkov))
            raise ValueError(f"Allan slopes: expected processes among {names}, each once; found {kind.__name__}")
    if not kinds:
        raise ValueError("Allan slopes: expected at least one process; found none")


@dataclass(frozen=True)
class AllanPeak:
    """Peak of an Allan curve: averaging time [s] and Allan deviation, with their limits."""

    tau: float
    tau_low: float
    tau_high: float
    deviation: float
    low: float
    high: float


def _peak(asd: pd.DataFrame, tangents: dict[type, Tangent], separated: bool) -> AllanPeak | None:
    """Return the first local maximum after the range of white noise, of the curve less the power laws beneath it.

    Without a range of white noise, or with a later one, it is the first of the curve. It has to exceed what was
    subtracted. Its averaging time is that of the parabola through its neighbours in logarithms; the limits of the
    averaging time are where the upper limit of the curve falls below the peak.
    """
    tau, deviation = asd.index.to_numpy(), asd["deviation"].to_numpy()
    white = tangents.get(WhiteNoise)
    after = np.searchsorted(tau, white.tau_high) if white is not None and white.holds else 0
    for start in dict.fromkeys((after, 0)):
        valley = _first(-deviation, max(start - NEIGHBOURS, 1)) if start else 0
        raw = None if valley is None else _first(deviation, valley + 1)
        if raw is None:
            continue
        beneath = _beneath(tau, tangents if separated else {}, tau[raw])
        middle, low, high = (_less(asd[column], beneath) for column in ("deviation", "low", "high"))
        peak = _first(middle, valley + 1)
        if peak is not None and (low > np.sqrt(FAINTEST) * deviation)[peak - NEIGHBOURS : peak + NEIGHBOURS + 1].all():
            place, value = _vertex(np.log(tau), np.log(middle), peak)
            first, last = _around(high >= value, peak)
            tau_high = tau[last] if last < len(tau) - 1 else np.inf
            return AllanPeak(place, tau[first] if first else 0.0, tau_high, value, low[peak], high[peak])
    return None


def _beneath(tau: np.ndarray, tangents: dict[type, Tangent], top: float) -> np.ndarray:
    """Return the Allan variance at the peak of the power laws that were read beside it."""
    total = np.zeros(len(tau))
    for kind, found in tangents.items():
        law = LAWS[SYMBOLS[kind]]
        before, behind = law.slope < 0 and found.tau_high < top, law.slope > 0 and found.tau_low > top
        if found.holds and (before or behind):
            total += law.deviation(found.value, tau) ** 2
    return total


def _less(deviation: pd.Series, variance: np.ndarray) -> np.ndarray:
    square = deviation.to_numpy() ** 2
    return np.sqrt(np.maximum(square - variance, FAINTEST * square))


def _first(values: np.ndarray, start: int) -> int | None:
    """Return the first local maximum from index ``start`` on, ends excluded, or None."""
    for k in range(max(start, 1), len(values) - 1):
        if values[k] == values[max(k - NEIGHBOURS, 0) : k + NEIGHBOURS + 1].max():
            return k
    return None


def _vertex(x: np.ndarray, y: np.ndarray, peak: int) -> tuple[float, float]:
    """Return exp of the vertex of the parabola through the points about ``peak``, or of the point if it has none."""
    span = slice(max(peak - PARABOLA, 0), peak + PARABOLA + 1)
    bend, slope, height = np.polyfit(x[span] - x[peak], y[span], 2)
    if bend >= 0:
        return float(np.exp(x[peak])), float(np.exp(y[peak]))
    shift = np.clip(-slope / (2 * bend), x[span][0] - x[peak], x[span][-1] - x[peak])
    return float(np.exp(x[peak] + shift)), float(np.exp(height + slope * shift + bend * shift**2))


def _around(inside: np.ndarray, peak: int) -> tuple[int, int]:
    """Return the first and the last index of the run of true points around ``peak``."""
    outside = np.flatnonzero(~inside)
    before, behind = outside[outside < peak], outside[outside > peak]
    return (before[-1] + 1 if len(before) else 0), (behind[0] - 1 if len(behind) else len(inside) - 1)


def _without_flank(white: Tangent, top: AllanPeak) -> Tangent:
    """Return N less S_B T_B^2, the contribution of the Gauss-Markov process to N^2 beyond its peak.

    The difference is uncertain; the lower limit is therefore zero, and the upper limit is kept.
    """
    flank = 2 * (top.deviation / PEAK_RATIO) ** 2 * top.tau / FLAT_TOP
    value = float(np.sqrt(max(white.value**2 - flank, 0.0)))
    return Tangent(value, 0.0, white.high, white.tau_low, white.tau_high, True)


def _of_peak(top: AllanPeak, level: float) -> list[ParameterEstimate]:
    """Return the estimates of std, T_B and S_B = 2 std^2/T_B; the limits of S_B combine those of both."""
    std, std_low, std_high = (
        value / PEAK_RATIO for value in (top.deviation, min(top.low, top.deviation), max(top.high, top.deviation))
    )
    time, time_low, time_high = (tau / FLAT_TOP for tau in (top.tau, top.tau_low, top.tau_high))
    time_low, time_high = min(time_low, time), max(time_high, time)
    driving_high = 2 * std_high**2 / time_low if time_low else np.inf
    return [
        _estimate(GaussMarkov.name, "std", std, std_low, std_high, level),
        _estimate(GaussMarkov.name, "correlation_time", time, time_low, time_high, level),
        _estimate(GaussMarkov.name, "driving_psd", 2 * std**2 / time, 2 * std_low**2 / time_high, driving_high, level),
    ]


def _bound(asd: pd.DataFrame, level: float) -> list[ParameterEstimate]:
    """Return zero with the largest std and S_B below the upper limit of the curve, over all T_B in its range."""
    tau = asd.index.to_numpy()
    times = tau / FLAT_TOP
    shapes = np.array([GaussMarkov(1.0, time).allan_variance(tau) for time in times])
    squares = (asd["high"].to_numpy() ** 2 / shapes).min(axis=1)
    time = float(times[squares.argmax()])
    return [
        _estimate(GaussMarkov.name, "std", 0.0, 0.0, float(np.sqrt(squares.max())), level),
        _estimate(GaussMarkov.name, "correlation_time", time, 0.0, np.inf, level),
        _estimate(GaussMarkov.name, "driving_psd", 0.0, 0.0, float((2 * squares / times).max()), level),
    ]


def _estimate(effect: str, parameter: str, value: float, low: float, high: float, level: float) -> ParameterEstimate:
    """Return an estimate whose error is the half width of its interval in logarithms, in standard deviations."""
    with np.errstate(divide="ignore"):
        error = float(np.diff(np.log([low, high]))[0] / (2 * ndtri((1 + level) / 2))) if high > 0 else np.inf
    return ParameterEstimate(
        effect, 1, parameter, float(value), float(low), float(high), error, identifiability(low, high)
    )

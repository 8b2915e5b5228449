"""Sampling clock of a run relative to that of another run of the same device, from two independent estimates.

A log without time stamps has only samples. If a run was sampled at ``r`` times the interval of the reference, every
analogue frequency appears at ``r`` times as many cycles per sample, and two things move together:

lines
    Narrow spectral lines of the surroundings (machines, building). Precise, but the speed of a machine may change, and
    its harmonics then move in proportion, as they do with the clock.
roll-off
    The smooth spectrum of the gyro noise, filtered inside the device before it is sampled, independent of the
    surroundings. A filter that is clocked with the sampling gives ``r = 1`` for any clock.

The measured roll-off includes aliases from beyond half the sampling rate; so a filter is fitted to both runs with all
its aliases. The shape of that filter is the main uncertainty.

A different clock is concluded only if both agree. ``power`` distinguishes it from a device whose filter was set
differently: sampling keeps the variance of the noise (``power`` = 1), whereas a filter of ``r`` times
the bandwidth, behind the same sensor, passes ``r`` times the variance.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from math import ceil, exp, floor, isnan, nan, sqrt

import numpy as np
import pandas as pd
from scipy import ndimage, optimize, signal, special, stats

from imugap.log import GYRO, LogError, axes

BLOCKS = 16
SHORTEST = 1000  # samples in a block
LEVEL = 0.01  # of the tests that an estimate exists and that both agree
COVERAGE = 0.95  # of the intervals

LOWEST = 200  # periods in a block of the slowest line
STEP = 0.002  # of log frequency, grid on which lines are detected
HEIGHT = 6.0  # of a line over its background [standard deviations]
WINDOW = 0.02  # of log frequency, within which a line is followed from block to block
REACH = 0.35  # largest |log ratio| looked for
TOLERANCE = 0.004  # of log frequency, within which two pairs of lines have the same ratio

EDGES = np.linspace(0.03, 0.5, 61)  # bins of the smooth spectrum [cycles/sample], above flicker noise and most lines
TRIM = 0.95  # share of the ordinates of a bin that is averaged: the highest may be lines
MISFIT = 2.0  # reduced chi-squared up to which one filter is said to shape both spectra
ALIASES = np.arange(-10, 11)[:, None]


@dataclass(frozen=True)
class Spectra:
    """Periodograms of one run: ``power`` (axes, blocks, 1 + length // 2), blocks of ``length`` samples."""

    axes: tuple[str, ...]
    length: int
    power: np.ndarray

    @cached_property
    def lines(self) -> np.ndarray:
        """Log frequency [log cycles/sample] of every line that keeps within the window, shape (lines, blocks)."""
        found = [(height, centre, axis) for axis, power in enumerate(self.power) for height, centre in _detect(power)]
        centres, tracks = [], []
        for _, centre, _ in sorted(found, reverse=True):
            if all(abs(centre - other) > WINDOW for other in centres):
                near = sorted({axis for _, other, axis in found if abs(centre - other) <= WINDOW})
                centres.append(centre)
                tracks.append(_follow(self.power[near], centre))
        tracks = np.array(tracks).reshape(-1, BLOCKS) - np.log(self.length)
        return tracks[tracks.std(axis=1, ddof=1) < 0.3 * WINDOW]  # noise alone, or a broad hump, gives 0.58 WINDOW

    @cached_property
    def smooth(self) -> dict[str, np.ndarray]:
        """Log power of each gyro axis in the bins of :data:`EDGES`, lines trimmed, shape (blocks, bins)."""
        bins = np.split(np.arange(self.power.shape[-1]), np.ceil(EDGES * self.length).astype(int))[1:-1]
        return {
            name: np.log([np.sort(power[:, b])[:, : ceil(TRIM * len(b))].mean(axis=1) for b in bins]).T
            for name, power in zip(self.axes, self.power, strict=True)
            if name in GYRO
        }


@dataclass(frozen=True)
class IntervalRatio:
    """Log of the ratio of sampling intervals, its standard deviation, and its variation over the blocks of the run."""

    log_ratio: float = nan
    sd: float = nan
    track: np.ndarray = field(default_factory=lambda: np.full(BLOCKS, nan))

    def __bool__(self) -> bool:
        """Return whether there is an estimate."""
        return not isnan(self.log_ratio)

    @property
    def interval(self) -> tuple[float, float, float]:
        """Ratio, and its lower and upper limit (Student, as many degrees of freedom as a run has blocks, less one)."""
        half = stats.t.ppf((1 + COVERAGE) / 2, BLOCKS - 1) * self.sd
        return exp(self.log_ratio), exp(self.log_ratio - half), exp(self.log_ratio + half)

    @property
    def contains_one(self) -> bool:
        """Return whether the interval of the ratio contains 1."""
        _, low, high = self.interval
        return low <= 1 <= high

    @property
    def drift(self) -> tuple[float, float]:
        """Relative change of the interval over the run, by a straight line through the blocks, and its p-value."""
        line = stats.linregress(np.linspace(0, 1, BLOCKS), self.track) if self else None
        return (float(line.slope), float(line.pvalue)) if line else (nan, nan)


@dataclass(frozen=True)
class Clock:
    """The sampling interval of a run over that of the reference; ``power`` is the ratio of their noise variances."""

    lines: IntervalRatio
    rolloff: IntervalRatio
    power: float = nan

    @property
    def agreement(self) -> float:
        """p-value of the hypothesis that lines and roll-off have one ratio; NaN unless there are both."""
        difference = abs(self.lines.log_ratio - self.rolloff.log_ratio) / sqrt(self.lines.sd**2 + self.rolloff.sd**2)
        return float(2 * stats.t.sf(difference, BLOCKS - 1))

    @property
    def combined(self) -> IntervalRatio:
        """Return the mean of the estimates, weighted by inverse variance; none if they disagree."""
        found = [] if self.agreement < LEVEL else [one for one in (self.lines, self.rolloff) if one]
        return _mean(found)

    @property
    def verdict(self) -> str:
        """Return ``no evidence``, ``conflict``, ``same clock``, ``different clock`` or ``unconfirmed`` (by one)."""
        if not self.lines and not self.rolloff:
            return "no evidence"
        if self.agreement < LEVEL:
            return "conflict"
        if self.combined.contains_one:
            return "same clock"
        both = self.lines and self.rolloff and not (self.lines.contains_one or self.rolloff.contains_one)
        return "different clock" if both else "unconfirmed"

    def row(self) -> pd.Series:
        """Return everything as one row of a table."""
        kinds = {"lines": self.lines, "rolloff": self.rolloff, "combined": self.combined}
        row = {}
        for kind, ratio in kinds.items():
            row |= zip((kind, f"{kind}_low", f"{kind}_high"), ratio.interval, strict=True)
        for kind in ("lines", "rolloff"):
            row |= zip((f"{kind}_drift", f"{kind}_drift_p"), kinds[kind].drift, strict=True)
        return pd.Series(row | {"power": self.power, "agreement_p": self.agreement, "verdict": self.verdict})


def spectra(log: pd.DataFrame) -> Spectra:
    """Return the periodograms of a log at rest: :data:`BLOCKS` blocks, straight line removed, Hann window."""
    names, length = axes(log), len(log) // BLOCKS
    if length < SHORTEST:
        raise LogError("log", "rows", f"at least {BLOCKS * SHORTEST} samples", str(len(log)))
    power = np.empty((len(names), BLOCKS, length // 2 + 1), dtype=np.float32)
    window = signal.windows.hann(length, sym=False)
    for axis, name in enumerate(names):
        blocks = log[name].to_numpy(dtype=float)[: BLOCKS * length].reshape(BLOCKS, length)
        power[axis] = np.abs(np.fft.rfft(signal.detrend(blocks) * window)) ** 2
    return Spectra(names, length, power)


def relative_interval(reference: Spectra, run: Spectra) -> Clock:
    """Estimate the sampling interval of ``run`` in units of that of ``reference`` (runs at rest of one device)."""
    pairs = [
        np.stack([reference.smooth[name], smooth]) for name, smooth in run.smooth.items() if name in reference.smooth
    ]
    return Clock(_match(reference, run), *_rolloff(pairs))


def _mean(found: list[IntervalRatio]) -> IntervalRatio:
    """Return the mean by inverse variance, its deviation enlarged by the Birge ratio."""
    if not found:
        return IntervalRatio()
    values, weights = np.array([e.log_ratio for e in found]), np.array([e.sd**-2 for e in found])
    mean = np.average(values, weights=weights)
    birge = max(1.0, weights @ (values - mean) ** 2 / max(1, len(found) - 1))
    return IntervalRatio(float(mean), sqrt(birge / weights.sum()), np.average([e.track for e in found], 0, weights))


def _detect(power: np.ndarray) -> list[tuple[float, float]]:
    """Return height [standard deviations] and log frequency [log periods per block] of the lines of one axis.

    The mean over blocks of the log power (so that a shock in one block has little weight) on a grid of log frequency,
    less its running median. The log of the mean of ``m`` ordinates has variance trigamma(m); the Hann window makes
    ``m`` neighbours count for 2/3 of it.
    """
    grid = np.arange(np.log(LOWEST), np.log(power.shape[1] - 1), STEP)
    edges = np.exp(grid)
    totals = np.cumsum(power, axis=1, dtype=float)
    totals = [np.interp(edges - 0.5, np.arange(len(total)), total) for total in totals]
    level = np.log(np.diff(totals) / np.diff(edges)).mean(axis=0)
    scale = np.sqrt(special.polygamma(1, np.maximum(1, np.diff(edges) / 1.5)) / BLOCKS)
    height = (level - ndimage.median_filter(level, size=round(4 * WINDOW / STEP) + 1)) / scale
    peaks, _ = signal.find_peaks(height, height=HEIGHT, distance=round(WINDOW / STEP))
    return [(float(height[peak]), float(grid[peak] + STEP / 2)) for peak in peaks]


def _follow(power: np.ndarray, centre: float) -> np.ndarray:
    """Return the log frequency [log periods per block] of the highest ordinate near ``centre`` in each block.

    ``power`` (axes, blocks, ordinates) is summed over the axes, each in units of its median near the line; a parabola
    through the log of the highest ordinate and its neighbours interpolates.
    """
    first, last = floor(exp(centre - WINDOW)), min(ceil(exp(centre + WINDOW)), power.shape[-1] - 1)
    part = power[:, :, first : last + 1]
    part = np.log((part / np.median(part, axis=(1, 2), keepdims=True)).sum(axis=0))
    top = 1 + part[:, 1:-1].argmax(axis=1)
    left, middle, right = (part[np.arange(BLOCKS), top + k] for k in (-1, 0, 1))
    bend = np.minimum(left - 2 * middle + right, -1e-9)
    return np.log(first + top + np.clip(0.5 * (left - right) / bend, -0.5, 0.5))


def _match(reference: Spectra, run: Spectra) -> IntervalRatio:
    """Find the ratio that most lines of two runs have in common, and estimate it.

    Under the null the lines of the run lie anywhere on the log axis: each meets one of the reference with probability
    ``share``, and the number of hits is binomial at each of the ratios tried. So one line alone proves nothing; but
    the harmonics of any two machines do match, at the ratio of their speeds.

    The source of a line wanders, slowly: the mean of a run is taken to be as uncertain as one of its blocks.
    """
    differences = np.median(run.lines, axis=1) - np.median(reference.lines, axis=1)[:, None]
    tried = differences[np.abs(differences) <= REACH]
    if not len(tried):
        return IntervalRatio()
    misses = np.abs(differences - tried[:, None, None])
    hits = (misses <= TOLERANCE).any(axis=1).sum(axis=1)
    best = np.lexsort((np.minimum(misses, TOLERANCE).sum(axis=(1, 2)), -hits))[0]
    share = min(1.0, 2 * TOLERANCE * len(reference.lines) / np.log(run.length / 2 / LOWEST))
    if REACH / TOLERANCE * stats.binom.sf(hits[best] - 1, len(run.lines), share) > LEVEL:
        return IntervalRatio()
    first, second = np.nonzero(misses[best] <= TOLERANCE)
    pairs = np.stack([reference.lines[first], run.lines[second]])
    before, after = np.average(pairs, axis=1, weights=1 / pairs.var(axis=2, ddof=1).sum(axis=0))
    sd = sqrt(before.var(ddof=1) + after.var(ddof=1))
    return IntervalRatio(float(after.mean() - before.mean()), sd, after - after.mean())


def _rolloff(pairs: list[np.ndarray]) -> tuple[IntervalRatio, float]:
    """Estimate the ratio from the log spectra of each axis, (2, blocks, bins); also the ratio of the noise powers.

    Families of filters are averaged by likelihood: the ratio is no surer than the shape, which is common to the axes.
    An axis does not count if a spectrum of it is flat or no filter fits both of them (a resonance, a vibration).
    """
    pairs = [pair for pair in pairs if not _flat(pair)]
    fits = [[_fit(pair, *start) for pair in pairs] for start in STARTS]
    misfit = np.array([[chi2 for chi2, _ in family] for family in fits])
    used = [axis for axis, pair in enumerate(pairs) if misfit[:, axis].min() < MISFIT * pair[:, 0].size]
    if not used:
        return IntervalRatio(), nan
    families = [_mean([family[axis][1] for axis in used]) for family in fits]
    weights = np.exp((misfit[:, used].sum(axis=1).min() - misfit[:, used].sum(axis=1)) / 2)
    ratios, sds = np.array([family.log_ratio for family in families]), np.array([family.sd for family in families])
    mean = np.average(ratios, weights=weights)
    deviation = sqrt(np.average(sds**2 + (ratios - mean) ** 2, weights=weights))
    track = np.average([family.track for family in families], axis=0, weights=weights)
    share = np.diff([0.0, *EDGES[1:]])  # flat below the lowest bin
    power = exp(np.mean([np.diff(np.log(np.exp(pairs[axis].mean(axis=1)) @ share)) for axis in used]))
    return (IntervalRatio(float(mean), deviation, track), power) if deviation < REACH / 10 else (IntervalRatio(), nan)


def _errors(pair: np.ndarray) -> np.ndarray:
    """Return the standard deviation of the mean over blocks, pooled over the bins, (2, 1)."""
    return np.sqrt(pair.var(axis=1, ddof=1).mean(axis=1, keepdims=True) / BLOCKS)


def _flat(pair: np.ndarray) -> bool:
    """Return whether one of two spectra, (2, blocks, bins), has no shape at all."""
    means = pair.mean(axis=1)
    chi2 = (((means - means.mean(axis=1, keepdims=True)) / _errors(pair)) ** 2).sum(axis=1)
    return bool(stats.chi2.sf(chi2.min(), means.shape[1] - 1) > LEVEL)


def _fit(pair: np.ndarray, family: Callable, shape: float) -> tuple[float, IntervalRatio]:
    """Fit log width, shape and log ratio to the means over blocks, the levels set aside; also return chi-squared.

    The ratio is linear in small changes of the spectra: applied to the blocks, that gives its course within the run,
    and their scatter its deviation.
    """
    means, sd = pair.mean(axis=1), _errors(pair)

    def residual(parameters: np.ndarray) -> np.ndarray:
        width, shape, ratio = parameters
        difference = np.stack([_folded(family, exp(width), shape), _folded(family, exp(width + ratio), shape)]) - means
        return ((difference - difference.mean(axis=1, keepdims=True)) / sd).ravel()

    starts = [(width, shape, 0.0) for width in np.arange(-3.0, 1.0, 0.25)]
    start = min(starts, key=lambda parameters: (residual(parameters) ** 2).sum())
    fit = optimize.least_squares(
        residual, start, bounds=([-4.0, -1.0, -2 * REACH], [1.0, 2.0, 2 * REACH]), x_scale="jac"
    )
    changes = (pair - means[:, None]) / sd[:, None]
    shifts = np.einsum("rbf,rf->rb", changes, np.linalg.pinv(fit.jac)[-1].reshape(means.shape))
    deviation = sqrt(shifts.var(axis=1, ddof=1).sum() / BLOCKS * max(1.0, 2 * fit.cost / means.size))
    slope = fit.jac[means.shape[1] :, -1]  # of the run alone, once width and shape are known
    return 2 * fit.cost, IntervalRatio(float(fit.x[-1]), deviation, changes[1] @ slope / (slope @ slope))


def _folded(family: Callable, width: float, shape: float) -> np.ndarray:
    """Return the log of the sampled spectrum ``sum_k H((nu + k) / width)`` of a filter, (bins,)."""
    distance = np.abs((EDGES[1:] + EDGES[:-1]) / 2 + ALIASES) / width
    return special.logsumexp(family(distance, shape), axis=0)


def _poles(x: np.ndarray, shape: float, power: int = 2) -> np.ndarray:
    """Log of ``(1 + shape x^power)^(-1/shape)``: one pole for shape 1, a Gauss curve for 0, a sharp edge below."""
    shape = shape if abs(shape) > 1e-4 else 1e-4
    return -np.log1p(np.maximum(shape * x**power, 1e-12 - 1)) / shape


def _butterworth(x: np.ndarray, shape: float) -> np.ndarray:
    """Log of ``(1 + shape x^4)^(-1/shape)``: a Butterworth filter of second order for shape 1."""
    return _poles(x, shape, power=4)


def _averages(x: np.ndarray, shape: float) -> np.ndarray:
    """Log of ``|sinc x|^(2 exp(shape))``: moving averages, ``exp(shape)`` of them in a row."""
    return 2 * exp(shape) * np.log(np.maximum(np.abs(np.sinc(x)), 1e-9))


STARTS = ((_poles, 0.5), (_butterworth, 1.0), (_averages, 0.0), (_averages, 0.7))  # one average, and two in a row

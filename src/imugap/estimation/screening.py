"""Find samples of a log at rest that are no noise of the sensor: outliers, knocks, level steps, stuck and lost samples.

The samples are compared with the predictions of an autoregression that is fitted to the undisturbed ones, so that
neither drift nor coloured noise counts as a disturbance. Samples that carry no noise of the sensor are drawn given the
others (:mod:`imugap.numerics.samples.gap_filling`): neither level nor spectrum is biased. A log without a disturbance
is returned unchanged.
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import binary_closing, binary_dilation, binary_opening, uniform_filter1d
from scipy.special import bdtrc, gammainc

from imugap.integrity.regular import counted
from imugap.numerics.samples.contaminated_normal import tails
from imugap.numerics.samples.gap_filling import ORDER, Autoregression
from imugap.numerics.samples.runs import runs_of

OUTLIER, LEVEL_STEP = "outlier", "level step"
"""Kinds that are counted by their samples, and that lose no samples."""
BLOCK = 128
"""Samples of a block, whose median is the local level; a burst is shorter than half of it."""
GAUSSIAN = 5.5
"""Size of a sample [robust standard deviations] that normal noise exceeds once in 26 million samples."""
COARSE = 8.0
"""The same where rounding hides the shape of the distribution."""
FAR = 5.0
"""Least ratio of the standard deviations of outliers and noise: less is noise of heavy tails."""
COMMON = 0.25
"""Share of outliers above which they are no exception: then only those far beyond the noise count."""
GAIN = 20.0
"""Least gain of log-likelihood by outliers: of two parameters, reached by chance once in 5e8 logs."""
CORE, ROUNDS = 2.0, 20
"""Size [standard deviations] below which hardly any sample is an outlier, and iterations of the fit to these."""
EDGES = np.arange(2.0, 6.1, 0.5)
"""Limits of the sizes [standard deviations] within which samples are counted."""
LARGE = 2.5
"""Size [standard deviations] of the samples that are counted in a window to find a knock."""
WINDOWS = (16, 64)
"""Lengths [samples] of the windows."""
SHORTEST, MARGIN = 4, 8
"""Least length of a knock, and samples on each side of it that are left out with it."""
IMPROBABLE = 1e-9
"""Probability of a window with as many large samples, from which it is a knock."""
REPEATED = 1e-6
"""Expected number of runs of repeats as long by chance, below which the output was stuck."""
FREQUENT = 0.2
"""Share of runs with a repeat above which the noise is below a step of the lattice: then drift makes long runs."""
LONGEST, LONGER = 4, 20
"""There a stuck run is so many times longer than the run of this rank."""
AROUND = 256
"""Undisturbed samples on each side of a knock whose medians are compared."""
STEP = 8.0
"""Least difference of the medians, in robust standard deviations of such differences elsewhere, of a level step."""
SHOWN = 3
"""Number of stretches that a sentence lists."""
SCATTERED = 0.1
"""Share of lost samples up to which, scattered over the log, an autoregression suffices."""
FEWEST = 0.1
"""Least share of undisturbed samples of a log that is estimated."""


@dataclass(frozen=True)
class LeftOut:
    """Samples of one kind that were left out: number, and first and last sample of each stretch.

    Attributes
    ----------
    kind
        What a stretch is.
    samples
        Their number.
    stretches
        First sample and sample after the last of each stretch, in order.
    """

    kind: str
    samples: int
    stretches: tuple[tuple[int, int], ...]


@dataclass(frozen=True, eq=False)
class Screened:
    """Samples of an axis without its disturbances.

    Attributes
    ----------
    values
        Samples, shape (n,); disturbed ones are drawn given the others.
    replaced
        Which samples are drawn, shape (n,).
    disturbances
        What was left out.
    """

    values: np.ndarray
    replaced: np.ndarray
    disturbances: tuple[LeftOut, ...]

    @property
    def share(self) -> float:
        """Return the share of samples that are measured."""
        return 1 - float(np.mean(self.replaced))

    @property
    def information(self) -> float:
        """Return the share of the information of a whole log that is left."""
        return information(self.share)

    def sentences(self, interval: float, start: float = 0.0) -> list[str]:
        """Return in words what was left out, and when, of samples every ``interval`` from ``start`` on [s]."""
        return [_sentence(one, interval, start, len(self.values)) for one in self.disturbances]


def information(share: float) -> float:
    """Return the share of the information of a whole log that is left where only a share of the samples is measured.

    The estimate of the variance of white noise has, relative to that of a whole log, the variance 1/share by the
    measured samples and 1 - share by the others, which are drawn once.
    """
    return 1 / (1 / share + 1 - share)


def _sentence(found: LeftOut, interval: float, start: float, count: int) -> str:
    """Return in words what was left out, e.g. "Left out: 2 knocks, 200 samples (0.1 %), at 12-12.6 s, 30-31.4 s"."""
    times = [(start + first * interval, start + (end - 1) * interval) for first, end in found.stretches[:SHOWN]]
    places = [f"{first:.6g} s" if first == last else f"{first:.6g}-{last:.6g} s" for first, last in times]
    rest = len(found.stretches) - SHOWN
    place = ", ".join(places) + (f" and {rest} more" if rest > 0 else "")
    if found.kind == LEVEL_STEP:
        return f"Taken out: {counted(len(found.stretches), found.kind)} at {place}"
    share = f"{100 * found.samples / count:.2g} %"
    if found.kind == OUTLIER:
        return f"Left out: {counted(found.samples, found.kind)} ({share}) at {place}"
    number = counted(len(found.stretches), found.kind)
    return f"Left out: {number}, {counted(found.samples, 'sample')} ({share}), at {place}"


def screen(values: np.ndarray, rng: np.random.Generator) -> Screened:
    """Find the disturbances of a log at rest and replace them.

    Parameters
    ----------
    values
        Evenly spaced samples, shape (n,); NaN where lost.
    rng
        Source of the replacements.
    """
    values = np.asarray(values, float)
    lost = ~np.isfinite(values)
    if not _varies(values[~lost]):
        return Screened(values, np.zeros(len(values), bool), ())
    stuck = _stuck(values)
    unknown = lost | stuck
    if not unknown.any() and not _suspicious(values):
        return Screened(values, unknown, ())
    _require_enough(unknown)
    if not is_scattered(lost):
        return _of_present(screen(values[~lost], rng), lost)
    probability, knocks = _disturbed(values, unknown, rng)
    replaced = unknown | knocks | (rng.random(len(values)) < probability)
    _require_enough(replaced)
    if not replaced.any():
        return Screened(values, replaced, ())
    filled, outliers = _drawn(values, replaced, rng), probability > 1 / 2
    found = _described({"gap": lost, "stuck stretch": stuck, OUTLIER: outliers, "knock": knocks})
    filled, steps = _without_steps(filled, replaced, np.vstack([runs_of(knocks), runs_of(stuck)]))
    if steps.any():
        filled = _drawn(filled, replaced, rng)
        found += _described({LEVEL_STEP: steps})
    return Screened(filled, replaced, found)


def disturbed(values: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Return which samples of a log at rest are outliers or knocks, shape (n,); arguments as of :func:`screen`."""
    unknown = ~np.isfinite(values)
    unknown |= _stuck(values)
    if np.mean(unknown) > 1 - FEWEST or not _varies(values[~unknown]) or not _suspicious(values[~unknown]):
        return np.zeros(len(values), bool)
    probability, knocks = _disturbed(values, unknown, rng)
    return knocks | (probability > 1 / 2)


def is_scattered(lost: np.ndarray) -> bool:
    """Return whether lost samples, mask of shape (n,), are few and apart: an autoregression reaches over them."""
    longest = int(np.max(np.diff(runs_of(lost)), initial=0))
    return longest <= ORDER and float(np.mean(lost)) < SCATTERED


def _of_present(screened: Screened, lost: np.ndarray) -> Screened:
    """Return the screened samples of a log, those that are present, at their places between lost ones (NaN)."""
    present = np.flatnonzero(~lost)
    values, replaced = np.full(len(lost), np.nan), lost.copy()
    values[present], replaced[present] = screened.values, screened.replaced
    found = [
        replace(one, stretches=tuple((int(present[first]), int(present[end - 1]) + 1) for first, end in one.stretches))
        for one in screened.disturbances
    ]
    return Screened(values, replaced, (*_described({"gap": lost}), *found))


def _require_enough(replaced: np.ndarray) -> None:
    """Raise a ValueError for a log that is mostly disturbed."""
    share = 1 - float(np.mean(replaced))
    if share < FEWEST:
        raise ValueError(f"samples: expected at least {FEWEST:.0%} that are undisturbed; found {share:.1%}")


def _varies(values: np.ndarray) -> bool:
    return len(values) > 0 and bool(np.ptp(values) > 0)


def _described(masks: dict[str, np.ndarray]) -> tuple[LeftOut, ...]:
    return tuple(
        LeftOut(kind, int(np.count_nonzero(mask)), tuple(map(tuple, runs_of(mask).tolist())))
        for kind, mask in masks.items()
        if mask.any()
    )


def _stuck(values: np.ndarray) -> np.ndarray:
    """Return the samples of runs of repeats that are too long for chance, shape (n,), without the first of each run.

    A sample repeats its predecessor by chance with the share of runs that have a repeat. A stuck stretch is one run
    among many and does not change it.
    """
    first = np.flatnonzero(np.r_[True, values[1:] != values[:-1]])
    repeats = np.diff(np.r_[first, len(values)]) - 1
    share = max(np.count_nonzero(repeats) / len(repeats), 1 / len(values))
    least = np.log(REPEATED / len(values)) / np.log(share) if share < 1 else np.inf
    if share > FREQUENT and len(repeats) >= LONGEST:
        least = max(least, LONGER * np.partition(repeats, -LONGEST)[-LONGEST])
    if repeats.max(initial=0) < max(least, 2):
        return np.zeros(len(values), bool)
    mask = np.repeat(repeats >= max(least, 2), repeats + 1)
    mask[first] = False
    return mask


def _suspicious(values: np.ndarray) -> bool:
    """Return whether a sample or a difference of samples is too large, or too many are large close together."""
    residual, differences = values - _level(values), np.diff(values)
    step = _step(differences)
    for sequence, factor in ((residual, 1.0), (differences, np.sqrt(2))):
        scale = _scale(sequence, factor * step)
        large = np.abs(sequence) > LARGE * scale
        if np.abs(sequence).max() > GAUSSIAN * scale or any(_crowded(large, width).any() for width in WINDOWS):
            return True
    return False


def _level(values: np.ndarray) -> np.ndarray:
    """Return the local level of each sample, shape (n,): straight lines through the medians of blocks."""
    blocks = max(len(values) // BLOCK, 1)
    size = len(values) // blocks
    parts = values[: blocks * size].reshape(blocks, size)
    good = np.isfinite(parts).any(axis=1)
    median = np.nanmedian if np.isnan(values).any() else np.median
    medians = median(parts[good], axis=1)
    middle = (np.flatnonzero(good) + 0.5) * size
    if len(middle) < 2:
        return np.full(len(values), medians[0])
    ends = np.array([0.0, len(values)])
    slopes = (np.diff(medians) / np.diff(middle))[[0, -1]]
    beyond = medians[[0, -1]] + slopes * (ends - middle[[0, -1]])
    knots, levels = np.r_[ends[0], middle, ends[1]], np.r_[beyond[0], medians, beyond[1]]
    return np.interp(np.arange(len(values)), knots, levels)


def _residual(values: np.ndarray) -> np.ndarray:
    """Return the distance of each sample from its surroundings, shape (n,); zero where it is NaN.

    From the local level, or from the mean of its two neighbours where the log changes too fast for the blocks.
    """
    level = np.nan_to_num(values - _level(values))
    middle = np.nan_to_num(values - np.r_[values[1], (values[2:] + values[:-2]) / 2, values[-2]])
    spread = [float(np.median(np.abs(one[np.isfinite(values)]))) for one in (level, middle)]
    return middle if 0 < spread[1] < spread[0] else level


def _step(differences: np.ndarray) -> float:
    """Return the smallest difference of neighbouring samples."""
    apart = np.abs(differences)
    return float(np.min(apart, initial=np.inf, where=apart > 0)) if apart.any() else 0.0


def _scale(sequence: np.ndarray, step: float) -> float:
    """Return a robust standard deviation; on a lattice of a step above it, a larger one that rounding cannot hide."""
    size = np.abs(sequence)
    scale = float(np.median(size)) / 0.6745
    if scale > step:
        return scale
    return max(scale, float(np.quantile(size, 0.9)) / 1.645, step / np.sqrt(12))


def _crowded(large: np.ndarray, width: int) -> np.ndarray:
    """Return the windows, by their middle sample, that hold too many large samples for independent ones."""
    if len(large) < width:
        return np.zeros(len(large), bool)
    before = np.cumsum(np.concatenate([np.zeros(width // 2 + 1, bool), large, np.zeros(width, bool)]), dtype=np.int32)
    count = (before[width:] - before[:-width])[: len(large)]
    share = max(float(np.mean(large)), 2e-2)
    limit = next(k for k in range(width + 1) if bdtrc(k, width, share) < IMPROBABLE)
    return count > limit


def _disturbed(values: np.ndarray, unknown: np.ndarray, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Return the probability of each sample to be an outlier, and the mask of knocks; shape (n,) each.

    First samples far from the local level are set aside; then all are compared with the autoregression of the others.
    """
    residual = _residual(np.where(unknown, np.nan, values))
    step = _step(np.diff(values[~unknown]))
    scale = _scale(residual[~unknown], step)
    coarse = step > scale
    far = np.abs(residual) > (COARSE if coarse else GAUSSIAN) * scale
    if not coarse:
        far &= _outlying(residual / scale, ~unknown) > 0.5
    crowded = _knocks(np.abs(residual) / scale, ~unknown)
    model = Autoregression.of(values, ~(unknown | far | crowded))
    past = model.fill(values, unknown | far, rng) if (unknown | far).any() else values
    innovation = model.innovations(past) + np.where(unknown, 0.0, values - past)
    innovation /= _scale(innovation[~(unknown | far | crowded)], step)
    if np.mean(np.diff(values) == 0) > FREQUENT and not coarse:  # held values: each predicts the next
        innovation = residual / scale
    knocks = _knocks(np.abs(innovation), ~unknown) & ~unknown
    probability = 1.0 * (np.abs(innovation) > COARSE) if coarse else _outlying(innovation, ~(unknown | knocks))
    return np.where(unknown | knocks, 0.0, probability), knocks


def _drawn(values: np.ndarray, flawed: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    return Autoregression.of(values, ~flawed).fill(values, flawed, rng)


def _outlying(residual: np.ndarray, known: np.ndarray) -> np.ndarray:
    """Return the probability of each sample to be an outlier, shape (n,): zero unless outliers are significant.

    The samples are taken from two normal laws. An outlier is drawn with this probability, so that those that are
    left, and those that are taken for outliers and are none, make up the narrow law. Where the outliers are not normal,
    their law is too large at the flanks of the narrow one; there the excess of the samples over the narrow law limits
    the probability (local false discovery rate: Efron 2004, doi:10.1198/016214504000000089).
    """
    posterior = np.zeros(len(residual))
    if not np.median(np.abs(residual[known])):  # most samples are one value, and no law is normal
        return posterior
    found = tails(residual[known])
    if found.gain < GAIN or found.wide < FAR * found.narrow:
        return posterior
    if found.probability > COMMON:
        return 1.0 * (known & (np.abs(residual) > GAUSSIAN * _scale(residual[known], 0.0)))
    posterior[known] = np.minimum(found.posterior, _excess(np.abs(residual[known])))
    return posterior


def _excess(size: np.ndarray) -> np.ndarray:
    """Return the share of samples, of those about as large as each, that exceeds the narrow law; shape (n,).

    The narrow law is fitted to the samples within :data:`CORE` standard deviations; beyond the last of :data:`EDGES`
    there is none of it.
    """
    scale = float(np.median(size)) / 0.6745
    for _ in range(ROUNDS):
        core = size[size < CORE * scale]
        scale *= np.sqrt(np.mean(core**2) / scale**2 / gammainc(1.5, CORE**2 / 2) * gammainc(0.5, CORE**2 / 2))
    number = np.count_nonzero(size < CORE * scale) / gammainc(0.5, CORE**2 / 2)
    expected = number * np.diff(gammainc(0.5, EDGES**2 / 2))
    seen = np.histogram(size, EDGES * scale)[0]
    share = np.maximum(1 - expected / np.maximum(seen, 1), 0.0)
    return np.r_[0.0, np.maximum.accumulate(share), 1.0][np.searchsorted(EDGES * scale, size)]


def _knocks(size: np.ndarray, known: np.ndarray) -> np.ndarray:
    """Return the samples of knocks and bursts, shape (n,): stretches with too many large samples, and their margins.

    ``size`` is in standard deviations.
    """
    large = (size > LARGE) & known
    dense = np.zeros(len(size), bool)
    for width in WINDOWS:
        middle = _crowded(large, width)
        if middle.any():
            dense |= uniform_filter1d(middle.astype(float), width, mode="constant") > 0.5 / width
    if not dense.any():
        return dense
    joined = binary_opening(binary_closing(dense & large, np.ones(WINDOWS[0])), np.ones(SHORTEST))
    return binary_dilation(joined, np.ones(2 * MARGIN + 1)) if joined.any() else joined


def _without_steps(
    values: np.ndarray, replaced: np.ndarray, stretches: Iterable[tuple[int, int]]
) -> tuple[np.ndarray, np.ndarray]:
    """Return the samples without the level steps at the stretches, and the mask of these stretches, shape (n,) each.

    A step is the difference of the medians on both sides, where it is far larger than such differences elsewhere.
    """
    steps = np.zeros(len(values), bool)
    good = np.flatnonzero(~replaced)
    blocks = len(good) // AROUND
    medians = np.median(values[good[: blocks * AROUND]].reshape(blocks, AROUND), axis=1)
    values = values.copy()
    for start, end in stretches:
        before, after = (values[good[slice(*side)]] for side in _sides(good, start, end))
        apart = 1 + (end - start) // AROUND
        if min(len(before), len(after)) < AROUND // 4 or blocks < 4 * apart:
            continue
        usual = float(np.median(np.abs(medians[apart:] - medians[:-apart]))) / 0.6745
        difference = float(np.median(after) - np.median(before))
        if abs(difference) > STEP * usual:
            values[end:] -= difference
            steps[start:end] = True
    return values, steps


def _sides(good: np.ndarray, start: int, end: int) -> tuple[tuple[int, int], tuple[int, int]]:
    """Return the ranges within ``good`` of the samples before and after a stretch."""
    left, right = (int(np.searchsorted(good, edge)) for edge in (start, end))
    return (max(left - AROUND, 0), left), (right, right + AROUND)

"""Integrity of a log as read: stamps, stuck and saturated samples, quantization step, shocks, gravity.

The report is made on the unchecked table (:func:`imugap.io.recording.read`). Each flag is a test against a
distribution estimated from the log itself (frequency of equal neighbours, mass of the outermost levels, extremes of the
samples), with :data:`IMPROBABLE` as its significance level.
"""

from dataclasses import asdict, dataclass

import numpy as np
import pandas as pd
from scipy.ndimage import uniform_filter1d
from scipy.special import bdtrc, ndtri

from imugap.log import ACCEL, axes
from imugap.units import STANDARD_GRAVITY, to_si

IMPROBABLE = 1e-6
HIGH_PASS_S = 1.0
GRAVITY_RATIO = 1.25
MAD_TO_SD = 1.482602218505602
ROUND_OFF = (2e-7, 1e-13)  # of single floats, of doubles after unit conversion, relative to the largest value
EDGES = (2, 5)
"""Outermost levels among which the last one may hold too many samples: of few samples near it, more levels tell."""


@dataclass(frozen=True)
class Timing:
    """Time stamps: rate [Hz] and interval [s] from the regular steps, and counts of irregular ones."""

    samples: int
    duration_s: float
    interval_s: float | None
    rate_hz: float | None
    step_sd_s: float | None
    gaps: int
    largest_gap_s: float
    first_gap_s: float | None
    duplicated: int
    reversed: int
    missing: int


@dataclass(frozen=True)
class Gravity:
    """Mean specific force of a log: norm and deviation from standard gravity [m/s^2], and its likely unit."""

    norm: float
    deviation: float
    unit: str | None


@dataclass(frozen=True)
class Axis:
    """Integrity of one axis: lost, repeated and clipped samples, and the quantization step (SI)."""

    axis: str
    nan: int
    lattice: float | None
    outliers: int
    longest_repeat: int = 0
    expected_repeat: float | None = None
    repeat_s: float | None = None
    stuck: bool = False
    minimum: float | None = None
    minimum_count: int = 0
    maximum: float | None = None
    maximum_count: int = 0
    saturated: bool = False


@dataclass(frozen=True)
class Shock:
    """Shock: consecutive outliers of any axis; ``size`` is the largest, in standard deviations, on ``axis``."""

    start_s: float
    end_s: float
    axis: str
    size: float


@dataclass(frozen=True)
class Report:
    """Integrity of one log."""

    timing: Timing
    gravity: Gravity | None
    axes: tuple[Axis, ...]
    events: tuple[Shock, ...]

    def to_frame(self) -> pd.DataFrame:
        """Return one row per axis, indexed by its name."""
        return pd.DataFrame([asdict(axis) for axis in self.axes]).set_index("axis")

    def facts(self) -> dict:
        """Return the properties of the log as a whole for JSON: timing, gravity, events."""
        gravity = None if self.gravity is None else asdict(self.gravity)
        return {"timing": asdict(self.timing), "gravity": gravity, "events": [asdict(event) for event in self.events]}


def report(table: pd.DataFrame) -> Report:
    """Return the integrity of a log of 2 samples or more; NaN and repeated or reversed stamps are allowed."""
    names = axes(table)
    if not names or len(table) < 2:
        raise ValueError(f"table: expected an inertial axis and 2 samples or more; found {len(names)}, {len(table)}")
    stamps = table.index.to_numpy(float)
    regularity = timing(stamps)
    time = _filled(np.where(np.isfinite(stamps), stamps, np.nan))
    reports, outliers = [], {}
    for name in names:
        values = table[name].to_numpy(float)
        values = np.where(np.isfinite(values), values, np.nan)
        levels, counts = np.unique(values[~np.isnan(values)], return_counts=True)
        step = lattice(levels, len(values))
        scores = np.abs(outlier_scores(values, regularity.interval_s, step))
        rows = np.flatnonzero(scores > outlier_limit(scores))
        outliers[name] = rows, scores[rows]
        reports.append(_axis(name, values, time, levels, counts, step, len(rows)))
    return Report(regularity, gravity(table), tuple(reports), events(outliers, time))


def timing(time: np.ndarray) -> Timing:
    """Return statistics of the stamps ``time`` [s], shape (n,).

    A gap is a step of more than 1.5 median steps; ``interval_s`` and the scatter ``step_sd_s`` are the mean and the
    standard deviation of the steps within half of the median step; ``missing`` counts stamps that are not numbers.
    """
    finite = time[np.isfinite(time)]
    steps = np.diff(finite)
    forward = steps[steps > 0]
    median = np.median(forward) if len(forward) else np.nan
    regular = forward[np.abs(forward - median) <= 0.5 * median]
    interval = float(regular.mean()) if len(regular) else None
    gaps = np.flatnonzero(steps > 1.5 * median)
    return Timing(
        samples=len(time),
        duration_s=float(np.ptp(finite)) + interval if interval else 0.0,
        interval_s=interval,
        rate_hz=1 / interval if interval else None,
        step_sd_s=float(regular.std()) if interval else None,
        gaps=len(gaps),
        largest_gap_s=float(steps[gaps].max(initial=0.0)),
        first_gap_s=float(finite[gaps[0]]) if len(gaps) else None,
        duplicated=int(np.count_nonzero(steps == 0)),
        reversed=int(np.count_nonzero(steps < 0)),
        missing=len(time) - len(finite),
    )


def gravity(table: pd.DataFrame) -> Gravity | None:
    """Compare the norm of the mean specific force with standard gravity; None without three axes."""
    if not set(ACCEL) <= set(table.columns):
        return None
    columns = [table[name].to_numpy(float) for name in ACCEL]
    finite = [values[np.isfinite(values)] for values in columns]
    norm = float(np.linalg.norm([values.mean() if len(values) else np.nan for values in finite]))
    if not np.isfinite(norm):
        return None
    return Gravity(norm, norm - STANDARD_GRAVITY, gravity_unit(norm))


def gravity_unit(norm: float) -> str | None:
    """Return the unit in which ``norm`` is gravity within 25 %, or None.

    Local gravity, scale-factor errors of a few per cent and walking stay well within this range.
    """
    ratios = {unit: to_si(norm, unit) / STANDARD_GRAVITY for unit in ("m/s^2", "g", "mg", "ug")}
    return next((unit for unit, ratio in ratios.items() if 1 / GRAVITY_RATIO <= ratio <= GRAVITY_RATIO), None)


def lattice(levels: np.ndarray, samples: int, grain: float = 0.0) -> float | None:
    """Return the greatest common step of the distinct values ``levels``, sorted, shape (m,), of ``samples`` samples.

    The levels are exact to ``grain``, the last decimal of a text, or to the round-off where that is larger.

    Euclid's algorithm on all differences at once. Differences below the round-off (single, then double precision) are
    neglected. None (continuous values) if most samples are distinct, or if the step is below 100 times the round-off.
    """
    if 2 * len(levels) > samples:
        return None
    steps = np.diff(levels)
    for relative in ROUND_OFF:
        round_off = max(relative * np.abs(levels).max(initial=0.0), grain)
        apart = steps[steps > round_off]
        step = apart.min(initial=np.inf)
        while 100 * round_off < step < np.inf:
            multiples = np.rint(apart / step)
            rest = np.abs(apart - multiples * step)
            rest = rest[rest > round_off * (1 + multiples)]
            if not len(rest):
                return float(apart.sum() / multiples.sum())
            step = rest.min()
    return None


def repeats(values: np.ndarray) -> tuple[int, int, float, float]:
    """Return the longest run of exact repeats in ``values``, shape (n,), and its expectation for random repeats.

    A sample repeats its predecessor with probability p: that of its level, or of the whole log where the level is
    rare, estimated without the run itself. The expected number of runs of k repeats is at most ``n p^k``.

    Returns
    -------
    tuple
        Repeats in the longest run, index of its first sample, expected longest run, expected number of such runs.
    """
    equal = values[1:] == values[:-1]
    edges = np.flatnonzero(np.concatenate([[True], ~equal, [True]]))
    lengths = np.diff(edges) - 1
    longest, first = int(lengths.max()), int(edges[lengths.argmax()])
    at_level = values[:-1] == values[first]
    hits, trials = np.count_nonzero(equal & at_level), np.count_nonzero(at_level)
    if trials - longest < 100:
        hits, trials = np.count_nonzero(equal), len(equal)
    probability = (hits - longest + 1) / (trials - longest + 2)
    return longest, first, float(np.log(len(values)) / -np.log(probability)), float(len(values) * probability**longest)


def clipped(counts: np.ndarray) -> bool:
    """Return whether the lowest or the highest level holds too many samples for an unclipped signal.

    ``counts``, shape (m,), are those of the sorted levels. The largest mass at an unclipped edge is that of a sinusoid,
    whose last level has 1 / sqrt(k) of the mass of the last k, and more levels are nearer to it only where some are
    empty. False for fewer than 5 levels.
    """
    if len(counts) < max(EDGES):
        return False
    ends = counts, counts[::-1]
    return any(bdtrc(end[0] - 1, end[:k].sum(), k**-0.5) < IMPROBABLE for end in ends for k in EDGES)


def outlier_scores(values: np.ndarray, interval_s: float | None, step: float | None = None) -> np.ndarray:
    """Return the deviation of each of ``values``, shape (n,), from its surroundings in robust standard deviations.

    High-passed by the centred mean over :data:`HIGH_PASS_S`; NaN repeats the sample before it. The scale is the
    median absolute deviation, and at least the standard deviation of rounding to the lattice ``step``.
    """
    filled = _filled(values)
    width = int(np.clip(HIGH_PASS_S / interval_s, 3, max(3, len(values)))) if interval_s else 3
    high = filled - uniform_filter1d(filled, width, mode="nearest")
    high -= np.median(high)
    scale = max(MAD_TO_SD * np.median(np.abs(high)), (step or 0.0) / np.sqrt(12))
    rounding = np.finfo(float).eps * np.abs(filled).max()
    return high / scale if scale > rounding else np.zeros_like(high)


def outlier_limit(scores: np.ndarray) -> float:
    """Return the score that no sample of normal noise exceeds; ``scores`` >= 0, shape (n,).

    Real accelerometers have heavier tails than a Gaussian. The tail is taken as exponential beyond the 99th percentile
    of the scores, with the median excess there (Pickands 1975, peaks over threshold), which is insensitive to shocks;
    ``n/100 exp(-(limit - threshold)/scale) = IMPROBABLE``.
    """
    count = min(max(len(scores) // 100, 30), len(scores) - 1)
    tail = np.partition(scores, -count - 1)[-count - 1 :]
    threshold = tail[0]
    scale = np.median(tail[1:] - threshold) / np.log(2)
    return max(threshold + scale * np.log(count / IMPROBABLE), -ndtri(IMPROBABLE / (2 * len(scores))))


def events(outliers: dict[str, tuple[np.ndarray, np.ndarray]], time: np.ndarray) -> tuple[Shock, ...]:
    """Merge outliers on any axis, no more than :data:`HIGH_PASS_S` apart, into shocks.

    Parameters
    ----------
    outliers
        Axis to the rows of its outliers, increasing, and their scores, shape (m,) each.
    time
        Stamps [s], shape (n,).
    """
    names = list(outliers)
    rows = np.unique(np.concatenate([own for own, _ in outliers.values()]))
    if not len(rows):
        return ()
    sizes = np.zeros((len(names), len(rows)))
    for size, (own, scores) in zip(sizes, outliers.values(), strict=True):
        size[np.searchsorted(rows, own)] = scores
    cuts = np.flatnonzero(np.abs(np.diff(time[rows])) > HIGH_PASS_S) + 1
    found = []
    for group in np.split(np.arange(len(rows)), cuts):
        largest = sizes[:, group].max(axis=1)
        start, end = time[rows[group[[0, -1]]]]
        found.append(Shock(float(start), float(end), names[largest.argmax()], float(largest.max())))
    return tuple(found)


def _filled(values: np.ndarray) -> np.ndarray:
    """Replace every NaN by the number before it (after it at the start)."""
    return pd.Series(values).ffill().bfill().fillna(0.0).to_numpy()


def _axis(name, values, time, levels, counts, step, outliers) -> Axis:
    finite = ~np.isnan(values)
    known = {
        "axis": name,
        "nan": int(np.count_nonzero(~finite)),
        "lattice": step,
        "outliers": outliers,
    }
    if not len(levels):
        return Axis(**known)
    longest, first, expected, number = repeats(values[finite])
    return Axis(
        **known,
        longest_repeat=longest,
        expected_repeat=expected,
        repeat_s=float(time[finite][first]) if longest else None,
        stuck=bool(number < IMPROBABLE),
        minimum=float(levels[0]),
        minimum_count=int(counts[0]),
        maximum=float(levels[-1]),
        maximum_count=int(counts[-1]),
        saturated=bool(clipped(counts)),
    )

"""Detect and remove lines of varying frequency or amplitude, as of a machine of varying speed.

A search fits such a line by several steady ones, which disturb all other estimates. The narrow band is removed: its
cosine coefficients are replaced by random ones of the level around it, the band is reported as unexplained, and the
search is repeated. A band that is not narrow is not removed.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from scipy.fft import dct
from scipy.stats import chi2

from imugap.discovery.fit.axis_fit import AxisFit
from imugap.discovery.preparation.sequence import AxisSequence
from imugap.effects.effect import Effect
from imugap.stream import stream

MAX_DISTANCE = 5.0
"""Maximum distance of two lines that may be one wandering line [periods per log]."""
MAX_BAND_RATIO = 1.15
"""Maximum ratio of the ends of a narrow band."""
FLANK_RATIO = 1.4
"""Ratio of the ends of the flank that determines the level on one side of a band."""
STRIDE, MIN_POWER = 16, 2.0
"""Number of coefficients by which a band is widened, and minimum ratio of their power to the level for that."""
MAX_SHARE = 0.1
"""Maximum share of the coefficients that may be removed."""
CHI2_MEDIAN = 0.4549
"""Median of chi-square with one degree of freedom."""


@dataclass(frozen=True)
class Band:
    """Band of frequencies [Hz] of an unnamed line, and the log p-value of its power."""

    name: ClassVar[str] = "sinusoid"
    """Nearest name of the catalogue."""
    low: float
    high: float
    log_p: float

    @property
    def narrow(self) -> bool:
        """Return whether the band is narrow enough for a line."""
        return self.high < MAX_BAND_RATIO * self.low


def find_bands(found: AxisFit, steady: Callable[[int], bool] = lambda _: False) -> tuple[Band, ...]:
    """Return the narrow bands in which several lines of a fit describe one wandering line.

    ``steady`` says of the index of a term whether it keeps its amplitude and phase over the log. Two that do are not
    one line where one sweeps across the other.
    """
    resolution = 1 / (2 * found.sequence.conditions.interval * len(found.sequence.values))
    lowest = 2 * STRIDE / (MAX_BAND_RATIO - 1) * resolution
    grown = (_widened_band(found.sequence, *ends) for ends in _line_groups(found, steady) if ends[0] > lowest)
    narrow = tuple(band for band in grown if band.narrow)
    span = sum(band.high - band.low for band in narrow)
    return narrow if span < MAX_SHARE * 0.5 / found.sequence.conditions.interval else ()


def without_bands(sequence: AxisSequence, bands: tuple[Band, ...]) -> AxisSequence:
    """Replace the cosine coefficients in each band by random ones of the level around it."""
    coefficients = dct(sequence.values, norm="ortho")
    for band in bands:
        first, last = _coefficient_range(sequence, band.low, band.high)
        rng = stream(0, "unsteady", sequence.conditions.axis, first)
        level = _level(coefficients**2, first, last, np.arange(first, last))
        coefficients[first:last] = np.sqrt(level) * rng.standard_normal(last - first)
    return sequence.with_values(dct(coefficients, type=3, norm="ortho")) if bands else sequence


def _line_groups(found: AxisFit, steady: Callable[[int], bool]) -> Iterator[tuple[float, float]]:
    """Yield the lowest and the highest frequency [Hz] of each group of close tones, of two or more."""
    duration = found.sequence.conditions.interval * len(found.sequence.values)
    tones = [(index, term.effect) for index, term in enumerate(found.description.terms) if term.effect.tonal]
    tones.sort(key=lambda tone: tone[1].reach(duration))
    low, high = np.array([one.reach(duration) for _, one in tones]).reshape(-1, 2).T
    high = np.maximum.accumulate(high)
    breaks = 1 + np.flatnonzero(low[1:] > high[:-1] + MAX_DISTANCE / duration)
    for group in np.split(np.arange(len(tones)), breaks):
        some = [tones[place] for place in group]
        apart = _cross([one for _, one in some], duration) and all(steady(index) for index, _ in some)
        if len(group) > 1 and not apart:
            yield float(low[group[0]]), float(high[group[-1]])


def _cross(tones: Sequence[Effect], duration: float) -> bool:
    """Return whether there are two tones, and the lower one at the begin of a log is the higher one at its end."""
    if len(tones) != 2:
        return False
    begin, end = np.subtract(*(one.sweep(duration) for one in tones))
    return bool(begin * end < 0 and min(abs(begin), abs(end)) > MAX_DISTANCE / duration)


def _coefficient_range(sequence: AxisSequence, low: float, high: float) -> tuple[int, int]:
    """Return the index of the first and the last + 1 cosine coefficient between two frequencies [Hz]."""
    scale = 2 * len(sequence.values) * sequence.conditions.interval
    return max(int(low * scale), 1), min(int(np.ceil(high * scale)) + 1, len(sequence.values))


def _widened_band(sequence: AxisSequence, low: float, high: float) -> Band:
    """Return the band about frequencies [Hz], widened until its power falls to the level, and by as much again."""
    power = dct(sequence.values, norm="ortho") ** 2
    first, last = _coefficient_range(sequence, low, high)
    scale, ends = 2 * len(power) * sequence.conditions.interval, []
    for end, step in ((first, -STRIDE), (last, STRIDE)):
        start = end
        while 0 < end + step < len(power) and max(end / last, first / max(end, 1)) < MAX_BAND_RATIO:
            window = np.arange(*sorted((end, end + step)))
            if np.mean(power[window] / _level(power, first, last, window)) < MIN_POWER:
                break
            end += step
        ends.append(2 * end - start + step)
    inside = np.arange(first, last)
    log_p = chi2.logsf(np.sum(power[inside] / _level(power, first, last, inside)), len(inside))
    return Band(max(ends[0], 1) / scale, min(ends[1], len(power) - 1) / scale, float(log_p))


def _level(power: np.ndarray, first: int, last: int, at: np.ndarray) -> np.ndarray:
    """Return the level of the power at some coefficients, a power law between the flanks of a band."""
    low, high = int(first / MAX_BAND_RATIO), min(int(last * MAX_BAND_RATIO), len(power) - STRIDE)
    sides = (slice(max(int(low / FLANK_RATIO), 1), low), slice(high, max(int(high * FLANK_RATIO), high + STRIDE)))
    least = np.finfo(float).eps * power.max()  # what rounding leaves where there is no noise
    level = [max(np.median(power[side]) / CHI2_MEDIAN, least) for side in sides]
    return np.exp(np.interp(np.log(at), np.log([max(low, 1), high]), np.log(level)))

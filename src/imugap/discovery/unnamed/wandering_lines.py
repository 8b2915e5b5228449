"""Lines that are not steady: a machine whose speed wanders, a building that sways. No effect of the catalogue is one.

A search describes such a line by several steady ones side by side, and what it then says of all else is as doubtful as
they are. So the narrow band is taken out: its cosine coefficients give way to random ones of the level around, the band
is told as a place without a name, and the search starts again. A band that is not narrow stays.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from scipy.fft import dct
from scipy.stats import chi2

from imugap.discovery.fit.axis_fit import AxisFit
from imugap.discovery.preparation.sequence import AxisSequence
from imugap.stream import stream

NEAR = 5.0
"""Distance of two lines, in periods per log, below which they may be one that is not steady."""
WIDEST = 1.15
"""Largest ratio of the ends of a narrow band."""
FLANK = 1.4
"""Ratio of the ends of a band that tells the level on one side."""
STRIDE, LOUD = 16, 2.0
"""Coefficients by which a band grows while their power is above this many times the level."""
SHARE = 0.1
"""Largest share of the coefficients that may be taken out."""
MEDIAN = 0.4549
"""Median of chi-square with one degree of freedom."""


@dataclass(frozen=True)
class Band:
    """A band of frequencies [Hz] with a line that is not steady, and the log-probability of its power by chance."""

    name: ClassVar[str] = "sinusoid"
    """The nearest name of the vocabulary."""
    low: float
    high: float
    log_p: float

    @property
    def narrow(self) -> bool:
        """Return whether the band is that of a line."""
        return self.high < WIDEST * self.low


def bands(found: AxisFit) -> tuple[Band, ...]:
    """Return the bands of the lines of a fit that are several where one is meant, as far as their power reaches."""
    resolution = 1 / (2 * found.sequence.conditions.interval * len(found.sequence.values))
    lowest = 2 * STRIDE / (WIDEST - 1) * resolution
    grown = (_grown(found.sequence, group) for group in _groups(found) if len(group) > 1 and group[0] > lowest)
    narrow = tuple(band for band in grown if band.narrow)
    span = sum(band.high - band.low for band in narrow)
    return narrow if span < SHARE * 0.5 / found.sequence.conditions.interval else ()


def without(sequence: AxisSequence, taken: tuple[Band, ...]) -> AxisSequence:
    """Return the sequence with random coefficients of the level around in the place of those of each band."""
    coefficients = dct(sequence.values, norm="ortho")
    for band in taken:
        first, last = _places(sequence, band.low, band.high)
        rng = stream(0, "unsteady", sequence.conditions.axis, first)
        level = _level(coefficients**2, first, last, np.arange(first, last))
        coefficients[first:last] = np.sqrt(level) * rng.standard_normal(last - first)
    return sequence.with_values(dct(coefficients, type=3, norm="ortho")) if taken else sequence


def _groups(found: AxisFit) -> Iterator[list[float]]:
    """Yield the frequencies of lines that are near each other, in groups."""
    lines = sorted(one.frequency for one in found.description.effects() if one.line)
    near = NEAR / (found.sequence.conditions.interval * len(found.sequence.values))
    breaks = np.flatnonzero(np.diff(lines) > near) + 1
    yield from (group.tolist() for group in np.split(np.array(lines), breaks))


def _places(sequence: AxisSequence, low: float, high: float) -> tuple[int, int]:
    """Return the first and the last + 1 of the cosine coefficients between two frequencies [Hz]."""
    scale = 2 * len(sequence.values) * sequence.conditions.interval
    return max(int(low * scale), 1), min(int(np.ceil(high * scale)) + 1, len(sequence.values))


def _grown(sequence: AxisSequence, lines: list[float]) -> Band:
    """Return the band of lines, widened until its power is down at the level, and by as much again."""
    power = dct(sequence.values, norm="ortho") ** 2
    first, last = _places(sequence, lines[0], lines[-1])
    scale, ends = 2 * len(power) * sequence.conditions.interval, []
    for end, step in ((first, -STRIDE), (last, STRIDE)):
        start = end
        while 0 < end + step < len(power) and max(end / last, first / max(end, 1)) < WIDEST:
            window = np.arange(*sorted((end, end + step)))
            if np.mean(power[window] / _level(power, first, last, window)) < LOUD:
                break
            end += step
        ends.append(2 * end - start + step)
    inside = np.arange(first, last)
    log_p = chi2.logsf(np.sum(power[inside] / _level(power, first, last, inside)), len(inside))
    return Band(max(ends[0], 1) / scale, min(ends[1], len(power) - 1) / scale, float(log_p))


def _level(power: np.ndarray, first: int, last: int, at: np.ndarray) -> np.ndarray:
    """Return the level of the power at some coefficients, a power law between both sides of a band."""
    low, high = int(first / WIDEST), min(int(last * WIDEST), len(power) - STRIDE)
    sides = (slice(max(int(low / FLANK), 1), low), slice(high, max(int(high * FLANK), high + STRIDE)))
    level = [np.median(power[side]) / MEDIAN for side in sides]
    return np.exp(np.interp(np.log(at), np.log([max(low, 1), high]), np.log(level)))

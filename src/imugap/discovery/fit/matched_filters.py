"""Where in a residual an event or a line sits: matched filters over all places at once."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.fft import dct, idct, next_fast_len, rfft
from scipy.optimize import minimize
from scipy.special import ndtr

EDGE_SHARE, MAX_EDGE_SAMPLES = 0.02, 64
"""Share of the samples at each end at which no step is looked for, and their largest number.

There a sharp filter, whose past and future the log does not hold, makes what looks like one.
"""
MIN_STEP_SHARE = 1e-6
"""Share of a step that the other terms have to leave of it for it to be told from them."""
MIN_END_GAIN = 2.0
"""Gain of log-likelihood that a change of variance has to make by ending before the samples do."""
BAND_FREQUENCIES, BAND_HALVINGS = 256, 4
"""Frequencies of a band over which the level of the power is taken; how often it is halved towards zero."""
SWING_BLOCKS, MAX_SWING_FREQUENCY = 4096, 0.125
"""Blocks in which a swing of the variance is looked for, and the highest frequency, over the rate of the blocks."""
MIN_SWING_CYCLES, MAX_SWING_DEPTH = 0.5, 8.0
"""Least cycles of such a swing in the log, and its largest depth: of less the depth is not told from the mean."""
MAX_DELAY, MAX_LINE_POWER = 64, 9.0
"""Longest delay of an echo [samples], and the largest power of a coefficient by which it is searched, because of lines.
"""
STRETCH_BLOCKS = 400
"""Blocks of the search for stretches of another variance."""


@dataclass(frozen=True, eq=False)
class StepFilters:
    """Matched filters of a step of the mean at each sample.

    Attributes
    ----------
    gains
        Gain of log-likelihood of each, shape (n,); zero near the ends, where none is looked for.
    apart
        One less the correlation of each with the next one, shape (n,); zero near the ends.
    """

    gains: np.ndarray
    apart: np.ndarray

    def places(self, gain: float) -> float:
        """Return among how many independent places a step is the highest, if it gains so much.

        The tail of the highest of normal variables of such correlations, over that of one (Siegmund and Yakir 2007,
        The statistics of gene mapping, section 5.3).
        """
        x = 2 * np.sqrt(max(gain, 0.0) * np.maximum(self.apart, 1e-12))
        overshoot = 2 / x * (ndtr(x / 2) - 0.5) / (x / 2 * ndtr(x / 2) + np.exp(-(x**2) / 8) / np.sqrt(2 * np.pi))
        return float(1 + 2 * max(gain, 0.0) * np.sum(self.apart * overshoot))


def steps(coefficients: np.ndarray, variance: np.ndarray, basis: np.ndarray) -> StepFilters:
    """Return what a step of the mean gains at each sample, beside terms that are free to move.

    The step at sample t has the cosine coefficients -sqrt(2/n) sin(pi k t/n)/(2 sin(pi k/(2 n))), so that with the
    spectrum S its matched filter is a sum of the samples weighted by 1/S, and products of two such filters are cosine
    transforms.

    Parameters
    ----------
    coefficients
        Cosine coefficients k = 1..n-1 of the residual over their standard deviations.
    variance
        Variance of each.
    basis
        Orthonormal columns that the other terms may move the coefficients in, shape (n - 1, m).
    """
    n = len(coefficients) + 1
    share = _squares(n) / variance
    cosine = dct(np.r_[0.0, share, 0.0], type=1) / 2
    cosine = np.r_[cosine, cosine[-2:0:-1]]
    alone = np.maximum(0.5 * (share.sum() - cosine[::2]), 1e-300)
    norm, product = alone.copy(), 0.5 * (cosine[1] - cosine[1::2])
    for column in basis.T:
        along = _matched(column, variance)
        norm -= along**2
        product -= along * np.r_[along[1:], 0.0]
    edge = min(max(int(EDGE_SHARE * n), 8), MAX_EDGE_SAMPLES)
    told = norm > MIN_STEP_SHARE * alone
    told[:edge] = told[n - edge :] = False
    norm = np.where(told, norm, np.inf)
    gains, apart = 0.5 * _matched(coefficients, variance) ** 2 / norm, np.zeros(n)
    apart[:-1] = np.clip(1 - product[:-1] / np.sqrt(norm[:-1] * norm[1:]), 0.0, 2.0) * (told[:-1] & told[1:])
    return StepFilters(gains, apart)


@lru_cache(maxsize=4)
def _squares(n: int) -> np.ndarray:
    """Return the squared amplitudes, over its places, of the cosine coefficients of a unit step, shape (n - 1,)."""
    return 2 / n / (4 * np.sin(np.pi * np.arange(1, n) / (2 * n)) ** 2)


def _matched(coefficients: np.ndarray, variance: np.ndarray) -> np.ndarray:
    """Return the products of coefficients with those of a unit step at each sample, shape (n,)."""
    weighted = idct(np.r_[0.0, coefficients / np.sqrt(variance)], norm="ortho")
    return np.r_[0.0, -np.cumsum(weighted)[:-1]]


def ripples(coefficients: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Return size and gain of log-likelihood of an echo, to second order, by its delay of 1, 2, ... samples.

    The score of the size is the sum of (c^2 - 1) cos(pi k delay/n) over the cosine coefficients c that are used.

    Parameters
    ----------
    coefficients
        Whitened cosine coefficients k = 1, 2, ... that are used.
    count
        Number n of samples.
    """
    power = np.minimum(coefficients**2, MAX_LINE_POWER)
    excess = power - power.mean()
    scores = rfft(np.r_[0.0, excess], 2 * count).real[1 : MAX_DELAY + 1]
    return scores / len(excess), scores**2 / np.sum(excess**2)


def lines(whitened: np.ndarray, interval: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return frequencies [Hz], the gain of log-likelihood of a sinusoid at each, and the level of the power around it.

    The whitened residual is transformed over twice its length, so that a line between two frequencies of the log
    loses at most a tenth of its power. Gains are over the level: where the fit is off over a band, no line of it is
    more than its neighbours.
    """
    n = len(whitened)
    length = next_fast_len(2 * n, real=True)
    spectrum = rfft(whitened, length)
    power = (spectrum.real**2 + spectrum.imag**2) / n
    frequency = np.arange(len(power)) / (length * interval)
    first = np.searchsorted(frequency, 1.5 / (n * interval), side="right")
    inner = slice(first, np.searchsorted(frequency, (0.5 - 1.0 / n) / interval))
    level = _level(power[inner])
    return frequency[inner], power[inner] / level, level


def _level(power: np.ndarray) -> np.ndarray:
    """Return the level of exponentially distributed power around each frequency, at least 1, shape (n,).

    It is taken from medians of bands, three standard deviations below them, and is 1 where that is less.
    """
    even = len(power) // BAND_FREQUENCIES
    if even < 2:
        return np.full(len(power), max(np.median(power) / (np.log(2) + 3 * np.sqrt(2 / len(power))), 1.0))
    number = np.r_[
        BAND_FREQUENCIES // 2**BAND_HALVINGS,
        [BAND_FREQUENCIES // 2**k for k in range(BAND_HALVINGS, 0, -1)],
        np.full(even - 1, BAND_FREQUENCIES),
    ]
    finer = np.split(power[:BAND_FREQUENCIES], np.cumsum(number[:BAND_HALVINGS]))
    coarse = np.median(power[BAND_FREQUENCIES : even * BAND_FREQUENCIES].reshape(-1, BAND_FREQUENCIES), axis=1)
    medians = np.r_[[np.median(band) for band in finer], coarse]
    number[-1] += len(power) - even * BAND_FREQUENCIES
    return np.repeat(np.maximum(medians / (np.log(2) + 3 * np.sqrt(2 / number)), 1.0), number)


def stretches(whitened: np.ndarray) -> tuple[float, int, int]:
    """Return the largest gain of log-likelihood that one stretch of another variance makes, and its first and last + 1.

    Stretches of whole blocks first, then the ends to the sample. One that may as well last to an end of the samples
    does.
    """
    n = len(whitened)
    width = max(n // STRETCH_BLOCKS, 8)
    blocks = n // width
    energy = np.r_[0.0, np.cumsum(whitened[: blocks * width].reshape(blocks, width) ** 2 @ np.ones(width))]
    first, last = np.triu_indices(blocks + 1, 1)
    gain = _change_gain(energy[last] - energy[first], (last - first) * width, energy[-1], blocks * width)
    best = int(np.argmax(gain))
    start, stop = int(first[best]) * width, int(last[best]) * width
    squares = np.r_[0.0, np.cumsum(whitened**2)]
    for _ in range(2):
        start = _refined(squares, start, stop, width, side=0)
        stop = _refined(squares, start, stop, width, side=1)
    ends = [(start, stop), *((a, b) for a, b in ((start, n), (0, stop)) if 0 < b - a < n)]
    gains = [float(_change_gain(squares[b] - squares[a], b - a, squares[-1], n)) for a, b in ends]
    lasting = int(np.argmax(gains[1:])) + 1 if len(ends) > 1 else 0
    chosen = lasting if gains[lasting] > gains[0] - MIN_END_GAIN else 0
    return gains[chosen], *ends[chosen]


def swing(whitened: np.ndarray, time: np.ndarray) -> tuple[float, float, float, float]:
    """Return frequency [Hz], depth, phase and gain of log-likelihood of the likeliest swing of the log-variance.

    It starts at the highest line of the mean squares of blocks; the log-variance is c + depth cos(2 pi f t + phase).
    """
    width = max(len(whitened) // SWING_BLOCKS, 1)
    squares, middle = (block_means(values, width) for values in (whitened**2, time))
    frequency, gains, _ = lines((squares - squares.mean()) / max(squares.std(), 1e-300), middle[1] - middle[0])
    slow = frequency < MAX_SWING_FREQUENCY / (middle[1] - middle[0])
    coarse = float(frequency[slow][np.argmax(gains[slow])])
    seconds, mean = middle - middle.mean(), squares.mean()

    def cost(theta: np.ndarray) -> tuple[float, np.ndarray]:
        angle = 2 * np.pi * (coarse + theta[3] / seconds[-1]) * seconds
        columns = np.array([np.ones(len(seconds)), np.cos(angle), np.sin(angle)])
        level = theta[:3] @ columns
        relative = squares * np.exp(-level)
        moved = (theta[2] * columns[1] - theta[1] * columns[2]) * 2 * np.pi * seconds / seconds[-1]
        return 0.5 * np.mean(level + relative), 0.5 * np.mean((1 - relative) * [*columns, moved], axis=1)

    wave = 2 * np.mean(squares * np.exp(-2j * np.pi * coarse * seconds)) / mean
    lowest = MIN_SWING_CYCLES / (time[-1] - time[0])
    ends = (
        (None, None),
        (-MAX_SWING_DEPTH, MAX_SWING_DEPTH),
        (-MAX_SWING_DEPTH, MAX_SWING_DEPTH),
        ((lowest - coarse) * seconds[-1], None),
    )
    start = [np.log(mean), wave.real, -wave.imag, max(ends[3][0], 0.0)]
    best = minimize(cost, start, jac=True, method="L-BFGS-B", bounds=ends)
    gain = width * len(squares) * (0.5 * (np.log(mean) + 1) - best.fun)
    found = coarse + best.x[3] / seconds[-1]
    phase = np.angle(complex(best.x[1], -best.x[2]) * np.exp(-2j * np.pi * found * middle.mean()))
    return float(max(found, 0.0)), float(np.hypot(*best.x[1:3])), float(phase), float(gain)


def block_means(values: np.ndarray, width: int) -> np.ndarray:
    """Return the means of blocks of ``width`` values, without the incomplete one at the end."""
    return values[: len(values) // width * width].reshape(-1, width).mean(axis=1)


def _refined(squares: np.ndarray, start: int, stop: int, width: int, side: int) -> int:
    n = len(squares) - 1
    end = (start, stop)[side]
    if end in (0, n):
        return end
    trial = np.arange(
        max(end - width, 0 if side == 0 else start + 2), min(end + width, stop - 2 if side == 0 else n) + 1
    )
    inside = squares[stop] - squares[trial] if side == 0 else squares[trial] - squares[start]
    count = stop - trial if side == 0 else trial - start
    return int(trial[np.argmax(_change_gain(inside, count, squares[-1], n))])


def _change_gain(inside, count, total, n):
    """Return the gain of two variances over one: sums of squares inside a stretch of ``count`` of ``n`` samples."""
    outside, rest = np.maximum(total - inside, 1e-300), n - count
    with np.errstate(divide="ignore", invalid="ignore"):
        gain = 0.5 * (
            n * np.log(total / n)
            - count * np.log(np.maximum(inside, 1e-300) / count)
            - np.where(rest > 0, rest * np.log(outside / np.maximum(rest, 1)), 0.0)
        )
    return np.where((rest < 8) | (count < 8), 0.0, gain)

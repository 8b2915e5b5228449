"""Detect tone bursts: excess power in cells of time and frequency, of a tone that wanders, is intermittent, or decays.

The whitened residual of a correct fit is stationary white noise: the powers of cells of time and frequency are
independent exponential variables. The statistic is the ratio of the power of a cell to the median of the cells of the
same time at near frequencies, so that neither a shock nor a small error of the spectrum raises it, and to the median
over time at a steady line. The median of m exponential variables is a sum of such variables
(Renyi 1953, Acta Mathematica Hungarica 4, 191-231), which makes the probability of the ratio known.
"""

import numpy as np
from scipy.fft import rfft
from scipy.stats import binom

from imugap.discovery.fit.axis_fit import AxisFit
from imugap.discovery.unnamed.wandering_lines import Band

LENGTHS = tuple(2**k for k in range(8, 13))
"""Lengths of a segment [samples]."""
MIN_SEGMENTS = 8
"""Minimum number of segments."""
NEIGHBOURS = 129
"""Number of frequencies of the same time, the cell included, for the median."""
FIRST_FREQUENCY = 43
"""Minimum frequency [periods per segment]; below it a step raises single cells."""
MAX_STEADY_POWER = 1.8
"""Maximum median power over the segments of a frequency without a steady line."""
CELL_LOG_PS = np.log([1e-2, 1e-3, 1e-4])
"""Levels of log-probability below which cells are counted."""
MAX_LOG_P = -30.0
"""Maximum log p-value for a detection; well-described steps reach -15."""
ISOLATION_MARGIN = 3.0
"""Margin in log-probability below one expected cell for the cells of the band."""


def find_tone_bursts(found: AxisFit) -> tuple[Band, ...]:
    """Return the band [Hz] of the cells of the whitened residual of a fit with significant excess power, if any.

    Values on a coarse lattice are not tested: their residual is that of the rounding.
    """
    if found.sequence.coarse:
        return ()
    whitened, interval = found.whitened, found.sequence.conditions.interval
    used = found.sequence.bins.last / len(whitened)
    lengths = [
        n
        for n in LENGTHS
        if len(whitened) >= MIN_SEGMENTS * n and _last_frequency(n, used) - FIRST_FREQUENCY >= NEIGHBOURS // 2
    ]
    bands = [loudest_band(cell_log_p(whitened, length, used), length * interval) for length in lengths]
    trials = np.log(max(len(lengths), 1) * (len(CELL_LOG_PS) + 1))
    loud = [band for band in bands if band.log_p + trials < MAX_LOG_P]
    if not loud:
        return ()
    low, high, log_p = min(band.low for band in loud), max(band.high for band in loud), min(band.log_p for band in loud)
    return (Band(float(low), float(high), log_p),)


def cell_log_p(whitened: np.ndarray, length: int, used: float) -> np.ndarray:
    """Return the log-probability of the power of each cell, shape (segments, frequencies).

    ``used`` is the fraction of the frequencies, from zero, that the fit uses.
    """
    segments, last = len(whitened) // length, _last_frequency(length, used)
    power = np.abs(rfft(whitened[: segments * length].reshape(segments, length), axis=1)[:, FIRST_FREQUENCY:last]) ** 2
    steady = np.median(power, axis=0) / power.mean()
    power /= np.where(steady > MAX_STEADY_POWER, steady, 1.0)
    return np.hstack(
        [_ratio_log_p(part) for part in np.array_split(power, max((last - FIRST_FREQUENCY) // NEIGHBOURS, 1), axis=1)]
    )


def _last_frequency(length: int, used: float) -> int:
    """Return the index of the last used frequency of a segment, + 1."""
    return int(used * (length // 2)) - 1


def _ratio_log_p(power: np.ndarray) -> np.ndarray:
    """Return the log-probability of the ratio of each cell to the median of the cells of its time.

    With the median M of m others, sum_j E_j/(m - j), it is E[exp(-x M)] = prod_j (m - j)/(m - j + x).
    """
    others = power.shape[1] - 1
    ratio = power / np.median(power, axis=1, keepdims=True)
    grid = np.r_[0.0, np.geomspace(1e-2, max(ratio.max(), 1.0), 2000)]
    log_p = -np.sum(np.log1p(grid / np.arange(others, others // 2 - 1, -1)[:, None]), axis=0)
    return np.interp(ratio, grid, log_p)


def loudest_band(log_p: np.ndarray, duration: float) -> Band:
    """Return the band [Hz] of the strongest cells of segments of a duration [s], and its log p-value."""
    count = log_p.size
    many = [binom.logsf(np.count_nonzero(log_p < level) - 1, count, np.exp(level)) for level in CELL_LOG_PS]
    least = min(float(log_p.min() + np.log(count)), *map(float, many))
    loud = np.flatnonzero((log_p < -np.log(count) - ISOLATION_MARGIN).any(axis=0))
    first, last = (loud[0], loud[-1]) if len(loud) else (0, log_p.shape[1] - 1)
    return Band((FIRST_FREQUENCY + first - 0.5) / duration, (FIRST_FREQUENCY + last + 0.5) / duration, min(least, 0.0))

"""Power at a time and a frequency where steady noise has none: a tone that wanders, comes and goes, or rings.

The whitened residual of a right fit is white, and stays so for all time: the power of a cell of time and frequency is
an exponential variable, whatever its neighbours are. A cell is held against the median of the cells of the same time
and near frequencies, so that neither a shock nor a spectrum that is slightly off makes it loud, and against that of
its frequency over all time where a steady line is. The median of m exponential variables is a sum of such variables
(Renyi 1953, Acta Mathematica Hungarica 4, 191-231), which makes the probability of the ratio known.
"""

import numpy as np
from scipy.fft import rfft
from scipy.stats import binom

from imugap.discovery.fit.axis_fit import AxisFit
from imugap.discovery.unnamed.wandering_lines import Band

LENGTHS = tuple(2**k for k in range(8, 13))
"""Samples of a segment."""
SEGMENTS = 8
"""Least number of segments."""
NEAR = 129
"""Frequencies of the same time, itself among them, that a cell is held against."""
LOWEST = 43
"""Frequency, in periods of a segment, from which on cells are held against others: below, a jump is no shock."""
STEADY = 1.8
"""Median power over the segments above which a frequency has a steady line."""
LEVELS = np.log([1e-2, 1e-3, 1e-4])
"""Log-probabilities below which cells are counted."""
CERTAIN = -30.0
"""Log-probability of chance below which the residual is no steady noise: jumps that are well described reach -15."""
ALONE = 3.0
"""Logarithm of the number of cells among which a loud one is alone by chance."""


def glints(found: AxisFit) -> tuple[Band, ...]:
    """Return the band of the cells of the residual of a fit that are too loud or too many for certain, if any.

    The residual of values on a coarse lattice is that of their rounding, and is not asked.
    """
    if found.sequence.coarse:
        return ()
    whitened, interval = found.whitened, found.sequence.conditions.interval
    used = found.sequence.bins.last / len(whitened)
    lengths = [n for n in LENGTHS if len(whitened) >= SEGMENTS * n and _last(n, used) - LOWEST >= NEAR // 2]
    bands = [loudest_band(cell_log_p(whitened, length, used), length * interval) for length in lengths]
    trials = np.log(max(len(lengths), 1) * (len(LEVELS) + 1))
    loud = [band for band in bands if band.log_p + trials < CERTAIN]
    if not loud:
        return ()
    low, high, log_p = min(band.low for band in loud), max(band.high for band in loud), min(band.log_p for band in loud)
    return (Band(float(low), float(high), log_p),)


def cell_log_p(whitened: np.ndarray, length: int, used: float) -> np.ndarray:
    """Return the log-probability of the power of each cell, shape (segments, frequencies).

    Of a share ``used`` of the frequencies, above which the fit asks nothing.
    """
    segments, last = len(whitened) // length, _last(length, used)
    power = np.abs(rfft(whitened[: segments * length].reshape(segments, length), axis=1)[:, LOWEST:last]) ** 2
    steady = np.median(power, axis=0) / power.mean()
    power /= np.where(steady > STEADY, steady, 1.0)
    return np.hstack([_above(part) for part in np.array_split(power, max((last - LOWEST) // NEAR, 1), axis=1)])


def _last(length: int, used: float) -> int:
    """Return the number of the last frequency of a segment that is used, + 1."""
    return int(used * (length // 2)) - 1


def _above(power: np.ndarray) -> np.ndarray:
    """Return the log-probability that a cell exceeds the median of those of its time as it does.

    That of a median M of m others, sum_j E_j/(m - j), is E[exp(-x M)] = prod_j (m - j)/(m - j + x).
    """
    others = power.shape[1] - 1
    ratio = power / np.median(power, axis=1, keepdims=True)
    grid = np.r_[0.0, np.geomspace(1e-2, max(ratio.max(), 1.0), 2000)]
    log_p = -np.sum(np.log1p(grid / np.arange(others, others // 2 - 1, -1)[:, None]), axis=0)
    return np.interp(ratio, grid, log_p)


def loudest_band(log_p: np.ndarray, duration: float) -> Band:
    """Return the band of the loudest cells of segments of so long [s], and how likely chance makes as much of all."""
    count = log_p.size
    many = [binom.logsf(np.count_nonzero(log_p < level) - 1, count, np.exp(level)) for level in LEVELS]
    least = min(float(log_p.min() + np.log(count)), *map(float, many))
    loud = np.flatnonzero((log_p < -np.log(count) - ALONE).any(axis=0))
    first, last = (loud[0], loud[-1]) if len(loud) else (0, log_p.shape[1] - 1)
    return Band((LOWEST + first - 0.5) / duration, (LOWEST + last + 0.5) / duration, min(least, 0.0))

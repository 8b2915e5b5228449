"""Likelihood gain of a periodic mean of any shape: a fundamental and its harmonics.

The catalogue has a sinusoid and a comb of few harmonics. A sawtooth or a relaxation oscillation imitates telegraph or
slow noise; its harmonics, which share one frequency, distinguish it.
"""

import numpy as np
from scipy.fft import next_fast_len, rfft

from imugap.discovery.fit.axis_fit import AxisFit
from imugap.discovery.fit.matched_filters import block_means

MIN_PERIODS, MAX_PERIODS = 3, 100
"""Minimum and maximum number of periods in a log; of more, the search finds each harmonic as a line."""
HARMONICS = 4
OVERSAMPLING = 8
"""Frequencies per resolution width of the log."""
MEANS_PER_PERIOD = 32
"""Number of block means per period of the highest harmonic, for a log of more samples."""
PARAMETERS = 2 * HARMONICS + 1
"""Number of parameters: two of each harmonic, and the frequency."""
TRIALS = HARMONICS * (MAX_PERIODS - MIN_PERIODS)
"""Number of independent frequencies (Bonferroni)."""


def gain(fit: AxisFit) -> float:
    """Return the log-likelihood gain of the best periodic term."""
    width = max(len(fit.whitened) // (MEANS_PER_PERIOD * HARMONICS * MAX_PERIODS), 1)
    coarse = block_means(fit.whitened, width)
    length = next_fast_len(OVERSAMPLING * len(coarse), real=True)
    power = np.abs(rfft(coarse, length)) ** 2
    bins = np.arange(MIN_PERIODS * OVERSAMPLING, MAX_PERIODS * OVERSAMPLING)
    bins = bins[HARMONICS * bins < len(power)]
    if not len(bins):
        return 0.0
    best = bins[np.argmax(sum(power[k * bins] for k in range(1, HARMONICS + 1)))]
    spacing = 1 / (length * width * fit.sequence.conditions.interval)
    return max(gain_at(near * spacing, fit) for near in best + np.linspace(-0.5, 0.5, 5))


def gain_at(frequency: float, fit: AxisFit) -> float:
    """Return the log-likelihood gain of a periodic term of ``frequency`` [Hz]."""
    angle = 2 * np.pi * frequency * fit.sequence.conditions.time
    columns = [part(k * angle) for k in range(1, HARMONICS + 1) for part in (np.cos, np.sin)]
    return fit.joint_gain(fit.whiten(np.column_stack(columns)))[0]

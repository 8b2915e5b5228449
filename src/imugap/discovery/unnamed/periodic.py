"""Waves: a mean that repeats itself after a period, in whatever shape.

No effect of the catalogue is one. A sawtooth or a relaxation oscillation jumps and wanders over a log like telegraph or
slow noise, and as such it would be named: a fundamental and its next harmonics, all of one frequency, tell.
"""

import numpy as np
from scipy.fft import next_fast_len, rfft

from imugap.discovery.fit.axis_fit import AxisFit
from imugap.discovery.fit.matched_filters import means

FEWEST, MOST = 3, 100
"""Periods in a log: of fewer nothing is known to repeat, and more make lines that are found one by one."""
HARMONICS = 4
FINER = 8
"""Frequencies tried per period in the log."""
FINE = 32
"""Means of the log that are taken per period of the highest harmonic, of a log that has more samples."""
MORE = 2 * HARMONICS + 1
"""Parameters of a wave: two of each harmonic, and the frequency."""
TRIALS = HARMONICS * (MOST - FEWEST)
"""Independent frequencies."""


def gain(fit: AxisFit) -> float:
    """Return the gain of log-likelihood by the best wave."""
    width = max(len(fit.whitened) // (FINE * HARMONICS * MOST), 1)
    coarse = means(fit.whitened, width)
    length = next_fast_len(FINER * len(coarse), real=True)
    power = np.abs(rfft(coarse, length)) ** 2
    bins = np.arange(FEWEST * FINER, MOST * FINER)
    bins = bins[HARMONICS * bins < len(power)]
    if not len(bins):
        return 0.0
    best = bins[np.argmax(sum(power[k * bins] for k in range(1, HARMONICS + 1)))]
    spacing = 1 / (length * width * fit.sequence.conditions.interval)
    return max(gain_at(near * spacing, fit) for near in best + np.linspace(-0.5, 0.5, 5))


def gain_at(frequency: float, fit: AxisFit) -> float:
    """Return the gain in log-likelihood of a periodic term with harmonics at ``frequency`` [Hz]."""
    angle = 2 * np.pi * frequency * fit.sequence.conditions.time
    wave = [part(k * angle) for k in range(1, HARMONICS + 1) for part in (np.cos, np.sin)]
    return fit.joint_gain(fit.whiten(np.column_stack(wave)))[0]

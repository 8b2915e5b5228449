"""Fractionally integrated white noise as a sum of first-order autoregressive processes, and filters of least phase.

A process of PSD |2 sin(pi f)|^(-2 d), f in cycles per sample, has no model of finite order. With 0 < d < 1 the PSD is a
mixture of those of first-order processes, so that a sum of few of them, with correlation times evenly spaced on a log
axis, approximates it over many decades. Source of the process: Hosking 1981, Biometrika 68, 165-176.
"""

from functools import lru_cache

import numpy as np
from scipy.fft import irfft, next_fast_len, rfft
from scipy.optimize import nnls

LOWEST = 1e-7
"""Lowest frequency [cycles per sample] down to which a bank has the spectrum: 28 hours of samples at 100 Hz."""
PER_DECADE = 2.5
"""Processes per decade: the PSD is approximated to half a percent."""
FIT = 40
"""Frequencies per decade at which a bank is fitted."""
NEGLIGIBLE = 1e-7
"""Share of the energy of a filter of least phase that is left out."""


@lru_cache(maxsize=16)
def fractional_bank(order: float, lowest: float = LOWEST) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Return decays per sample, exp(-1/correlation time), and standard deviations of the processes of a sum.

    Its PSD is |2 sin(pi f)|^(-2 d).

    Parameters
    ----------
    order
        d, between 0 and 1, both excluded.
    lowest
        Frequency down to which it has this spectrum [cycles per sample].
    """
    decades = np.log10(0.5 / lowest)
    frequency = np.geomspace(lowest, 0.5, int(FIT * decades))
    decays = np.exp(-2 * np.pi * np.geomspace(lowest / 2, 1.5, int(PER_DECADE * decades) + 2))
    squared = 4 * np.sin(np.pi * frequency) ** 2
    spectra = (1 - decays**2) / ((1 - decays) ** 2 + decays * squared[:, None])
    columns = np.column_stack([spectra, np.ones(len(frequency))]) * squared[:, None] ** order
    variances, _ = nnls(columns, np.ones(len(frequency)), maxiter=100 * columns.shape[1])
    kept = variances > 0
    stds = np.sqrt(variances[kept])
    return tuple(np.r_[decays, 0.0][kept].tolist()), tuple(stds.tolist())


def least_phase(gain: np.ndarray) -> np.ndarray:
    """Return the weights of the causal filter of least phase with a power gain, by the cepstrum.

    Parameters
    ----------
    gain
        Power gain at ``len(gain)`` frequencies, evenly spaced from 0 to half the rate, above 0.

    Source: Oppenheim and Schafer 2010, Discrete-Time Signal Processing, sec. 13.5.
    """
    length = 2 * (len(gain) - 1)
    cepstrum = irfft(0.5 * np.log(gain), length)
    cepstrum[1 : length // 2] *= 2
    cepstrum[length // 2 + 1 :] = 0.0
    weights = irfft(np.exp(rfft(cepstrum)), length)
    left = np.cumsum(weights[::-1] ** 2)[::-1]
    return weights[: max(int(np.argmax(left < NEGLIGIBLE * left[0])), 1)]


def frequencies(count: int) -> np.ndarray:
    """Return ``count`` or more frequencies for :func:`least_phase` [cycles per sample]."""
    return np.linspace(0.0, 0.5, next_fast_len(max(count, 2), real=True) + 1)

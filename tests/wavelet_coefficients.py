"""Compute wavelet coefficients by their definition."""

import numpy as np

from imugap.numerics.spectra.daubechies import filters


def by_definition(sequence, level, width):
    """Boundary-free coefficients as inner products with the filter of the level, built by upsampled convolution."""
    high, low = filters(width)
    taps = np.ones(1)
    for j in range(level):
        stretched = np.zeros((width - 1) * 2**j + 1)
        stretched[:: 2**j] = high if j == level - 1 else low
        taps = np.convolve(taps, stretched)
    return np.convolve(sequence, taps, "valid")

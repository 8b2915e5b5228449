"""Daubechies wavelet filters of extremal phase for the maximal-overlap transform, and their gains."""

from functools import lru_cache
from math import comb

import numpy as np
from numpy.polynomial.polynomial import polyval

WIDTHS = (2, 4, 6, 8)
"""Widths of the filters D2 (Haar), D4, D6, D8."""


def check(width: int) -> None:
    """Raise ValueError unless there are filters of ``width``."""
    if width not in WIDTHS:
        raise ValueError(f"wavelet: expected a width among {', '.join(map(str, WIDTHS))}; found {width}")


@lru_cache
def filters(width: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the wavelet and the scaling filter of the MODWT, each shape (width,); the scaling filter sums to 1.

    Spectral factorisation (Daubechies 1988): the squared gain of the scaling filter is cos^L times the polynomial in
    y = sin^2 = (2 - z - 1/z)/4 of :func:`gains`; of each pair of roots z, 1/z the one inside the unit circle is
    taken. The wavelet filter is h_l = (-1)^l g_(L-1-l) (Percival & Walden 2000, eq. 75a, section 4.8).
    """
    check(width)
    middle = 1 - 2 * np.roots(_binomials(width)[::-1]).astype(complex)
    root = middle + np.sqrt(middle**2 - 1)
    inside = np.where(np.abs(root) < 1, root, 1 / root)
    scaling = np.poly(np.r_[-np.ones(width // 2), inside]).real
    scaling /= scaling.sum()
    wavelet = scaling[::-1] * (-1.0) ** np.arange(width)
    scaling.flags.writeable = wavelet.flags.writeable = False
    return wavelet, scaling


def length(level: int, width: int = 2) -> int:
    """Return the number of samples in the filter of ``level`` (Percival & Walden 2000, eq. 96a)."""
    return (2**level - 1) * (width - 1) + 1


def depth(count: int, width: int = 2) -> int:
    """Return the deepest level with a coefficient free of boundary effects in ``count`` samples."""
    check(width)
    return int(np.log2((count - 1) // (width - 1) + 1))


def free(count: int, levels: int, width: int = 2) -> np.ndarray:
    """Return the number M_j of coefficients of each level free of boundary effects, shape (levels,)."""
    return np.array([count - length(level, width) + 1 for level in range(1, levels + 1)])


def gains(cycles: np.ndarray, width: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the squared gains of the wavelet and the scaling filter (Percival & Walden 2000, eq. 105a)."""
    angle, binomials = np.pi * (cycles % 1), _binomials(width)
    sine, cosine = np.sin(angle) ** 2, np.cos(angle) ** 2
    return sine ** (width // 2) * polyval(cosine, binomials), cosine ** (width // 2) * polyval(sine, binomials)


def squared_gain(cycles: np.ndarray, level: int, width: int = 2) -> np.ndarray:
    """Return |H_j|^2 at ``cycles`` [1/sample]: |H|^2 at 2^(j-1) f times |G|^2 at all 2^l f, l < j - 1."""
    gain = gains(2.0 ** (level - 1) * cycles, width)[0]
    for octave in range(level - 1):
        gain = gain * gains(2.0**octave * cycles, width)[1]
    return gain


def transfer(cycles: np.ndarray, levels: int, width: int = 2) -> np.ndarray:
    """Return the transfer functions H_j at ``cycles`` [1/sample], shape (levels, n)."""
    high, low = filters(width)
    result = np.empty((levels, len(cycles)), complex)
    smooth = np.ones(len(cycles))
    for level in range(levels):
        delay = np.exp(-2j * np.pi * ((2.0**level * cycles) % 1))
        result[level] = smooth * polyval(delay, high)
        smooth = smooth * polyval(delay, low)
    return result


def _binomials(width: int) -> np.ndarray:
    return np.array([comb(width // 2 - 1 + k, k) for k in range(width // 2)], float)

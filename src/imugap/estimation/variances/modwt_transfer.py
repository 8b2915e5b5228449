"""Wavelet variances implied by a spectrum, and the covariances of wavelet coefficients, to rounding.

A spectrum is taken on Gauss-Legendre nodes in each octave below half a cycle per sample. Level j of the filter cascade
repeats j - 1 times: filter and take every other sample, which folds the spectrum onto one octave less, S'(f) =
(|G(f/2)|^2 S(f/2) + |G(1/2 - f/2)|^2 S(1/2 - f/2))/2, and |G(1/2 - f)|^2 = |H(f)|^2. The halves f/2 are nodes of the
next octave; 1/2 - f/2 lies in the top one, where the spectrum is interpolated. All this is linear: it is done once,
backwards, on the weights of the quadrature, so no lobe of a deep level is ever resolved.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.polynomial.legendre import leggauss
from scipy.fft import ifft, next_fast_len
from scipy.interpolate import BarycentricInterpolator

from imugap.numerics.spectra.daubechies import free, gains, transfer

NODES = 24
NODE, WEIGHT = leggauss(NODES)
BELOW = 45
"""Octaves of the spectrum below the deepest level; lower frequencies contribute less than 1e-12."""
APART = 3
"""Halvings of the sampling rate between the smoothed sequence and the first level computed on it."""

PERIODS = 4
"""Length of the transform in lengths of the sequence, so that wrap-around is negligible."""

PSD = Callable[[np.ndarray], np.ndarray]
"""Power spectral density at cycles per sample; its integral over one cycle is the variance."""


def passed(psd: PSD, levels: int, width: int = 2) -> np.ndarray:
    """Return the integrals of |H_j|^2 S over one cycle, shape (levels,): the wavelet variances, to rounding."""
    return _single(levels, width) @ psd(_nodes(levels + BELOW).ravel())


def overlap(psd: PSD, levels: int, width: int = 2) -> np.ndarray:
    """Return the integrals of |H_i|^2 |H_j|^2 S^2 over one cycle, shape (levels, levels), to rounding.

    They are the sums over all lags of the squared cross-covariances of the coefficients of levels i and j.
    """
    return _symmetric(_pairs(levels, width) @ psd(_nodes(levels + BELOW).ravel()) ** 2)


def counted(psd: PSD, count: int, levels: int, width: int, halvings: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the sums of the cross-covariances s_ij of the coefficients of the deepest levels over ``count`` samples.

    Every 2^halvings-th scaling coefficient V_halvings replaces the sequence, for the m levels above ``halvings`` +
    :data:`APART`; without halvings the sequence itself, for all levels.

    Returns
    -------
    share
        Sum of s_ij^2 over all pairs of coefficients, over min(M_i, M_j) times the sum over all lags, shape (m, m).
    means
        Covariance of the mean coefficients of two levels, shape (m, m).
    """
    lags = _lags(count, levels, halvings, width)
    cross = lags.covariances(_smooth(psd, lags.cycles, halvings, width))
    seen = np.where(lags.lag < 0, -1, 1) * cross[:, lags.lag]  # between the harmonics a period turns the sign
    power = np.maximum(np.einsum("kl,kl->k", cross, cross), np.finfo(float).tiny)  # 0 without noise, as the sum is
    squares = np.einsum("kl,kl,kl->k", lags.pairs, seen, seen) / power
    means = 2**halvings * np.einsum("kl,kl->k", lags.pairs, seen)
    return _symmetric(squares), _symmetric(means / lags.number)


@lru_cache
def _nodes(octaves: int) -> np.ndarray:
    """Return the nodes [cycles per sample], one row for each octave downwards from 1/4 to 1/2."""
    return (3 + NODE) / 8 * 2.0 ** -np.arange(octaves)[:, None]


@lru_cache
def _interpolation(octaves: int) -> np.ndarray:
    """Return the weights of the top octave's nodes for 1/2 - f/2, shape (octaves - 1, NODES, NODES)."""
    return _interpolant(np.eye(NODES))(0.5 - _nodes(octaves)[1:])


def _interpolant(values: np.ndarray) -> BarycentricInterpolator:
    """Return the polynomial of these values at the nodes of the top octave.

    Its weights are those of Gauss-Legendre nodes (Wang, Xiang 2012, Mathematics of Computation 81, 861-877); without
    them they would be multiplied out in an order drawn at random, and differ in the last digits from call to call.
    """
    signs = (-1.0) ** np.arange(NODES)
    return BarycentricInterpolator(_nodes(1)[0], values, wi=signs * np.sqrt((1 - NODE**2) * WEIGHT))


def _fold(spectrum: np.ndarray, width: int) -> np.ndarray:
    """Return the spectrum of every other scaling coefficient of level 1, on one octave less."""
    high, low = gains(_nodes(len(spectrum))[1:], width)
    return (low * spectrum[1:] + high * (_interpolation(len(spectrum)) @ spectrum[0])) / 2


def _unfold(weights: np.ndarray, direct: np.ndarray, mirrored: np.ndarray) -> np.ndarray:
    """Return quadrature weights before a fold from those after it, shape (..., octaves, NODES) -> one octave more.

    ``direct`` and ``mirrored`` are the squared gains at f/2 and at 1/2 - f/2.
    """
    octaves = weights.shape[-2] + 1
    top = np.einsum("...on,onm->...m", mirrored * weights, _interpolation(octaves))
    return np.concatenate([top[..., None, :], direct * weights], axis=-2) / 2


def _quadrature(octaves: int) -> np.ndarray:
    """Return the weights of the integral over one cycle."""
    return WEIGHT * 2.0 ** -np.arange(octaves)[:, None] / 4


def _powers(levels: int, width: int) -> np.ndarray:
    """Return the quadrature weights of |H_j|^2 S, shape (levels, levels + BELOW, NODES)."""
    octaves = levels + BELOW
    weights = [_quadrature(octaves) * gains(_nodes(octaves), width)[0]]
    high, low = gains(_nodes(octaves)[1:], width)
    while len(weights) < levels:
        weights.append(_unfold(weights[-1][:-1], low, high))
    return np.array(weights)


@lru_cache
def _single(levels: int, width: int) -> np.ndarray:
    return _powers(levels, width).reshape(levels, -1)


@lru_cache
def _pairs(levels: int, width: int) -> np.ndarray:
    """Return the quadrature weights of |H_i|^2 |H_j|^2 S^2, a row for each of the pairs of the upper triangle.

    The stages that both levels have in common fold with |G|^4, the next of the deeper level alone with |H|^2 |G|^2.
    """
    octaves = levels + BELOW
    high, low = gains(_nodes(octaves)[1:], width)
    same = _quadrature(octaves) * gains(_nodes(octaves), width)[0] ** 2
    apart = _unfold(_powers(levels, width)[:-1, :-1], high * low, low * high)
    ahead = np.concatenate([same[None], apart])  # by the number of levels between the two
    result = [ahead]
    while len(ahead) > 1:
        ahead = _unfold(ahead[:-1, :-1], low**2, high**2)
        result.append(ahead)
    return np.concatenate(result).reshape(-1, octaves * NODES)


@dataclass(frozen=True, eq=False)
class _Lags:
    """Pairs of levels, and the pairs of their coefficients at every lag.

    Attributes
    ----------
    cycles, gain
        Frequencies of the transform, shape (f,), and H_i H_j* of each pair of levels, shape (p, f).
    turn
        Phase by which the frequencies, between the harmonics, turn each lag; shape (2 f,).
    lag, pairs
        Lags, shape (l,), and the number of pairs of coefficients over that of the deeper level, shape (p, l).
    number
        Number of coefficients of the shallower level, shape (p,).
    """

    cycles: np.ndarray
    gain: np.ndarray
    turn: np.ndarray
    lag: np.ndarray
    pairs: np.ndarray
    number: np.ndarray

    def covariances(self, spectrum: np.ndarray) -> np.ndarray:
        """Return the cross-covariances of all lags, shape (p, 2 f), of coefficients of a sequence of this spectrum."""
        return (ifft(self.gain * spectrum, len(self.turn)) * self.turn).real


@lru_cache(maxsize=8)
def _lags(count: int, levels: int, halvings: int, width: int) -> _Lags:
    """Return the lags in steps of 2^halvings samples; pairs of coefficients in between are shared out linearly."""
    step, skipped = 2**halvings, APART if halvings else 0
    samples = (count - 1) // step + 1
    period = 2 * next_fast_len(PERIODS * samples // 2)
    cycles = (np.arange(period // 2) + 0.5) / period  # the spectrum may be infinite at 0
    turn = 2 * np.exp(1j * np.pi * np.arange(period) / period)
    response = transfer(cycles, levels - halvings, width)[skipped:]
    number = free(count, levels, width)[halvings + skipped :]
    first, second = np.triu_indices(len(number))
    more, fewer = number[first][:, None], number[second][:, None]
    lag = np.arange(-samples, samples + 1)
    corners = ((-more, 1), (fewer - more, -1), (0, -1), (fewer, 1))  # of the trapezoid of their number over the lag
    pairs = sum(sign * _shared_out(lag * step - corner, step) for corner, sign in corners) / fewer
    return _Lags(cycles, response[first] * response[second].conj(), turn, lag, pairs, number[first])


def _shared_out(distance: np.ndarray, step: int) -> np.ndarray:
    """Return the sum over l of max(l, 0) times the tent of height 1/step and half width step about ``distance``.

    The second difference of the second antidifference y (y^2 - 1)/6 of y.
    """
    ahead, here, behind = (np.maximum(distance + shift, 0.0) for shift in (step, 0, -step))
    return sum(weight * y * (y**2 - 1) / 6 for weight, y in ((1, ahead), (-2, here), (1, behind))) / step**2


def _symmetric(values: np.ndarray) -> np.ndarray:
    """Return the symmetric matrix with this upper triangle."""
    size = int(np.sqrt(2 * len(values)))
    result = np.empty((size, size))
    rows, columns = np.triu_indices(size)
    result[rows, columns] = result[columns, rows] = values
    return result


def _smooth(psd: PSD, cycles: np.ndarray, halvings: int, width: int) -> np.ndarray:
    """Return the spectrum, at ``cycles`` of its own sampling, of every 2^halvings-th scaling coefficient."""
    if not halvings:
        return psd(cycles)
    octave = np.ceil(-np.log2(cycles)).astype(int) - 2
    spectrum = psd(_nodes(halvings + octave.max() + 1))
    for _ in range(halvings):
        spectrum = _fold(spectrum, width)
    result = np.empty(len(cycles))
    for k in range(octave.max() + 1):
        inside = octave == k
        result[inside] = _interpolant(spectrum[k])(cycles[inside] * 2.0**k)
    return result

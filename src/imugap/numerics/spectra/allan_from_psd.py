"""Allan variance from a power spectral density by numerical integration, for spectra without a closed form."""

from collections.abc import Callable

import numpy as np
from numpy.polynomial.legendre import leggauss

Spectrum = Callable[[np.ndarray], np.ndarray]

HALF_LOBES = 64
"""Half lobes of sin^4 that are integrated one by one."""
OCTAVES = 60
"""Octaves below the first and above the last half lobe."""
HALVINGS = 8
"""Largest number of halvings of the panels."""
NODES, WEIGHTS = leggauss(12)


def allan_variance(
    psd: Spectrum,
    tau: np.ndarray,
    interval: float = 0.0,
    highest: float = np.inf,
    accuracy: float = 1e-8,
) -> np.ndarray:
    """Return the Allan variance [unit^2] that a two-sided PSD implies (Farrell et al. 2022, eq. 16).

    sigma^2(tau) = 4 int_0^highest S(f) sin^4(pi f tau)/(pi f tau)^2 df, which has no inverse. The PSD has to be smooth
    on the scale of its frequency (a resonance may be sharp, a line not), to rise less than 1/f^3 towards zero
    and, where it does not end, less than f towards infinity.

    Parameters
    ----------
    psd
        S(f) [unit^2/Hz] at frequencies [Hz] above zero, shape (n,) to shape (n,), e.g. ``model.psd`` or
        ``model.state_space().psd``.
    tau
        Averaging times [s]; of samples, multiples of their interval.
    interval
        Sampling interval [s] if the PSD is that of samples, aliases included: pi f tau in the denominator becomes
        n sin(pi f interval), n = tau/interval, and the integral ends at 1/(2 interval).
    highest
        Frequency [Hz] at which the PSD ends, if it does.
    accuracy
        Relative error allowed: panels are halved until the integral changes by less; ValueError if it never does.
    """
    end = min(highest, 0.5 / interval if interval else np.inf)
    found = [_spectral_integral(psd, float(one), interval, end, accuracy) for one in np.ravel(tau)]
    return np.reshape(found, np.shape(tau))


def _spectral_integral(psd: Spectrum, tau: float, interval: float, end: float, accuracy: float) -> float:
    """Return 4/(pi tau) int g sin^4 u du over u = pi f tau, g = S/u^2 or, of samples, S/(n sin(u/n))^2.

    Octave by octave up to pi/2, then half lobe by half lobe. Beyond :data:`HALF_LOBES` of them sin^4 is written as
    3/8 - cos(2u)/2 + cos(4u)/8: the constant is integrated octave by octave, the rest by parts (:func:`_oscillating`).
    """

    def g(u):
        return psd(u / (np.pi * tau)) / (np.sin(u * interval / tau) * tau / interval if interval else u) ** 2

    top = np.pi * end * tau
    start, far = min(np.pi / 2, top), HALF_LOBES * np.pi / 2
    edges = np.r_[0.0, start * 2.0 ** np.arange(-OCTAVES, 0), np.arange(start, min(far, top), np.pi / 2), min(far, top)]
    tail = np.r_[far, far * 2.0 ** np.arange(1, min(np.log2(max(top / far, 1)), OCTAVES)), min(top, far * 2.0**OCTAVES)]
    rest = 0.0
    if top > far:
        rest = -_oscillating(g, far, 1) + (_oscillating(g, top, -1) if np.isfinite(top) else 0.0)
    slowest, previous = _slowest(g, edges[1]), np.inf
    for halvings in range(HALVINGS):
        near = _panels(lambda u: g(u) * np.sin(u) ** 4, edges[1:], halvings)
        beyond = _panels(lambda u: 3 / 8 * g(u), tail, halvings) if top > far else np.zeros(1)
        total = slowest + near.sum() + beyond.sum() + rest
        lost = beyond[-1] if np.isinf(top) else 0.0
        if np.isfinite(total) and abs(total - previous) + abs(lost) <= accuracy * abs(total):
            return 4 / (np.pi * tau) * total
        previous = total
    raise ValueError(
        f"Allan variance: expected a PSD whose integral at tau = {tau:g} s converges; found {total:g} and more"
    )


def _slowest(g: Spectrum, end: float) -> float:
    """Return the integral of g u^4 to ``end``, with g a power of u below; infinite for u^-5 and steeper."""
    values = g(end * np.array([1.0, 2.0]))
    if not values.all():
        return 0.0
    power = 5 + np.log2(values[1] / values[0])
    return values[0] * end**5 / power if power > 0 else np.inf


def _panels(function: Spectrum, edges: np.ndarray, halvings: int) -> np.ndarray:
    """Return the integral over each panel, Gauss-Legendre on 2^halvings equal parts of it."""
    parts = (np.arange(2**halvings)[:, None] + (NODES + 1) / 2).ravel() / 2**halvings
    width = np.diff(edges)[:, None]
    values = function((edges[:-1, None] + width * parts).ravel()).reshape(len(width), -1)
    return width[:, 0] * (values @ np.tile(WEIGHTS, 2**halvings)) / 2 ** (halvings + 1)


def _oscillating(g: Spectrum, u: float, side: int) -> float:
    """Return the indefinite integral of g (-cos(2u)/2 + cos(4u)/8) at u, to second order, from values on one side."""
    step = 1e-3 * u
    first, second, third = g(u + side * step * np.arange(3))
    slope = side * (4 * second - 3 * first - third) / (2 * step)
    return first * (np.sin(4 * u) / 32 - np.sin(2 * u) / 4) + slope * (np.cos(4 * u) / 128 - np.cos(2 * u) / 8)

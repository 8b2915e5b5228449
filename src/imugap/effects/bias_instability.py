"""Flicker noise: bias instability."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from typing import ClassVar

import numpy as np
from numpy.polynomial.legendre import leggauss
from scipy.fft import irfft, next_fast_len, rfftfreq
from scipy.integrate import quad

from imugap.effects.block import Block
from imugap.effects.coloured_block import coloured_block, coloured_parts
from imugap.effects.conditions import Conditions, Run
from imugap.effects.effect import Start, StochasticEffect, Transform, parameter
from imugap.effects.residual import Residual
from imugap.numerics.spectra.fractional_bank import frequencies, least_phase

TAPER = 4096
"""Frequencies from which the filter of 1/f up to half the rate is made."""
FLOOR = np.sqrt(2 * np.log(2) / np.pi)
"""Allan deviation of flicker noise over B: 0.664 (IEEE 952)."""


@dataclass(frozen=True)
class BiasInstability(StochasticEffect):
    """Flicker noise: S(f) = B^2/(2 pi |f|), sigma(tau) = 0.664 B (IEEE 952, bias instability)."""

    name: ClassVar[str] = "bias_instability"
    slow: ClassVar[bool] = True
    stationary: ClassVar[bool] = False
    fractional: ClassVar[bool] = False
    """Whether the spectrum of the samples bends up towards half the sampling rate."""
    density_b: float = parameter("{u}", "B")

    @classmethod
    def starts(cls, fit: Residual) -> Iterator[Start]:
        """Yield both forms of its sampled spectrum, where the spectrum of the residual exceeds the fit."""
        if not fit.has(BiasInstability):
            for form in (BiasInstability, FractionalFlicker):
                size = fit.room(form(1.0))
                if size > 0:
                    yield Start(form(size), ("density_b",), gain=fit.gain_of(form(size)))

    def sample(self, conditions: Conditions, rng: np.random.Generator) -> np.ndarray:
        """Draw by spectral synthesis: independent Gaussian Fourier coefficients under the spectrum.

        The synthesis is four times longer than the run, so the run is not periodic and has variations on scales of its
        own length; power below 1/(4 duration), which a run cannot tell from its bias, is left out.
        """
        count = len(conditions)
        length = next_fast_len(4 * count, real=True)
        scale = self.density_b * _amplitudes(type(self)(1.0), length, conditions.interval)
        spectrum = np.zeros(len(scale) + 1, complex)
        spectrum.real[1:] = scale * rng.standard_normal(len(scale))
        spectrum.imag[1:] = scale * rng.standard_normal(len(scale))
        return irfft(spectrum, length)[:count]

    def block(self, interval: float, axis: str) -> Block:
        """Return the effect as a step: the sampled form with the spectrum of 1/f, or the fractional one.

        Power below 1e-7 of the rate is left out.
        """
        return coloured_block(self.density_b, 0.5, self._weights())

    def in_parts(self, run: Run, rng: np.random.Generator) -> Transform:
        """Return a function that adds such noise to one part of a run after the other, from other draws.

        Its power at low frequencies does not end at once, but within a factor of two about 1/(4 duration).
        """
        return coloured_parts(run, rng, self.density_b, 0.5, self._weights())

    def _weights(self) -> np.ndarray | tuple[float, ...]:
        """Return the filter that makes the spectrum of 1/f from that of fractional noise."""
        return (1.0,) if self.fractional else least_phase(np.sinc(frequencies(TAPER)))

    def psd(self, frequency: np.ndarray) -> np.ndarray:
        """Return B^2/(2 pi |f|) (Farrell et al. 2022, eq. 18)."""
        return self.density_b**2 / (2 * np.pi * np.abs(np.asarray(frequency, float)))

    def allan_variance(self, tau: np.ndarray) -> np.ndarray:
        """Return 2 ln 2/pi B^2 for every tau (IEEE 952)."""
        return np.full_like(np.asarray(tau, float), (FLOOR * self.density_b) ** 2)

    def sampled_psd(self, frequency: np.ndarray, interval: float) -> np.ndarray:
        """Return B^2/(2 pi |f|): the synthesis fills this spectrum up to half the sampling rate; nothing is aliased.

        The power of a run sits on lines 1/(4 duration) apart, half that of the last where it is at 1/(2 interval).
        """
        return self.psd(frequency)

    def sampled_allan_variance(self, averaging: np.ndarray, interval: float) -> np.ndarray:
        """Return the Allan variance of samples with this spectrum, to a relative 1e-11.

        It is the limit of a long run. The lines of a run of L samples leave out pi/6 (n/(4 L))^2 B^2: 0.5 % of the
        variance at n = L/4, 0.03 % at n = L/16.
        """
        shape = [_band_limited(int(n), self.fractional) for n in np.ravel(averaging)]
        return self.density_b**2 * np.reshape(shape, np.shape(averaging))


@dataclass(frozen=True)
class FractionalFlicker(BiasInstability):
    """Flicker noise as fractionally integrated white samples (Kasdin 1995, Proc. IEEE 83, 802-827).

    Up to a tenth of the sampling rate its spectrum is that of 1/f, within 2 %; at half the rate it is pi/2 of that.
    A model file does not distinguish the forms; it is read as flicker noise.
    """

    fractional: ClassVar[bool] = True

    def sampled_psd(self, frequency: np.ndarray, interval: float) -> np.ndarray:
        """Return B^2 interval/(2 sin(pi f interval))."""
        return self.density_b**2 * interval / (2 * np.sin(np.pi * np.asarray(frequency, float) * interval))


@lru_cache(maxsize=1)
def _amplitudes(unit: BiasInstability, length: int, interval: float) -> np.ndarray:
    """Return the deviation of either part of the Fourier coefficients of a synthesis, from the first one on."""
    frequency = rfftfreq(length, interval)[1:]
    return np.sqrt(unit.sampled_psd(frequency, interval) * length / interval / 2)


LOBES = 400
NODES, WEIGHTS = (0.5 * np.array(rule) for rule in leggauss(14))


@lru_cache(maxsize=4096)
def _band_limited(n: int, fractional: bool) -> float:
    """Return the Allan variance, over B^2, of flicker noise that ends at half the sampling rate.

    (2/pi) int_0^(n pi/2) sin^4 v/(w (n sin(v/n))^2) dv, from the gain 2 sin^4(n u)/(n sin u)^2, u = pi f interval, of
    the Allan variance, with w = v, or n sin(v/n) if ``fractional``: lobe by lobe, and beyond :data:`LOBES` half lobes
    with the mean 3/8 of sin^4, which changes it by less than 1e-11.
    """
    half_lobes = min(n, LOBES)
    v = np.pi / 2 * (np.arange(half_lobes)[:, None] + 0.5 + NODES)
    sine = n * np.sin(v / n)
    near = np.pi / 2 * np.sum(WEIGHTS * np.sin(v) ** 4 / ((sine if fractional else v) * sine**2))
    far = quad(lambda t: _tail(t, n, fractional), np.log(half_lobes * np.pi / 2), np.log(n * np.pi / 2))[0]
    return float(2 / np.pi * (near + 3 / 8 * far))


def _tail(logarithm: float, n: int, fractional: bool) -> float:
    """Return v/(w (n sin(v/n))^2) at the logarithm of v."""
    sine = n * np.sin(np.exp(logarithm) / n)
    return float(np.exp(logarithm) * sine**-3.0 if fractional else sine**-2.0)

"""Runs whose true interval is known: sums of waves and noise of known covariance, evaluated at the true times."""

import numpy as np
import pytest

from imugap import clock
from imugap.log import LogError, from_samples
from imugap.stream import stream

NOMINAL_S = 0.01
COUNT = clock.BLOCKS * 6000
LINES_HZ = (3.1, 5.7, 9.3, 13.9, 17.3)
WANDER = 1e-3  # of a line, relative: as much from run to run as from block to block


def averaging(lag_s, width_s=9.8e-3):
    """Covariance of white noise averaged twice over ``width_s``: a cubic B-spline."""
    u = np.abs(lag_s) / width_s
    return np.where(u < 1, 1 - 1.5 * u**2 + 0.75 * u**3, 0.25 * np.maximum(2 - u, 0) ** 3)


def two_poles(lag_s, rate_per_s=250.0):
    """Covariance of white noise behind two equal real poles."""
    u = np.abs(lag_s) * rate_per_s
    return (1 + u) * np.exp(-u)


def white(lag_s):
    """Covariance of noise that no filter shaped."""
    return (lag_s == 0).astype(float)


def noise(rng, interval_s, covariance):
    """Draw a stationary Gaussian sequence with exactly this covariance at the true lags (circulant embedding)."""
    lags = np.minimum(np.arange(COUNT), COUNT - np.arange(COUNT))
    spectrum = np.fft.fft(covariance(lags * interval_s)).real.clip(0)
    return np.fft.fft(np.sqrt(spectrum / COUNT) * (rng.normal(size=(2, COUNT)).T @ [1, 1j])).real


def waves(rng, interval_s, lines_hz):
    """Return unit waves whose common frequency wanders from run to run and, by steps, from block to block."""
    wander = WANDER * (rng.normal() + np.repeat(rng.normal(size=clock.BLOCKS), COUNT // clock.BLOCKS))
    cycles = np.cumsum(interval_s * (1 + wander))
    return sum(np.sin(2 * np.pi * (f * cycles + rng.uniform())) for f in lines_hz)


def run(seed, label, ratio=1.0, lines_hz=LINES_HZ, covariance=averaging, filter_ratio=None):
    """Return the spectra of a run; ``filter_ratio`` is the stretch of the filter where it is not that of the lines."""
    rng = stream(seed, "clock", label)
    inside_s = NOMINAL_S * (ratio if filter_ratio is None else filter_ratio)
    samples = {f"gyro_{axis}": noise(rng, inside_s, covariance) for axis in "xy"}
    samples["accel_z"] = noise(rng, inside_s, white) + 0.3 * waves(rng, NOMINAL_S * ratio, lines_hz)
    return clock.spectra(from_samples(samples, NOMINAL_S))


def compare(seed, ratio=1.0, **options):
    return clock.relative_interval(run(seed, "reference", **options), run(seed, "run", ratio, **options))

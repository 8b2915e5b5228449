"""Simulate effects on conditions of every kind, and judge their samples."""

from functools import lru_cache
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy.stats import chi2

from imugap import log
from imugap.effects import (
    BandNoise,
    Bias,
    BiasInstability,
    BiasStep,
    Chirp,
    ClockScale,
    Comb,
    CommonMode,
    Conditions,
    DeadZone,
    Echo,
    GaussMarkov,
    GSensitivity,
    HeldSamples,
    LeverArm,
    Misalignment,
    NoiseDistribution,
    Outliers,
    OutputFilter,
    PowerLaw,
    Quantization,
    RandomTelegraph,
    RandomWalk,
    RateRamp,
    Resolution,
    SampleLoss,
    Saturation,
    ScaleFactor,
    Sinusoid,
    SkewedNoise,
    StabilityRestoration,
    StanceMotion,
    StuckSamples,
    Temperature,
    TimeOffset,
    TimestampJitter,
    TornWords,
    TurnOnBias,
    UniformNoise,
    VarianceChange,
    VibrationRectification,
    WarmUp,
    WhiteNoise,
)
from imugap.estimation.variances import allan
from imugap.stream import stream

PUBLISHED = pd.read_csv(
    Path(__file__).parents[1] / "reference" / "farrell2022_gauss_markov.csv", comment="#", index_col="quantity"
)


PROCESSES = (
    WhiteNoise(0.3),
    RandomWalk(0.2),
    GaussMarkov(0.7, 0.2),
    BiasInstability(0.4),
    RandomTelegraph(1.4, 2.5),
    CommonMode(0.3, -0.5),
    PowerLaw(0.4, 1.5),
    UniformNoise(0.3, 0.8),
    SkewedNoise(0.3, -1.2),
)


NAMES = [process.name for process in PROCESSES]


SAMPLED = (*PROCESSES, Quantization(0.003), BandNoise(0.3, 25.0, 50.0))
"""All processes: quantization has a spectrum only once it is sampled, and that of a band has edges."""


SAMPLED_NAMES = [process.name for process in SAMPLED]


RUNS = 330


EXAMPLES = {
    effect.name: effect
    for effect in (
        *SAMPLED,
        Bias(-0.3),
        TurnOnBias(0.2),
        RateRamp(-0.3),
        Sinusoid(3.0, 0.5, 1.0),
        Chirp(3.0, 0.7, 0.5, 1.0),
        Comb(2.0, 0.3, 0.5, 1.0, 0.3, -0.4, 0.2, 0.1, 0.4, 0.9, 0.6, 2.0, 0.7, -1.0),
        Outliers(0.05, 2.0),
        BiasStep(0.2, -0.4),
        WarmUp(0.8, 0.1),
        Temperature(0.02, 24.0, 1e-3, -0.1),
        VarianceChange(0.1, 0.3, 4.0),
        NoiseDistribution(0.1, q_001=-2.5, q_999=4.0),
        StabilityRestoration(0.1, 0.05),
        OutputFilter(10.0, 3),
        Echo(0.4, 12),
        Saturation(0.2),
        Resolution(0.05),
        DeadZone(0.1),
        TornWords(0.3, 1e-3, 8.0),
        StuckSamples(0.1, 3.0),
        HeldSamples(3.0, 1.0),
        SampleLoss(0.1, 3.0),
        TimestampJitter(1e-3),
        ClockScale(1.01),
        ScaleFactor(0.01, -0.02, 0.03),
        Misalignment(0.01, -0.02, 0.0),
        GSensitivity(1e-3, -2e-3, 3e-3),
        VibrationRectification(0.04),
        LeverArm(0.1, -0.2, 0.3),
        TimeOffset(2e-3),
        StanceMotion(0.01, -0.002),
    )
}
"""One of every effect, at home on gyro_z, accel_z or time."""


def conditions(count, interval=0.01, temperature=None):
    return Conditions(interval * np.arange(count), interval, temperature)


def motion(count, interval=0.01):
    """An error-free log of every axis at its own frequency, around its own mean."""
    time = interval * np.arange(count)
    phases = [2 * np.pi * (0.3 + 0.1 * k) * time + k for k in range(6)]
    columns = {axis: 0.3 * k + (1 + k) * np.sin(phases[k]) for k, axis in enumerate(log.AXES)}
    return log.from_samples(columns | {"temperature": 20 + 5 * time**2}, interval)


def moving(count, axis, interval=0.01):
    """Conditions of an axis under motion."""
    return under(axis, motion(count, interval), interval)


@lru_cache(maxsize=16)
def draws(effect, runs, count, *labels, interval=0.01):
    """Sequences of an effect, shape (runs, count), drawn once for all tests that ask for the same."""
    at = conditions(count, interval)
    return np.array([effect.sample(at, stream(11, effect.name, *labels, run)) for run in range(runs)])


def published(quantity):
    """A published value with the tolerance that its digits leave."""
    row = PUBLISHED.loc[quantity]
    return pytest.approx(row["value"], abs=row["half_digit"])


def sharp_std(samples, std, alpha=1e-4):
    """Whether independent zero-mean Gaussian samples have this standard deviation (chi-square, two-sided)."""
    low, high = chi2.ppf([alpha / 2, 1 - alpha / 2], samples.size)
    return low < np.sum(samples**2) / std**2 < high


def under(axis, ideal, interval=0.01):
    """Conditions of an axis under the motion of an error-free log."""
    temperature = ideal["temperature"].to_numpy() if "temperature" in ideal else None
    return Conditions(ideal.index.to_numpy(), interval, temperature, axis, ideal)


def inputs(axis, interval=0.01, **values):
    """Conditions of an axis under the inputs of the axes that are given."""
    return under(axis, log.from_samples(values, interval), interval)


def held(axis, **values):
    """Conditions of an axis under constant inputs."""
    return inputs(axis, **{name: np.full(200, values.get(name, 0.0)) for name in log.AXES})


def tapered_power(sequences, interval=0.01):
    """Two-sided spectra of sequences, shape (runs, count), through a Hann window, and the frequencies [Hz]."""
    count = sequences.shape[1]
    taper = np.hanning(count)
    power = np.abs(np.fft.rfft(sequences * taper)) ** 2 * interval / np.sum(taper**2)
    return power, np.fft.rfftfreq(count, interval)


def allan_variances(sequences, averaging):
    """Allan variances of sequences, shape (runs, averaging times), the latter in samples."""
    return np.array([allan.variance(sequence, averaging) for sequence in sequences])

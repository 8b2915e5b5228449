"""Features of an axis of a case, from which a classifier tells what is hidden: numbers without units."""

from itertools import pairwise

import numpy as np
from scipy.signal import periodogram
from scipy.stats import kurtosis, skew

from imu_benchmark.baselines.allan_slopes import allan_deviation
from imu_benchmark.case import Case
from imu_benchmark.log import ACCEL, GYRO

OCTAVES = 12
"""Octaves of the Allan deviation."""
BANDS = 8
"""Bands of the spectrum, from low to high frequency with equal ratios."""
BASES = ("bias_instability", "random_walk", "quantization", "sinusoid")
"""Effects that a start model may have."""


def of_axis(case: Case, axis: str) -> np.ndarray:
    """Return the features of an axis, shape (m,)."""
    errors = case.errors(axis)
    steps = np.diff(errors)
    scale = np.median(np.abs(steps)) + np.finfo(float).tiny
    parts = (
        _allan(errors, scale),
        _spectrum(errors),
        _distribution(case.logs[0][axis].to_numpy(), errors, steps, scale),
        _over_time(errors, steps, scale),
        _over_conditions(case, axis, errors),
        _stamps(case),
        _others(case, axis, errors),
        [axis in GYRO, *(name in case.known(axis) for name in BASES)],
    )
    return np.nan_to_num(np.concatenate([np.asarray(part, float) for part in parts]), posinf=1e6, neginf=-1e6)


def _allan(errors: np.ndarray, scale: float) -> list[float]:
    """Return the log Allan deviations over that of one sample, times the root of the size: flat for white noise."""
    sizes = [2**octave for octave in range(OCTAVES)]
    return [
        float(np.log(allan_deviation(errors, size) * np.sqrt(size) / scale + 1e-12)) if 4 * size < len(errors) else 0.0
        for size in sizes
    ]


def _spectrum(errors: np.ndarray) -> list[float]:
    """Return log mean and log peak of the periodogram in each band over its median, and where the peak is."""
    frequency, power = periodogram(errors, detrend="linear")
    frequency, power = frequency[1:], power[1:] / (np.median(power[1:]) + np.finfo(float).tiny)
    edges = np.geomspace(frequency[0], 0.5, BANDS + 1)
    bands = [power[(frequency >= low) & (frequency <= high)] for low, high in pairwise(edges)]
    levels = [
        value for band in bands for value in ((np.log(band.mean()), np.log(band.max())) if len(band) else (0.0, 0.0))
    ]
    return [*levels, float(np.log(frequency[np.argmax(power)])), float(np.log(np.sort(power)[-20:].sum()))]


def _distribution(values: np.ndarray, errors: np.ndarray, steps: np.ndarray, scale: float) -> list[float]:
    return [
        np.log(len(np.unique(values)) / len(values)),
        np.log(np.mean(np.diff(values) == 0) + 1e-6),
        np.log(np.mean(values == 0) + 1e-6),
        np.log(np.mean(np.abs(values) >= np.abs(values).max()) * len(values)),
        kurtosis(steps),
        skew(errors),
        np.log(np.abs(steps).max() / scale),
    ]


def _over_time(errors: np.ndarray, steps: np.ndarray, scale: float) -> list[float]:
    """Return trends and the best step of the mean, in standard errors, and the spread of the variance over time."""
    count = len(errors)
    time = np.linspace(-1, 1, count)
    waves = (time, time**2, np.exp(-5 * (time + 1)), np.exp(-15 * (time + 1)))
    trends = [_significance(errors, wave, scale) for wave in waves]
    sums = np.cumsum(errors)[:-1]
    at = np.arange(1, count)
    step = np.abs(sums) / np.sqrt(at * (count - at) / count)
    blocks = np.array_split(steps, 32)
    variances = np.log([block.var() + np.finfo(float).tiny for block in blocks])
    return [*trends, np.log1p(step.max() / scale), np.argmax(step) / count, np.ptp(variances), np.diff(variances).std()]


def _over_conditions(case: Case, axis: str, errors: np.ndarray) -> list[float]:
    """Return significances against temperature, and against the inputs of all axes, their products and derivative."""
    degrees = case.temperature
    scale = np.median(np.abs(np.diff(errors))) + np.finfo(float).tiny
    warm = 0.0 if degrees is None else _significance(errors, degrees, scale)
    if case.ideal is None:
        return [warm, 0.0, *[0.0] * 12]
    inputs = case.ideal.to_numpy()
    own = inputs[:, case.axes.index(axis)]
    waves = [*inputs.T[:6], own**2, np.abs(own), np.gradient(own), inputs[:, 0] ** 2, inputs[:, 1] ** 2]
    # the mean square acceleration of a second stands for vibration
    shaking = np.convolve((inputs[:, 3:] ** 2).sum(axis=1), np.ones(25) / 25, "same")
    return [warm, 1.0, *(_significance(errors, wave, scale) for wave in (*waves, shaking))]


def _significance(errors: np.ndarray, wave: np.ndarray, scale: float) -> float:
    """Return the signed logarithm of the coefficient of a wave in standard errors."""
    centred = wave - wave.mean()
    norm = np.linalg.norm(centred)
    ratio = errors @ centred / (norm * scale) if norm > 0 else 0.0
    return float(np.sign(ratio) * np.log1p(np.abs(ratio)))


def _stamps(case: Case) -> list[float]:
    steps = np.diff(case.logs[0].index) / case.interval
    gaps = steps > 1.5
    return [np.log(gaps.mean() + 1e-7), np.log(steps.max()), np.log(steps[~gaps].std() + 1e-9)]


def _others(case: Case, axis: str, errors: np.ndarray) -> list[float]:
    """Return the correlations of steps with those of other axes, and the spread of the means of several runs."""
    triad = [name for name in (GYRO if axis in GYRO else ACCEL) if name != axis and name in case.axes]
    steps = np.diff(errors)
    common = [np.corrcoef(steps, np.diff(case.errors(name)))[0, 1] * np.sqrt(len(steps)) for name in triad]
    means = np.array([log[axis].mean() for log in case.logs])
    spread = means.std() * np.sqrt(len(errors)) / (np.median(np.abs(steps)) + np.finfo(float).tiny)
    ordered = sorted(np.nan_to_num(common), key=abs)
    return [*ordered, *[0.0] * (2 - len(ordered)), np.log1p(spread), len(case.logs)]

"""Baseline of detectors: change points of mean and variance by ruptures, lines by a periodogram of SciPy, outliers."""

import numpy as np
import ruptures
from scipy.signal import periodogram
from scipy.stats import norm

from imu_benchmark.baselines.findings import Estimate, answer, effect
from imu_benchmark.case import Case

BLOCKS = 512
"""Blocks of a log, whose means and log variances are searched."""
FALSE_ALARM = 0.01
"""Probability that the noise of a log gives a line, and an outlier."""


def report(case: Case) -> dict:
    """Return what the detectors find on each axis."""
    return answer(
        found
        for axis in case.axes
        for found in _found(axis, case.errors(axis), case.interval, case.known(axis), len(case.axes))
    )


def _found(axis: str, values: np.ndarray, interval: float, known: dict, axes: int) -> list[dict]:
    level = FALSE_ALARM / axes
    size = max(len(values) // BLOCKS, 1)
    blocks = values[: len(values) // size * size].reshape(-1, size)
    found = []
    slow = {"random_walk", "bias_instability"} & set(known)
    changes = [] if slow else _changes(blocks.mean(axis=1))
    if changes:
        edge = changes[0] * size
        step = values[edge:].mean() - values[:edge].mean()
        found.append(effect("bias_step", [axis], {"time": Estimate(edge * interval), "step": Estimate(float(step))}))
    if size > 1 and _changes(np.log(blocks.var(axis=1) + np.finfo(float).tiny)):
        found.append(effect("variance_change", [axis]))
    return found + _lines(axis, values, interval, known, level) + _outliers(axis, values, level)


def _changes(values: np.ndarray) -> list[int]:
    """Return the change points of the mean: PELT with the penalty 3 log n, the noise from differences of neighbours."""
    noise = np.diff(values).std() / np.sqrt(2)
    if not noise > 0:
        return []
    search = ruptures.KernelCPD(kernel="linear", min_size=2).fit(values[:, None] / noise)
    return search.predict(pen=3 * np.log(len(values)))[:-1]


def _lines(axis: str, values: np.ndarray, interval: float, known: dict, level: float) -> list[dict]:
    """Return the highest ordinate over the median of its neighbours, if chance does not reach it."""
    frequency, power = periodogram(values, 1 / interval, detrend="linear")
    frequency, power = frequency[1:-1], power[1:-1]
    width = min(2 * (len(power) // 200) + 1, len(power))
    floor = np.maximum(_running_median(power, max(width, 51)) / np.log(2), np.finfo(float).tiny)
    ratio = power / floor
    if "sinusoid" in known:
        ratio[np.abs(frequency - known["sinusoid"]["frequency"]) < 3 * frequency[0]] = 0
    peak = int(np.argmax(ratio))
    if ratio[peak] < -np.log(level / len(ratio)):
        return []
    amplitude = np.sqrt(2 * power[peak] / (len(values) * interval))
    return [
        effect(
            "sinusoid", [axis], {"frequency": Estimate(float(frequency[peak])), "amplitude": Estimate(float(amplitude))}
        )
    ]


def _running_median(values: np.ndarray, width: int) -> np.ndarray:
    """Return the medians of blocks of ``width`` values, at each value."""
    edges = np.arange(0, len(values), width)
    medians = [np.median(values[begin : begin + width]) for begin in edges]
    return np.interp(np.arange(len(values)), edges + width / 2, medians)


def _outliers(axis: str, values: np.ndarray, level: float) -> list[dict]:
    """Return outliers where a difference of neighbours lies farther out than normal noise does by chance."""
    steps = np.diff(values)
    scale = np.median(np.abs(steps)) / norm.ppf(0.75)
    far = np.abs(steps) > scale * norm.isf(level / len(steps) / 2)
    return [effect("outliers", [axis])] if scale > 0 and far.sum() > 1 else []

"""Baseline that reads slopes from the Allan deviation, as IEEE Std 952-1997, annex C, describes.

Each random process has its slope in the log-log plot of the deviation over averaging time. A term is named where the
local slope between octaves agrees with it over two octaves in succession, and read off there.
"""

import numpy as np
from scipy.stats import chi2

from imu_benchmark.baselines.findings import Estimate, answer, effect
from imu_benchmark.case import Case

SLOPES = {
    -1.0: ("quantization", "q", lambda tau: np.sqrt(3) / tau),
    -0.5: ("white_noise", "density", lambda tau: 1 / np.sqrt(tau)),
    0.0: ("bias_instability", "density_b", lambda tau: np.full(len(tau), np.sqrt(2 * np.log(2) / np.pi))),
    0.5: ("random_walk", "density_k", lambda tau: np.sqrt(tau / 3)),
    1.0: ("rate_ramp", "slope", lambda tau: tau / np.sqrt(2)),
}
"""For each slope: name, parameter, and the deviation of the parameter one over averaging time [s]."""
TOLERANCE = 0.1
"""Largest distance of a local slope from that of a term."""
STRETCH = 2
"""Octaves in succession that have to agree."""
WINDOWS = 8
"""Fewest independent averages of an averaging time that is used."""


def report(case: Case) -> dict:
    """Return the terms that the slopes show and the start model does not have."""
    return answer(
        found for axis in case.axes for found in _terms(axis, case.errors(axis), case.interval, case.known(axis))
    )


def allan_deviation(values: np.ndarray, size: int) -> float:
    """Return the overlapping Allan deviation of averages of ``size`` values."""
    sums = np.cumsum(np.r_[0.0, values])
    second = sums[2 * size :] - 2 * sums[size:-size] + sums[: -2 * size]
    return float(np.sqrt(np.mean(second**2) / 2) / size)


def _terms(axis: str, values: np.ndarray, interval: float, known: dict) -> list[dict]:
    sizes = 2 ** np.arange(int(np.log2(len(values) / WINDOWS)) + 1)
    tau, deviation = sizes * interval, np.array([allan_deviation(values, size) for size in sizes])
    if not deviation.all():
        return []
    local = np.diff(np.log2(deviation))
    found = []
    for slope, (name, parameter, unit) in SLOPES.items():
        agrees = np.abs(local - slope) <= TOLERANCE
        runs = np.flatnonzero(np.convolve(agrees, np.ones(STRETCH, int), "valid") == STRETCH)
        if len(runs) and name not in known:
            at = int(runs[0] + 1)
            freedom = len(values) / sizes[at] - 1
            value = float(deviation[at] / unit(tau[at : at + 1])[0])
            low, high = (value * np.sqrt(freedom / chi2.ppf(p, freedom)) for p in (0.975, 0.025))
            found.append(effect(name, [axis], {parameter: Estimate(value, float(low), float(high))}))
    return found

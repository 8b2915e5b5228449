"""Baseline that chooses a model by the generalised method of wavelet moments (Guerrier et al. 2013).

As the automatic choice of the R package gmwm, it fits all sums of white noise, quantization noise, random walk and
drift, with up to three first-order autoregressions, to the Haar wavelet variances, and takes the one whose objective,
increased by the optimism of its parameters, is the smallest. This is an own implementation: weights are the inverse
variances of the levels, correlation times lie on a grid, and the optimism is two per parameter, that of a sum of
squares of independent levels.
"""

from collections.abc import Iterator
from itertools import combinations

import numpy as np
from scipy.optimize import nnls

from imu_benchmark.baselines.allan_slopes import allan_deviation
from imu_benchmark.baselines.findings import Estimate, answer, effect
from imu_benchmark.case import Case

TIMES = 40
"""Correlation times on the grid."""
ITERATIONS = 1000
"""Most iterations of a fit."""
MOST = 3
"""Most autoregressions in a sum."""
FEWEST = 4
"""Fewest independent coefficients of a level that is used."""


def report(case: Case) -> dict:
    """Return the terms of the chosen sums that the start model does not have."""
    return answer(
        found for axis in case.axes for found in _terms(axis, case.errors(axis), case.interval, case.known(axis))
    )


def _terms(axis: str, values: np.ndarray, interval: float, known: dict) -> list[dict]:
    levels = np.arange(int(np.log2(len(values) / FEWEST)) + 1)
    size = 2.0**levels
    # the Haar wavelet variance is half the Allan variance (Percival and Walden 2000)
    observed = np.array([allan_deviation(values, int(one)) ** 2 / 2 for one in size])
    if not observed.all():
        return []
    weight = np.sqrt(len(values) / (2 * size) / 2) / observed
    curves = {
        "white_noise": 1 / (2 * size),
        "quantization": 3 / (2 * size**2),
        "random_walk": (2 * size**2 + 1) / (12 * size),
        "rate_ramp": size**2 / 4,
    }
    times = np.geomspace(1, len(values) / 16, TIMES)
    autoregressions = [_autoregression(np.exp(-1 / time), size) for time in times]
    chosen, squares, chosen_times = _choice(curves, autoregressions, observed, weight)
    units = {
        "white_noise": ("density", np.sqrt(interval)),
        "quantization": ("q", interval),
        "random_walk": ("density_k", 1 / np.sqrt(interval)),
        "rate_ramp": ("slope", 1 / interval),
    }
    found = [
        effect(name, [axis], {units[name][0]: Estimate(float(np.sqrt(square) * units[name][1]))})
        for name, square in zip(chosen, squares, strict=False)
        if name not in known
    ]
    found += [
        effect(
            "gauss_markov",
            [axis],
            {"std": Estimate(float(np.sqrt(square))), "correlation_time": Estimate(float(times[number] * interval))},
        )
        for number, square in zip(chosen_times, squares[len(chosen) :], strict=True)
    ]
    return found


def _choice(
    curves: dict[str, np.ndarray], autoregressions: list[np.ndarray], observed: np.ndarray, weight: np.ndarray
) -> tuple[tuple[str, ...], np.ndarray, tuple[int, ...]]:
    """Return names, squared parameters and numbers of the times of the sum with the smallest criterion."""
    best = (np.inf, (), np.zeros(0), ())
    for names, numbers in _sums(curves, autoregressions, observed, weight):
        columns = [curves[name] for name in names] + [autoregressions[number] for number in numbers]
        squares, objective = _fit(columns, observed, weight)
        criterion = objective + 2 * (len(names) + 2 * len(numbers))
        if criterion < best[0] and (squares > 0).all():
            best = (criterion, names, squares, numbers)
    return best[1:]


def _sums(curves, autoregressions, observed, weight) -> Iterator[tuple[tuple[str, ...], tuple[int, ...]]]:
    """Yield all sums of terms; each autoregression more has the time that lowers the objective most."""
    for count in range(len(curves) + 1):
        for names in combinations(curves, count):
            numbers: tuple[int, ...] = ()
            base = [curves[name] for name in names]
            if names:
                yield names, numbers
            for _ in range(MOST):
                columns = base + [autoregressions[number] for number in numbers]
                tried = {
                    more: _fit([*columns, autoregressions[more]], observed, weight)[1]
                    for more in range(len(autoregressions))
                    if more not in numbers
                }
                numbers = (*numbers, min(tried, key=tried.__getitem__))
                yield names, numbers


def _fit(columns: list[np.ndarray], observed: np.ndarray, weight: np.ndarray) -> tuple[np.ndarray, float]:
    """Return the non-negative squares of the parameters and the weighted sum of squares that is left."""
    weighted = np.array(columns).T * weight[:, None]
    scale = np.linalg.norm(weighted, axis=0)
    squares, distance = nnls(weighted / scale, observed * weight, maxiter=ITERATIONS)
    return squares / scale, distance**2


def _autoregression(ratio: float, size: np.ndarray) -> np.ndarray:
    """Return the Haar wavelet variances of an autoregression of unit variance and coefficient ``ratio``.

    Half the Allan variance of averages of m values: (m (1 - r^2) - 3 r + 4 r^(m+1) - r^(2m+1))/(2 m^2 (1 - r)^2).
    """
    m, r = size, ratio
    return (m * (1 - r**2) - 3 * r + 4 * r ** (m + 1) - r ** (2 * m + 1)) / (2 * m**2 * (1 - r) ** 2)

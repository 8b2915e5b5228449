"""Whether a log was long enough: how narrow its intervals are, and the length at which they would be narrow."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from math import inf, isfinite

import numpy as np

from imugap.effects import Quantization, WhiteNoise
from imugap.estimation.cramer_rao import fisher
from imugap.estimation.likelihood import Grid, parameters
from imugap.estimation.report import AxisEstimate
from imugap.estimation.result import ParameterEstimate
from imugap.log import GYRO
from imugap.numerics.normal_quantile import NORMAL_QUANTILE

NARROW = 0.1
"""Half width of an interval over its value that is narrow."""
STEPS = 8
"""Most corrections of a length; with the root of the length the first one is exact."""
CLOSE = 0.02
"""Relative change of a length at which it is found."""
UNKNOWN = 1e-12
"""Information that keeps the matrix of parameters which a log does not separate invertible."""
LEAST = 1000
"""Samples of the shortest log of which the information is computed."""
LONG_S = 7 * 86400.0
"""Length that is not given as a number [s]."""
LARGEST = 2_000_000
"""Samples above which the error falls with the root of the length: far longer than any process."""


@dataclass(frozen=True)
class Width:
    """Half width of an interval over its value, and the length of a log at rest at which it is :data:`NARROW` [s]."""

    axis: str
    now: float
    length: float


def widths(estimate: AxisEstimate, white: bool) -> list[Width]:
    """Return the width of the interval of each parameter of white noise, or of the slow processes, of an axis."""
    if not tuple(estimate.fit.present):
        return []
    composition, _ = parameters(estimate.fit.present)
    return [
        _width(estimate, estimate.fit.shown[one.key], one.direction)
        for one in composition.quantities()
        if np.count_nonzero(one.direction) == 1
        and one.key[0] != Quantization.name
        and (one.key[0] == WhiteNoise.name) == white
    ]


def _width(estimate: AxisEstimate, parameter: ParameterEstimate, direction: np.ndarray) -> Width:
    """Return the width of an interval, and the length at which its Cramer-Rao bound has shrunk as far as needed."""
    used = estimate.used
    count = float(len(used.values))
    now = (parameter.high - parameter.low) / (2 * parameter.value) if parameter.low > 0 else inf
    target = _error(estimate, direction, count) * NARROW / now if isfinite(now) else NARROW / NORMAL_QUANTILE
    length = count
    for _ in range(STEPS):
        before, length = length, length * (_error(estimate, direction, length) / target) ** 2
        if abs(length / before - 1) < CLOSE:
            break
    return Width(estimate.axis, now, length * used.interval)


def _error(estimate: AxisEstimate, direction: np.ndarray, count: float) -> float:
    """Return the least standard deviation of direction' theta, theta the log parameters, from ``count`` samples."""
    used = estimate.used
    counted = int(min(max(count, LEAST), max(LARGEST, len(used.values))))
    composition, theta = parameters(estimate.fit.present)
    grid = Grid.of(counted, used.interval, used.highest)
    information = fisher(theta, composition.shapes(grid), grid) + UNKNOWN * np.eye(len(theta))
    return float(np.sqrt(direction @ np.linalg.solve(information, direction) * counted / count))


def sentences(estimates: Sequence[AxisEstimate]) -> list[str]:
    """Return for each kind of sensor how well its parameters are known, and what a longer log would give.

    Only of the axes whose model fits: the parameters of another are not those of the device.
    """
    kinds = {"gyroscopes": lambda one: one.axis in GYRO, "accelerometers": lambda one: one.axis not in GYRO}
    grouped = {name: [one for one in estimates if one.fits and has(one)] for name, has in kinds.items()}
    return [f"{name}: {_sentence(some)}" for name, some in grouped.items() if some]


def _sentence(estimates: Iterable[AxisEstimate]) -> str:
    """Return the widths of the axes of a sensor in words, each of the axis with the widest."""
    estimates = list(estimates)
    parts, longest = [], 0.0
    for name, white in (("white noise", True), ("slow processes", False)):
        found = [one for estimate in estimates for one in widths(estimate, white)]
        if not found:
            parts.append(f"no {'white noise' if white else 'slow process'} is shown")
            continue
        widest = max(found, key=lambda one: (one.now, one.length))
        now = f"to {100 * widest.now:.2g} %" if isfinite(widest.now) else "to no better than an upper bound"
        parts.append(f"{name} known {now}{f' ({widest.axis})' if len(estimates) > 1 else ''}")
        longest = max(longest, *(one.length for one in found if one.now > NARROW), 0.0)
    if not longest:
        return f"{'; '.join(parts)}: long enough for 10 %"
    parts.append(f"10 % of each takes about {_minutes(longest)} at rest (approximate, by the Fisher information)")
    return "; ".join(parts)


def _minutes(seconds: float) -> str:
    if seconds > LONG_S:
        return "more than a week"
    minutes = float(f"{seconds / 60:.2g}")
    return f"{minutes:g} min" if minutes < 600 else f"{minutes / 60:.2g} h"

"""Hysteresis: a mean that depends on the temperature and on where it came from.

No effect of the catalogue has a memory of the temperature. A loop over it wanders over a log like slow noise, and as
slow noise it would be named. The play operator, the element of which Preisach's loops are made (Visintin, Differential
Models of Hysteresis, 1994, ch. III), follows the temperature by half its width: with it and the temperature itself a
loop of any breadth is described well enough to tell it from noise.
"""

import numpy as np
from numba import njit

from imugap.discovery.axis import AxisFit
from imugap.effects.effect import Conditions

HALVES = 0.03, 0.06, 0.1, 0.15, 0.22, 0.33
"""Halves of the widths, in ranges of the temperature."""
MORE = 3
"""Parameters of a loop: two amplitudes and a width."""


def gain(fit: AxisFit) -> float:
    """Return the gain of log-likelihood by the best loop over the temperature; 0 where none is known."""
    temperature = fit.sequence.conditions.temperature
    if temperature is None or np.ptp(temperature) == 0:
        return 0.0
    straight, *dragged = fit.whiten(fit.sequence.conditions.once(_columns)).T
    return max(fit.joint_gain(np.column_stack([straight, one]))[0] for one in dragged)


def _columns(conditions: Conditions) -> np.ndarray:
    """Return the temperature and what each play makes of it, each less its mean, shape (n, 1 + plays)."""
    temperature = np.ascontiguousarray(conditions.temperature, dtype=float)
    plays = [_play(temperature, half * np.ptp(temperature)) for half in HALVES]
    columns = np.column_stack([temperature, *plays])
    return columns - columns.mean(axis=0)


@njit(cache=True)
def _play(values, half):
    """Return what a pointer shows that ``values`` drag along with a play of twice ``half``."""
    dragged, at = np.empty(len(values)), values[0]
    for row in range(len(values)):
        at = min(max(at, values[row] - half), values[row] + half)
        dragged[row] = at
    return dragged

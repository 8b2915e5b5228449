"""Bias of a device at the start, as one log at rest shows it, for a filter that has to find the rest.

The gyroscopes at rest read their bias and the rotation of the Earth. The accelerometers read gravity: the bias along
it is the difference of the norm, and across it a bias cannot be distinguished from a tilt. One log does not show how
far the bias differs from one start to the next; it is taken to be as large as the bias itself.
"""

from collections.abc import Mapping

import numpy as np

from imugap.effects import Bias, TurnOnBias
from imugap.integrity.rest import GRAVITY_LEAST
from imugap.kinematics.earth import ROTATION_RATE
from imugap.log import ACCEL, GYRO

SITE = 0.043
"""Largest difference of gravity on the ground from the standard value [m/s^2] (Hirt et al. 2013)."""
UPRIGHT = 0.17
"""Largest tilt of an axis along gravity [rad] of a device that was set down level."""


def known_biases(levels: Mapping[str, float], gravity: float) -> dict[str, float]:
    """Return the biases that a log at rest shows: of each gyroscope, and of ``accel`` along gravity.

    Parameters as :func:`start_bias`.
    """
    found = {axis: levels[axis] for axis in GYRO if axis in levels}
    force = _force(levels, gravity)
    if force is not None:
        found["accel"] = float(np.linalg.norm(force)) - gravity
    return found


def start_bias(levels: Mapping[str, float], gravity: float) -> dict[str, tuple[Bias, TurnOnBias]]:
    """Return bias and its standard deviation at the start, of each axis.

    Parameters
    ----------
    levels
        Mean output of each axis at rest, SI.
    gravity
        Gravity of the site [m/s^2].
    """
    gyro = {axis: levels[axis] for axis in GYRO if axis in levels}
    std = max([ROTATION_RATE, *map(abs, gyro.values())])
    found = {axis: (Bias(level), TurnOnBias(std)) for axis, level in gyro.items()}
    force = _force(levels, gravity)
    if force is None:
        return found
    norm = float(np.linalg.norm(force))
    across = np.sort(np.abs(force))[:2].max()
    spread = float(max(SITE, abs(norm - gravity), across if across < UPRIGHT * norm else 0.0))
    along = (norm - gravity) * force / norm
    return found | {axis: (Bias(float(one)), TurnOnBias(spread)) for axis, one in zip(ACCEL, along, strict=True)}


def _force(levels: Mapping[str, float], gravity: float) -> np.ndarray | None:
    """Return the specific force, shape (3,); None where an axis or gravity is missing, so that it shows no bias."""
    if not set(ACCEL) <= set(levels):
        return None
    force = np.array([levels[axis] for axis in ACCEL])
    return force if np.linalg.norm(force) >= GRAVITY_LEAST * gravity else None

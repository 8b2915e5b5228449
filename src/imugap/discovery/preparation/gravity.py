"""Gravity in the log of a device at rest: a part of its level that is no error."""

from dataclasses import dataclass

import numpy as np

from imugap.log import ACCEL
from imugap.model import ErrorModel, offset_of, shifted

MAX_DIFFERENCE = 0.1
"""Largest relative difference of the level from gravity for a device that senses gravity on the axes of its log."""
SITE_UNCERTAINTY = 0.043
"""Largest difference of gravity on the ground, 9.764 to 9.834 m/s^2, from the standard value [m/s^2].

Hirt et al. 2013, doi:10.1002/grl.50838.
"""


@dataclass(frozen=True)
class SensedGravity:
    """Gravity in the level of the accelerometers of a device at rest.

    Attributes
    ----------
    size
        Assumed gravity [m/s^2].
    axes
        Accelerometer axes of the log.
    biases
        Bias of each of them [m/s^2]: that of the start model, and what the size of the level shows along its direction.
        Across it a bias cannot be distinguished from a tilt.
    along
        Component of the biases along the sensed gravity [m/s^2].
    """

    size: float
    axes: tuple[str, ...]
    biases: tuple[float, ...]
    along: float

    @classmethod
    def of(cls, levels: ErrorModel, known: ErrorModel, size: float) -> "SensedGravity | None":
        """Return the gravity in the constant terms of a model of a device at rest; None if it senses none.

        ``known`` is the start model, ``size`` the gravity of the site [m/s^2].
        """
        axes = tuple(axis for axis in ACCEL if axis in levels.axes)
        before = np.array([offset_of(known[axis]) if axis in known.axes else 0.0 for axis in axes])
        force = np.array([offset_of(levels[axis]) for axis in axes]) - before
        length = float(np.linalg.norm(force))
        if abs(length - size) > MAX_DIFFERENCE * size:
            return None
        biases = before + (length - size) * force / length
        return cls(size, axes, tuple(biases.tolist()), float(biases @ force) / length)

    def taken_from(self, model: ErrorModel) -> ErrorModel:
        """Return a model whose constant terms are the biases, without gravity."""
        biases = dict(zip(self.axes, self.biases, strict=True))
        cleared = {axis: shifted(model[axis], bias - offset_of(model[axis])) for axis, bias in biases.items()}
        return ErrorModel({**model.axes, **cleared})

    def sentence(self) -> str:
        """Return what was assumed, and what the log does not tell, as text."""
        return (
            f"{', '.join(self.axes)}: the level holds gravity, {self.size:g} m/s^2, which is not in the model. "
            f"The bias along it is {self.along:.3g} m/s^2, as uncertain as the gravity of the site (up to "
            f"{SITE_UNCERTAINTY:g} m/s^2 if not given); across it a bias cannot be distinguished from a tilt."
        )

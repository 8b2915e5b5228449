"""Simulate the log of a device at rest with an error model."""

import os

import numpy as np
import pandas as pd

from imugap import log
from imugap.model import ErrorModel
from imugap.units import STANDARD_GRAVITY


def simulate(
    model: ErrorModel, duration: float, rate: float, gravity: float = STANDARD_GRAVITY, seed: int = 0
) -> pd.DataFrame:
    """Simulate the log of a device at rest, z down.

    Parameters
    ----------
    duration, rate
        Length [s] and sampling rate [Hz].
    gravity
        Gravity of the site [m/s^2].
    """
    return model.simulate(_at_rest(model, duration, rate, gravity), seed, "simulate")


def _at_rest(model: ErrorModel, duration: float, rate: float, gravity: float) -> pd.DataFrame:
    """Return the error-free log of the axes of ``model``, z down; ValueError where it exceeds the memory."""
    memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    samples, most = (
        duration * rate,
        memory // (2 * 8 * (len(model.sensors) + 1)),
    )  # its columns, and as many random ones
    if samples > most:
        raise ValueError(f"simulate: expected a duration and rate of at most {most:.3g} samples; found {samples:.3g}")
    values = {axis: -gravity if axis == "accel_z" else 0.0 for axis in log.AXES if axis in model.axes}
    return log.from_samples({axis: np.full(round(samples), value) for axis, value in values.items()}, 1 / rate)

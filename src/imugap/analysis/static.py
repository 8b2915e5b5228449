"""Simulate the log of a device at rest with an error model."""

import os
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pandas as pd

from imugap import log
from imugap.model import ErrorModel
from imugap.units import STANDARD_GRAVITY

WHOLE, PART = 2**20, 2**18
"""Largest number of samples of a run that is simulated at once, and of a part of a longer one."""


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
    memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    most = memory // (2 * 8 * (len(model.sensors) + 1))  # its columns, and as many random ones
    require_count(duration * rate, most, "memory")
    return model.simulate(_at_rest(model, 0, round(duration * rate), rate, gravity), seed, "simulate")


def simulate_parts(
    model: ErrorModel,
    duration: float,
    rate: float,
    gravity: float = STANDARD_GRAVITY,
    seed: int = 0,
    whole: int = WHOLE,
    most: int = PART,
) -> Iterator[pd.DataFrame]:
    """Simulate the log of a device at rest in parts of at most ``most`` samples, as :func:`simulate` does.

    A run of at most ``whole`` samples, or of a model with an effect that needs the whole run, is one part: that of
    :func:`simulate`. Of a longer run the samples are the same to rounding; flicker noise and noise of any slope come
    from other draws.
    """
    count = round(duration * rate)
    edges = np.linspace(0, count, -(-count // most) + 1).astype(int)

    def at_rest() -> Iterator[pd.DataFrame]:
        return (_at_rest(model, *edges[part : part + 2], rate, gravity) for part in range(len(edges) - 1))

    parts = None if count <= whole else model.simulate_parts(at_rest, count, 1 / rate, seed, "simulate")
    return iter([simulate(model, duration, rate, gravity, seed)]) if parts is None else parts


def require_count(count: float, most: float, room: str | Path) -> None:
    """Raise a ValueError for more samples than there is room for; ``room`` is the memory, or the file on its disk."""
    if count > most:
        raise ValueError(
            f"{room}: simulate: expected a duration and rate of at most {most:.3g} samples, for which there is room; "
            f"found {count:.3g}"
        )


def _at_rest(model: ErrorModel, first: int, last: int, rate: float, gravity: float) -> pd.DataFrame:
    """Return the error-free log of the axes of ``model``, z down, from one sample to before another one."""
    values = {axis: -gravity if axis == "accel_z" else 0.0 for axis in log.AXES if axis in model.axes}
    time = pd.Index(1 / rate * np.arange(first, last), name=log.TIME)
    return log.check(pd.DataFrame({axis: np.full(last - first, value) for axis, value in values.items()}, index=time))

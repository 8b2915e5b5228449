"""Conditions of an axis, on which its error depends: time, temperature, and the error-free motion."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TypeVar

import numpy as np
import pandas as pd

from imugap.log import axes

Made = TypeVar("Made")


@dataclass(frozen=True)
class Conditions:
    """Input of an effect besides its parameters and its random stream.

    Attributes
    ----------
    time
        Time of the samples since power-on [s], shape (n,).
    interval
        Sampling interval [s].
    temperature
        Temperature of the device [degC], shape (n,), or None where it is not known.
    axis
        Canonical name of the axis, or None where it is not known.
    ideal
        Error-free log of all axes at the samples, or None where it is not known.
    motion
        Error-free log at the sampling interval, index time [s], which also covers times before the first and after the
        last sample, as far as they are known; None where only ``ideal`` is known.
    """

    time: np.ndarray
    interval: float
    temperature: np.ndarray | None = None
    axis: str | None = None
    ideal: pd.DataFrame | None = None
    motion: pd.DataFrame | None = None
    _made: dict = field(init=False, repr=False, compare=False, default_factory=dict)

    def __len__(self) -> int:
        """Return the number of samples."""
        return len(self.time)

    @property
    def error_free(self) -> np.ndarray | float:
        """Return the error-free signal of the axis, shape (n,); 0 where it is not known, as for a device at rest."""
        return 0.0 if self.axis is None else self.signals.get(self.axis, 0.0)

    @cached_property
    def signals(self) -> dict[str, np.ndarray]:
        """Error-free signal of each axis, shape (n,); none where they are not known."""
        return {} if self.ideal is None else {axis: self.ideal[axis].to_numpy(float) for axis in axes(self.ideal)}

    @property
    def known_motion(self) -> pd.DataFrame | None:
        """Return all that is known of the error-free log, index time [s]: at the samples, and beyond them if known."""
        if self.motion is not None or self.ideal is None:
            return self.motion
        return self.ideal.set_axis(self.time)

    def once(self, make: Callable[["Conditions"], Made]) -> Made:
        """Return ``make(self)``, computed at the first call and cached."""
        if make not in self._made:
            self._made[make] = make(self)
        return self._made[make]

    def knows(self, axes: Sequence[str]) -> bool:
        """Return whether the own axis and the error-free signals of ``axes`` are known."""
        return self.axis is not None and self.ideal is not None and self.signals.keys() >= set(axes)


@dataclass(frozen=True, eq=False)
class Run:
    """Run of a device at rest that is simulated in parts, in the memory of a part.

    Attributes
    ----------
    count
        Number of samples.
    interval
        Sampling interval [s].
    parts
        Function that iterates over the conditions of the parts, as often as it is called.
    """

    count: int
    interval: float
    parts: Callable[[], Iterator[Conditions]]

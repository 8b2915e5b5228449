"""Case as a program under test gets it: the logs, the error-free log if the device moves, and the start model."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
import pandas as pd

from imu_benchmark import start_model
from imu_benchmark.log import AXES, TEMPERATURE, read
from imu_benchmark.schema import FormatError


@dataclass(frozen=True, eq=False)
class Case:
    """A case.

    Attributes
    ----------
    logs
        One log, or several of one device.
    reference
        The error-free log of a device that moves, with its own instants.
    model
        The start model, empty where the device has bias and white noise.
    """

    name: str
    logs: tuple[pd.DataFrame, ...]
    reference: pd.DataFrame | None
    model: start_model.StartModel

    @property
    def axes(self) -> list[str]:
        """Return the axes of the first log."""
        return [axis for axis in AXES if axis in self.logs[0]]

    @cached_property
    def interval(self) -> float:
        """Return the sampling interval [s] of the first log: the median step."""
        return float(np.median(np.diff(self.logs[0].index)))

    @cached_property
    def ideal(self) -> pd.DataFrame | None:
        """Return the reference at the instants of the first log."""
        if self.reference is None:
            return None
        time = self.logs[0].index
        columns = {axis: np.interp(time, self.reference.index, self.reference[axis]) for axis in self.axes}
        return pd.DataFrame(columns, index=time)

    @cached_property
    def temperature(self) -> np.ndarray | None:
        """Return the temperature [degC] of the first log, if it has one."""
        return self.logs[0][TEMPERATURE].to_numpy() if TEMPERATURE in self.logs[0] else None

    def errors(self, axis: str) -> np.ndarray:
        """Return the first log of an axis without its reference and without its mean, shape (n,)."""
        values = self.logs[0][axis].to_numpy()
        values = values if self.ideal is None else values - self.ideal[axis].to_numpy()
        return values - values.mean()

    def known(self, axis: str) -> dict[str, dict[str, float]]:
        """Return the effects of the start model on an axis, by name; without a model bias and white noise."""
        effects = self.model.get(axis, [{"bias": {}}, {"white_noise": {}}])
        return {name: dict(parameters) for effect in effects for name, parameters in effect.items()}


def read_case(folder: str | Path) -> Case:
    """Read a case."""
    folder = Path(folder)
    paths = sorted([*folder.glob("log.csv"), *folder.glob("run*.csv")])
    if not paths:
        raise FormatError(folder, "", "log.csv or run1.csv", "neither")
    reference, model = folder / "reference.csv", folder / "model.yaml"
    return Case(
        folder.name,
        tuple(map(read, paths)),
        read(reference) if reference.exists() else None,
        start_model.read(model) if model.exists() else {},
    )

"""Virtual bench: static logs of a simulated device from a recipe, with the truth kept apart."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
import yaml

from imugap import log
from imugap.kinematics.site import Site
from imugap.model import ErrorModel
from imugap.stream import stream


@dataclass(frozen=True)
class Room:
    """Temperature of the device [degC] over a run: self-heating after power-on, and a slow swing of the room."""

    ambient_degC: float
    self_heating_degC: float
    time_constant_s: float
    room_swing_degC: float
    room_period_s: float

    def temperature(self, time: np.ndarray, phase: float) -> np.ndarray:
        """Return the temperature at ``time`` [s] since power-on, for a ``phase`` [rad] of the room's swing."""
        warm = self.self_heating_degC * -np.expm1(-time / self.time_constant_s)
        swing = self.room_swing_degC * np.sin(2 * np.pi * time / self.room_period_s + phase)
        return self.ambient_degC + warm + swing


@dataclass(frozen=True)
class Bench:
    """A recipe: the device's error model, the site, the room."""

    model: ErrorModel
    site: Site
    room: Room

    @classmethod
    def read(cls, path: str | Path) -> "Bench":
        """Read a recipe (YAML with ``model``, ``site`` and ``temperature``)."""
        recipe = yaml.safe_load(Path(path).read_text())
        try:
            return cls(
                ErrorModel.from_mapping(recipe["model"]),
                Site.from_mapping(recipe["site"]),
                Room(**recipe["temperature"]),
            )
        except (KeyError, TypeError, ValueError) as error:
            raise ValueError(f"{path}: expected a recipe with model, site and temperature; found {error}") from error

    def run(self, number: int, interval: float, duration: float, seed: int) -> pd.DataFrame:
        """Return the log of static run ``number``: six axes and the temperature, ``duration`` [s] long."""
        ideal = self.site.ideal()
        count = round(duration / interval)
        phase = stream(seed, "bench", number, "room").uniform(0, 2 * np.pi)
        samples = {axis: np.full(count, ideal[axis]) for axis in log.AXES}
        samples[log.TEMPERATURE] = self.room.temperature(interval * np.arange(count), phase)
        measured = self.model.simulate(log.from_samples(samples, interval), seed, "bench", number)
        return measured.assign(temperature=measured["temperature"].round(2))

    def truth(self) -> dict:
        """Return the truth, for scoring only: the model."""
        return {"model": self.model.to_mapping()}

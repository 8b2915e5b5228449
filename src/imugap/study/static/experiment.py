"""Simulated static logs of one axis with known truth, in any number of runs."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pandas as pd
import yaml

from imugap.effects import Conditions, GaussMarkov
from imugap.effects.effect import AxisModel
from imugap.model import ErrorModel


@dataclass(frozen=True)
class Experiment:
    """Recipe of the simulated logs.

    Attributes
    ----------
    axis
        Canonical name of the axis, for units.
    model
        Its error model.
    interval, count
        Sampling interval [s] and number of samples.
    """

    axis: str
    model: AxisModel
    interval: float
    count: int

    @classmethod
    def read(cls, path: str | Path) -> "Experiment":
        """Read a recipe (YAML: ``axis``, ``rate_hz``, ``duration_s``, ``model``)."""
        recipe = yaml.safe_load(Path(path).read_text())
        model = ErrorModel.from_mapping(recipe["model"])[recipe["axis"]]
        return cls(recipe["axis"], model, 1 / recipe["rate_hz"], round(recipe["duration_s"] * recipe["rate_hz"]))

    @property
    def kinds(self) -> tuple[type, ...]:
        """Return the types of the processes."""
        return tuple(map(type, self.model.stochastic()))

    def at(self, time: float) -> "Experiment":
        """Return the same with another correlation time [s] of the Gauss-Markov process, its std unchanged."""
        effects = [
            replace(effect, correlation_time=float(time)) if isinstance(effect, GaussMarkov) else effect
            for effect in self.model
        ]
        return replace(self, model=AxisModel(tuple(effects)))

    def simulate(self, seed: int, *labels: object) -> np.ndarray:
        """Return the error sequence of the run that ``labels`` name, shape (count,)."""
        conditions = Conditions(np.arange(self.count) * self.interval, self.interval)
        return self.model.simulate(np.zeros(self.count), conditions, seed, *labels)

    def truth(self) -> pd.Series:
        """Return every parameter and the driving PSD, index ``effect``, ``ordinal``, ``parameter``."""
        values = {(effect.name, 1, key): value for effect in self.model for key, value in effect.parameters().items()}
        for effect in self.model:
            if isinstance(effect, GaussMarkov):
                values[(effect.name, 1, "driving_psd")] = effect.driving_psd
        return pd.Series(values, name="truth").rename_axis(["effect", "ordinal", "parameter"])

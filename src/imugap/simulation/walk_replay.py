"""The replay of a real walk: its own log once more, with errors added, stands for another walk of the same kind.

What the navigator makes of the log as it is counts as the truth. The same strides, turns and stands, the same shocks
and the same mounting go through a device whose errors are drawn, and what the end moves by is the error of that walk.
To first order it is no matter that the log has errors already: they are in both.
"""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from imugap.filters.zero_velocity import STANCE
from imugap.kinematics.strapdown import POSITION
from imugap.model import ErrorModel
from imugap.navigation.pedestrian import WalkAssumptions, WalkSolution, navigate
from imugap.simulation.camera_track import footprints


@dataclass(frozen=True, eq=False)
class Replay:
    """A walk to be replayed.

    Attributes
    ----------
    log
        The log as it is.
    solution
        What the filter makes of it.
    model, assumptions
        What the filter takes for granted.
    seen
        Whether the end is told as where cameras saw the foot: with origin and heading fitted to the whole walk.
    """

    log: pd.DataFrame
    solution: WalkSolution
    model: ErrorModel
    assumptions: WalkAssumptions
    seen: bool

    @classmethod
    def of(cls, log: pd.DataFrame, model: ErrorModel, assumptions: WalkAssumptions, seen: bool) -> "Replay":
        """Navigate the log as it is."""
        return cls(log, navigate(log, model, assumptions), model, assumptions, seen)

    def end(self, device: ErrorModel, velocity: np.ndarray, seed: int, *labels: object) -> np.ndarray:
        """Return the error of the end [m], shape (3,), with the errors of a device.

        Parameters
        ----------
        device
            The errors that are added.
        velocity
            Of the foot at stance, in ``n`` [m/s], shape (n, 3): the filter takes it for zero.
        """
        log = device.simulate(self.log, seed, *labels)
        found = navigate(log, self.model, self.assumptions, velocity=-velocity)
        if self.seen:
            return footprints(found, self.solution.trajectory[list(POSITION)]).off
        return (found.trajectory - self.solution.trajectory)[list(POSITION)].iloc[-1].to_numpy()

    def still(self) -> np.ndarray:
        """Return the velocity at stance of a foot that rests, shape (n, 3)."""
        return np.zeros((len(self.log), 3))

    def slip(self, std: float, rng: np.random.Generator) -> np.ndarray:
        """Return a velocity drawn for each stance, each axis with this standard deviation [m/s], shape (n, 3)."""
        stance = self.solution.phase == STANCE
        number = np.cumsum(np.diff(stance, prepend=False) & stance)
        return stance[:, None] * (std * rng.standard_normal((number[-1] + 1, 3)))[number]

    def sink(self, velocity: float) -> np.ndarray:
        """Return a velocity down at every stance [m/s], shape (n, 3)."""
        return np.outer(self.solution.phase == STANCE, [0.0, 0.0, velocity])

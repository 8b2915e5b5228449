"""Replay of a real walk: its own log with simulated errors added, as another walk of the same kind.

The solution of the original log is the truth. The same strides, shocks and mounting pass through a device whose errors
are drawn, and the displacement of the end is the error of that walk. To first order the errors of the original log do
not matter, since they are in both.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd

from imugap.effects.conditions import Conditions
from imugap.filters.zero_velocity import STANCE
from imugap.kinematics.strapdown import POSITION
from imugap.model import ErrorModel
from imugap.navigation.walk.pedestrian import WalkAssumptions, WalkSolution, navigate
from imugap.simulation.camera_track import compare_with_cameras


@dataclass(frozen=True, eq=False)
class Replay:
    """Walk to replay.

    Attributes
    ----------
    log
        Original log.
    solution
        Its filter solution.
    model, assumptions
        Error model and assumptions of the filter.
    seen
        Whether the end error is that of a comparison with cameras: origin and heading fitted to the whole walk.
    """

    log: pd.DataFrame
    solution: WalkSolution
    model: ErrorModel
    assumptions: WalkAssumptions
    seen: bool

    @classmethod
    def of(cls, log: pd.DataFrame, model: ErrorModel, assumptions: WalkAssumptions, seen: bool) -> "Replay":
        """Navigate the original log."""
        return cls(log, navigate(log, model, assumptions), model, assumptions, seen)

    def end(
        self, device: ErrorModel, velocity: np.ndarray, seed: int, *labels: object,
        at: Mapping[str, Conditions] | None = None,
    ) -> np.ndarray:  # fmt: skip
        """Return the error of the end [m], shape (3,), with the errors of a device.

        Parameters
        ----------
        device
            Errors to add.
        velocity
            Velocity of the foot at stance, in ``n`` [m/s], shape (n, 3), which the filter assumes zero.
        at
            Conditions of the log (:func:`imugap.model.conditions`), which several replays may share.
        """
        log = device.simulate(self.log, seed, *labels, at=at)
        found = navigate(log, self.model, self.assumptions, velocity=-velocity)
        if self.seen:
            return compare_with_cameras(found, self.solution.trajectory[list(POSITION)]).off
        return (found.trajectory - self.solution.trajectory)[list(POSITION)].iloc[-1].to_numpy()

    def still(self) -> np.ndarray:
        """Return zero velocity at stance, shape (n, 3)."""
        return np.zeros((len(self.log), 3))

    def slip(self, std: float, rng: np.random.Generator) -> np.ndarray:
        """Draw a velocity for each stance, each axis with a standard deviation [m/s], shape (n, 3)."""
        stance = self.solution.phase == STANCE
        number = np.cumsum(np.diff(stance, prepend=False) & stance)
        return stance[:, None] * (std * rng.standard_normal((number[-1] + 1, 3)))[number]

    def sink(self, velocity: float) -> np.ndarray:
        """Return a constant downward velocity at every stance [m/s], shape (n, 3)."""
        return np.outer(self.solution.phase == STANCE, [0.0, 0.0, velocity])

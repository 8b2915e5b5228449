"""What a model of the errors of a device is worth to a walk: subtracted ahead of the navigator, or inside its filter.

He et al. (2023, section 3.3, figure 5) simulate the errors of the device and subtract the sequence from its output.
Such a sequence shares with the errors of the device what the model knows for certain, its fixed bias; all that is
random in it is drawn anew, and adds to what is there. A filter can use the random part too: not one draw of it, but its
states and densities.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from imugap.effects import Bias, StabilityRestoration, WhiteNoise
from imugap.effects.effect import AxisModel
from imugap.filters.zero_velocity import Detector
from imugap.kinematics.strapdown import POSITION
from imugap.log import ACCEL, AXES, GYRO, axes, interval
from imugap.model import ErrorModel
from imugap.navigation.pedestrian import WalkAssumptions, WalkSolution
from imugap.numerics.rotation import wrap
from imugap.simulation.walk import Walk


@dataclass(frozen=True)
class End:
    """How far a navigated walk ends from where it does.

    Attributes
    ----------
    position, height
        Horizontal distance (He et al. 2023, eq. 22) and height too much [m].
    heading
        Magnitude of the error of the heading (eq. 23) [rad].
    nees
        Square of the horizontal error by its covariance: chi-square with two degrees of freedom for a filter that
        knows itself.
    heading_nees
        The same of the heading, with one.
    """

    position: float
    height: float
    heading: float
    nees: float
    heading_nees: float

    @classmethod
    def of(cls, solution: WalkSolution, truth: pd.DataFrame) -> "End":
        """Compare the end of a solution with that of the true Trajectory; both begin at the origin."""
        found, std = solution.trajectory.iloc[-1], solution.trajectory_std.iloc[-1]
        off = (found[list(POSITION)] - truth[list(POSITION)].iloc[-1]).to_numpy(float)
        turn = wrap(float(found["heading"] - truth["heading"].iloc[-1]))
        nees = off[:2] @ np.linalg.solve(solution.horizontal[-1], off[:2])
        return cls(float(np.hypot(*off[:2])), -float(off[2]), abs(turn), float(nees), (turn / std["heading"]) ** 2)


def granted(walk: Walk) -> WalkAssumptions:
    """Return what a filter takes for granted on a simulated walk: gravity, and a body that stands without a sway."""
    return WalkAssumptions(gravity=walk.site.gravity, rate_std=0.0)


def subtracted(log: pd.DataFrame, model: ErrorModel, seed: int, *labels: object) -> pd.DataFrame:
    """Return the log less one sequence of errors that the model draws from the named stream."""
    nothing = pd.DataFrame(0.0, index=log.index, columns=list(axes(log)))
    return log - model.simulate(nothing, seed, *labels)


def at_stand(log: pd.DataFrame) -> ErrorModel:
    """Return the mean of the gyroscopes at the stand, as biases: what a user takes off without any model."""
    gyro, accel = (log[list(triad)].to_numpy() for triad in (GYRO, ACCEL))
    bias = Detector().stand(gyro, accel, interval(log)).bias
    return ErrorModel({axis: AxisModel((Bias(value),)) for axis, value in zip(GYRO, bias, strict=True)})


def plain(densities: Mapping[str, float]) -> ErrorModel:
    """Return the model of a filter that has no states for its sensors: white noise of each axis."""
    return ErrorModel({axis: AxisModel((WhiteNoise(densities[axis]),)) for axis in AXES})


def inside(model: ErrorModel) -> ErrorModel:
    """Return what of a model a filter can hold.

    The statistical restoration scales the errors of a run about their mean until their stability over periods P is Bs.
    Of white noise, whose own is N/sqrt(P), it so makes white noise of density Bs sqrt(P), and nothing else. An effect
    that is fitted to be nothing is left out.
    """
    return ErrorModel({axis: _without_restoration(one) for axis, one in model.axes.items()})


def _without_restoration(model: AxisModel) -> AxisModel:
    effects = [one for one in model if all(one.parameters().values())]
    for restored in [one for one in effects if isinstance(one, StabilityRestoration)]:
        density = restored.stability * np.sqrt(restored.period)
        effects = [replace(one, density=density) if isinstance(one, WhiteNoise) else one for one in effects]
        effects.remove(restored)
    return AxisModel(tuple(effects))

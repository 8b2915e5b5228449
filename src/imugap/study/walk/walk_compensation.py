"""Effect of a sensor-error model on a walk: simulated errors subtracted from the log, or the model in the filter.

He et al. (2023, section 3.3, figure 5) simulate the errors of the device and subtract the sequence from its output. The
sequence shares only its deterministic part, the fixed bias, with the errors of the device; its random part is drawn
anew, and adds to them. A filter can use the random part too, by its states and densities.
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
from imugap.navigation.walk.pedestrian import WalkAssumptions, WalkSolution
from imugap.numerics.rotation import wrap
from imugap.simulation.walk import Walk


@dataclass(frozen=True)
class End:
    """Error of a navigated walk at its end.

    Attributes
    ----------
    position, height
        Horizontal distance (He et al. 2023, eq. 22) and height error [m].
    heading
        Magnitude of the error of the heading (eq. 23) [rad].
    nees
        Normalised squared horizontal error: chi-square with two degrees of freedom for a consistent filter.
    heading_nees
        The same for the heading, with one.
    """

    position: float
    height: float
    heading: float
    nees: float
    heading_nees: float

    @classmethod
    def of(cls, solution: WalkSolution, truth: pd.DataFrame) -> "End":
        """Compare the ends of a solution and of the true Trajectory; both begin at the origin."""
        found, std = solution.trajectory.iloc[-1], solution.trajectory_std.iloc[-1]
        off = (found[list(POSITION)] - truth[list(POSITION)].iloc[-1]).to_numpy(float)
        turn = wrap(float(found["heading"] - truth["heading"].iloc[-1]))
        nees = off[:2] @ np.linalg.solve(solution.horizontal[-1], off[:2])
        return cls(float(np.hypot(*off[:2])), -float(off[2]), abs(turn), float(nees), (turn / std["heading"]) ** 2)


def known_assumptions(walk: Walk) -> WalkAssumptions:
    """Return the assumptions for a simulated walk: known gravity, and a body that stands without sway."""
    return WalkAssumptions(gravity=walk.site.gravity, rate_std=0.0)


def subtracted(log: pd.DataFrame, model: ErrorModel, seed: int, *labels: object) -> pd.DataFrame:
    """Return the log minus one error sequence that the model draws from the named stream."""
    nothing = pd.DataFrame(0.0, index=log.index, columns=list(axes(log)))
    return log - model.simulate(nothing, seed, *labels)


def stand_biases(log: pd.DataFrame) -> ErrorModel:
    """Return the mean gyroscope outputs at the stand as biases: a correction without any model."""
    gyro, accel = (log[list(triad)].to_numpy() for triad in (GYRO, ACCEL))
    bias = Detector().stand(gyro, accel, interval(log)).bias
    return ErrorModel({axis: AxisModel((Bias(value),)) for axis, value in zip(GYRO, bias, strict=True)})


def white_noise_model(densities: Mapping[str, float]) -> ErrorModel:
    """Return a model without sensor states: white noise of each axis."""
    return ErrorModel({axis: AxisModel((WhiteNoise(densities[axis]),)) for axis in AXES})


def filter_model(model: ErrorModel) -> ErrorModel:
    """Return the part of a model that a filter can use.

    The statistical restoration scales the errors of a run about their mean to a stability Bs over periods P. White
    noise, whose stability is N/sqrt(P), thus becomes white noise of density Bs sqrt(P). Effects that are fitted to be
    zero are left out.
    """
    return ErrorModel({axis: _without_restoration(one) for axis, one in model.axes.items()})


def _without_restoration(model: AxisModel) -> AxisModel:
    effects = [one for one in model if all(one.parameters().values())]
    for restored in [one for one in effects if isinstance(one, StabilityRestoration)]:
        density = restored.stability * np.sqrt(restored.period)
        effects = [replace(one, density=density) if isinstance(one, WhiteNoise) else one for one in effects]
        effects.remove(restored)
    return AxisModel(tuple(effects))

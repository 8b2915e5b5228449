"""The simulated twin of a real walk: the same strides, turns and stands, on a device whose errors are drawn.

What a single error does to the end of a walk is told from pairs: the twin is navigated with all errors and without the
one, everything else drawn the same. While the errors act independently and in proportion to their size, the variances
of these differences add up to that of all.
"""

from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pandas as pd
import yaml

from imugap.effects import CATALOGUE
from imugap.effects.effect import AxisModel, Effect
from imugap.filters.zero_velocity import MOVING
from imugap.io import reference
from imugap.kinematics.strapdown import POSITION, VELOCITY
from imugap.log import ACCEL, AXES, GYRO, triad
from imugap.model import ErrorModel
from imugap.navigation.pedestrian import SHORTEST_STRIDE_M, WalkAssumptions, WalkSolution
from imugap.simulation.walk import Course, Leg, Walk
from imugap.stream import stream

SLIP = "stance_motion"
"""Name of the motion of the foot at stance among the errors."""

AT_REST = ("white_noise", "random_walk", "turn_on_bias")
"""Errors of which a log at rest says something."""


@dataclass(frozen=True)
class Kind:
    """Errors of a kind of device: triad to effect to parameters, a number each or the spread of what is drawn."""

    errors: Mapping[str, Mapping[str, Mapping]]

    @classmethod
    def read(cls, path: str | Path) -> "Kind":
        """Read from YAML; parameters of all other axes, or of all, may go by ``others`` or ``all``."""
        return cls(yaml.safe_load(Path(path).read_text()))

    def names(self) -> list[tuple[str, str]]:
        """Return (triad, effect) of every error."""
        return [(kind, name) for kind, effects in self.errors.items() for name in effects]

    def only(self, names: Collection[str]) -> "Kind":
        """Return the kind with these effects alone."""
        kept = {
            kind: {name: values for name, values in effects.items() if name in names}
            for kind, effects in self.errors.items()
        }
        return Kind(kept)

    def draw(self, seed: int, *labels: object) -> ErrorModel:
        """Return the errors of one device of this kind."""
        axes = {}
        for axis in AXES:
            kind = "gyro" if axis in GYRO else "accel"
            own = [self._effect(kind, name, axis, seed, labels) for name in self.errors[kind]]
            axes[axis] = AxisModel(tuple(own))
        return ErrorModel(axes)

    def _effect(self, kind: str, name: str, axis: str, seed: int, labels: tuple) -> Effect:
        effect, values = CATALOGUE[name], {}
        own = () if effect.common else (axis,)
        for key, given in self.errors[kind][name].items():
            whole = [one[-1] for one in triad(axis)]
            places = {"all": whole, "others": [one for one in whole if one != axis[-1]]}.get(key, [key])
            for place in places:
                if not isinstance(given, Mapping):
                    values[place] = given
                    continue
                values[place] = given["spread"] * stream(seed, *labels, kind, name, place, *own).standard_normal()
        return effect(**values)


def without(model: ErrorModel, kind: str, name: str) -> ErrorModel:
    """Return a model without one effect of one triad, ``gyro`` or ``accel``."""
    spared = GYRO if kind == "gyro" else ACCEL
    axes = {
        axis: AxisModel(tuple(one for one in of if axis not in spared or one.name != name))
        for axis, of in model.axes.items()
    }
    return ErrorModel(axes)


def twin(solution: WalkSolution, like: Walk) -> Walk:
    """Return a walk with the strides of a solution, and in all else like another.

    A stride is what lies between the middles of two stances; all take the same time. How a foot swings and lands is
    that of the other: what a detector takes for stance is but the stillest part of it.
    """
    time, table, at = solution.time.to_numpy(), solution.trajectory, solution.stances()
    steps = np.diff(table[list(POSITION)].to_numpy()[at], axis=0)
    turns = np.degrees(np.diff(np.unwrap(table["heading"].to_numpy())[at]))
    lengths, times = np.hypot(steps[:, 0], steps[:, 1]), np.diff(time[at])
    walked = lengths > SHORTEST_STRIDE_M
    usual, stride = float(np.median(lengths[walked])), float(np.median(times[walked]))
    gait = replace(like.gait, stride_s=stride, length_m=usual)
    legs = [
        Leg(1, float(turn), float(-down), float(length / usual))
        for turn, down, length in zip(turns, steps[:, 2], lengths, strict=True)
    ]
    first, last = (np.flatnonzero(solution.phase == MOVING)[end] for end in (0, -1))
    course = Course(float(time[first] - time[0]), tuple(legs), max(float(time[-1] - time[last]), 0.5))
    return replace(like, gait=gait, course=course, rate_hz=(len(time) - 1) / float(time[-1] - time[0]))


def measured(walk: Walk, assumptions: WalkAssumptions, run: int, seed: int) -> tuple[pd.DataFrame, np.ndarray]:
    """Return the log of a walk, and the velocity of a point of the foot as a filter measures it that assumes rightly.

    The arm of the point is drawn, and noise of the assumed density is added to its velocity, shape (n, 3) [m/s].
    """
    truth, ideal = walk.truth(run, seed), walk.ideal(run, seed)
    rng = stream(seed, "measured", run)
    point = np.cross(ideal[list(GYRO)].to_numpy(), assumptions.arm_std * rng.standard_normal(3))
    velocity = truth[list(VELOCITY)].to_numpy(float) + reference.rotations(truth).apply(point)
    std = np.sqrt(2 * assumptions.velocity_std**2 * assumptions.correlation_s * walk.rate_hz)
    return walk.model.simulate(ideal, seed, "walk", run), velocity + std * rng.standard_normal(velocity.shape)

"""Simulated walk matched to a real one: the same strides, turns and stands, on a device whose errors are drawn.

The effect of a single error on the end of a walk follows from pairs: the walk is navigated with all errors and without
that one, with the same draws of all others. For independent and linear errors the variances of these differences add up
to that of all errors.
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
from imugap.io.references import reference
from imugap.kinematics.strapdown import POSITION, VELOCITY
from imugap.log import ACCEL, AXES, GYRO, triad
from imugap.model import ErrorModel
from imugap.navigation.walk.pedestrian import SHORTEST_STRIDE_M, WalkAssumptions, WalkSolution
from imugap.simulation.walk import Walk, WalkCourse, WalkLeg
from imugap.stream import stream

STANCE_MOTION = "stance_motion"
"""Name of the motion of the foot at stance among the errors."""

AT_REST = ("white_noise", "random_walk", "turn_on_bias")
"""Errors that a log at rest shows."""


@dataclass(frozen=True)
class DeviceClass:
    """Errors of a class of devices: triad to effect to parameters, each a number or the spread of a normal draw."""

    errors: Mapping[str, Mapping[str, Mapping]]

    @classmethod
    def read(cls, path: str | Path) -> "DeviceClass":
        """Read from YAML; a key ``others`` or ``all`` stands for the parameters of all other axes, or of all."""
        return cls(yaml.safe_load(Path(path).read_text()))

    def names(self) -> list[tuple[str, str]]:
        """Return (triad, effect) of every error."""
        return [(kind, name) for kind, effects in self.errors.items() for name in effects]

    def only(self, names: Collection[str]) -> "DeviceClass":
        """Return the class with these effects alone."""
        kept = {
            kind: {name: values for name, values in effects.items() if name in names}
            for kind, effects in self.errors.items()
        }
        return DeviceClass(kept)

    def draw(self, seed: int, *labels: object) -> ErrorModel:
        """Draw the error model of one device."""
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


def matched_walk(solution: WalkSolution, like: Walk) -> Walk:
    """Return a walk with the strides of a solution, and the gait and device of the walk ``like``.

    A stride goes from the middle of a stance to that of the next; all take the same time. Swing and strike are those of
    ``like``, since the detected stance is only the stillest part of the true one.
    """
    time, table, at = solution.time.to_numpy(), solution.trajectory, solution.stances()
    steps = np.diff(table[list(POSITION)].to_numpy()[at], axis=0)
    turns = np.degrees(np.diff(np.unwrap(table["heading"].to_numpy())[at]))
    lengths, times = np.hypot(steps[:, 0], steps[:, 1]), np.diff(time[at])
    moved = lengths > SHORTEST_STRIDE_M
    usual, stride = float(np.median(lengths[moved])), float(np.median(times[moved]))
    gait = replace(like.gait, stride_s=stride, length_m=usual)
    legs = [
        WalkLeg(1, float(turn), float(-down), float(length / usual))
        for turn, down, length in zip(turns, steps[:, 2], lengths, strict=True)
    ]
    first, last = (np.flatnonzero(solution.phase == MOVING)[end] for end in (0, -1))
    course = WalkCourse(float(time[first] - time[0]), tuple(legs), max(float(time[-1] - time[last]), 0.5))
    return replace(like, gait=gait, course=course, rate_hz=(len(time) - 1) / float(time[-1] - time[0]))


def simulated_walk(walk: Walk, assumptions: WalkAssumptions, run: int, seed: int) -> tuple[pd.DataFrame, np.ndarray]:
    """Return the log of a walk, and the velocity of a point of the foot with the noise that the filter assumes.

    The arm of the point is drawn, and noise of the assumed density is added to its velocity, shape (n, 3) [m/s].
    """
    truth, ideal = walk.truth(run, seed), walk.ideal(run, seed)
    rng = stream(seed, "measured", run)
    point = np.cross(ideal[list(GYRO)].to_numpy(), assumptions.arm_std * rng.standard_normal(3))
    velocity = truth[list(VELOCITY)].to_numpy(float) + reference.rotations(truth).apply(point)
    std = np.sqrt(2 * assumptions.velocity_std**2 * assumptions.correlation_s * walk.rate_hz)
    return walk.model.simulate(ideal, seed, "walk", run), velocity + std * rng.standard_normal(velocity.shape)

"""Navigate a walk with the device on a foot.

Stages, each a function of the value that the one before returns: check columns and gaps, and fill lost samples; align
on the stand at the start; filter; smooth.
"""

from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from imugap.effects import Bias, TurnOnBias
from imugap.effects.effect import AxisModel
from imugap.filters.sensor_states import SensorStates
from imugap.filters.zero_velocity import MOVING, STILL, Stand
from imugap.integrity.timestamps import filled
from imugap.io.recording import Recording
from imugap.log import ACCEL, AXES, GYRO, LogError, axes
from imugap.model import ErrorModel
from imugap.navigation.walk import pedestrian
from imugap.navigation.walk.pedestrian import DOWN, AlignedWalk, WalkAssumptions, WalkSolution
from imugap.navigation.walk.walk_physics import StanceFit, check_walk
from imugap.workflow.tables import measured

STD = "_std"
"""Suffix of the name of a standard deviation."""
LONGEST_GAP_S = 0.1
"""Longest gap that is filled [s]."""
GYRO_CLASS = {"white_noise": {"density": 2e-4}, "random_walk": {"density_k": 3e-5}, "turn_on_bias": {"std": 5e-3}}
ACCEL_CLASS = {"white_noise": {"density": 0.02}, "random_walk": {"density_k": 1e-4}, "turn_on_bias": {"std": 0.3}}
DEFAULT_MODEL = ErrorModel.from_mapping(
    {axis: [GYRO_CLASS] for axis in GYRO} | {axis: [ACCEL_CLASS] for axis in ACCEL}
)  # fmt: skip
"""Error model of an unknown device on a foot: that of a cheap device, larger for the shocks."""
IMPROBABLE_SIGMA = 5.0
"""Deviation from which on the rate at a stand contradicts the error model."""
INDOORS = WalkAssumptions(floor_std=0.01)
"""Assumptions within a building: floors are level except for stairs and ramps."""


@dataclass(frozen=True, eq=False)
class WalkInputs:
    """Log, error model and assumptions of a walk."""

    log: pd.DataFrame
    model: ErrorModel = DEFAULT_MODEL
    assumptions: WalkAssumptions = INDOORS

    @classmethod
    def of(
        cls, recording: Recording, model: ErrorModel = DEFAULT_MODEL, assumptions: WalkAssumptions = INDOORS
    ) -> "WalkInputs":
        """Take the true samples of a recording on an even clock; LogError unless all six axes have them."""
        log = recording.require_gravity().regular.measured
        if axes(log) != AXES:
            raise LogError(recording.source, "columns", f"all of {', '.join(AXES)}", ", ".join(log.columns))
        return cls(log, model, assumptions)


@dataclass(frozen=True)
class NavigatedWalk:
    """Solution of the smoother for a walk, and how the foot comes to rest at its stances."""

    smoothed: WalkSolution
    fit: StanceFit

    def summary(self) -> dict[str, float]:
        """Return distance, times, strides, pace, and the end relative to the start, with standard deviations.

        ``walking_s`` is the time in which the body does not stand. Speed and cadence [strides a minute] are those of
        the strides but the first, the last and those with a stand, where there are some. The distance is the sum of
        the horizontal chords between stances; its variance is that of the sum, with what their errors have in common
        (:mod:`imugap.filters.chords`). ``end_vertical_m`` is a height, ``end_heading_deg`` the change of heading.
        """
        strides = self.smoothed.strides()
        end, std = (table.iloc[-1] for table in (self.smoothed.trajectory, self.smoothed.trajectory_std))
        away = end[["north", "east"]].to_numpy()
        horizontal = float(np.hypot(*away))
        along = away / horizontal if horizontal > 0 else np.array([1.0, 0.0])
        time = self.smoothed.trajectory.index
        found = {
            "distance_m": (strides["length"].sum(), np.sqrt(self.smoothed.chords.length_variance[0])),
            "duration_s": (time[-1] - time[0], 0.0),
            "walking_s": (np.diff(time)[self.smoothed.phase[1:] < STILL].sum(), 0.0),
            "strides": (len(strides), 0.0),
            "end_horizontal_m": (horizontal, np.sqrt(along @ self.smoothed.horizontal[-1] @ along)),
            "end_vertical_m": (-end["down"], std["down"]),
            "end_heading_deg": (np.degrees(end["heading"]), np.degrees(std["heading"])),
        } | self._pace()
        values = {name: value if name == "strides" else float(value) for name, (value, _) in found.items()}
        return values | {name + STD: self.fit.factor * float(value) for name, (_, value) in found.items()}

    def verdict(self) -> str:
        """Return in words how far the walk went, and where it ended."""
        one = self.summary()
        names = ("end_horizontal_m", "end_vertical_m", "end_heading_deg")
        away, height, turn = (" ± ".join(measured(one[name], one[name + STD])) for name in names)
        share = f" ({one['end_horizontal_m'] / one['distance_m']:.2%} of the distance)" if one["distance_m"] > 0 else ""
        pace = " Without stands a stride is made at {speed_m_per_s:.3g} m/s, {cadence_per_min:.3g} a minute."
        return (
            f"The walk went {one['distance_m']:.2f} m in {one['strides']} strides and {one['walking_s']:.1f} s, of a "
            f"log of {one['duration_s']:.1f} s.{pace.format(**one) if 'speed_m_per_s' in one else ''}\n"
            f"It ended {away} m from where it began{share}, {height} m in height, and turned by {turn}° net, whole "
            "turns apart (± one standard deviation)." + (f"\n{self.fit}" if str(self.fit) else "")
        )

    def _pace(self) -> dict[str, tuple[float, float]]:
        """Return speed and cadence of the strides but the first, the last and those with a stand, and deviations."""
        strides, phase = self.smoothed.strides(), self.smoothed.phase
        first, last = (np.searchsorted(self.smoothed.time, strides[name]) for name in ("start", "end"))
        stood = np.array([(phase[i : j + 1] == STILL).any() for i, j in zip(first, last, strict=True)], bool)
        inner = strides[1:-1][~stood[1:-1]]
        if not len(inner):
            return {}
        time, distance = (inner["end"] - inner["start"]).sum(), strides["length"].sum()
        speed = inner["length"].sum() / time
        std = np.sqrt(self.smoothed.chords.length_variance[0])
        return {"speed_m_per_s": (speed, speed * std / distance), "cadence_per_min": (60 * len(inner) / time, 0.0)}

    def strides(self) -> pd.DataFrame:
        """Return the strides, with standard deviations.

        Columns ``stride``, its number; ``start``, ``end`` since the begin of the log, ``duration`` [s] between the
        middles of stances; ``length``, ``rise`` [m] and
        ``heading`` [deg] of the chord between them, with the standard deviations by which the smoother knows that chord
        (:mod:`imugap.filters.chords`), and ``peak_height`` [m], the largest height of the device over the chord. The
        first and the last stride have half of the stand beside them in their duration.
        """
        found, one = self.smoothed.strides(), self.smoothed
        time, down = one.trajectory.index.to_numpy(), one.trajectory["down"].to_numpy()
        place, stances = one.trajectory[["north", "east"]].to_numpy(), one.stances()
        numbers = np.searchsorted(time[stances], found["start"])
        first, last, covariance = stances[numbers], stances[numbers + 1], one.chords.covariance[numbers]
        steps, length = place[last] - place[first], found["length"].to_numpy()
        along = steps / length[:, None]
        across = along @ np.array([[0.0, 1.0], [-1.0, 0.0]])
        lengthwise, sideways = (
            self.fit.factor * np.sqrt(np.einsum("ni,nij,nj->n", unit, covariance[:, :2, :2], unit))
            for unit in (along, across)
        )
        peaks = [
            np.max(np.interp(time[i : j + 1], time[[i, j]], down[[i, j]]) - down[i : j + 1])
            for i, j in zip(first, last, strict=True)
        ]
        found.insert(0, "stride", np.arange(1, len(found) + 1))
        return found.assign(
            start=found["start"] - time[0], end=found["end"] - time[0],
            duration=found["end"] - found["start"], peak_height=peaks,
            heading=np.degrees(np.arctan2(steps[:, 1], steps[:, 0])), length_std=lengthwise,
            rise_std=self.fit.factor * np.sqrt(covariance[:, DOWN, DOWN]), heading_std=np.degrees(sideways / length),
        )  # fmt: skip

    def table(self) -> pd.DataFrame:
        """Return the smoothed Trajectory with standard deviations, sensor errors, and whether the foot is at stance."""
        one = self.smoothed
        factor = self.fit.factor
        stds = (factor * part.add_suffix(STD) for part in (one.trajectory_std, one.sensors_std))
        parts = [one.trajectory, next(stds), one.sensors, next(stds)]
        return pd.concat(parts, axis=1).assign(stance=one.phase > MOVING)


def with_turn_on(model: ErrorModel) -> tuple[ErrorModel, tuple[str, ...]]:
    """Return a model of which every axis has a turn-on bias, and a sentence on those that had none.

    The bias of one log is no knowledge of another run: an axis that does not say how far it differs from one start to
    the next begins at zero, with the larger of its bias and what a cheap device has.
    """
    unknown = [
        axis for axis, own in model.axes.items() if axis in AXES and not any(isinstance(one, TurnOnBias) for one in own)
    ]
    if not unknown:
        return model, ()
    changed = {}
    for axis in unknown:
        kept = [effect for effect in model.axes[axis] if not isinstance(effect, Bias)]
        level = abs(sum(effect.value for effect in model.axes[axis] if isinstance(effect, Bias)))
        usual = (GYRO_CLASS if axis in GYRO else ACCEL_CLASS)["turn_on_bias"]["std"]
        changed[axis] = AxisModel((*kept, TurnOnBias(max(level, usual))))
    said = f"no turn-on bias of {', '.join(unknown)}: it begins at zero, as uncertain as that of a cheap device"
    return replace(model, axes={**model.axes, **changed}), (said,)


def contradicted(model: ErrorModel, stand: Stand, interval: float) -> tuple[str, ...]:
    """Return which rates of the stand at the begin are far beyond what a model allows, a sentence.

    Parameters
    ----------
    interval
        Sampling interval [s].
    """
    states, length = SensorStates.of(model), stand.count * interval
    found = []
    for number, axis in enumerate(GYRO if stand.still else ()):
        variance = states.variance[states.axis == number].sum() + states.white[number] / length + INDOORS.rate_std**2
        std, off = np.sqrt(variance), stand.bias[number] - states.fixed[number]
        if abs(off) > IMPROBABLE_SIGMA * std:
            found.append(f"{axis} is {off:+.2g} rad/s off, where it allows {std:.1g}")
    return (f"at the stand at the begin {'; '.join(found)}: the model of another device?",) if found else ()


def navigate_walk(inputs: WalkInputs) -> NavigatedWalk:
    """Check, align, filter and smooth a walk."""
    return smooth(align(check(inputs)))


def check(inputs: WalkInputs) -> WalkInputs:
    """Check the gaps of the log, fill lost samples, and check the physics."""
    steps = np.diff(inputs.log.index.to_numpy())
    if steps.max() > LONGEST_GAP_S:
        since = inputs.log.index[int(steps.argmax())] - inputs.log.index[0]
        found = f"{steps.max():.3g} s, {since:.4g} s after the begin of the log"
        raise ValueError(f"walk: expected gaps of at most {LONGEST_GAP_S:g} s; found {found}")
    inputs = replace(inputs, log=filled(inputs.log))
    check_walk(inputs.log, inputs.model, inputs.assumptions)
    return inputs


def align(inputs: WalkInputs) -> AlignedWalk:
    """Align on the stand at the start."""
    return pedestrian.align(inputs.log, inputs.model, inputs.assumptions)


def smooth(aligned: AlignedWalk) -> NavigatedWalk:
    """Filter and smooth."""
    return NavigatedWalk(pedestrian.solve(aligned, smooth=True), StanceFit.of(aligned))

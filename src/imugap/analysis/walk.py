"""Navigate a walk with the device on a foot.

Stages, each a function of the value that the one before returns: check columns and gaps, and fill lost samples; align
on the stand at the start; filter; smooth.
"""

from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from imugap.filters.zero_velocity import MOVING
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
    """Solutions of the filter and of the smoother for a walk, and how the foot comes to rest at its stances."""

    filtered: WalkSolution
    smoothed: WalkSolution
    fit: StanceFit

    def summary(self) -> dict[str, float]:
        """Return distance, duration, strides, and the end relative to the start, with standard deviations.

        The distance is the sum of the horizontal strides; its variance is that of independent strides, each with the
        growth of the filter's position variance along it. ``end_vertical_m`` is a height, ``end_heading_deg`` the
        change of heading.
        """
        strides = self.smoothed.strides()
        end, std = (table.iloc[-1] for table in (self.smoothed.trajectory, self.smoothed.trajectory_std))
        away = end[["north", "east"]].to_numpy()
        horizontal = float(np.hypot(*away))
        along = away / horizontal if horizontal > 0 else np.array([1.0, 0.0])
        time = self.smoothed.trajectory.index
        found = {
            "distance_m": (strides["length"].sum(), self._distance_std()),
            "duration_s": (time[-1] - time[0], 0.0),
            "strides": (len(strides), 0.0),
            "end_horizontal_m": (horizontal, np.sqrt(along @ self.smoothed.horizontal[-1] @ along)),
            "end_vertical_m": (-end["down"], std["down"]),
            "end_heading_deg": (np.degrees(end["heading"]), np.degrees(std["heading"])),
        }
        values = {name: value if name == "strides" else float(value) for name, (value, _) in found.items()}
        return values | {name + STD: self.fit.factor * float(value) for name, (_, value) in found.items()}

    def verdict(self) -> str:
        """Return in words how far the walk went, and where it ended."""
        one = self.summary()
        names = ("end_horizontal_m", "end_vertical_m", "end_heading_deg")
        away, height, turn = (" ± ".join(measured(one[name], one[name + STD])) for name in names)
        share = f" ({one['end_horizontal_m'] / one['distance_m']:.2%} of the distance)" if one["distance_m"] > 0 else ""
        return (
            f"The walk went {one['distance_m']:.2f} m in {one['strides']} strides and {one['duration_s']:.1f} s.\n"
            f"It ended {away} m from where it began{share}, {height} m in height, and turned by {turn}° (± one "
            "standard deviation)." + (f"\n{self.fit}" if str(self.fit) else "")
        )

    def strides(self) -> pd.DataFrame:
        """Return the strides, with standard deviations.

        Columns ``start``, ``end``, ``duration`` [s] between the middles of stances, ``length``, ``rise``, ``clearance``
        [m], the largest height of the device over the line between both ends, and ``heading`` of the stride [deg].
        The first and the last stride have half of the stand beside them in their duration.
        """
        found, one = self.smoothed.strides(), self.smoothed
        time, down = one.trajectory.index.to_numpy(), one.trajectory["down"].to_numpy()
        place = one.trajectory[["north", "east"]].to_numpy()
        first, last = (np.searchsorted(time, found[name]) for name in ("start", "end"))
        steps, gained = place[last] - place[first], self.filtered.horizontal[last] - self.filtered.horizontal[first]
        along = steps / found["length"].to_numpy()[:, None]
        across = along @ np.array([[0.0, 1.0], [-1.0, 0.0]])
        spread = [np.sqrt(np.maximum(np.einsum("ni,nij,nj->n", one, gained, one), 0)) for one in (along, across)]
        vertical = self.filtered.history.variances[:, DOWN]
        sunk = np.sqrt(np.maximum(vertical[last] - vertical[first], 0))
        turned = self.smoothed.trajectory_std["heading"].to_numpy()[first]
        clearance = [
            np.max(np.interp(time[i : j + 1], time[[i, j]], down[[i, j]]) - down[i : j + 1])
            for i, j in zip(first, last, strict=True)
        ]
        spread, sunk, turned = (self.fit.factor * np.asarray(one) for one in (spread, sunk, turned))
        return found.assign(
            duration=found["end"] - found["start"], clearance=clearance,
            heading=np.degrees(np.arctan2(steps[:, 1], steps[:, 0])), length_std=spread[0], rise_std=sunk,
            clearance_std=sunk, heading_std=np.degrees(np.hypot(spread[1] / found["length"].to_numpy(), turned)),
        )  # fmt: skip

    def _distance_std(self) -> float:
        at = self.filtered.stances()
        steps = np.diff(self.smoothed.trajectory[["north", "east"]].to_numpy()[at], axis=0)
        lengths = np.hypot(*steps.T)
        units = steps / np.where(lengths > 0, lengths, 1.0)[:, None]
        gained = np.diff(self.filtered.horizontal[at], axis=0)
        return float(np.sqrt(np.maximum(np.einsum("ni,nij,nj->n", units, gained, units), 0).sum()))

    def table(self) -> pd.DataFrame:
        """Return the smoothed Trajectory with standard deviations, sensor errors, and whether the foot is at stance."""
        one = self.smoothed
        factor = self.fit.factor
        stds = (factor * part.add_suffix(STD) for part in (one.trajectory_std, one.sensors_std))
        parts = [one.trajectory, next(stds), one.sensors, next(stds)]
        return pd.concat(parts, axis=1).assign(stance=one.phase > MOVING)


def navigate_walk(inputs: WalkInputs) -> NavigatedWalk:
    """Check, align, filter and smooth a walk."""
    return smooth(align(check(inputs)))


def check(inputs: WalkInputs) -> WalkInputs:
    """Check the gaps of the log, fill lost samples, and check the physics."""
    steps = np.diff(inputs.log.index.to_numpy())
    if steps.max() > LONGEST_GAP_S:
        found = f"{steps.max():.3g} s after {inputs.log.index[int(steps.argmax())]:g} s"
        raise ValueError(f"walk: expected gaps of at most {LONGEST_GAP_S:g} s; found {found}")
    inputs = replace(inputs, log=filled(inputs.log))
    check_walk(inputs.log, inputs.model, inputs.assumptions)
    return inputs


def align(inputs: WalkInputs) -> AlignedWalk:
    """Align on the stand at the start."""
    return pedestrian.align(inputs.log, inputs.model, inputs.assumptions)


def smooth(aligned: AlignedWalk) -> NavigatedWalk:
    """Filter and smooth."""
    fit = StanceFit.of(aligned)
    return NavigatedWalk(pedestrian.solve(aligned), pedestrian.solve(aligned, smooth=True), fit)

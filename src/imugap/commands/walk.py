"""Command ``walk``: navigate a walk with the device on a foot, and write a folder.

Stages, each a function of the value that the one before returns: read the log and the error model; check columns and
gaps, and fill lost samples; align on the stand at the start; filter; smooth; report summary, table and figures; write
the folder.
"""

import argparse
import json
from collections.abc import Iterable
from dataclasses import asdict, dataclass, replace
from math import inf

import numpy as np
import pandas as pd

from imugap.commands.arguments import add_effects, add_examples, add_gravity, positive
from imugap.commands.outputs import add_format, require_folder, write_folder
from imugap.commands.reading import LOG_HELP, MODEL_HELP, InputFile, add_reading, model_at, open_model, settings_of
from imugap.commands.reading import read as read_log
from imugap.filters.zero_velocity import MOVING
from imugap.integrity.timestamps import filled
from imugap.log import ACCEL, AXES, GYRO, LogError, axes, rate
from imugap.model import ErrorModel
from imugap.navigation import pedestrian
from imugap.navigation.pedestrian import DOWN, AlignedWalk, WalkAssumptions, WalkSolution
from imugap.navigation.walk_physics import check_walk
from imugap.units import to_si

FILES = ("solution.parquet", "strides.csv", "summary.json", "inputs.json", "plan.svg", "height.svg")
"""Files of the folder."""
STD = "_std"
"""Suffix of the name of a standard deviation."""
LONGEST_GAP_S = 0.1
"""Longest gap that is filled [s]."""
GYRO_CLASS = {"white_noise": {"density": 5e-4}, "random_walk": {"density_k": 1e-4}, "turn_on_bias": {"std": 5e-3}}
ACCEL_CLASS = {"white_noise": {"density": 0.05}, "random_walk": {"density_k": 1e-4}, "turn_on_bias": {"std": 0.3}}
DEFAULT_MODEL = ErrorModel.from_mapping(
    {axis: [GYRO_CLASS] for axis in GYRO} | {axis: [ACCEL_CLASS] for axis in ACCEL}
)  # fmt: skip
"""Error model of an unknown device on a foot: that of a cheap device, larger for the shocks."""
INDOORS = WalkAssumptions(floor_std=0.01)
"""Assumptions within a building: floors are level except for stairs and ramps."""


@dataclass(frozen=True, eq=False)
class WalkInputs:
    """Log, error model and assumptions of a walk, and the files that they were read from."""

    log: pd.DataFrame
    model: ErrorModel = DEFAULT_MODEL
    assumptions: WalkAssumptions = INDOORS
    files: tuple[InputFile, ...] = ()


@dataclass(frozen=True)
class NavigatedWalk:
    """Solutions of the filter and of the smoother for a walk."""

    filtered: WalkSolution
    smoothed: WalkSolution

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
        return values | {name + STD: float(value) for name, (_, value) in found.items()}

    def strides(self) -> pd.DataFrame:
        """Return the strides, with standard deviations.

        Columns ``start``, ``end``, ``duration`` [s] between the middles of stances, ``length``, ``rise``, ``clearance``
        [m], the largest height of the device over the line between both ends, and ``heading`` of the stride [deg].
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
        parts = [one.trajectory, one.trajectory_std.add_suffix(STD), one.sensors, one.sensors_std.add_suffix(STD)]
        return pd.concat(parts, axis=1).assign(stance=one.phase > MOVING)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    add_examples(parser, "imugap walk foot.csv --outdoors --out walk")
    parser.description = (
        "Navigate a walk with the device on a foot. The log begins with a stand of 0.2 s or more. Lost samples are "
        "filled, up to a tenth of a second."
    )
    parser.add_argument("log", help=f"{LOG_HELP}; six axes")
    parser.add_argument("--model", help=f"{MODEL_HELP} (default that of a cheap device)")
    add_effects(parser)
    add_gravity(parser)
    parser.add_argument(
        "--full-scale", type=positive, default=inf, metavar="G",
        help="full scale of the accelerometers [g], where heel strikes come near to it (default: none do)",
    )  # fmt: skip
    parser.add_argument("--outdoors", action="store_true", help="do not take floors for level but for stairs and ramps")
    parser.add_argument("--out", required=True, help="folder for solution, summary and figures")
    add_format(parser)
    add_reading(parser)


def run(options: argparse.Namespace) -> None:
    """Navigate the walk, write the folder ``--out``, and print the summary."""
    folder = require_folder(options.out, FILES, (options.log, options.model))
    inputs = read(options)
    try:
        files = report(navigate_walk(inputs), inputs.files)
    except ValueError as error:
        raise ValueError(f"{options.log}: {error}") from error
    write_folder(folder, files, options.format)
    print(json.dumps(files["summary.json"], indent=1))


def navigate_walk(inputs: WalkInputs) -> NavigatedWalk:
    """Check, align, filter and smooth a walk."""
    return smooth(align(check(inputs)))


def read(options: argparse.Namespace) -> WalkInputs:
    """Read the log, its true samples on an even clock, and the error model."""
    found = read_log(options.log, settings_of(options)).require_gravity()
    log = found.regular.measured
    if axes(log) != AXES:
        raise LogError(options.log, "columns", f"all of {', '.join(AXES)}", ", ".join(log.columns))
    model = DEFAULT_MODEL
    if options.model is not None:
        model = model_at(open_model(options.model, options.effects), rate(log)).require_axes(options.model)
    ground = WalkAssumptions() if options.outdoors else INDOORS
    full_scale = to_si(options.full_scale, "g")
    file = InputFile("log", options.log, found.recognised)
    return WalkInputs(log, model, replace(ground, gravity=options.gravity, full_scale=full_scale), (file,))


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
    return NavigatedWalk(pedestrian.solve(aligned), pedestrian.solve(aligned, smooth=True))


def report(found: NavigatedWalk, inputs: Iterable[InputFile] = ()) -> dict[str, object]:
    """Return the content of each of the :data:`FILES`."""
    from imugap.figures import walk  # figures take longer to import than to read and check the log

    tables, drawn = (found.table(), found.strides()), (walk.plan(found.smoothed), walk.height(found.smoothed))
    return dict(zip(FILES, (*tables, found.summary(), [*map(asdict, inputs)], *drawn), strict=True))

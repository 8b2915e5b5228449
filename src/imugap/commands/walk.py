"""The folder that a walk leaves: what the smoother says of it, how far it went and where it ended, and figures."""

import argparse
import json
from dataclasses import dataclass, replace
from math import inf
from pathlib import Path

import numpy as np
import pandas as pd

from imugap.atomic import write_together
from imugap.commands.arguments import add_effects, add_gravity, positive
from imugap.filters.zero_velocity import MOVING
from imugap.integrity.timestamps import filled
from imugap.interchange.plugins import catalogue
from imugap.io import readers
from imugap.log import ACCEL, AXES, GYRO, LogError, axes
from imugap.model import ErrorModel
from imugap.navigation.pedestrian import Assumptions, Solution, navigate
from imugap.units import to_si

FILES = ("solution.parquet", "summary.json", "plan.svg", "height.svg")
"""What is in the folder."""
STD = "_std"
"""Ending of the name of a standard deviation."""
GYRO_CLASS = {"white_noise": {"density": 5e-4}, "random_walk": {"density_k": 1e-4}, "turn_on_bias": {"std": 5e-3}}
ACCEL_CLASS = {"white_noise": {"density": 0.05}, "random_walk": {"density_k": 1e-4}, "turn_on_bias": {"std": 0.3}}
LONGEST_GAP_S = 0.1
"""Longest time without samples that a walk is navigated across [s]."""
USUAL = ErrorModel.from_mapping(
    {axis: [GYRO_CLASS] for axis in GYRO} | {axis: [ACCEL_CLASS] for axis in ACCEL}
)  # fmt: skip
"""Errors of a sensor on a foot of which nothing is known: those of a cheap device, and the more for the shocks."""
INDOORS = Assumptions(floor_std=0.01)
"""What is taken for granted within a building: floors are level but for stairs and ramps."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    parser.description = (
        "Navigate a walk with the device on a foot. The log begins with a stand of half a second or more. Rows whose "
        "stamp does not exceed those before are left out, and lost samples filled."
    )
    parser.add_argument("log", help="canonical CSV or Parquet log of six axes")
    parser.add_argument("--model", help="error model of the device (YAML; default that of a cheap one)")
    add_effects(parser)
    add_gravity(parser)
    parser.add_argument(
        "--full-scale", type=positive, default=inf, metavar="G",
        help="full scale of the accelerometers [g], where heel strikes come near to it (default: none do)",
    )  # fmt: skip
    parser.add_argument("--outdoors", action="store_true", help="do not take floors for level but for stairs and ramps")
    parser.add_argument("--out", required=True, help="folder for solution, summary and figures")


def run(options: argparse.Namespace) -> None:
    """Navigate the walk, write the folder ``--out``, and print the summary."""
    ground = Assumptions() if options.outdoors else INDOORS
    assumptions = replace(ground, gravity=options.gravity, full_scale=to_si(options.full_scale, "g"))
    print(json.dumps(compose(options.log, options.out, options.model, options.effects, assumptions), indent=1))


@dataclass(frozen=True)
class Walked:
    """A walk: what the filter says as it goes, and what the smoother says when all is known."""

    filtered: Solution
    smoothed: Solution

    def summary(self) -> dict[str, float]:
        """Return how far the walk went and where it ended, from where it began, with standard deviations.

        The distance is the sum of the strides, level; its variance is that of independent strides, each with what the
        filter's position gained along it. ``end_vertical_m`` is a height, ``end_heading_deg`` the change of heading.
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

    def _distance_std(self) -> float:
        at = self.filtered.stances()
        steps = np.diff(self.smoothed.trajectory[["north", "east"]].to_numpy()[at], axis=0)
        lengths = np.hypot(*steps.T)
        units = steps / np.where(lengths > 0, lengths, 1.0)[:, None]
        gained = np.diff(self.filtered.horizontal[at], axis=0)
        return float(np.sqrt(np.maximum(np.einsum("ni,nij,nj->n", units, gained, units), 0).sum()))

    def table(self) -> pd.DataFrame:
        """Return the smoothed Trajectory with standard deviations, sensor errors and whether the foot stands."""
        one = self.smoothed
        parts = [one.trajectory, one.trajectory_std.add_suffix(STD), one.sensors, one.sensors_std.add_suffix(STD)]
        return pd.concat(parts, axis=1).assign(stance=one.phase > MOVING)


def walked(log: pd.DataFrame, model: ErrorModel = USUAL, assumptions: Assumptions = INDOORS) -> Walked:
    """Navigate a walk that begins with a stand; lost samples are filled, up to :data:`LONGEST_GAP_S` at a time."""
    steps = np.diff(log.index.to_numpy())
    if steps.max() > LONGEST_GAP_S:
        found = f"{steps.max():.3g} s after {log.index[int(steps.argmax())]:g} s"
        raise ValueError(f"walk: expected gaps of at most {LONGEST_GAP_S:g} s; found {found}")
    log = filled(log)
    return Walked(navigate(log, model, assumptions), navigate(log, model, assumptions, smooth=True))


def compose(
    path: str | Path, out: str | Path, model: str | Path | None = None, effects: str | None = None,
    assumptions: Assumptions = INDOORS,
) -> dict[str, float]:  # fmt: skip
    """Navigate the walk of a file, write all :data:`FILES` into the folder ``out``, and return the summary.

    Rows whose stamp does not exceed those before, as wireless devices send them, are left out, and lost samples filled.
    """
    out = Path(out)
    if out.exists() and not out.is_dir():
        raise ValueError(f"{out}: expected a folder; found a file")
    log = readers.read(path, repair=True)
    if axes(log) != AXES:
        raise LogError(path, "columns", f"all of {', '.join(AXES)}", ", ".join(log.columns))
    known = USUAL if model is None else ErrorModel.read(model, catalogue(effects))
    try:
        found = walked(log, known, assumptions)
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from error
    write(found, out)
    return found.summary()


def write(found: Walked, out: str | Path) -> None:
    """Write all :data:`FILES` into the folder ``out``, or none if one of them fails."""
    from imugap.figures import save, walk  # figures take longer to import than to read and check the log

    text = json.dumps(found.summary(), indent=1, allow_nan=False) + "\n"
    drawn = walk.plan(found.smoothed), walk.height(found.smoothed)
    writers = (
        found.table().to_parquet,
        lambda path: path.write_text(text),
        *(lambda path, figure=figure: save(figure, path) for figure in drawn),
    )
    write_together({Path(out) / name: writer for name, writer in zip(FILES, writers, strict=True)})

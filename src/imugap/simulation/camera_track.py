"""Comparison of a navigated walk with the track of a camera system: a marker on the foot, in its own frame and time.

The marker sits at a constant arm from the device. The arm, the heading, the origin and the clock offset are fitted to
the whole walk; lengths are never scaled. The residual is the navigation error, less the little that the eight fitted
parameters absorb. Cameras lose a marker, and some then repeat its last position or jump to another marker; such
instants are left out.
"""

from dataclasses import dataclass

import numpy as np
import pandas as pd
from scipy.optimize import least_squares

from imugap.kinematics.strapdown import ATTITUDE, POSITION
from imugap.navigation.walk.pedestrian import PositionAiding, WalkSolution
from imugap.numerics.rotation import from_euler

STEP_S = 0.02
"""Sampling interval of the comparison [s]."""
FASTEST_M_PER_S = 10.0
"""Largest speed of a foot."""
FROZEN = 3
"""Number of bit-identical samples from which on a marker counts as lost."""
MARGIN_S = 0.05
"""Time around a loss that is left out [s]."""
MARKER_STD_M, ORIGIN_STD_M, HEADING_STD = 0.01, 0.03, np.radians(3.0)
"""Standard deviations of the position of a marker, or of a foot that returns [m], and of the fitted origin [m] and
heading [rad]."""


@dataclass(frozen=True, eq=False)
class CameraComparison:
    """Navigated and measured track of a walk.

    Attributes
    ----------
    time
        Instants of the log [s], shape (n,).
    found, seen
        Positions of the marker, navigated and measured, in the frame of the cameras [m], shape (n, 3): north, east,
        down; NaN where it was lost.
    heading, lag
        Rotation of the navigated walk into the frame of the cameras [rad]; delay of their stamps [s].
    arm
        From the device to the marker, in ``b`` [m], shape (3,).
    """

    time: np.ndarray
    found: np.ndarray
    seen: np.ndarray
    heading: float
    lag: float
    arm: np.ndarray

    @property
    def error(self) -> np.ndarray:
        """Return navigated - measured [m], shape (n, 3)."""
        return self.found - self.seen

    def rmse(self) -> tuple[float, float]:
        """Return the root mean square error, horizontal and vertical [m]."""
        square = np.nanmean(self.error**2, axis=0)
        return float(np.sqrt(square[0] + square[1])), float(np.sqrt(square[2]))

    @property
    def off(self) -> np.ndarray:
        """Return the error of the displacement from begin to end in the frame of the solution [m], shape (3,)."""
        known = self.error[np.isfinite(self.error[:, 0])]
        return (known[-1] - known[0]) @ _frame(self.heading)

    def end(self) -> tuple[float, float]:
        """Return the error of the displacement from begin to end: horizontal length, and height [m]."""
        north, east, down = self.off
        return float(np.hypot(north, east)), -float(down)

    def aiding(self, solution: WalkSolution) -> PositionAiding:
        """Return the camera position of the device in the middle of each stance, in the frame of the solution.

        Parameters
        ----------
        solution
            The compared solution.
        """
        time = solution.time.to_numpy()
        rows, at = np.searchsorted(time, self.time), solution.stances()
        place = np.searchsorted(self.time, time[at])
        place = place[place < len(rows)]
        position = np.full((len(time), 3), np.nan)
        navigated = solution.trajectory[list(POSITION)].to_numpy()[rows[place]]
        position[rows[place]] = navigated - self.error[place] @ _frame(self.heading)
        return PositionAiding(position, MARKER_STD_M, HEADING_STD, ORIGIN_STD_M)

    def reach(self) -> tuple[float, float]:
        """Return the largest horizontal distance from the begin, navigated and measured [m]."""
        known = np.isfinite(self.seen[:, 0])
        found, seen = (np.hypot(*(one[known] - one[known][0])[:, :2].T).max() for one in (self.found, self.seen))
        return float(found), float(seen)

    def strides(self, strides: pd.DataFrame) -> pd.DataFrame:
        """Return the horizontal lengths ``found`` and ``seen`` [m] of strides from ``start`` to ``end`` [s].

        Those of which an end was not seen are left out.
        """
        known = strides[(strides["start"] >= self.time[0]) & (strides["end"] <= self.time[-1])]
        lengths = {}
        for name, track in {"found": self.found, "seen": self.seen}.items():
            ends = [[np.interp(known[at], self.time, track[:, i]) for i in (0, 1)] for at in ("start", "end")]
            lengths[name] = np.hypot(*(np.array(ends[1]) - ends[0]))
        return known[["start", "end"]].assign(**lengths).dropna()


def closed_loop_aiding(solution: WalkSolution) -> PositionAiding:
    """Return the known end of a walk that returns to its start."""
    position = np.full((len(solution.time), 3), np.nan)
    position[-1] = 0.0
    return PositionAiding(position, MARKER_STD_M)


def compare_with_cameras(solution: WalkSolution, seen: pd.DataFrame, stiff: bool = True) -> CameraComparison:
    """Fit a solution to the measured positions of a marker.

    Parameters
    ----------
    seen
        Index ``time`` [s], columns :data:`imugap.kinematics.strapdown.POSITION` [m]
        (:func:`imugap.io.catalogue.readers.read_positions`).
    stiff
        Whether the arm is fitted; if not, the marker is at the device.
    """
    table, seen = solution.trajectory, _seen(seen)
    begin, end = max(table.index[0], seen.index[0]), min(table.index[-1], seen.index[-1])
    time = np.arange(begin + MARGIN_S, end - MARGIN_S, STEP_S)
    every = np.unique(np.clip(np.searchsorted(table.index, time), 0, len(table) - 1))
    time = table.index.to_numpy()[every]
    known = _known(seen, time)
    position = table[list(POSITION)].to_numpy()[every]
    turns = from_euler(table[list(ATTITUDE)].to_numpy()[every]).as_matrix()
    heading, lag = _clocked(seen, time[known], position[known], turns[known], stiff)
    origin, arm = _placed(_at(seen, time[known] + lag), position[known], turns[known], heading, stiff)
    found = (position + turns @ arm) @ _frame(heading).T + origin
    target = np.where(known[:, None], _at(seen, time + lag), np.nan)
    return CameraComparison(time, found, target, heading, lag, arm)


def _clocked(
    seen: pd.DataFrame, time: np.ndarray, position: np.ndarray, turns: np.ndarray, stiff: bool
) -> tuple[float, float]:
    """Return heading and lag of the least-squares fit."""

    def misfit(parameters: np.ndarray) -> np.ndarray:
        heading, lag = parameters
        target = _at(seen, time + lag)
        origin, arm = _placed(target, position, turns, heading, stiff)
        return ((position + turns @ arm) @ _frame(heading).T + origin - target).ravel()

    away, aim = (one - one.mean(axis=0) for one in (position, _at(seen, time)))
    across, along = away[:, 0] @ aim[:, 1] - away[:, 1] @ aim[:, 0], np.sum(away[:, :2] * aim[:, :2])
    heading, lag = least_squares(misfit, [np.arctan2(across, along), 0.0]).x
    return float(heading), float(lag)


def _placed(
    target: np.ndarray, position: np.ndarray, turns: np.ndarray, heading: float, stiff: bool
) -> tuple[np.ndarray, np.ndarray]:
    """Return the origin and the arm, least squares, for a heading."""
    frame = _frame(heading)
    left = target - position @ frame.T
    if not stiff:
        return left.mean(axis=0), np.zeros(3)
    design = np.concatenate([frame @ turns, np.broadcast_to(np.eye(3), turns.shape)], axis=2)
    solved = np.linalg.lstsq(design.reshape(-1, 6), left.ravel())[0]
    return solved[3:], solved[:3]


def _frame(heading: float) -> np.ndarray:
    c, s = np.cos(heading), np.sin(heading)
    return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])


def _seen(table: pd.DataFrame) -> pd.DataFrame:
    """Drop NaN, repeated and jumping samples."""
    table = table.dropna()
    steps = np.diff(table.to_numpy(), axis=0, prepend=np.nan)
    speed = np.linalg.norm(steps, axis=1) / np.diff(table.index, prepend=np.nan)
    repeats = pd.Series((steps == 0).all(axis=1))
    run = repeats.groupby((~repeats).cumsum()).transform("sum").to_numpy()
    return table[(run < FROZEN) & ~(speed > FASTEST_M_PER_S)]


def _known(seen: pd.DataFrame, time: np.ndarray) -> np.ndarray:
    """Return which instants have a measured position, away from gaps."""
    stamps = seen.index.to_numpy()
    place = np.clip(np.searchsorted(stamps, time), 1, len(stamps) - 1)
    near = np.diff(stamps)[place - 1] < MARGIN_S
    return np.convolve(~near, np.ones(2 * round(MARGIN_S / STEP_S) + 1), "same") < 0.5


def _at(seen: pd.DataFrame, time: np.ndarray) -> np.ndarray:
    return np.column_stack([np.interp(time, seen.index, seen[name]) for name in POSITION])

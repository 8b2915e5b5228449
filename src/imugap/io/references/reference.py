"""Reference attitudes: their table, the alignment of a log with them, and the error of a solution.

A reference contains only the instants at which the attitude is known; :data:`QUATERNION` and :data:`MOVING` are
its columns. The error of an attitude is *estimated - reference*: the rotation vector in ``n`` that turns the reference
into the estimate, ``exp(error) C_reference = C_estimated``. Its down component is the error of the heading, north and
east are the tilt. Unlike a difference of Euler angles it has no singularity.
"""

import numpy as np
import pandas as pd
from scipy.optimize import minimize_scalar
from scipy.spatial.transform import Rotation, Slerp
from scipy.special import stdtrit

from imugap.kinematics.error_free import QUATERNION
from imugap.kinematics.strapdown import ATTITUDE
from imugap.log import GYRO, interval
from imugap.numerics.rotation import to_euler

MOVING = "moving"
"""Column that marks the phase of motion."""
ERROR = ("north", "east", "down")
"""Columns of an error [rad]."""
MEASURED = ("lag", "frame_x", "frame_y", "frame_z", "bias_x", "bias_y", "bias_z")
"""Quantities of an alignment."""
ENU_TO_NED = Rotation.from_matrix([[0, 1, 0], [1, 0, 0], [0, 0, -1]])
SPAN_S = 0.04
"""Time [s] over which the mean rate of the reference is taken, which reduces its noise."""
BLOCK_S = 10.0
"""Length [s] of the blocks whose scatter gives the intervals of an alignment."""
FEWEST = 50
"""Fewest rates in a block."""
LONGEST_LAG_S = 0.05
"""Limit of the search for the lag, either way [s]."""


def from_rotations(time: np.ndarray, rotation_nb: Rotation, moving: np.ndarray) -> pd.DataFrame:
    """Make a reference from its instants [s], shape (n,), attitudes and mask of motion."""
    table = pd.DataFrame(rotation_nb.as_quat(), index=pd.Index(time, name="time"), columns=list(QUATERNION))
    return table.assign(**{MOVING: np.asarray(moving, bool)})


def rotations(table: pd.DataFrame) -> Rotation:
    """Return the attitudes ``b`` to ``n`` of a table with the columns :data:`QUATERNION`."""
    return Rotation.from_quat(table[list(QUATERNION)].to_numpy())


def motion(reference: pd.DataFrame) -> tuple[float, float]:
    """Return the first and the last instant in motion [s]."""
    times = reference.index[reference[MOVING]]
    return float(times[0]), float(times[-1])


def rests(log: pd.DataFrame, reference: pd.DataFrame, margin: float) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Return the log before and after the motion, without ``margin`` [s] next to it."""
    begin, end = motion(reference)
    return log[log.index <= begin - margin], log[log.index >= end + margin]


def error(solution: pd.DataFrame, reference: pd.DataFrame, lag: float = 0.0) -> pd.DataFrame:
    """Return the error of a solution at those of its instants at which the reference is known.

    The reference is interpolated between two samples by a uniform rotation, but not across a gap.

    Parameters
    ----------
    solution, reference
        Tables with the columns :data:`QUATERNION`.
    lag
        Time by which the stamps of the solution are later than those of the reference [s].

    Returns
    -------
    pandas.DataFrame
        Columns :data:`ERROR` [rad], and :data:`imugap.kinematics.strapdown.ATTITUDE`: differences of the Euler angles
        [rad], meaningful only for a pitch away from +-90 deg.
    """
    known, at = reference.index.to_numpy(), solution.index.to_numpy() - lag
    before = np.clip(np.searchsorted(known, at, side="right") - 1, 0, len(known) - 2)
    near = known[before + 1] - known[before] < 1.5 * np.median(np.diff(known))
    inside = (near & (known[before] <= at) & (at <= known[before + 1])) | np.isin(at, known)
    estimated, true = rotations(solution[inside]), Slerp(known, rotations(reference))(at[inside])
    euler = np.angle(np.exp(1j * (to_euler(estimated) - to_euler(true))))
    table = pd.DataFrame((estimated * true.inv()).as_rotvec(), index=solution.index[inside], columns=list(ERROR))
    return table.assign(**dict(zip(ATTITUDE, euler.T, strict=True)))


def alignment(log: pd.DataFrame, reference: pd.DataFrame, level: float = 0.95) -> pd.DataFrame:
    """Estimate lag and frame of a log relative to its reference, from angular rates in motion alone.

    The mean rates w of the reference over :data:`SPAN_S` are compared with those of the gyroscopes, from their
    integral: ``rate(t + lag) = w(t) + frame x w(t) + bias``. Each block of :data:`BLOCK_S` gives its own least
    squares solution; the intervals are those of Student for the mean of the blocks.

    Returns
    -------
    pandas.DataFrame
        Index ``lag`` [s], ``frame_x``, ``frame_y``, ``frame_z`` [rad], ``bias_x``, ``bias_y``, ``bias_z`` [rad/s]: the
        axes of the log turned by ``-frame`` are those of the reference; columns ``value``, ``low``, ``high``.
    """
    early, late, rate = _mean_rates(reference)
    angle = _Angle(log)
    blocks = ((early - early[0]) // BLOCK_S).astype(int)
    chosen = [blocks == block for block in np.unique(blocks) if np.count_nonzero(blocks == block) >= FEWEST]
    if len(chosen) < 3:
        raise ValueError(f"alignment: expected 3 blocks of {BLOCK_S:g} s in motion or more; found {len(chosen)}")
    found = np.array([_fit(angle, early[one], late[one], rate[one]) for one in chosen])
    middle = found.mean(axis=0)
    half = stdtrit(len(found) - 1, (1 + level) / 2) * found.std(axis=0, ddof=1) / np.sqrt(len(found))
    columns = {"value": middle, "low": middle - half, "high": middle + half}
    return pd.DataFrame(columns, index=pd.Index(MEASURED, name="quantity"))


def _mean_rates(reference: pd.DataFrame) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return begin and end [s] of spans without a gap, and their mean rates [rad/s]; spans overlap by half."""
    time, rotation = reference.index.to_numpy(), rotations(reference)
    step = float(np.median(np.diff(time)))
    span = max(round(SPAN_S / step), 2)
    whole = (time[span:] - time[:-span] < (span + 0.5) * step) & reference[MOVING].to_numpy()[span:]
    first = np.flatnonzero(whole)[:: span // 2]
    early, late = time[first], time[first + span]
    return early, late, (rotation[first].inv() * rotation[first + span]).as_rotvec() / (late - early)[:, None]


class _Angle:
    """Integral of the gyroscopes; each sample is the mean over the interval that it ends."""

    def __init__(self, log: pd.DataFrame) -> None:
        step = interval(log)
        self.time = np.concatenate([[log.index[0] - step], log.index])
        self.sums = np.vstack([np.zeros(3), np.cumsum(log[list(GYRO)].to_numpy() * step, axis=0)])

    def mean_rate(self, early: np.ndarray, late: np.ndarray) -> np.ndarray:
        """Return the mean rate [rad/s], shape (n, 3), between instants [s]."""
        ends = [np.column_stack([np.interp(at, self.time, one) for one in self.sums.T]) for at in (early, late)]
        return (ends[1] - ends[0]) / (late - early)[:, None]


def _fit(angle: _Angle, early: np.ndarray, late: np.ndarray, rate: np.ndarray) -> np.ndarray:
    """Return lag [s], frame rotation vector [rad] and biases [rad/s] that fit the rates of one block best."""
    crossed = -np.cross(rate[:, None, :], np.eye(3))  # row j: unit vector j x rate
    design = np.concatenate([crossed, np.broadcast_to(np.eye(3), crossed.shape)], axis=1).transpose(0, 2, 1)
    design = design.reshape(-1, 6)

    def solve(lag: float) -> tuple[np.ndarray, float]:
        difference = (angle.mean_rate(early + lag, late + lag) - rate).ravel()
        solution = np.linalg.lstsq(design, difference)[0]
        return solution, float(np.sum((difference - design @ solution) ** 2))

    bounds = (-LONGEST_LAG_S, LONGEST_LAG_S)
    lag = minimize_scalar(lambda lag: solve(lag)[1], bounds=bounds, method="bounded", options={"xatol": 1e-7}).x
    return np.concatenate([[lag], solve(lag)[0]])

"""Error-free log of a device from motion capture: angular rate and specific force from orientation and position.

A Track is a table with index ``time`` [s], evenly spaced, the columns :data:`imugap.io.references.reference.QUATERNION`
(``quat_nb``, NaN where the cameras lost the device) and :data:`imugap.kinematics.strapdown.POSITION` [m]. Differences
of neighbouring samples are exact but noisy; so the log and the track are limited to the same band by the same linear
filter, and their difference is the sum of the errors of both within the band. Within it the noise
of an angle with standard deviation s per sample of interval T has the two-sided spectrum (2 pi f)^2 s^2 T as a rate,
that of a position (2 pi f)^4 s^2 T as a specific force.
"""

from dataclasses import dataclass

import numpy as np
import pandas as pd
from scipy.fft import dct, idct
from scipy.interpolate import CubicSpline
from scipy.ndimage import binary_dilation
from scipy.spatial.transform import Rotation

from imugap.io.references.reference import QUATERNION, alignment, rotations
from imugap.kinematics.strapdown import POSITION
from imugap.log import AXES, GYRO, TIME, interval

BLOCK = 28
"""Samples that are averaged before the vertical is fitted, which reduces the noise of second differences."""
FAR = 4.0
"""Multiple of the median residual above which a block is excluded."""
ROUNDS = 8


@dataclass(frozen=True, eq=False)
class BandLimited:
    """Log and error-free log at the same instants, limited to the same band.

    Attributes
    ----------
    log, ideal
        Canonical logs with the same evenly spaced index.
    unseen
        Mask of the instants at which the cameras lost the device nearby, shape (n,); the ideal is filled there.
    """

    log: pd.DataFrame
    ideal: pd.DataFrame
    unseen: np.ndarray


@dataclass(frozen=True, eq=False)
class Alignment:
    """Alignment of a log with a track.

    Attributes
    ----------
    lag
        Time by which the stamps of the log are later than those of the track [s].
    rotation
        Turns vectors from the body frame of the track into that of the log.
    gravity
        Gravity [m/s^2] in the frame of the positions, shape (3,).
    """

    lag: float
    rotation: Rotation
    gravity: np.ndarray


def track_of(reference: pd.DataFrame, positions: pd.DataFrame) -> pd.DataFrame:
    """Return the Track of a Reference and evenly spaced positions, at the times of the positions."""
    found = positions.reindex(columns=[*QUATERNION, *POSITION])
    found.iloc[positions.index.get_indexer(reference.index, method="nearest"), : len(QUATERNION)] = reference[
        list(QUATERNION)
    ]
    return found.where(found.notna().all(axis=1))


def ideal(track: pd.DataFrame, alignment: Alignment) -> pd.DataFrame:
    """Return the unfiltered error-free log of a track, NaN where a required sample is lost.

    Each row is the mean over the interval that it ends: of the rate exactly but for coning, of the specific force as
    the mean of its values at both ends, with second differences of the position.
    """
    time, step = track.index.to_numpy(), interval(track)
    quat, position = track[list(QUATERNION)].to_numpy(), track[list(POSITION)].to_numpy()
    seen = np.isfinite(quat).all(axis=1) & np.isfinite(position).all(axis=1)
    rotation = Rotation.from_quat(np.where(seen[:, None], quat, [0.0, 0.0, 0.0, 1.0])) * alignment.rotation.inv()
    rate = (rotation[:-1].inv() * rotation[1:]).as_rotvec() / step
    acceleration = np.full(position.shape, np.nan)
    acceleration[1:-1] = np.diff(position, 2, axis=0) / step**2
    force = rotation.inv().apply(acceleration - alignment.gravity)
    values = np.hstack([rate, (force[:-1] + force[1:]) / 2])
    values[~(seen[:-1] & seen[1:])] = np.nan
    return pd.DataFrame(values, index=pd.Index(time[1:], name=TIME), columns=list(AXES))


def band_limited(log: pd.DataFrame, track: pd.DataFrame, alignment: Alignment, bandwidth_hz: float) -> BandLimited:
    """Return a log and its ideal within a band, sampled at twice its width or slightly faster.

    The log is interpolated by a cubic spline at the instants of the track. Both are limited by removing the cosine
    coefficients above the band. Where the track is lost, the ideal is the log less the median difference, which has
    almost no weight.
    """
    raw, stamps, measured = _together(log, track, alignment)
    known = raw.to_numpy(copy=True)
    lost = ~np.isfinite(known).all(axis=1)
    known[lost] = measured[lost] - np.median((measured - known)[~lost], axis=0)
    step = interval(raw)
    factor = int(0.5 / step / bandwidth_hz)
    count = len(stamps) // factor
    thin = pd.Index(stamps[0] + step * (factor * (np.arange(count) + 0.5) - 0.5), name=TIME)
    tables = (pd.DataFrame(_thinned(one, factor), index=thin, columns=list(AXES)) for one in (measured, known))
    unseen = lost[: count * factor].reshape(count, factor).any(axis=1)
    return BandLimited(*tables, binary_dilation(unseen, iterations=2))


def aligned(log: pd.DataFrame, track: pd.DataFrame, reference: pd.DataFrame, gravity: float) -> Alignment:
    """Estimate the alignment of a log with its track.

    Lag and rotation are estimated from the angular rates in motion (:func:`imugap.io.references.reference.alignment`);
    then the direction of gravity, of the given size [m/s^2], from the specific forces, together with biases, scale
    factors, a lever arm and a delay of the accelerometers, without outliers.

    Parameters
    ----------
    reference
        The attitudes of the track as a Reference, its mask of motion included.
    """
    values = alignment(log, reference)["value"]
    rotation = Rotation.from_rotvec(values[["frame_x", "frame_y", "frame_z"]].to_numpy(copy=True))
    level = Alignment(float(values["lag"]), rotation, np.zeros(3))
    raw, _, measured = _together(log, track, level)
    seen = np.isfinite(raw.to_numpy()).all(axis=1)
    down = np.full((len(raw), 3, 3), np.nan)
    down[seen] = -rotations(_middle(track, level).loc[raw.index[seen]]).inv().as_matrix()
    difference = (measured - raw.to_numpy())[:, len(GYRO) :]
    found = _trimmed(np.concatenate([down, _nuisances(measured, interval(raw))], axis=2), difference)
    return Alignment(level.lag, rotation, gravity * found[:3] / np.linalg.norm(found[:3]))


def _together(
    log: pd.DataFrame, track: pd.DataFrame, alignment: Alignment
) -> tuple[pd.DataFrame, np.ndarray, np.ndarray]:
    """Return the unfiltered ideal within the log, the stamps of its rows on the clock of the log, and the log there."""
    raw = ideal(track, alignment)
    stamps = raw.index.to_numpy() + alignment.lag
    inside = np.flatnonzero(raw.notna().all(axis=1) & (stamps >= log.index[0]) & (stamps <= log.index[-1]))
    whole = slice(inside[0], inside[-1] + 1)
    measured = CubicSpline(log.index.to_numpy(), log[list(AXES)].to_numpy())(stamps[whole])
    return raw.iloc[whole], stamps[whole], measured


def _middle(track: pd.DataFrame, alignment: Alignment) -> pd.DataFrame:
    """Return the attitudes of the body frame of the log at the middle of the interval of each row of the ideal."""
    quat = track[list(QUATERNION)].to_numpy()
    seen = np.isfinite(quat).all(axis=1)
    rotation = Rotation.from_quat(np.where(seen[:, None], quat, [0.0, 0.0, 0.0, 1.0])) * alignment.rotation.inv()
    half = Rotation.from_rotvec((rotation[:-1].inv() * rotation[1:]).as_rotvec() / 2)
    return pd.DataFrame((rotation[:-1] * half).as_quat(), index=track.index[1:], columns=list(QUATERNION))


def _nuisances(measured: np.ndarray, step: float) -> np.ndarray:
    """Return the derivatives in biases, scale factors, lever arm and delay of the accelerometers, shape (n, 3, 10)."""
    rate, force = measured[:, : len(GYRO)], measured[:, len(GYRO) :]
    change = np.gradient(measured, step, axis=0)
    arms = [np.cross(rate, np.cross(rate, arm)) + np.cross(change[:, : len(GYRO)], arm) for arm in np.eye(3)]
    own = np.einsum("ni,ij->nij", force, np.eye(3))
    delay = change[:, len(GYRO) :, None]
    return np.concatenate([np.broadcast_to(np.eye(3), own.shape), own, np.stack(arms, axis=-1), delay], axis=2)


def _trimmed(design: np.ndarray, difference: np.ndarray) -> np.ndarray:
    """Return the least-squares solution over means of blocks, with outliers excluded iteratively.

    Parameters
    ----------
    design, difference
        Arrays of shape (n, 3, k) and (n, 3); a block with a NaN is excluded.
    """
    size = len(difference) // BLOCK * BLOCK
    design, difference = (one[:size].reshape(-1, BLOCK, *one.shape[1:]).mean(axis=1) for one in (design, difference))
    whole = np.isfinite(design).all(axis=(1, 2)) & np.isfinite(difference).all(axis=1)
    design, difference = design[whole], difference[whole]
    near = np.ones(len(difference), bool)
    for _ in range(ROUNDS):
        found = np.linalg.lstsq(design[near].reshape(-1, design.shape[2]), difference[near].ravel())[0]
        left = np.linalg.norm(difference - design @ found, axis=1)
        near = left < FAR * np.median(left)
    return found


def _thinned(values: np.ndarray, factor: int) -> np.ndarray:
    """Return columns limited to the lowest 1/factor of the band by cosine coefficients, and decimated by ``factor``."""
    count = len(values) // factor
    kept = dct(values[: count * factor], axis=0, norm="ortho")[:count]
    return idct(kept, axis=0, norm="ortho") / np.sqrt(factor)

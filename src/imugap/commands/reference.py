"""Make the error-free log of a device from its poses, as discovery takes it as the reference.

Stages: read the poses and the log; turn the poses into the axes of the device; differentiate them at the stamps of the
log; compare both; write, and say up to which frequency the reference can be trusted.
"""

import argparse
import sys
from dataclasses import replace

import numpy as np
import pandas as pd
from scipy.spatial.transform import Rotation

from imugap import log
from imugap.commands.arguments import add_examples, add_gravity
from imugap.commands.outputs import require_files
from imugap.commands.reading import LOG_HELP, add_reading, read, settings_of
from imugap.discovery.inputs import MIN_SAMPLES
from imugap.discovery.preparation.reference_band import reference_band
from imugap.io.recognition.frame import AS_IS
from imugap.io.references.poses import read_poses
from imugap.kinematics.error_free import QUATERNION, error_free_log_of, rows_like
from imugap.log import GYRO, LogError

ONE_AXIS = 1e-12
"""Share of the product of the rates about two other axes, below which a device turns about one axis alone."""
MAX_ANGLE_DEG = 5.0
"""Largest angle between the axes of poses and device that may be an error of the device."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    add_examples(parser, "imugap reference data.csv --log imu.csv --align --out reference.csv")
    parser.description = (
        "Make the error-free log of a device from its poses: the angular rate and the specific force of the motion at "
        "the stamps of the log. It is the --reference of discover."
    )
    parser.add_argument(
        "poses", help="poses of the device: EuRoC/ASL or TUM, or a table with a header (time, q_w..., p_x...)"
    )
    parser.add_argument("--log", required=True, help=f"{LOG_HELP}; the reference is made at its stamps, in its axes")
    parser.add_argument(
        "--lag", type=float, default=0.0, help="time by which the stamps of the log are late [s] (default %(default)s)"
    )
    parser.add_argument(
        "--align", action="store_true", help="turn the poses into the axes of the gyroscopes of the log"
    )
    add_gravity(parser)
    parser.add_argument("--out", required=True, help="CSV or Parquet file of the error-free log")
    add_reading(parser)


def run(options: argparse.Namespace) -> None:
    """Write the error-free log to ``--out``, and say how it fits the log."""
    require_files({"--out": options.out}, [options.poses, options.log])
    measured = read(options.log, replace(settings_of(options), frame=AS_IS)).recording.log
    poses = _in_axes(read_poses(options.poses), measured, options)
    found = _error_free(poses, measured, options)
    log.write(found, options.out)
    for line in _fit(found, measured):
        print(line)


def _in_axes(poses: pd.DataFrame, measured: pd.DataFrame, options: argparse.Namespace) -> pd.DataFrame:
    """Return the poses in the axes of the device: as they are, or turned with ``--align``; else a LogError."""
    turn = _turn(_error_free(poses, measured, options), measured)
    angle = float(np.degrees(turn.magnitude()))
    if not options.align:
        if angle > MAX_ANGLE_DEG:
            expected = f"the axes of the device, within {MAX_ANGLE_DEG:g} deg (--align turns them)"
            raise LogError(options.poses, "quaternions", expected, f"them turned by {angle:.1f} deg")
        return poses
    print(f"imugap: poses: turned by {angle:.2f} deg into the axes of the device", file=sys.stderr)
    turned = Rotation.from_quat(poses[list(QUATERNION)]) * turn
    return poses.assign(**dict(zip(QUATERNION, turned.as_quat().T, strict=True)))


def _error_free(poses: pd.DataFrame, measured: pd.DataFrame, options: argparse.Namespace) -> pd.DataFrame:
    """Return the error-free log [rad/s, m/s^2]; a LogError where the poses cover too little of the log."""
    found = error_free_log_of(measured, poses, options.gravity, options.lag)
    if len(found) < MIN_SAMPLES:
        span = f"{poses.index[0]:.9g} to {poses.index[-1]:.9g} s"
        stamps = f"{measured.index[0]:.9g} to {measured.index[-1]:.9g} s"
        expected = f"times of the log, {stamps}, of {MIN_SAMPLES} samples at least"
        raise LogError(options.poses, "time", expected, span)
    return found


def _turn(ideal: pd.DataFrame, measured: pd.DataFrame) -> Rotation:
    """Return the rotation from the axes of the gyroscopes to those of the poses that fits the angular rates best.

    Least squares of Wahba's problem; no rotation for a log without all three gyroscopes, or that turns about one axis
    alone.
    """
    names = [axis for axis in GYRO if axis in measured]
    if len(names) < len(GYRO):
        return Rotation.identity()
    rates = rows_like(measured, ideal)[names]
    true, own = (one[names].to_numpy() - one[names].mean().to_numpy() for one in (ideal, rates))
    first, *others = np.linalg.svd(true.T @ own, compute_uv=False)
    return Rotation.align_vectors(true, own)[0] if sum(others) > ONE_AXIS * first else Rotation.identity()


def _fit(ideal: pd.DataFrame, measured: pd.DataFrame) -> list[str]:
    """Return sentences on how a reference fits the log."""
    rows, step = rows_like(measured, ideal), log.interval(measured)
    names = [axis for axis in log.axes(ideal) if axis in rows]
    band = reference_band(rows[names], ideal[names], step)
    difference = rows[names] - ideal[names]
    mean = ", ".join(f"{axis} {difference[axis].mean():.4g}" for axis in names)
    spread = ", ".join(f"{axis} {difference[axis].std():.3g}" for axis in names)
    trusted = "at all frequencies" if band is None else f"below {band.highest:.3g} Hz"
    return [
        f"Error-free log of {len(ideal)} samples at {1 / step:.6g} Hz; it can be trusted {trusted}.",
        f"Log less reference, mean: {mean} (rad/s, m/s^2).",
        f"Standard deviation: {spread}.",
    ]

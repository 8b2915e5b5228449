"""Nonholonomic constraints: the rear axle of a vehicle has no velocity across and up.

At the end of each epoch these two velocity components of a point of the vehicle, in ``b``, are measured as zero. The
true values, from tyre slip and suspension, have a standard deviation s and a correlation time T; at an epoch of length
d they count as white noise of the same power at zero frequency, with variance ``2 s^2 T/d``, so that the length of the
epochs makes no difference. A component farther from zero than slip allows, by its standard deviation and that of the
velocity, is left out: the vehicle skids, or has no wheels.

At standstill the forward velocity is zero as well. Standstill is detected where the device is nearly as quiet as it
ever is, engine running or not, and the filter is certain of a low speed: on a smooth road a device may be as quiet in
steady motion as at rest.

Sources: S. Sukkarieh, E. M. Nebot, H. F. Durrant-Whyte, A high integrity IMU/GPS navigation loop for autonomous land
vehicle applications, IEEE Trans. Robot. Autom. 15 (1999) 572-578; G. Dissanayake, S. Sukkarieh, E. Nebot, H.
Durrant-Whyte, The aiding of a low-cost strapdown inertial measurement unit using vehicle model constraints for land
vehicle applications, IEEE Trans. Robot. Autom. 17 (2001) 731-747; P. D. Groves, Principles of GNSS, Inertial, and
Multisensor Integrated Navigation Systems, 2nd ed., 2013, section 15.4.1.
"""

from typing import NamedTuple

import numpy as np

from imugap.filters.epochs import STAMP_TOLERANCE_S
from imugap.filters.error_state import ATTITUDE, NAVIGATION, VELOCITY, innovation_variance
from imugap.filters.smoother import apply_measurement
from imugap.filters.zero_velocity import Statistic, statistic
from imugap.numerics.rotation import cross, dot, kernel, mat_from_quat

ACROSS, UP, AHEAD = 1, 2, 0
"""Components in ``b``, in the order of their update."""
CONSTRAINTS = 3
"""Number of constraints."""
WINDOW_S = 1.0
"""Window of the quietness test [s]."""
QUIET_STD = 0.1, 0.02
"""Scales of specific force [m/s^2] and angular rate [rad/s] in the quietness statistic."""
QUIET_RATIO = 2.0
"""Limit of the quietness statistic, as a multiple of its minimum."""
SLOW_M_PER_S, SLOW_SIGMA = 2.0, 3.0
"""A quiet vehicle stands if its speed is below this limit [m/s] by this number of standard deviations."""
SKID_SIGMA = 4.0
"""Limit of a component, in standard deviations, beyond which it is left out."""


class WheelConstraint(NamedTuple):
    """Constraint of the rear axle, for compiled code.

    Attributes
    ----------
    std
        Standard deviation of the velocity across and up [m/s]; 0 for no constraint.
    correlation_s
        Its correlation time [s].
    axle
        From the device to the middle of the rear axle, in ``b`` [m].
    """

    std: float
    correlation_s: float
    axle: tuple[float, float, float]


def quiet_epochs(samples: np.ndarray, stamp: np.ndarray, time: np.ndarray) -> np.ndarray:
    """Return whether the device has been quiet for :data:`WINDOW_S` up to each time, shape (times,).

    Parameters
    ----------
    samples, stamp, time
        Rates and specific forces, shape (n, 6), their stamps, and the times [s].
    """
    window = round(WINDOW_S / float(np.median(np.diff(stamp))))
    found = np.zeros(len(samples), bool)
    if 2 <= window <= len(samples):
        gyro, accel = samples[:, :3] - np.median(samples[:, :3], axis=0), samples[:, 3:]
        force, rate = (statistic(kind, gyro, accel, window, *QUIET_STD, 0.0)
                       for kind in (Statistic.MOVING_VARIANCE, Statistic.RATE_ENERGY))  # fmt: skip
        found[window - 1 :] = force + rate <= QUIET_RATIO * (force + rate).min()
    return found[np.clip(np.searchsorted(stamp, time + STAMP_TOLERANCE_S) - 1, 0, None)]


@kernel
def axle_velocity(i, nav, mat, rate, sensors, sensitivity, axle, row):
    """Return component ``i`` of the axle velocity in ``b``; store its derivative by the states in ``row``."""
    axis = mat[0][i], mat[1][i], mat[2][i]
    turned, swing = cross(axis, nav[1]), cross(rate, axle)
    unit = 1.0 if i == 0 else 0.0, 1.0 if i == 1 else 0.0, 1.0 if i == 2 else 0.0
    shift = cross(unit, axle)
    for m in range(3):
        row[VELOCITY + m], row[ATTITUDE + m] = axis[m], turned[m]
    for s in range(len(sensors.axis)):
        if sensors.axis[s] < 3:
            row[NAVIGATION + s] = sensitivity[s] * shift[sensors.axis[s]]
    return dot(axis, nav[1]) + swing[i]


@kernel
def apply_wheel_constraint(
    wheels, still, interval, nav, rate, covariance, errors, sensors, sensitivity, row, cross_covariance, gain, block,
    slot, first,
):  # fmt: skip
    """Apply the constraints at the end of an epoch of length ``interval`` [s]; return the corrected navigation.

    Parameters
    ----------
    still
        Whether the device is quiet.
    nav, rate
        Position, velocity and quaternion at its end, and the angular rate there, less its estimated error.
    sensors, sensitivity
        Sensor states, and error of the axis per unit of each.
    row
        Workspace, shape (states,), all zero before and after.
    slot, first
        Row of the block, and number of the first measurement there.
    """
    square = wheels.std * wheels.std
    noise = square * max(2 * wheels.correlation_s / interval, 1.0)
    for number in range(CONSTRAINTS if still else CONSTRAINTS - 1):
        mat, component = mat_from_quat(nav[2]), (ACROSS + number) % CONSTRAINTS
        residual = axle_velocity(component, nav, mat, rate, sensors, sensitivity, wheels.axle, row)
        variance = innovation_variance(covariance, row, square, cross_covariance)
        fits = residual * residual <= SKID_SIGMA * SKID_SIGMA * variance
        if fits and (component != AHEAD or abs(residual) + SLOW_SIGMA * np.sqrt(variance) < SLOW_M_PER_S):
            nav, _ = apply_measurement(covariance, errors, row, residual, noise, cross_covariance, gain, nav, block,
                             slot, first + number, True)  # fmt: skip
        else:
            for j in range(len(row)):
                row[j] = 0.0
    return nav

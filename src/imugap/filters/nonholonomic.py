"""Wheels that roll: a vehicle on the road has, at its rear axle, next to no velocity across and none up.

What the filter takes in at the end of each epoch are these two components of the velocity of a point of the vehicle, in
``b``, as measured to be zero. What they truly are, the slip of tyres and the play of the suspension, goes on for a
while: with a standard deviation s and a correlation time T it counts, at an epoch of length d, with the variance
``2 s^2 T/d`` of the white noise that has the same power at zero frequency, so that longer or shorter epochs tell the
same. Where a component is farther from zero than a slip can be, by its standard deviation and that of the velocity,
the vehicle skids, or does not go on wheels at all, and that component is left out.

A vehicle that stands has no velocity ahead either. It is taken to stand where its device is nearly as quiet as it ever
gets, engine running or not, and where the filter is sure that it is slow: on a smooth road a device may be as quiet in
steady motion as at rest.

Sources: S. Sukkarieh, E. M. Nebot, H. F. Durrant-Whyte, A high integrity IMU/GPS navigation loop for autonomous land
vehicle applications, IEEE Trans. Robot. Autom. 15 (1999) 572-578; G. Dissanayake, S. Sukkarieh, E. Nebot, H.
Durrant-Whyte, The aiding of a low-cost strapdown inertial measurement unit using vehicle model constraints for land
vehicle applications, IEEE Trans. Robot. Autom. 17 (2001) 731-747; P. D. Groves, Principles of GNSS, Inertial, and
Multisensor Integrated Navigation Systems, 2nd ed., 2013, section 15.4.1.
"""

from typing import NamedTuple

import numpy as np

from imugap.filters.epochs import NEAR
from imugap.filters.error_state import ATTITUDE, NAVIGATION, VELOCITY, project
from imugap.filters.smoother import take_in
from imugap.filters.zero_velocity import Statistic, statistic
from imugap.numerics.rotation import cross, dot, kernel, mat_from_quat

ACROSS, UP, AHEAD = 1, 2, 0
"""Components in ``b``, in the order in which they are taken in."""
MEASURED = 3
"""How many they are."""
WINDOW_S = 1.0
"""Time over which a device is, or is not, quiet [s]."""
WEIGHTS = 0.1, 0.02
"""Specific force [m/s^2] and angular rate [rad/s] that count the same in its motion."""
QUIET = 2.0
"""A quiet device moves, by the mean square, no more than this many times as much as where it moves least."""
SLOW, SURE = 2.0, 3.0
"""A quiet vehicle that is slower than this [m/s], by so many standard deviations, stands."""
SKID = 4.0
"""A component that is farther from zero, in standard deviations, is none of a wheel that rolls."""


class Wheels(NamedTuple):
    """What is taken for granted of the wheels, as the kernel takes it.

    Attributes
    ----------
    std
        Standard deviation of the velocity across and up [m/s]; 0: nothing is taken for granted.
    correlation_s
        Its correlation time [s].
    axle
        From the device to the middle of the rear axle, in ``b`` [m].
    """

    std: float
    correlation_s: float
    axle: tuple[float, float, float]


def quiet(samples: np.ndarray, stamp: np.ndarray, time: np.ndarray) -> np.ndarray:
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
        force, rate = (statistic(kind, gyro, accel, window, *WEIGHTS, 0.0)
                       for kind in (Statistic.MOVING_VARIANCE, Statistic.RATE_ENERGY))  # fmt: skip
        found[window - 1 :] = force + rate <= QUIET * (force + rate).min()
    return found[np.clip(np.searchsorted(stamp, time + NEAR) - 1, 0, None)]


@kernel
def axle_velocity(i, nav, mat, rate, sensors, gain, axle, row):
    """Return component ``i`` of the velocity of the axle in ``b``, and fill ``row`` with its slope in the states."""
    axis = mat[0][i], mat[1][i], mat[2][i]
    turned, swing = cross(axis, nav[1]), cross(rate, axle)
    unit = 1.0 if i == 0 else 0.0, 1.0 if i == 1 else 0.0, 1.0 if i == 2 else 0.0
    shift = cross(unit, axle)
    for m in range(3):
        row[VELOCITY + m], row[ATTITUDE + m] = axis[m], turned[m]
    for s in range(len(sensors.axis)):
        if sensors.axis[s] < 3:
            row[NAVIGATION + s] = gain[s] * shift[sensors.axis[s]]
    return dot(axis, nav[1]) + swing[i]


@kernel
def roll(
    wheels, still, interval, nav, rate, covariance, errors, sensors, gain, row, spread, weight, tape, place, first
):
    """Take in that the wheels have rolled over an epoch of this length [s]; return the corrected navigation.

    Parameters
    ----------
    still
        Whether the device is quiet.
    nav, rate
        Position, velocity and quaternion at its end, and the angular rate there, less what is known of its error.
    sensors, gain
        The states of the sensors, and what a unit of each adds to its axis.
    row
        Room, shape (states,), that is empty; so it is left.
    place, first
        Row of the tape, and the number of the first measurement there.
    """
    square = wheels.std * wheels.std
    noise = square * max(2 * wheels.correlation_s / interval, 1.0)
    for number in range(MEASURED if still else MEASURED - 1):
        mat, component = mat_from_quat(nav[2]), (ACROSS + number) % MEASURED
        residual = axle_velocity(component, nav, mat, rate, sensors, gain, wheels.axle, row)
        variance = project(covariance, row, square, spread)
        fits = residual * residual <= SKID * SKID * variance
        if fits and (component != AHEAD or abs(residual) + SURE * np.sqrt(variance) < SLOW):
            nav, _ = take_in(covariance, errors, row, residual, noise, spread, weight, nav, tape, place,
                             first + number, True)  # fmt: skip
        else:
            for j in range(len(row)):
                row[j] = 0.0
    return nav

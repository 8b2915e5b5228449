"""Initial alignment: levelling from specific force, and gyroscope biases from a rest."""

import numpy as np

from imugap.filters.sensor_states import SensorStates
from imugap.log import AXES, GYRO


def level_sensitivity(force: np.ndarray, mat_nb: np.ndarray, states: SensorStates, gravity: float) -> np.ndarray:
    """Return the sensitivity of a levelled attitude to the sensor states, shape (2, states).

    A horizontal accelerometer error f tilts the level by ``f/gravity`` (Groves 2013, eq. 5.101). Rows are the errors
    about north and east [rad], columns those of the states, *estimated - true*.
    """
    error = np.zeros((3, len(states)))
    for s in np.flatnonzero((states.axis >= len(GYRO)) & (states.axis < len(AXES))):
        error[states.axis[s] - len(GYRO), s] = force[states.axis[s] - len(GYRO)] if states.scale[s] else 1.0
    across = mat_nb @ error / gravity
    return np.stack([across[1], -across[0]])


def biases_from_rest(
    rate: np.ndarray, duration: float, states: SensorStates, covariance: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Estimate the sensor states, and their covariance, from the mean gyroscope output over a rest.

    Parameters
    ----------
    rate
        Mean output over the rest, less Earth rate and fixed biases [rad/s], shape (3,).
    duration
        Length of the rest [s].
    covariance
        Prior covariance of the states, shape (states, states).
    """
    errors, covariance = np.zeros(len(states)), covariance.copy()
    for axis in range(len(GYRO)):
        row = ((states.axis == axis) & ~states.scale).astype(float)
        noise = states.white[axis] / duration + row @ states.driving_psd * duration / 3
        variance = row @ covariance @ row + noise
        if variance > 0:
            weight = covariance @ row / variance
            errors += weight * (rate[axis] - row @ errors)
            covariance -= np.outer(weight, weight) * variance
    return errors, covariance

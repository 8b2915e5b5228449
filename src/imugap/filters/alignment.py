"""What a body knows of its attitude and its sensors before a filter runs: from a rest, or from what it is given."""

import numpy as np

from imugap.filters.sensor_states import SensorStates
from imugap.log import GYRO


def tilt(force: np.ndarray, mat_nb: np.ndarray, states: SensorStates, gravity: float) -> np.ndarray:
    """Return how the sensor states tilt a level that is taken from the mean specific force, shape (2, states).

    What the accelerometers are off tilts the level by ``1/gravity`` of it, across (Groves 2013, eq. 5.101). Rows are
    the errors about north and east [rad], columns those of the states, *estimated - true*.
    """
    felt = np.zeros((3, len(states)))
    for s in np.flatnonzero(states.axis >= len(GYRO)):
        felt[states.axis[s] - len(GYRO), s] = force[states.axis[s] - len(GYRO)] if states.scale[s] else 1.0
    across = mat_nb @ felt / gravity
    return np.stack([across[1], -across[0]])


def calibrated(
    rate: np.ndarray, duration: float, states: SensorStates, covariance: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return errors of the sensor states and their covariance after a rest in which the gyroscopes show ``rate``.

    Parameters
    ----------
    rate
        Mean over the rest, less the rate of the Earth and the fixed biases [rad/s], shape (3,).
    duration
        Of the rest [s]: the mean of white noise falls with it, and a process moves by its driving noise meanwhile.
    covariance
        Of the states before, shape (states, states).
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

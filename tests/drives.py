"""Compare solutions of simulated drives with their truth."""

import numpy as np
from scipy.spatial.transform import Rotation

from imugap.io.references import reference
from imugap.kinematics.strapdown import POSITION, VELOCITY


def true_state(drive, time):
    """Return true position and velocity, shape (n, 6), and attitude at times [s] of samples."""
    truth = drive.path[0].iloc[np.rint(np.atleast_1d(time) * drive.rate_hz).astype(int)]
    return truth[[*POSITION, *VELOCITY]].to_numpy(float), reference.rotations(truth)


def navigation_error(drive, solution, rows):
    """Return the error of position, velocity and attitude (rotation vector) at rows of a solution, shape (rows, 9)."""
    linear, turn = true_state(drive, solution.time.to_numpy()[rows])
    found = solution.history.navigation[rows]
    return np.hstack([found[:, :6] - linear, (Rotation.from_quat(found[:, 6:]) * turn.inv()).as_rotvec()])

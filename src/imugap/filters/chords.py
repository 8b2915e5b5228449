"""Chords between epochs of a smoothed path, as exactly as the smoother knows them.

The errors of two places are alike, since most of what moves the one moves the other: the difference of their variances
says little about the chord between them, and may be negative. With P the covariance of the filter after the
measurements of an epoch, L the information from the later ones (Bierman 1973), and T the transition of the error of the
filter from epoch i to a later epoch j, measurements included, the errors of the smoother have the covariance

* at one epoch ``P - P L P``,
* between i and j ``P_i T' (I - L_j P_j)``.

The backward pass carries ``T' (I - L_j P_j)`` of the position with the adjoint: that of the last end that was passed,
and the sum over all of them weighted by the gradient of the length of the path.

Sources: P. de Jong, M. J. MacKinnon, Covariances for smoothed estimates in state space models, Biometrika 75 (1988)
601-602; G. J. Bierman, Fixed interval smoothing with discrete measurements, Int. J. Control 18 (1973) 65-75.
"""

from typing import NamedTuple

import numpy as np

from imugap.numerics.rotation import kernel

LENGTH = 3
"""Row of the carried functionals for the length of the path; those before are the components of the position."""


class Chords(NamedTuple):
    """Chords between successive ends.

    Attributes
    ----------
    epochs
        Ends, increasing, shape (ends,).
    gradient
        Gradient of the horizontal length of the path by the position of each end, shape (ends, 3).
    covariance
        Covariance of each chord in ``n`` [m^2], shape (ends - 1, 3, 3).
    length_variance
        Variance of the length of the path [m^2], shape (1,).
    place
        Covariance of the position of the end that was passed last [m^2], a workspace, shape (3, 3).
    """

    epochs: np.ndarray
    gradient: np.ndarray
    covariance: np.ndarray
    length_variance: np.ndarray
    place: np.ndarray

    @classmethod
    def between(cls, epochs: np.ndarray, position: np.ndarray, shortest: float) -> "Chords":
        """Allocate the chords between epochs.

        Parameters
        ----------
        epochs
            Ends, increasing, from 1 on, shape (ends,).
        position
            Position at the ends [m], shape (ends, 3).
        shortest
            Horizontal length up to which a chord does not count for the path [m].
        """
        steps = np.diff(position, axis=0) * [1.0, 1.0, 0.0]
        lengths = np.linalg.norm(steps, axis=1, keepdims=True)
        units = np.divide(steps, lengths, out=np.zeros_like(steps), where=lengths > shortest)
        gradient = np.pad(units, ((1, 0), (0, 0))) - np.pad(units, ((0, 1), (0, 0)))
        epochs = np.asarray(epochs, np.int64)
        return cls(epochs, gradient[: len(epochs)], np.zeros((len(steps), 3, 3)), np.zeros(1), np.zeros((3, 3)))


@kernel
def pass_end(chords, number, covariance, inner, carried):
    """Take in an end on the way backward: the chord to the end after it, and its part of the length of the path.

    Parameters
    ----------
    number
        Number of the end.
    covariance, inner
        P and P L at the end, shape (states, states).
    carried
        Functionals carried from the later ends, shape (4, states); those from this end on afterwards.
    """
    size, gradient = len(covariance), chords.gradient[number]
    for i in range(3):
        for j in range(3):
            smoothed = covariance[i, j]
            for m in range(size):
                smoothed -= inner[i, m] * covariance[m, j]
            if number < len(chords.covariance):
                chord = smoothed + chords.place[i, j]
                for m in range(size):
                    chord -= covariance[i, m] * carried[j, m] + covariance[j, m] * carried[i, m]
                chords.covariance[number, i, j] = chord
            chords.place[i, j] = smoothed
            chords.length_variance[0] += gradient[i] * smoothed * gradient[j]
        for m in range(size):
            chords.length_variance[0] += 2 * gradient[i] * covariance[i, m] * carried[LENGTH, m]
    for m in range(size):
        for i in range(3):
            carried[i, m] = (1.0 if i == m else 0.0) - inner[i, m]
            carried[LENGTH, m] += gradient[i] * carried[i, m]


@kernel
def carry_measurement(carried, row, gain):
    """Carry the functionals back over a scalar measurement of a row h and a gain k: ``(I - h'k') a`` for each."""
    for a in range(len(carried)):
        along = 0.0
        for j in range(len(row)):
            along += gain[j] * carried[a, j]
        for j in range(len(row)):
            carried[a, j] -= along * row[j]


@kernel
def carry_transition(carried, transposed, work):
    """Carry the functionals back over an epoch; ``transposed`` is the transposed transition, ``work`` a vector."""
    size = len(transposed)
    for a in range(len(carried)):
        for i in range(size):
            work[i] = 0.0
            for m in range(size):
                work[i] += transposed[i, m] * carried[a, m]
        for i in range(size):
            carried[a, i] = work[i]

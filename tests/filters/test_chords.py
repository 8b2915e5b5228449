"""Chords of the smoother against the joint covariance of all epochs, conditioned on all measurements at once."""

import numpy as np
import pytest

from imugap.filters.chords import Chords
from imugap.filters.error_state import NAVIGATION
from imugap.filters.smoother import History, SmootherBlock, smooth_block
from imugap.stream import stream

SEED = 5
EPOCHS = 8
ENDS = np.array([1, 4, 7])


def drawn():
    """Return the block and the history of a filter of random transitions, and the conditioned joint covariance."""
    rng, size = stream(SEED, "chords"), NAVIGATION
    moves = np.eye(size) + 0.3 * rng.standard_normal((EPOCHS, size, size))
    rows = rng.standard_normal((EPOCHS, 2, size))
    block, history = SmootherBlock.empty(EPOCHS - 1, size, 2), History.empty(EPOCHS, size)
    history.navigation[:] = np.r_[np.zeros(NAVIGATION), 1.0]
    covariance = np.eye(size)
    joint = np.zeros((EPOCHS * size, EPOCHS * size))
    joint[:size, :size] = covariance
    for k in range(1, EPOCHS):
        now, before = slice(k * size, (k + 1) * size), slice(k * size)
        noise = 0.1 * np.eye(size)
        joint[now, before] = moves[k] @ joint[(k - 1) * size : k * size, before]
        joint[before, now] = joint[now, before].T
        joint[now, now] = moves[k] @ joint[(k - 1) * size : k * size, (k - 1) * size : k * size] @ moves[k].T + noise
        covariance = moves[k] @ covariance @ moves[k].T + noise
        for number, row in enumerate(rows[k]):
            variance = row @ covariance @ row + 0.5
            gain = covariance @ row / variance
            covariance = covariance - np.outer(gain, gain) * variance
            block.gains[k - 1, number], block.variances[k - 1, number] = gain, variance
        block.transposed[k - 1], block.rows[k - 1], block.covariance[k - 1] = moves[k].T, rows[k], covariance
    for k in range(1, EPOCHS):
        for row in rows[k]:
            whole = np.zeros(EPOCHS * size)
            whole[k * size : (k + 1) * size] = row
            gain = joint @ whole / (whole @ joint @ whole + 0.5)
            joint = joint - np.outer(gain, whole @ joint)
    return history, block, joint


@pytest.mark.parametrize("edge", [EPOCHS, 5, 4])
def test_chords_are_those_of_the_joint_covariance(edge):
    """In one block, and in two with an end on either side of their edge."""
    history, block, joint = drawn()
    chords = Chords.between(ENDS, stream(SEED, "places").standard_normal((len(ENDS), 3)), 0.0)
    adjoint, information, carried = np.zeros(NAVIGATION), np.zeros((NAVIGATION, NAVIGATION)), np.zeros((4, NAVIGATION))
    largest = np.zeros(NAVIGATION)
    for first, last in ((edge, EPOCHS), (1, edge)):
        part = SmootherBlock(*(one[first - 1 : last - 1] for one in block))
        smooth_block(history, first, last, part, adjoint, information, largest, chords, carried)
    place = np.zeros((len(ENDS), 3, len(joint)))
    for number, end in enumerate(ENDS):
        place[number, :, end * NAVIGATION : end * NAVIGATION + 3] = np.eye(3)
    steps = np.diff(place, axis=0)
    np.testing.assert_allclose(chords.covariance, steps @ joint @ steps.transpose(0, 2, 1), atol=1e-9)
    length = np.einsum("ni,nij->j", chords.gradient, place)
    np.testing.assert_allclose(chords.length_variance, length @ joint @ length, atol=1e-9)


def test_the_gradient_is_that_of_the_horizontal_length_and_a_short_chord_does_not_count():
    position = np.array([[0.0, 0.0, 0.0], [3.0, 4.0, 9.0], [3.0, 4.05, 9.0], [3.0, 5.05, 9.0]])
    gradient = Chords.between(np.arange(1, 5), position, 0.1).gradient
    np.testing.assert_allclose(gradient, [[-0.6, -0.8, 0], [0.6, 0.8, 0], [0, -1, 0], [0, 1, 0]])

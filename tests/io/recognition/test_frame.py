from itertools import permutations, product

import numpy as np
import pytest

from imugap.io.recognition.frame import UPWARD, rotation_of, upright
from imugap.numerics.rotation import from_euler


@pytest.mark.parametrize(("axis", "sign"), UPWARD)
def test_a_device_at_rest_is_turned_so_that_z_points_down(axis, sign):
    force = np.zeros(3)
    force[axis] = sign
    turn = rotation_of(upright(force))
    np.testing.assert_array_equal(turn @ force, [0, 0, -1])
    assert np.linalg.det(turn) == pytest.approx(1)


def test_a_device_that_turns_or_leans_is_left_as_it_is():
    assert upright(np.array([0.0, 0.1, 0.5])) is None
    assert upright(np.array([0.0, 0.6, 0.8])) is None


@pytest.mark.parametrize(
    ("frame", "measured", "expected"),
    [
        ("FRD", [1, 2, 3], [1, 2, 3]),
        ("FLU", [1, 2, 3], [1, -2, -3]),
        ("NED", [1, 2, 3], [1, 2, 3]),
        ("ENU", [1, 2, 3], [2, 1, -3]),
        ("RFU", [1, 2, 3], [2, 1, -3]),
        ("flu", [1, 2, 3], [1, -2, -3]),
    ],
)
def test_directions_are_turned_to_forward_right_down(frame, measured, expected):
    np.testing.assert_array_equal(rotation_of(frame) @ measured, expected)


def test_half_of_the_directions_are_left_handed_and_refused():
    count = {True: 0, False: 0}
    for letters in (p for order in permutations(["FB", "RL", "DU"]) for p in product(*order)):
        try:
            turn = rotation_of("".join(letters))
        except ValueError as error:
            assert "right-handed" in str(error)  # noqa: PT017
            count[False] += 1
        else:
            assert np.linalg.det(turn) == pytest.approx(1)
            count[True] += 1
    assert count == {True: 24, False: 24}


def test_angles_are_the_attitude_of_the_device():
    angles = [10.0, -20.0, 130.0]
    turn = rotation_of(",".join(map(str, angles)))
    np.testing.assert_allclose(turn, from_euler(np.radians(angles)).as_matrix())
    with pytest.raises(ValueError, match=r"--frame: expected .*; found 'up'"):
        rotation_of("up")

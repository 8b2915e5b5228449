import numpy as np
import pytest

from imugap.numerics.small_matrix import invert
from imugap.stream import stream


@pytest.mark.parametrize("size", range(7))
def test_inverse_and_determinant_of_indefinite_matrices(size):
    for run in range(20):
        half = stream(3, "matrix", size, run).standard_normal((size, size))
        matrix = half + half.T
        inverse, log_determinant = invert(matrix)
        np.testing.assert_allclose(inverse @ matrix, np.eye(size), atol=1e-9 * max(1, np.linalg.norm(inverse, 2)))
        assert log_determinant == pytest.approx(np.linalg.slogdet(matrix)[1], abs=1e-9)


def test_pivots_are_exchanged_and_the_argument_is_kept():
    matrix = np.array([[0.0, 2.0], [0.5, 0.0]])
    inverse, log_determinant = invert(matrix)
    np.testing.assert_array_equal(inverse, [[0.0, 2.0], [0.5, 0.0]])
    assert log_determinant == 0.0
    np.testing.assert_array_equal(matrix, [[0.0, 2.0], [0.5, 0.0]])


def test_a_singular_matrix_has_no_inverse():
    inverse, log_determinant = invert(np.zeros((2, 2)))
    assert not np.isfinite(inverse).any()
    assert log_determinant == -np.inf

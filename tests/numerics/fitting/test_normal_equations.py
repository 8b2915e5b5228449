"""Normal equations of few unknowns."""

import numpy as np
import pytest

from imugap.numerics.fitting import normal_equations

COLUMNS = np.random.default_rng(3).standard_normal((50, 4))
RIGHT = np.random.default_rng(4).standard_normal(50)


def solved(columns, least=1e-10):
    return normal_equations.solution(columns.T @ columns, columns.T @ RIGHT, least)


def test_the_solution_is_that_of_least_squares():
    np.testing.assert_allclose(solved(COLUMNS), np.linalg.lstsq(COLUMNS, RIGHT)[0], rtol=1e-10)


@pytest.mark.parametrize("unit", [1e-9, 1e9])
def test_the_unit_of_an_unknown_scales_it_and_nothing_else(unit):
    units = np.array([1.0, unit, 1.0, 1.0])
    np.testing.assert_allclose(solved(COLUMNS * units) * units, solved(COLUMNS), rtol=1e-9)


def test_equal_columns_share_what_one_of_them_has_and_an_empty_one_gets_nothing():
    one, *others = solved(COLUMNS)
    shared = solved(np.column_stack([COLUMNS[:, 0], COLUMNS, np.zeros(50)]))
    np.testing.assert_allclose(shared, [one / 2, one / 2, *others, 0.0], rtol=1e-9, atol=1e-12)


def test_nothing_is_asked_of_no_unknowns():
    assert solved(COLUMNS[:, :0]).shape == (0,)


def test_a_right_side_that_is_not_finite_has_no_solution():
    assert np.isnan(normal_equations.solution(np.eye(2), np.array([1.0, np.nan]), 1e-10)).all()

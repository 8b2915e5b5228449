"""Ends of walks: an ellipse holds its share of normal ends, and a mean has an interval that holds it."""

import numpy as np
import pytest

from imugap.stream import stream
from imugap.study.walk.end_consistency import SQUARES, in_ellipse, interval_columns, mean_row

COUNT = 20_000


@pytest.mark.parametrize("probability", [0.5, 0.9, 0.99])
def test_an_ellipse_holds_the_share_of_ends_that_it_states(probability):
    nees = np.sum(stream(1, "ends", probability).standard_normal((COUNT, 2)) ** 2, axis=1)
    share = in_ellipse(nees, probability).mean()
    assert abs(share - probability) < 4 * np.sqrt(probability * (1 - probability) / COUNT)


@pytest.mark.parametrize("square", SQUARES)
def test_the_mean_squared_error_over_its_degrees_of_freedom_is_one_for_a_consistent_filter(square):
    _, degrees = SQUARES[square]
    rng = stream(2, "ends", square)
    row = mean_row(square, rng.chisquare(degrees, 2000) / degrees, rng)
    value, low, high = (row[name] for name in interval_columns(square))
    error = np.sqrt(2 / degrees / 2000)
    assert abs(value - 1) < 4 * error
    assert low < value < high
    assert 0.8 < (high - low) / (2 * 1.96 * error) < 1.25

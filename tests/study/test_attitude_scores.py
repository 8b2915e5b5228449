import numpy as np
import pandas as pd
import pytest
from scipy.stats import chi2

from imugap.navigation.attitude import COVARIANCE
from imugap.stream import stream
from imugap.study import attitude_scores


def test_scores_of_a_swing_about_an_offset():
    phase = 2 * np.pi * np.arange(1000) / 1000
    found = attitude_scores.scores(pd.DataFrame({"roll": 3 + 2 * np.sin(phase)})).loc["roll"]
    assert found.to_dict() == pytest.approx(
        {"variance": 2, "mean_abs": 3, "rms": np.sqrt(11), "lowest": 1, "highest": 5}
    )


def test_nees_of_errors_drawn_from_the_covariance_is_chi_square_of_two():
    rng, count = stream(1, "nees"), 2000
    root = np.array([[0.02, 0.0], [0.015, 0.01]])
    covariance = root @ root.T
    drawn = rng.standard_normal((count, 2)) @ root.T
    error = pd.DataFrame(drawn, columns=["north", "east"])
    values = (covariance[0, 0], covariance[0, 1], covariance[1, 1], 1.0)
    solution = pd.DataFrame(dict(zip(COVARIANCE, values, strict=True)), index=error.index)
    low, high = chi2.ppf([0.0005, 0.9995], 2 * count) / count
    assert low < attitude_scores.nees(error, solution).mean() < high


def test_a_larger_variance_is_told_from_chance_and_an_equal_one_is_not():
    rng = stream(2, "difference")
    noise = rng.standard_normal((3, 1000))
    louder = attitude_scores.difference(noise[0], 3 + 1.5 * noise[1], stream(3))
    assert louder.low < 1.25 < louder.high
    assert louder.differs
    assert not attitude_scores.difference(noise[0], noise[2], stream(4)).differs
    assert attitude_scores.difference(noise[0], noise[0] + 7, stream(5)).value == pytest.approx(0, abs=1e-12)

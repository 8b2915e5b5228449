import numpy as np
import pandas as pd
import pytest
from scipy.stats import chi2

from imugap.navigation.attitude import COVARIANCE
from imugap.stream import stream
from imugap.study.attitude import attitude_scores


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


def test_a_larger_variance_is_significant_and_an_equal_one_is_not():
    rng = stream(2, "difference")
    noise = rng.standard_normal((3, 1000))
    louder = attitude_scores.difference(noise[0], 3 + 1.5 * noise[1], stream(3))
    assert louder.low < 1.25 < louder.high
    assert louder.differs
    assert not attitude_scores.difference(noise[0], noise[2], stream(4)).differs
    assert attitude_scores.difference(noise[0], noise[0] + 7, stream(5)).value == pytest.approx(0, abs=1e-12)


def test_scored_and_differences_keep_the_labels_of_a_solution_and_of_a_group():
    rng = stream(6, "groups")
    rows = []
    for run, scheme in ((2, "allan"), (2, "indirect"), (1, "allan"), (1, "indirect")):
        error = pd.DataFrame(rng.standard_normal((400, 2)), columns=["north", "east"]).rename_axis("time")
        solution = pd.DataFrame(dict(zip(COVARIANCE, (1.0, 0.0, 1.0, 1.0), strict=True)), index=error.index)
        errors, scores = attitude_scores.scored(solution, error, ["east"], {"run": run, "scheme": scheme})
        assert scores[["angle", "run", "scheme"]].to_numpy().tolist() == [["east", run, scheme]]
        assert scores["nees"].iloc[0] == pytest.approx((error**2).sum(axis=1).mean())
        rows.append(errors)
    found = attitude_scores.differences(pd.concat(rows), ["run"], ["north", "east"], 1)
    assert found[["run", "angle"]].to_numpy().tolist() == [[2, "north"], [2, "east"], [1, "north"], [1, "east"]]
    first, second = (one["north"].to_numpy() for one in rows[:2])
    expected = attitude_scores.difference(first, second, stream(1, "difference", 2, "north"))
    assert found[["value", "low", "high"]].iloc[0].tolist() == [expected.value, expected.low, expected.high]

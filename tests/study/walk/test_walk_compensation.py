from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from scipy.special import chdtri

from imugap import log
from imugap.effects import Bias, GaussMarkov, TurnOnBias, WhiteNoise
from imugap.effects.effect import AxisModel
from imugap.estimation.variances import allan
from imugap.interchange.from_indices import AxisIndices, restoration
from imugap.kinematics.strapdown import COLUMNS
from imugap.log import AXES, GYRO
from imugap.model import ErrorModel
from imugap.simulation.walk import Walk, WalkCourse
from imugap.study.walk.walk_compensation import End, filter_model, stand_biases, subtracted, white_noise_model

ROOT = Path(__file__).parents[3]
SEED = 41


def nothing(count, interval=0.01):
    return log.from_samples(dict.fromkeys(AXES, np.zeros(count)), interval)


def one_axis(*effects):
    return ErrorModel({"gyro_z": AxisModel(effects)})


def test_what_is_certain_is_taken_off_and_nothing_else():
    model = one_axis(Bias(0.3))
    left = subtracted(model.simulate(nothing(50), SEED), model, SEED, "any")
    np.testing.assert_allclose(left, 0, atol=1e-15)


def test_a_drawn_bias_doubles_the_variance_of_that_of_the_device():
    model, runs = one_axis(TurnOnBias(0.2)), 1000
    left = [
        subtracted(model.simulate(nothing(2), SEED, "device", run), model, SEED, "drawn", run)["gyro_z"].iloc[0]
        for run in range(runs)
    ]
    low, high = chdtri(runs, [0.995, 0.005])
    assert low < np.sum(np.square(left)) / (2 * 0.2**2) < high


def test_restoration_in_a_filter_is_the_white_noise_that_it_makes():
    """Stability Bs over periods P: density Bs sqrt(P), as the Allan deviation of its sequences has it."""
    of = AxisIndices(0.1, 3e-3, 0.02, 1e-3, 0.0, 0.0, 0.5, pd.DataFrame())
    model = ErrorModel({"gyro_x": restoration(of)})
    held = filter_model(model)["gyro_x"]
    density = next(one.density for one in held if isinstance(one, WhiteNoise))
    assert density == pytest.approx(3e-3 * np.sqrt(0.5))
    assert {one.name for one in held} == {"bias", "turn_on_bias", "white_noise"}
    sequence = model.simulate(nothing(40_000), SEED)["gyro_x"].to_numpy()
    curve = allan.curve(sequence, 0.01)["deviation"].iloc[:10]
    np.testing.assert_allclose(curve * np.sqrt(curve.index), density, rtol=0.06)


def test_what_is_fitted_to_be_nothing_is_no_state():
    assert list(filter_model(one_axis(GaussMarkov(0.0, 10.0), WhiteNoise(1e-3)))["gyro_z"]) == [WhiteNoise(1e-3)]


def test_the_stand_shows_the_biases_of_the_gyroscopes():
    walk = replace(Walk.read(ROOT / "data" / "walk.yaml"), course=WalkCourse.loop(6))
    record = walk.record(1, SEED)
    found, drawn = stand_biases(record), (record - walk.ideal(1, SEED)).loc[: walk.course.stand_s].mean()
    assert set(found.axes) == set(GYRO)
    for axis in GYRO:
        assert next(iter(found[axis])).value == pytest.approx(drawn[axis], rel=0.1)


def test_a_filter_without_states_has_the_densities_that_it_is_given():
    densities = dict(zip(AXES, np.arange(1.0, 7.0), strict=True))
    assert {axis: list(one) for axis, one in white_noise_model(densities).axes.items()} == {
        axis: [WhiteNoise(value)] for axis, value in densities.items()
    }


def test_the_end_is_compared_the_short_way_round_and_by_its_covariance():
    found = pd.DataFrame([[3.0, 4.0, -2.0, 0, 0, 0, 0, 0, np.radians(179)]], columns=list(COLUMNS))
    true = pd.DataFrame([[0.0] * 8 + [np.radians(-179)]], columns=list(COLUMNS))
    covariance = np.array([[4.0, 1.0], [1.0, 2.0]])
    solution = SimpleNamespace(trajectory=found, trajectory_std=0 * found + 0.01, horizontal=covariance[None])
    end = End.of(solution, true)
    assert (end.position, end.height) == pytest.approx((5.0, 2.0))
    assert end.heading == pytest.approx(np.radians(2))
    assert end.heading_nees == pytest.approx((np.radians(2) / 0.01) ** 2)
    assert end.nees == pytest.approx(np.array([3.0, 4.0]) @ np.linalg.inv(covariance) @ [3.0, 4.0])

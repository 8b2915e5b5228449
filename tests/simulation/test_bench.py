from math import pi
from pathlib import Path

import numpy as np
import pytest
import yaml

from imugap import log
from imugap.estimation.variances import allan
from imugap.simulation.bench import Bench, Room

RECIPE = Path(__file__).parents[2] / "data" / "bench.yaml"
ROOM = Room(25.0, 6.0, 900.0, 0.8, 5400.0)
RUNS = 60


@pytest.fixture(scope="module")
def bench():
    return Bench.read(RECIPE)


@pytest.fixture(scope="module")
def runs(bench):
    """Short runs of the device of the study."""
    return [bench.run(number, 0.01, 20.0, seed=81) for number in range(1, RUNS + 1)]


def parameter(bench, axis, name, key):
    (found,) = (effect for effect in bench.model[axis] if effect.name == name)
    return getattr(found, key)


def test_a_run_is_a_log_of_six_axes_and_the_temperature(runs):
    assert tuple(log.check(runs[0]).columns) == log.COLUMNS
    assert log.duration(runs[0]) == pytest.approx(20.0)
    assert log.interval(runs[0]) == pytest.approx(0.01)


def test_a_run_comes_back_by_its_number_and_its_seed(bench, runs):
    assert bench.run(3, 0.01, 20.0, seed=81).equals(runs[2])
    assert not bench.run(3, 0.01, 20.0, seed=82).equals(runs[2])
    assert not runs[3].equals(runs[2])


@pytest.mark.parametrize("axis", log.AXES)
def test_runs_scatter_about_the_bias_by_the_turn_on_deviation(bench, runs, axis):
    starts = np.array([run[axis].mean() for run in runs]) - bench.site.ideal()[axis]
    cold = parameter(bench, axis, "temperature", "coefficient") * (25.0 - 31.0)
    spread = parameter(bench, axis, "turn_on_bias", "std")
    swing = 0.8 * abs(parameter(bench, axis, "temperature", "coefficient"))
    assert abs(starts.mean() - parameter(bench, axis, "bias", "value") - cold) < 4 * spread / np.sqrt(RUNS) + swing
    assert 0.7 < starts.std(ddof=1) / np.hypot(spread, swing / np.sqrt(2)) < 1.3  # 4 sigma at 60 runs


@pytest.mark.parametrize("axis", log.AXES)
def test_samples_lie_on_the_lattice_of_the_resolution(bench, runs, axis):
    step = parameter(bench, axis, "resolution", "step")
    count = runs[0][axis] / step
    np.testing.assert_allclose(count, np.rint(count), atol=1e-6)
    assert np.ptp(count) > 3


@pytest.mark.parametrize("axis", log.AXES)
def test_fast_noise_is_white_noise_and_rounding(bench, runs, axis):
    found = np.mean([allan.variance(run[axis].to_numpy(), np.array([10]))[0] for run in runs])
    white = parameter(bench, axis, "white_noise", "density") ** 2 / 0.1
    rounding = parameter(bench, axis, "resolution", "step") ** 2 / 12 / 10
    assert found == pytest.approx(white + rounding, rel=0.05)


def test_temperature_rises_from_the_room_to_the_self_heated_device():
    time = np.array([0.0, 900.0, 1e9])
    calm = Room(25.0, 6.0, 900.0, 0.0, 5400.0).temperature(time, 0.0)
    np.testing.assert_allclose(calm, [25.0, 25.0 + 6.0 * 0.6321, 31.0], atol=1e-3)  # 63.2 % after a time constant


def test_temperature_swings_with_the_room():
    calm = Room(25.0, 6.0, 900.0, 0.0, 5400.0)
    time = np.linspace(0, 5400.0, 5401)
    swing = ROOM.temperature(time, 0.7) - calm.temperature(time, 0.7)
    assert np.abs(swing).max() == pytest.approx(0.8, rel=1e-4)
    np.testing.assert_allclose(swing[:2701] + swing[2700:], 0, atol=1e-9)
    np.testing.assert_allclose(ROOM.temperature(time, 0.7 + 2 * pi), ROOM.temperature(time, 0.7), atol=1e-9)


def test_recorded_temperature_is_the_room_to_a_hundredth(runs):
    recorded = runs[0]["temperature"]
    np.testing.assert_allclose(recorded * 100, np.rint(recorded * 100), atol=1e-6)
    assert recorded.between(25 - 0.9, 25 + 0.9 + 0.2).all()


def test_runs_meet_the_room_at_different_phases(runs):
    assert np.std([run["temperature"].iloc[0] for run in runs]) == pytest.approx(0.8 / np.sqrt(2), rel=0.25)


def test_truth_is_the_recipe(bench):
    truth, recipe = bench.truth()["model"], yaml.safe_load(RECIPE.read_text())["model"]
    assert list(truth) == list(recipe)
    for axis, items in recipe.items():
        found = {name: values for item in truth[axis] for name, values in item.items()}
        written = {name: values for item in items for name, values in item.items()}
        assert len(truth[axis]) == len(items)
        assert {name: {key: found[name][key] for key in values} for name, values in written.items()} == written
        assert not any(found[name][key] for name in found for key in found[name].keys() - written[name].keys())


def test_site_of_the_recipe_knows_its_heading(bench):
    assert str(bench.site) == "latitude 40 deg, height 50 m, heading 30 deg"

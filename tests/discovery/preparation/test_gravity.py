"""Gravity at rest is no error: a model that is found simulates the log that it was found on."""

import numpy as np
import pytest

from imugap import log
from imugap.discovery.device import Settings, discover
from imugap.discovery.inputs import Files, discover_files
from imugap.discovery.preparation.gravity import SensedGravity
from imugap.discovery.verdict import verdict
from imugap.effects import Bias, WhiteNoise
from imugap.effects.effect import AxisModel
from imugap.log import from_samples
from imugap.model import ErrorModel, offset_of
from imugap.units import STANDARD_GRAVITY

INTERVAL, COUNT = 0.02, 6000
QUICK = Settings(replicates=20, simulations=10, catalogue=(WhiteNoise,))


def levels(*values):
    return ErrorModel(
        {axis: AxisModel((Bias(value), WhiteNoise(1e-3))) for axis, value in zip(log.ACCEL, values, strict=False)}
    )


def at_rest(direction, size=STANDARD_GRAVITY):
    """Return the error-free log of a device at rest whose specific force has a direction."""
    force = size * np.asarray(direction, float) / np.linalg.norm(direction)
    values = {axis: np.zeros(COUNT) for axis in log.GYRO}
    values |= {axis: np.full(COUNT, part) for axis, part in zip(log.ACCEL, force, strict=True)}
    return from_samples(values, INTERVAL)


@pytest.mark.parametrize("direction", [(0, 0, -1), (0, 0, 1), (1, 0, 0), (0.3, -0.5, 0.8)])
def test_only_the_bias_along_gravity_is_in_the_model(direction):
    up = np.asarray(direction, float) / np.linalg.norm(direction)
    model = levels(*((STANDARD_GRAVITY + 0.03) * up))
    gravity = SensedGravity.of(model, ErrorModel({}), STANDARD_GRAVITY)
    biases = [offset_of(gravity.taken_from(model)[axis]) for axis in log.ACCEL]
    np.testing.assert_allclose(biases, 0.03 * up, atol=1e-12)
    assert gravity.along == pytest.approx(0.03)


def test_biases_of_the_start_model_stay_across_gravity():
    gravity = SensedGravity.of(levels(0.2, 0.0, -9.8), levels(0.2, 0.0, 0.0), STANDARD_GRAVITY)
    np.testing.assert_allclose(gravity.biases, [0.2, 0.0, STANDARD_GRAVITY - 9.8], atol=1e-12)


def test_the_bias_along_gravity_is_that_of_the_model_and_not_the_rest_beside_the_start_model():
    gravity = SensedGravity.of(levels(0.0, 0.0, -9.98), levels(0.0, 0.0, 0.1), STANDARD_GRAVITY)
    assert gravity.along == pytest.approx(9.98 - STANDARD_GRAVITY)
    assert gravity.biases[2] == pytest.approx(STANDARD_GRAVITY - 9.98)


@pytest.mark.parametrize("values", [(0.0, 0.0, 0.02), (0.1, 0.1), (0.0, 0.0, -4.9), ()])
def test_a_log_without_gravity_keeps_its_level(values):
    assert SensedGravity.of(levels(*values), ErrorModel({}), STANDARD_GRAVITY) is None


def test_discovery_on_its_own_simulation_finds_nothing_more():
    """A law: discover, simulate at rest, and discover again; no gravity enters a model twice."""
    noise = AxisModel((WhiteNoise(1e-3), Bias(2e-3)))
    truth = ErrorModel(dict.fromkeys(log.AXES, noise))
    first = discover([truth.simulate(at_rest((0.1, 0.2, -1.0)), 1, "law")], QUICK)
    assert all(abs(offset_of(first.final[axis])) < 0.05 for axis in log.ACCEL)
    assert "gravity" in verdict(first)
    again = discover([first.final.simulate(at_rest((0, 0, -1)), 2, "law")], QUICK)
    assert again.findings == ()
    for axis in log.AXES:
        assert offset_of(again.final[axis]) == pytest.approx(offset_of(first.final[axis]), abs=5e-3)


def test_the_local_gravity_is_taken_where_it_is_given():
    truth = ErrorModel(dict.fromkeys(log.AXES, AxisModel((WhiteNoise(1e-3),))))
    still = truth.simulate(at_rest((0, 0, -1), 9.78), 1, "local")
    found = discover([still], Settings(replicates=20, simulations=10, catalogue=(WhiteNoise,), gravity=9.78))
    assert found.gravity.along == pytest.approx(0.0, abs=1e-3)


@pytest.mark.parametrize("direction", [(0, 0, 1), (1, 0, 0), (0, -1, 0)])
def test_a_model_is_of_the_axes_of_the_file_whichever_of_them_points_up(tmp_path, direction):
    truth = ErrorModel({axis: AxisModel((WhiteNoise(1e-4), Bias(0.01 * k))) for k, axis in enumerate(log.AXES)})
    log.write(truth.simulate(at_rest(direction), 1, "axes").iloc[:2000], tmp_path / "log.csv")
    found = discover_files(Files((tmp_path / "log.csv",)), QUICK).found
    for axis in log.GYRO:
        assert offset_of(found.final[axis]) == pytest.approx(offset_of(truth[axis]), abs=1e-3)

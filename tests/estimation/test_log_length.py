"""How well a log determines its parameters, and how long one would have to be."""

import re

import numpy as np
import pytest

from imugap.effects import BiasInstability, Conditions, GaussMarkov, RandomWalk, WhiteNoise
from imugap.effects.effect import AxisModel
from imugap.estimation.log_length import NARROW, sentences, widths
from imugap.estimation.report import EstimatorSettings, estimate_axis

INTERVAL = 0.1


def estimated(model, count, *kinds, axis="gyro_x"):
    conditions = Conditions(np.arange(count) * INTERVAL, INTERVAL)
    samples = AxisModel(tuple(model)).simulate(np.zeros(count), conditions, 5, "length")
    return estimate_axis(axis, samples, INTERVAL, EstimatorSettings(kinds))


def test_white_noise_goes_with_the_root_of_the_length():
    found = estimated((WhiteNoise(1e-3),), 2000, WhiteNoise)
    (width,) = widths(found, white=True)
    assert width.now == pytest.approx(1.96 / np.sqrt(2 * 2000), rel=0.05)
    assert width.length == pytest.approx(2000 * INTERVAL * (width.now / NARROW) ** 2, rel=0.05)


def test_at_the_length_that_is_named_the_interval_is_narrow():
    model = WhiteNoise(1e-3) + RandomWalk(3e-4)
    (width,) = widths(estimated(model, 3000, WhiteNoise, RandomWalk), white=False)
    assert width.now > NARROW
    longer = estimated(model, round(width.length / INTERVAL), WhiteNoise, RandomWalk)
    assert widths(longer, white=False)[0].now == pytest.approx(NARROW, rel=0.2)


def test_each_sensor_has_one_sentence():
    model = WhiteNoise(1e-3) + BiasInstability(1e-3)
    some = [estimated(model, 5000, WhiteNoise, BiasInstability, axis=axis) for axis in ("gyro_x", "gyro_y", "accel_x")]
    gyro, accel = sentences(some)
    assert re.match(r"gyroscopes: white noise known to [\d.]+ % \(gyro_.\); slow processes known to", gyro)
    assert re.search(r"10 % of each takes about [\d.]+ min at rest", gyro)
    assert accel.startswith("accelerometers: white noise known to")


def test_a_log_without_a_slow_process_says_so():
    (said,) = sentences([estimated((WhiteNoise(1e-3),), 20000, WhiteNoise)])
    assert said.endswith("no slow process is shown: long enough for 10 %")


def test_a_process_that_is_zero_has_no_width():
    """Two Gauss-Markov processes of white noise alone: some of them are zero, and the others keep their numbers."""
    found = estimated((WhiteNoise(1e-3),), 3000, WhiteNoise, GaussMarkov, GaussMarkov)
    shown = {one.std for one in found.fit.present if isinstance(one, GaussMarkov)}
    assert len(widths(found, white=False)) == 2 * len(shown)
    assert len(widths(found, white=True)) == 1

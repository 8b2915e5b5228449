from dataclasses import replace

import numpy as np
import pytest

from imugap import log
from imugap.effects import GaussMarkov, RandomWalk, WhiteNoise
from imugap.effects.effect import AxisModel
from imugap.estimation.result import Fit, ParameterEstimate, identifiability
from imugap.model import ErrorModel
from imugap.study.attitude import attitude_schemes


def estimate(effect, parameter, value, low, high):
    return ParameterEstimate(effect, 1, parameter, value, low, high, 0.1, identifiability(low, high))


def test_a_bound_enters_the_filter_with_its_limit_and_an_estimate_with_its_value():
    model = AxisModel((WhiteNoise(2.0), GaussMarkov(0.0, 50.0), RandomWalk(0.3)))
    estimates = (
        estimate("white_noise", "density", 2.0, 1.9, 2.1),
        estimate("gauss_markov", "std", 0.0, 0.0, 0.7),
        estimate("gauss_markov", "correlation_time", 50.0, 10.0, np.inf),
        estimate("gauss_markov", "driving_psd", 0.0, 0.0, 9.0),
        estimate("random_walk", "density_k", 0.3, 0.0, np.inf),
    )
    fits = dict.fromkeys(log.AXES, Fit(model, estimates, 0.0, True))
    given = attitude_schemes.filter_model(fits)["gyro_x"]
    assert given == AxisModel((WhiteNoise(2.0), GaussMarkov(0.7, 50.0), RandomWalk(0.3)))


@pytest.fixture(scope="module")
def static():
    gyro, accel = WhiteNoise(1e-3) + GaussMarkov(1e-3, 20.0), WhiteNoise(3e-3) + RandomWalk(2e-4)
    model = ErrorModel({axis: gyro if axis in log.GYRO else accel for axis in log.AXES})
    still = log.from_samples(dict.fromkeys(log.AXES, np.zeros(30_000)), 0.1)
    return model, model.simulate(still, 3, "static")


@pytest.mark.parametrize("scheme", attitude_schemes.SCHEMES)
def test_every_scheme_finds_the_white_noise_and_the_slow_part_of_a_long_log(static, scheme):
    truth, table = static
    fits = attitude_schemes.fit(table, scheme)
    rows = attitude_schemes.table(fits, scheme=scheme).set_index(["axis", "parameter"])
    assert set(rows["scheme"]) == {scheme}
    for axis, model in truth.axes.items():
        assert rows.loc[(axis, "density"), "value"] == pytest.approx(model.effects[0].density, rel=0.1)
    assert rows.loc[("gyro_y", "std"), "value"] == pytest.approx(1e-3, rel=0.7)
    assert rows.loc[("accel_y", "density_k"), "high"] > 1.5e-4


def test_fits_do_not_change_with_the_mean(static):
    _, table = static
    shifted = attitude_schemes.fit(table + 4.0, "likelihood")["gyro_z"]
    straight = attitude_schemes.fit(table, "likelihood")["gyro_z"]
    for one, other in zip(shifted.estimates, straight.estimates, strict=True):
        assert replace(one, error=0) == replace(other, error=0, value=pytest.approx(other.value, rel=1e-3),
                                                low=pytest.approx(other.low, rel=1e-2),
                                                high=pytest.approx(other.high, rel=1e-2))  # fmt: skip

"""Intervals of N and K of an axis follow from those of its estimates."""

import numpy as np
import pytest

from imugap.effects import BiasInstability, Conditions, GaussMarkov, RandomWalk, WhiteNoise
from imugap.effects.effect import AxisModel
from imugap.estimation import reduced_limits
from imugap.estimation.report import EstimatorSettings, estimate_axis
from imugap.interchange.conventions import Rule

INTERVAL, COUNT = 0.1, 40000
RULE = Rule(rate=1 / INTERVAL)


def estimated(model, *kinds):
    samples = AxisModel(tuple(model)).simulate(
        np.zeros(COUNT), Conditions(np.arange(COUNT) * INTERVAL, INTERVAL), 4, "reduced limits"
    )
    return estimate_axis("gyro_x", samples, INTERVAL, EstimatorSettings(kinds))


def test_one_process_has_the_interval_of_its_parameter():
    found = estimated(WhiteNoise(1e-3) + BiasInstability(2e-3), WhiteNoise, BiasInstability)
    limits = reduced_limits.of(found, (), RULE)
    for name, effect in (("white", "white_noise"), ("walk", "bias_instability")):
        (one,) = (one for one in found.fit.estimates if one.effect == effect)
        ratio = getattr(limits.high, name) / getattr(limits.low, name)
        assert ratio == pytest.approx(one.high / one.low)


def test_a_slow_process_of_two_parameters_has_the_interval_of_what_drives_it():
    """A process far slower than the horizon acts as a random walk whose density is that of its driving noise."""
    found = estimated(WhiteNoise(1e-3) + GaussMarkov(2e-2, 300.0), WhiteNoise, GaussMarkov)
    limits = reduced_limits.of(found, (), RULE)
    (driving,) = (one for one in found.fit.estimates if one.parameter == "driving_psd")
    assert np.log(limits.high.walk / limits.low.walk) / 2 == pytest.approx(1.96 * driving.error / 2, rel=0.1)


def test_a_bound_has_no_lower_limit():
    found = estimated((WhiteNoise(1e-3),), WhiteNoise)
    limits = reduced_limits.of(found, (RandomWalk(1e-4),), RULE)
    assert limits.low.walk == 0
    assert limits.high.walk == pytest.approx(1e-4)
    assert 0 < limits.low.white < limits.high.white

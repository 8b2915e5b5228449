"""Advice on what to record next: it separates what the log leaves open, and the log that it asks for does."""

import numpy as np
import pandas as pd
import pytest

from imugap.discovery.device import Settings, discover
from imugap.discovery.next_log import Advice, Proposal, advise
from imugap.discovery.posterior import ambiguity_set
from imugap.effects import RateRamp, Sinusoid, Temperature, WhiteNoise
from imugap.effects.conditions import Conditions
from imugap.effects.effect import AxisModel
from imugap.model import ErrorModel

INTERVAL, COUNT = 0.04, 12_000
WHITE = WhiteNoise(1e-4)
DRIFT, WARMING = 1e-6, 0.01
"""Drift of the axis [rad/s^2], and of the temperature [degC/s], which goes with the time."""
TIME = INTERVAL * np.arange(COUNT)


def found_of(effect, degrees, seed):
    rest = pd.DataFrame({"gyro_x": 0.0, "temperature": degrees}, index=pd.Index(TIME, name="time"))
    log = ErrorModel({"gyro_x": AxisModel((WHITE, effect))}).simulate(rest, seed)
    return discover([log], Settings(seed=seed, replicates=39, simulations=4))


def advice(found):
    return advise(found.findings, lambda axis: found.results[axis].whole_fit.sequence.conditions)


@pytest.fixture(scope="module", params=[RateRamp(DRIFT), Temperature(DRIFT / WARMING)], ids=["ramp", "temperature"])
def drifting(request):
    return request.param, found_of(request.param, 25 + WARMING * TIME, 7)


def test_a_drift_with_a_temperature_that_goes_with_time_asks_for_another_temperature(drifting):
    _, found = drifting
    (finding,) = found.findings
    assert {"rate_ramp", "temperature"} <= set(ambiguity_set(finding.probabilities))
    (one,) = advice(found)
    assert "warmed" in one.best.action
    assert one.best.duration == pytest.approx(COUNT * INTERVAL)
    assert one.longer is None or one.longer >= 2 * one.best.duration


def test_the_log_that_is_advised_tells_the_names_apart(drifting):
    effect, found = drifting
    (one,) = advice(found)
    again = found_of(effect, one.best.conditions.temperature, 8)
    (finding,) = again.findings
    assert finding.name == effect.name
    assert not {"rate_ramp", "temperature"} <= set(ambiguity_set(finding.probabilities))


def test_a_certain_name_needs_no_further_log():
    found = found_of(Sinusoid(3.0, 2e-4), 25 + 0.1 * np.sin(TIME / 40), 7)
    assert [one.name for one in found.findings] == ["sinusoid"]
    assert not advice(found)


def test_the_advice_says_what_it_tells_apart_and_how_long_it_takes(drifting):
    _, found = drifting
    (one,) = advice(found)
    assert one.sentence().startswith("gyro_x: to tell ")
    assert "record the device warmed by 20 °C and cooled again (480 s)" in one.sentence()


@pytest.mark.parametrize(
    ("longest", "expected"), [(0.0, "(60 s)."), (240.0, "(60 s); more of the same, up to 240 s, is ")]
)
def test_the_advice_speaks_of_more_of_the_same_only_where_it_was_tried(longest, expected):
    moved = Proposal("the motion 2 times as large", 60.0, Conditions(TIME, INTERVAL))
    said = Advice(("gyro_x",), "dead_zone", ("scale_factor",), moved, (), None, longest).sentence()
    assert f"to tell dead zone from scale factor, record the motion 2 times as large {expected}" in said

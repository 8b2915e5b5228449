"""Held samples are found by their period, and are neither stuck samples nor a coarse lattice."""

import numpy as np
import pytest
from tests.effects.simulated import conditions

from imugap.discovery.device import Settings, discover
from imugap.effects import HeldSamples, Resolution, StuckSamples, WhiteNoise
from imugap.effects.effect import AxisModel
from imugap.log import from_samples
from imugap.stream import stream

COUNT = 6000


def noise(run=0):
    return stream(4, "held", run).standard_normal(COUNT)


def held(values, every, first=0.0):
    return HeldSamples(every, first).apply(values, conditions(len(values)), stream(4))


def found(values):
    return HeldSamples.found(values, conditions(len(values)))


def test_each_new_value_is_repeated_until_the_next():
    np.testing.assert_array_equal(held(np.arange(8.0), 3.0, 1.0), [0, 1, 1, 1, 4, 4, 4, 7])


@pytest.mark.parametrize(("every", "first"), [(2.0, 1.0), (4.0, 0.0), (5.0, 3.0)])
@pytest.mark.parametrize("step", [0.0, 0.7])
def test_period_and_place_are_found_on_a_lattice_too(every, first, step):
    for run in range(5):
        values = noise(run) if not step else step * np.rint(noise(run) / step)
        one = found(held(values, every, first))
        assert one.effect == HeldSamples(every, first)
        assert np.count_nonzero(one.flawed) == pytest.approx(COUNT * (1 - 1 / every), abs=3)
        assert StuckSamples.found(held(values, every, first), conditions(COUNT)) is None


def test_lost_samples_do_not_hide_it():
    values = held(noise(), 4.0)
    values[stream(4, "lost").random(COUNT) < 0.05] = np.nan
    one = found(values)
    assert one.effect == HeldSamples(4.0, 0.0)
    assert not one.flawed[np.isnan(values)].any()


@pytest.mark.parametrize("step", [0.0, 0.7, 3.0, 8.0])
def test_noise_on_any_lattice_is_not_held(step):
    for run in range(5):
        assert found(noise(run) if not step else step * np.rint(noise(run) / step)) is None


def test_stuck_samples_are_not_held_and_keep_their_name():
    for run in range(5):
        values = StuckSamples(0.3, 3.0).apply(noise(run), conditions(COUNT), stream(4, "stuck", run))
        assert found(values) is None
        assert StuckSamples.found(values, conditions(COUNT)) is not None


def test_parts_are_held_as_the_whole():
    values, at = noise(), conditions(COUNT)
    step = HeldSamples(7.0, 3.0).in_parts(None, stream(4))
    parts = np.concatenate([step(one, at) for one in np.split(values, [2, 300, 301, 3000])])
    np.testing.assert_array_equal(parts, held(values, 7.0, 3.0))


@pytest.mark.parametrize("kinds", [(WhiteNoise, HeldSamples, StuckSamples, Resolution), (WhiteNoise, StuckSamples)])
def test_it_is_named_where_it_is_in_the_catalogue_and_nothing_else_is(kinds):
    model = AxisModel((WhiteNoise(3e-4), HeldSamples(4.0)))
    log = from_samples(
        {axis: model.simulate(np.zeros(COUNT), conditions(COUNT), 3, axis) for axis in ("gyro_x", "gyro_y")}, 0.01
    )
    found = discover([log], Settings(replicates=20, simulations=10, catalogue=kinds))
    assert [(one.name, one.axes) for one in found.findings] == [("held_samples", ("gyro_x", "gyro_y"))] * (
        HeldSamples in kinds
    )
    if HeldSamples in kinds:
        apart = found.distances["distribution"]
        assert apart.after.value < apart.floor.high < apart.before.value

"""Shocks of a device at rest are left out; what one axis alone has is not."""

import numpy as np
import pytest

from imugap import log
from imugap.discovery.preparation.prepare import prepare
from imugap.discovery.preparation.shocks import common_shocks
from imugap.stream import stream

COUNT, INTERVAL = 12_000, 0.01
SHOCK = slice(7000, 7040)


def samples(*axes, size=40.0, seed=1):
    """White noise of unit deviation, with a ringing burst on some axes."""
    outputs = {axis: stream(seed, "shock", axis).standard_normal(COUNT) for axis in log.AXES}
    ringing = size * np.exp(-np.arange(40) / 12) * np.cos(np.arange(40))
    for number, axis in enumerate(axes):
        outputs[axis][SHOCK] += ringing * (1 + 0.3 * number)
    return outputs


@pytest.mark.parametrize("axes", [log.AXES, ("gyro_x", "accel_y", "accel_z")])
def test_a_burst_on_several_axes_of_both_sensors_is_a_shock(axes):
    shocks = common_shocks(samples(*axes), INTERVAL)
    assert shocks[7000:7020].all()
    assert shocks.sum() < 80


@pytest.mark.parametrize("axes", [(), ("gyro_x",), ("accel_x", "accel_y", "accel_z"), ("gyro_z", "accel_z")])
def test_a_burst_of_one_sensor_or_of_few_axes_is_none(axes):
    assert not common_shocks(samples(*axes), INTERVAL).any()


def test_one_row_far_off_on_all_axes_is_a_shock():
    outputs = samples()
    for values in outputs.values():
        values[7000] += 100.0
    assert np.flatnonzero(common_shocks(outputs, INTERVAL)).tolist() == [7000]


@pytest.mark.parametrize("share", [0.001, 0.02])
def test_outliers_of_single_axes_that_coincide_by_chance_are_none(share):
    outputs = samples()
    for axis, values in outputs.items():
        flawed = stream(2, "shock", axis, share).random(COUNT) < share
        values[flawed] += 30.0
    assert not common_shocks(outputs, INTERVAL).any()


def test_a_long_stretch_of_more_noise_on_all_axes_is_none():
    outputs = samples()
    for values in outputs.values():
        values[3000:6000] *= 8
    assert not common_shocks(outputs, INTERVAL).any()


def test_a_shock_leaves_neither_a_name_nor_its_power_in_a_prepared_log():
    table = log.from_samples(samples(*log.AXES, size=300.0), INTERVAL)
    record = prepare(table)
    assert record.findings == ()
    ((begin, end),) = record.shocks
    assert 69.8 < begin <= 70.0 < 70.2 < end < 71.0
    assert all(np.abs(one.values).max() < 6 for one in record.sequences.values())
    assert all(np.abs(values).max() < 6 for values in record.outputs.values())

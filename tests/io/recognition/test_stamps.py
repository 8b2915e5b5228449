import numpy as np
import pytest

from imugap.io.recognition.stamps import seconds, unit_of_fine, unit_of_stamps
from imugap.units import factor

UNITS = ["s", "ms", "us", "ns"]
EPOCH_S = 1_700_000_000


@pytest.mark.parametrize("unit", UNITS)
@pytest.mark.parametrize(("rate", "contract"), [(20, True), (200, True), (20, False), (200, False), (400, False)])
def test_the_rate_of_an_inertial_sensor_leaves_one_unit(unit, rate, contract):
    assert unit_of_stamps(np.arange(1000) / (rate * factor(unit)), contract)[0] == unit


@pytest.mark.parametrize("unit", UNITS)
def test_the_year_leaves_one_unit_at_any_rate(unit):
    time = (EPOCH_S + np.arange(100) / 3.0) / factor(unit)
    assert unit_of_stamps(time, contract=False) == (unit, "the year")


def test_bursts_do_not_hide_the_rate():
    i = np.arange(4000)
    assert unit_of_stamps((i // 4 * 20 + i % 4) * 1000, contract=True)[0] == "us"


def test_a_slow_log_in_seconds_is_in_seconds_by_contract():
    assert unit_of_stamps(np.arange(3600.0), contract=True)[0] == "s"


def test_two_readings_are_refused_with_both():
    with pytest.raises(ValueError, match=r"--time-unit decides.*4 Hz in ms or 4000 Hz in us"):
        unit_of_stamps(np.arange(1000) * 250, contract=False)


def test_steps_of_one_are_those_of_a_second_or_of_a_millisecond():
    with pytest.raises(ValueError, match=r"--time-unit decides.*1 Hz in s or 1000 Hz in ms"):
        unit_of_stamps(np.arange(1000), contract=False)


def test_nanoseconds_keep_a_regular_step():
    time = EPOCH_S * 10**9 + 5_000_000 * np.arange(1000)
    steps = np.diff(seconds(time, 1e-9))
    assert np.abs(steps - 0.005).max() < 3e-7


@pytest.mark.parametrize(("tick", "rate"), [("us", 60), ("us", 120), ("100us", 100), ("100us", 400)])
def test_the_tick_of_a_fine_counter_follows_from_the_rate(tick, rate):
    time = np.round(np.arange(1000) / (rate * factor(tick))).astype(np.int64)
    assert unit_of_fine(time)[0] == tick

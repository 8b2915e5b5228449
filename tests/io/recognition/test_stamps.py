import numpy as np
import pytest
from tests.io.devices import at_rest, times, write_text

from imugap.io.recognition.stamps import are_clock_numbers, seconds, unit_of_fine, unit_of_stamps
from imugap.io.recording import read
from imugap.log import AXES, LogError
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


@pytest.mark.parametrize(
    ("name", "per_second"), [("Time [min]", 1 / 60), ("t (h)", 1 / 3600), ("millis", 1e3), ("micros", 1e6), ("ms", 1e3)]
)
def test_the_unit_in_the_name_of_the_stamps_decides(tmp_path, name, per_second):
    columns = np.column_stack([times(400) * per_second, at_rest(400, up=(0, 0, -1))])
    header = [name, *(f"{one} [{unit}]" for one, unit in zip(AXES, ["rad/s"] * 3 + ["m/s^2"] * 3, strict=True))]
    found = read(write_text(tmp_path / "run.csv", header, columns, form="{:.15g}"))
    np.testing.assert_allclose(found.log.index, times(400), atol=1e-9)


def test_whole_minutes_are_no_division_by_zero():
    np.testing.assert_array_equal(seconds(np.arange(3), 60.0), [0.0, 60.0, 120.0])


@pytest.mark.parametrize("zone", ["", "Z", "+00:00"])
def test_stamps_as_a_date_may_have_a_zone(tmp_path, zone):
    lines = [",".join(["time", *AXES])]
    for k, row in enumerate(at_rest(400, up=(0, 0, -1)).tolist()):
        lines.append(f"2024-05-01T10:00:{k // 100:02d}.{k % 100:02d}0{zone}," + ",".join(map(repr, row)))
    (tmp_path / "run.csv").write_text("\n".join([*lines, ""]))
    found = read(tmp_path / "run.csv").log
    np.testing.assert_allclose(found.index - found.index[0], times(400), atol=1e-6)


@pytest.mark.parametrize("mark", [".", ":", ","])
def test_times_of_day_are_stamps(tmp_path, mark):
    lines = [";".join(["time", *AXES])]
    for k, row in enumerate(at_rest(400, up=(0, 0, -1)).tolist()):
        lines.append(f"9:59:{56 + k // 100:02d}{mark}{k % 100:02d}0;" + ";".join(map(repr, row)))
    path = tmp_path / "run.csv"
    path.write_text("\n".join([*lines, ""]))
    found = read(path).log
    np.testing.assert_allclose(found.index - found.index[0], times(400), atol=1e-9)
    assert found.index[0] == pytest.approx(9 * 3600 + 59 * 60 + 56)
    path.write_text("\n".join([*lines[:200], lines[200].replace(";", ";x", 1), *lines[201:], ""]))
    with pytest.raises(LogError, match="line 201, column gyro_x: expected a number; found 'x"):
        read(path)
    path.write_text("\n".join([*lines[:300], "noon" + lines[300][lines[300].index(";") :], *lines[301:], ""]))
    with pytest.raises(LogError, match="line 301, column time: expected a value as in the rows above; found 'noon'"):
        read(path)


@pytest.mark.parametrize("begin", [951_000_000, 1_200_000_000, 4_000_000_000])
def test_microseconds_since_power_on_are_no_seconds_of_a_year(begin):
    assert unit_of_stamps(begin + 5000 * np.arange(1000), contract=True) == ("us", "the rate")


@pytest.mark.parametrize(
    ("begin", "per_second", "unit"),
    [(45_413.5, 1 / 86_400, "d"), (739_000.5, 1 / 86_400, "d"), (1.335e17, 1e7, "100ns"), (6.385e17, 1e7, "100ns")],
    ids=["spreadsheet", "MATLAB", "Windows", ".NET"],
)
def test_clocks_of_programs_are_known_by_their_year(begin, per_second, unit):
    time = begin + np.arange(1000) / 100 * per_second
    assert unit_of_stamps(time.astype(np.int64) if per_second > 1 else time, contract=False) == (unit, "the year")


def test_numbers_of_a_clock_go_from_59_s_to_the_next_minute():
    hhmmss = [100_000 + 100 * (k // 60) + k % 60 for k in range(200)]
    assert are_clock_numbers(np.array(hhmmss))
    assert not are_clock_numbers(np.random.default_rng(1).permutation(6000) / 100)


@pytest.mark.parametrize("parts", [10, 100, 1000])
def test_numbers_of_a_clock_may_hold_the_parts_of_a_second(parts):
    hhmmss = [(100_000 + 100 * (k // 60) + k % 60) * parts for k in range(200)]
    assert are_clock_numbers(np.array(hhmmss))
    assert not are_clock_numbers(100_000 * parts + np.arange(200) * parts // 10)

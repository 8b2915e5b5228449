"""Whole numbers as stamps are seconds or milliseconds by what the samples say, or are refused with both readings."""

import numpy as np
import pytest
from tests.io import devices
from tests.io.devices import at_rest, write_text

from imugap.io.recording import RecordingSettings, read
from imugap.log import AXES, LogError
from imugap.stream import stream

COUNT = 3000
LOUD = [3.0, 3.0, 3.0, 1.0, 1.0, 1.0]
"""Factors of the noise of gyroscopes sampled at 1 kHz, over those at 100 Hz."""


def written(path, samples, stamps, name="time"):
    return write_text(path / "run.csv", [name, *AXES], np.column_stack([stamps, samples]))


def rate_of(found):
    return 1 / np.diff(found.log.index).mean()


def at_rest_down(count=COUNT, factors=1.0):
    samples = at_rest(count, up=(0, 0, 0)) * factors
    samples[:, 5] -= 9.80665
    return samples


def test_noise_that_no_gyroscope_has_in_seconds_shows_milliseconds(tmp_path):
    found = read(written(tmp_path, at_rest_down(factors=LOUD), np.arange(COUNT)))
    assert rate_of(found) == pytest.approx(1000)
    assert found.recognised[2].startswith("stamps ms -> s from noise at rest of")


@pytest.mark.parametrize("step", [1, 2])
def test_the_turns_of_gravity_show_the_rate(tmp_path, monkeypatch, step):
    monkeypatch.setattr(devices, "RATE", 1000.0)
    samples = devices.turned(6000 * step)[::step]
    found = read(written(tmp_path, samples, step * np.arange(6000)))
    assert rate_of(found) == pytest.approx(1000 / step)
    assert "stamps ms -> s from the turns of gravity" in found.recognised


def test_noise_that_no_gyroscope_has_in_milliseconds_shows_seconds(tmp_path):
    samples = at_rest_down(factors=[3e-4] * 3 + [0.01] * 3)
    found = read(written(tmp_path, samples, np.arange(COUNT)))
    assert rate_of(found) == pytest.approx(1)
    assert found.recognised == ()


def test_less_than_a_second_is_no_log(tmp_path):
    assert rate_of(read(written(tmp_path, at_rest_down(500), np.arange(500)))) == pytest.approx(1)


def test_what_nothing_shows_is_refused_with_both_readings_and_decided_by_option_or_header(tmp_path):
    samples = at_rest_down(factors=0.1)
    path = written(tmp_path, samples, np.arange(COUNT))
    with pytest.raises(LogError, match=r"\(--time-unit decides\); found a step of 1: 1 Hz in s or 1000 Hz in ms"):
        read(path)
    for unit, rate in (("s", 1), ("ms", 1000)):
        assert rate_of(read(path, RecordingSettings(time_unit=unit))) == pytest.approx(rate)
    named = written(tmp_path, samples, np.arange(COUNT), "time (s)")
    assert rate_of(read(named, RecordingSettings(units={"gyro": "rad/s"}))) == pytest.approx(1)


def test_stamps_with_a_decimal_point_or_of_a_year_are_seconds(tmp_path):
    samples = at_rest_down(factors=0.1)
    path = written(tmp_path, samples, np.arange(COUNT))
    head, *rows = path.read_text().splitlines(keepends=True)
    path.write_text(head + "".join(row.replace(",", ".0,", 1) for row in rows))
    assert rate_of(read(path)) == pytest.approx(1)
    rows = [f"{1_700_000_000 + k},{row.partition(',')[2]}" for k, row in enumerate(rows)]
    path.write_text(head + "".join(rows))
    assert rate_of(read(path)) == pytest.approx(1)


def test_uneven_milliseconds_are_not_taken_for_seconds(tmp_path):
    late = np.abs(stream(5, "late stamps").standard_normal(COUNT)) * 0.1
    path = written(tmp_path, at_rest_down(factors=0.1), np.arange(COUNT) + late)
    with pytest.raises(
        LogError, match=r"expected the unit of the stamps \(--time-unit decides\).* Hz in s or .* Hz in ms"
    ):
        read(path)
    assert rate_of(read(path, RecordingSettings(time_unit="ms"))) == pytest.approx(1000, rel=0.01)


@pytest.mark.parametrize(("clock", "size"), [("time_ms", 1e3), ("time_us", 1e6), ("t_ns", 1e9)])
def test_a_unit_in_the_name_of_the_stamps_counts_and_noise_alone_makes_no_degrees_of_canonical_rates(
    tmp_path, clock, size
):
    samples = at_rest(COUNT)
    samples[:, :3] *= 40
    path = write_text(
        tmp_path / "run.csv", [clock, *AXES], np.column_stack([np.arange(COUNT) * size / 100, samples]), form="{:.15g}"
    )
    with pytest.raises(LogError, match=r"names of rates in rad/s, but noise at rest of .* is that of deg/s"):
        read(path)
    found = read(path, RecordingSettings(units={"gyro": "rad/s"}))
    assert rate_of(found) == pytest.approx(100)
    assert f"stamps {clock[-2:]} -> s from the header" in found.recognised

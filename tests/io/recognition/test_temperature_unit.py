"""Readings of a thermometer in other units than degC are converted, and said."""

import numpy as np
import pytest
from tests.io.devices import at_rest, times, write_text

from imugap.io.recording import RecordingSettings, read, stream
from imugap.log import AXES

COUNT = 400
CELSIUS = np.linspace(25.0, 31.0, COUNT)


@pytest.mark.parametrize(
    ("name", "readings", "said"),
    [
        ("temperature", CELSIUS, None),
        ("temperature [degC]", CELSIUS, None),
        ("Temperature (\u00b0F)", CELSIUS * 1.8 + 32, "temperature degF -> degC from the header"),
        ("temp [K]", CELSIUS + 273.15, "temperature K -> degC from the header"),
        ("temperature", CELSIUS + 273.15, "temperature K -> degC from its size"),
    ],
)
def test_the_temperature_is_in_degrees_celsius(tmp_path, name, readings, said):
    columns = np.column_stack([times(COUNT), at_rest(COUNT, up=(0, 0, -1)), readings])
    found = read(write_text(tmp_path / "run.csv", ["time", *AXES, name], columns))
    np.testing.assert_allclose(found.log["temperature"], CELSIUS, atol=1e-6)
    assert [one for one in found.recognised if "temperature" in one] == ([said] if said else [])


@pytest.mark.parametrize("readings", [CELSIUS * 100, (CELSIUS - 36.53) * 340])
@pytest.mark.parametrize("name", ["temperature", "temp_raw"])
def test_a_temperature_of_no_device_is_left_out_and_that_is_said(tmp_path, name, readings):
    columns = np.column_stack([times(COUNT), at_rest(COUNT, up=(0, 0, -1)), readings])
    path = write_text(tmp_path / "run.csv", ["time", *AXES, name], columns)
    found = read(path)
    assert list(found.table) == list(AXES)
    (said,) = (one for one in found.recognised if "temperature" in one)
    assert said.startswith(f"temperature left out: a median of {np.median(readings):.4g} degC is of no device (--units")
    converted, parts = stream(path)
    assert {name for part in parts for name in part} == set(AXES)
    assert converted.without == ("temperature",)


def test_a_temperature_in_an_unknown_unit_is_left_out_and_that_is_said(tmp_path):
    columns = np.column_stack([times(COUNT), at_rest(COUNT, up=(0, 0, -1)), CELSIUS * 100])
    found = read(write_text(tmp_path / "run.csv", ["time", *AXES, "Temp [0.01 degC]"], columns))
    assert list(found.table) == list(AXES)
    assert "left out Temp [0.01 degC]" in found.recognised


def test_a_temperature_without_a_unit_is_said_to_be_taken_in_celsius(tmp_path):
    columns = np.column_stack([times(COUNT), at_rest(COUNT, up=(0, 0, -1)), CELSIUS * 1.8 + 32])
    found = read(write_text(tmp_path / "run.csv", ["time", *AXES, "temp"], columns))
    assert "temperature taken as degC" in found.recognised


def test_counts_of_a_thermometer_are_scaled_by_the_option(tmp_path):
    columns = np.column_stack([times(COUNT), at_rest(COUNT, up=(0, 0, -1)), CELSIUS * 340])
    path = write_text(tmp_path / "run.csv", ["time", *AXES, "temperature"], columns)
    found = read(path, RecordingSettings(units={"temperature": "degC//340"}))
    np.testing.assert_allclose(found.log["temperature"], CELSIUS, atol=1e-6)

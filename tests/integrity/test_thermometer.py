"""Readings of a thermometer: their noise goes, their course and their steps stay."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from imugap.integrity.thermometer import smoothed
from imugap.stream import stream

COUNT = 20_000
COURSE = 25 + 3 * np.sin(np.linspace(0, 7, COUNT)) + np.linspace(0, 2, COUNT)


@pytest.mark.parametrize("noise", [0.01, 0.05, 0.5])
def test_noise_of_the_readings_goes(noise):
    error = smoothed(COURSE + noise * stream(1, "readings").standard_normal(COUNT)) - COURSE
    assert np.std(error) < 0.2 * noise
    assert np.abs(error[[0, -1]]).max() < noise


@pytest.mark.parametrize("readings", [COURSE, np.round(COURSE), np.full(COUNT, 25.0), COURSE[:1], COURSE[:2]])
def test_readings_without_noise_stay(readings):
    np.testing.assert_allclose(smoothed(readings), readings, rtol=1e-12)


def test_a_line_stays_one_to_its_ends():
    line = np.linspace(20, 30, COUNT)
    error = smoothed(line + 0.05 * stream(2, "line").standard_normal(COUNT)) - line
    assert np.abs(error).max() < 0.02


@given(st.integers(1, 400), st.integers(0, 2**32 - 1))
def test_any_number_of_readings_can_be_smoothed(count, seed):
    readings = np.random.default_rng(seed).standard_normal(count)
    found = smoothed(readings)
    assert found.shape == readings.shape
    assert np.all(np.abs(found) <= 3 * np.abs(readings).max())

"""Above which frequency a reference does not follow the motion of a device."""

import numpy as np
import pandas as pd
import pytest
from scipy.signal import butter, sosfiltfilt

from imugap import log
from imugap.discovery.device import Settings, discover
from imugap.discovery.preparation.reference_band import ReferenceBand, reference_band
from imugap.discovery.verdict import verdict
from imugap.stream import stream

RATE, COUNT = 100.0, 6000
TIME = np.arange(COUNT) / RATE
REST = TIME < 4
SIZE = dict.fromkeys(log.GYRO, 0.5) | dict.fromkeys(log.ACCEL, 2.0)


def band_limited(label, low, high, axis):
    """Noise of standard deviation 1 between two frequencies [Hz]."""
    kind = {"btype": "lowpass"} if low == 0 else {"btype": "bandpass"}
    edges = high if low == 0 else (low, high)
    values = sosfiltfilt(butter(6, edges, fs=RATE, output="sos", **kind), stream(1, label, axis).normal(size=COUNT))
    return values / values.std()


def table(make):
    return pd.DataFrame({axis: make(axis) for axis in log.AXES}, index=pd.Index(TIME, name=log.TIME))


IDEAL = table(lambda axis: np.where(REST, 0.0, SIZE[axis] * band_limited("motion", 0, 3.0, axis)))
"""A motion below 3 Hz that begins after a rest."""
NOISE = table(lambda axis: 5e-3 * SIZE[axis] * stream(2, axis).normal(size=COUNT))
SHAKING = table(lambda axis: np.where(REST, 0.0, 0.1 * SIZE[axis] * band_limited("shaking", 25.0, 45.0, axis)))
"""Vibration during the motion."""


def found(measured, ideal):
    return reference_band(measured, ideal, 1 / RATE)


@pytest.mark.parametrize(
    "error",
    [0.0, 0.2 * IDEAL, IDEAL.shift(2, fill_value=0.0) - IDEAL, 5 * NOISE, 30 * NOISE.mul(TIME > 40, axis=0)],
    ids=["none", "scale factor", "delay", "louder noise", "change of variance"],
)
def test_errors_of_the_device_are_not_taken_for_the_reference(error):
    assert found(IDEAL + NOISE + error, IDEAL) is None


def test_a_vibration_that_the_reference_lacks_ends_its_band_below_it():
    band = found(IDEAL + SHAKING + NOISE, IDEAL)
    assert 6 < band.highest <= 25
    assert band.factor == np.ceil(RATE / 2 / band.highest)


def test_noise_of_the_reference_ends_its_band_where_it_is_louder_than_that_of_the_log():
    noisy = IDEAL + table(lambda axis: 0.05 * SIZE[axis] * band_limited("own", 20.0, 45.0, axis))
    band = found(IDEAL + NOISE, noisy)
    assert 6 < band.highest <= 25


def test_one_axis_alone_does_not_end_the_band():
    assert found(IDEAL + NOISE + SHAKING[["gyro_y"]].reindex(columns=IDEAL.columns, fill_value=0.0), IDEAL) is None


def test_means_of_log_and_reference_are_of_the_same_samples():
    band = ReferenceBand(12.0, 1 / RATE)
    means, moving = band.means(IDEAL.rename_axis(None)), band.moving_means(IDEAL)
    assert band.factor == 5
    np.testing.assert_allclose(means.iloc[7], IDEAL.iloc[35:40].mean())
    pd.testing.assert_frame_equal(moving.iloc[::5].set_axis(means.index), means)
    np.testing.assert_allclose(moving.index[::5], means.index, atol=1e-9)


@pytest.mark.slow
def test_what_the_reference_lacks_is_said_and_not_put_into_the_model():
    bias = 0.02
    device = IDEAL + SHAKING + NOISE + bias
    result = discover([device], Settings(), reference=IDEAL)
    assert result.band is not None
    assert "The reference does not follow the motion above" in verdict(result)
    assert not result.findings
    for axis in log.AXES:
        value = next(one.value for one in result.final[axis] if one.name == "bias")
        assert value == pytest.approx(bias, abs=5e-3 * SIZE[axis])

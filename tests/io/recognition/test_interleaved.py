"""Rows of several devices that alternate, which no column says."""

import numpy as np
import pytest
from tests.io.devices import at_rest, times, turned, write_text

from imugap.io.recognition.interleaved import interleaved, order_changes
from imugap.io.recording import RecordingSettings, read, stream
from imugap.log import AXES, LogError
from imugap.stream import stream as random_stream

COUNT = 1500
OFFSETS = np.array([
    [0.004, -0.003, 0.005, 0.1, -0.2, 0.1],
    [-0.006, 0.002, 0.001, -0.2, 0.1, 0.05],
    [0.001, 0.005, -0.004, 0.15, 0.1, -0.2],
    [-0.002, -0.004, 0.003, 0.0, -0.1, 0.15],
])  # fmt: skip
"""Biases of devices [rad/s], [m/s^2]."""


def devices_of(count, device=at_rest):
    """Samples of devices, shape (devices, COUNT, 6); those in motion move in their own time."""
    shift = 700 * np.arange(count)
    noise = random_stream(3, "devices").standard_normal((count, COUNT, 6)) * 1e-3
    return np.stack([device(6000)[one : one + COUNT] for one in shift]) + OFFSETS[:count, None] + noise


def alternating(devices):
    return devices.transpose(1, 0, 2).reshape(-1, 6)


@pytest.mark.parametrize("device", [at_rest, turned])
@pytest.mark.parametrize("count", [2, 3, 4])
def test_rows_of_devices_that_alternate_are_counted(count, device):
    stamps = np.repeat(times(COUNT), count) + 1e-5 * np.arange(COUNT * count)
    assert interleaved(alternating(devices_of(count, device)), stamps).devices == count


@pytest.mark.parametrize("device", [at_rest, turned])
def test_rows_of_one_device_are_of_one(device):
    samples = device(6000)
    assert interleaved(samples) is None
    assert interleaved(np.repeat(samples, 2, axis=0)) is None
    assert interleaved(np.round(samples, 2)) is None
    shaken = samples + 2 * np.sin(2 * np.pi * 0.47 * np.arange(6000))[:, None]
    assert interleaved(shaken) is None


def test_a_vibration_at_a_fraction_of_the_rate_is_of_one_device():
    samples, row = at_rest(12000), np.arange(12000)
    for period in (4, 5, 8):
        amplitudes = [0.01, 0.02, 0.0, 1.0, 0.5, 2.0]
        shaken = samples + np.sin(2 * np.pi * row / period + 0.4)[:, None] * amplitudes
        assert interleaved(shaken) is None


def test_a_weak_vibration_at_a_fraction_of_the_rate_is_of_one_device():
    row = np.arange(60_000)
    for seed in range(8):
        noise = random_stream(seed, "noise").standard_normal((len(row), 3))
        assert interleaved(noise + 0.16 * np.sin(2 * np.pi * row / 8 + 0.4)[:, None]) is None


def test_two_devices_that_move_alike_on_average_are_found_by_their_motion():
    left, right = turned(6000)[:3000], -turned(6000)[1111:4111] + 0.0
    mixed = np.stack([left, right], axis=1).reshape(-1, 6)
    assert interleaved(mixed).devices == 2


def test_two_devices_in_any_order_are_found_at_rest():
    first, second = devices_of(2)
    later = random_stream(4, "order").random(COUNT) < 0.5
    found = interleaved(np.where(later[:, None], first, second))
    assert found.devices is None
    assert interleaved(np.vstack([first, second])) is None


def two_in_a_file(path, stamps, samples):
    return write_text(path / "two.csv", ["time", *AXES], np.column_stack([stamps, samples]), form="{:.9g}")


@pytest.mark.parametrize("later", [0.0, 0.001, 0.005])
@pytest.mark.parametrize("device", [at_rest, turned])
def test_a_file_of_two_devices_is_refused_and_each_is_read_by_the_option(tmp_path, device, later):
    devices = devices_of(2, device)
    stamps = (times(COUNT)[:, None] + [0.0, later]).ravel()
    path = two_in_a_file(tmp_path, stamps, alternating(devices))
    for reading in (read, stream):
        with pytest.raises(LogError, match=r"rows: expected one device \(--rows 1/2 takes .* --rows 1/1 takes all"):
            reading(path)
    for k in range(2):
        settings = RecordingSettings(rows=(k + 1, 2), frame="as-is")
        found = read(path, settings)
        assert f"row {k + 1} of 2" in found.recognised
        np.testing.assert_allclose(found.log.to_numpy(), devices[k], rtol=1e-7, atol=1e-9)
        np.testing.assert_allclose(found.log.index, times(COUNT) + k * later, atol=1e-9)
        assert found.place(3) == f"line {2 + 2 * 3 + k}"
        streamed = np.vstack([part.to_numpy() for part in stream(path, settings)[1]])
        np.testing.assert_allclose(streamed, devices[k], rtol=1e-7, atol=1e-9)
    assert len(read(path, RecordingSettings(rows=(1, 1), frame="as-is")).table) == 2 * COUNT


def test_a_lost_row_of_one_of_two_devices_is_refused_where_rows_are_taken_in_turn(tmp_path):
    kept = np.delete(np.arange(2 * COUNT), 1501)
    samples = alternating(devices_of(2))[kept]
    assert abs(order_changes(samples, 2) - 1501) < 200
    path = two_in_a_file(tmp_path, np.repeat(times(COUNT), 2)[kept], samples)
    with pytest.raises(LogError, match=r"rows near line .*: expected rows of 2 devices in one order"):
        read(path, RecordingSettings(rows=(1, 2)))


def test_four_devices_are_not_taken_as_two(tmp_path):
    path = two_in_a_file(tmp_path, np.repeat(times(COUNT), 4), alternating(devices_of(4)))
    with pytest.raises(LogError, match="--rows 1/4"):
        read(path)
    with pytest.raises(LogError, match="--rows 1/2"):
        read(path, RecordingSettings(rows=(1, 2)))


@pytest.mark.filterwarnings("error")
def test_devices_are_counted_whatever_the_size_of_their_values():
    stamps = np.repeat(times(COUNT), 2) + 1e-5 * np.arange(2 * COUNT)
    assert interleaved(1e200 * alternating(devices_of(2)), stamps).devices == 2

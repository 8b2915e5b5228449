import numpy as np
import pytest
from tests.io.devices import at_rest, times

from imugap.io.recording import RecordingSettings, read
from imugap.log import AXES, LogError

COUNT = 400


def written(path, names, label, order):
    """Rows of several devices in a file, ``order(rows)`` their numbers of device."""
    samples = [at_rest(COUNT, up=(0, 0, -1), seed=seed) for seed in range(1, len(names) + 1)]
    rows = [
        ",".join([f"{times()[k]:.3f}", names[device], *(f"{value:.9g}" for value in samples[device][k])])
        for k, device in order
    ]
    path.write_text("\n".join([",".join(["time", label, *AXES]), *rows]) + "\n")
    return samples


INTERLEAVED = [(k, device) for k in range(COUNT) for device in range(2)]


@pytest.mark.parametrize(
    ("label", "names"), [("I", ["0", "1"]), ("sensor_id", ["left", "right"]), ("MAC address", ["AA:01", "AA:02"])]
)
def test_rows_of_two_devices_are_refused_and_taken_by_the_topic(tmp_path, label, names):
    path = tmp_path / "two.csv"
    samples = written(path, names, label, INTERLEAVED)
    with pytest.raises(LogError, match=rf"column {label}: expected one device, .*: {', '.join(names)}; found rows of"):
        read(path)
    with pytest.raises(LogError, match=r"expected one device, .*; found 'third'"):
        read(path, RecordingSettings(topic="third"))
    for name, expected in zip(names, samples, strict=True):
        found = read(path, RecordingSettings(topic=name))
        assert f"rows of {name}" in found.recognised
        np.testing.assert_allclose(found.log.to_numpy(), expected, rtol=1e-8)
    assert found.place(0) == "line 3"


def test_a_column_with_one_device_or_a_number_of_each_row_is_none_of_devices(tmp_path):
    path = tmp_path / "one.csv"
    (samples,) = written(path, ["left"], "device", [(k, 0) for k in range(COUNT)])
    np.testing.assert_allclose(read(path).log.to_numpy(), samples, rtol=1e-8)
    (samples,) = written(path, ["left"], "id", [(k, 0) for k in range(COUNT)])
    lines = path.read_text().splitlines()
    numbered = [lines[0], *(line.replace("left", str(k)) for k, line in enumerate(lines[1:]))]
    path.write_text("\n".join(numbered) + "\n")
    np.testing.assert_allclose(read(path).log.to_numpy(), samples, rtol=1e-8)


def test_a_bad_row_of_a_file_with_devices_is_named(tmp_path):
    path = tmp_path / "two.csv"
    written(path, ["left", "right"], "device", INTERLEAVED)
    lines = path.read_text().splitlines()
    path.write_text("\n".join([*lines[:9], "1,left,3", *lines[9:]]) + "\n")
    with pytest.raises(LogError, match=r"line 10: expected 8 values .*; found 3"):
        read(path, RecordingSettings(topic="left"))

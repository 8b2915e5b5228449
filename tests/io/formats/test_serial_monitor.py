"""Tables with the prompt of a serial monitor, and logs of ArduPilot as text."""

import numpy as np
import pytest
from tests.io.devices import at_rest

from imugap.io.recording import RecordingSettings, read
from imugap.log import AXES, LogError

COUNT = 600
AS_IS = RecordingSettings(frame="as-is", units={"gyro": "rad/s"})


def prompted(path, first=()):
    samples = at_rest(COUNT).tolist()
    lines = (f"12:{k // 6000:02d}:{k / 100 % 60:06.3f} -> {','.join(map(repr, one))}" for k, one in enumerate(samples))
    path.write_text("\n".join([*first, *lines, ""]))
    return path


def test_the_time_of_the_prompt_is_that_of_the_row(tmp_path):
    found = read(prompted(tmp_path / "log.txt", ["11:59:59.990 -> gx,gy,gz,ax,ay,az"]), AS_IS)
    np.testing.assert_array_equal(found.log.to_numpy(), at_rest(COUNT))
    assert found.regular.interval == pytest.approx(0.01)


def test_names_may_be_given_where_the_prompt_has_none(tmp_path):
    path = prompted(tmp_path / "log.txt")
    with pytest.raises(LogError, match="7 columns without names"):
        read(path)
    found = read(path, RecordingSettings(frame="as-is", columns=("time", *AXES), units={"gyro": "rad/s"}))
    np.testing.assert_array_equal(found.log.to_numpy(), at_rest(COUNT))


def test_the_devices_of_a_text_of_ardupilot_are_topics(tmp_path):
    path = tmp_path / "flight.log"
    lines = [
        "FMT, 128, 89, FMT, BBnNZ, Type,Length,Name,Format,Columns",
        "FMT, 141, 47, IMU, QBffffffI, TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ,EG",
        "PARM, 1000, INS_ACC_ID, 0",
    ]
    for k, one in enumerate(at_rest(COUNT)):
        for device in (0, 1):
            values = ", ".join(map(repr, (one + device).tolist()))
            lines.append(f"IMU, {10_000 * k + 951_000_000}, {device}, {values}, 0")
        lines.append(f"ATT, {10_000 * k}, 0, 0")
    path.write_text("\n".join([*lines, ""]))
    with pytest.raises(LogError, match=r"--topic with one of them: 0, 1"):
        read(path)
    found = read(path, RecordingSettings(frame="as-is", topic="1"))
    np.testing.assert_allclose(found.log.to_numpy(), at_rest(COUNT) + 1, rtol=1e-12)
    assert found.regular.interval == pytest.approx(0.01)

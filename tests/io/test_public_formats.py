"""Public files as people have them go in unchanged, with gravity and noise of a real device."""

from pathlib import Path

import numpy as np
import pytest

from imugap.integrity.report import gravity
from imugap.io.recording import RecordingSettings, read
from imugap.log import ACCEL, AXES, GYRO

FILES = {
    "xio_fusion_sensor_data.csv": ({}, 99.2, AXES),
    "ximu_straightLine_CalInertialAndMag.csv": ({"rate_hz": 256.0}, 256, AXES),
    "gnss_ins_sim_time.csv": ({}, 100, AXES),
    "gnss_ins_sim_gyro-0.csv": ({}, 100, AXES),
    "gnss_ins_sim_accel-0.csv": ({"rate_hz": 100.0}, 100, AXES),
    "airbrakes_nosecone.csv": ({}, 91, (*AXES, "temperature")),
    "imucal_ferraris_session.csv": ({"rate_hz": 204.8}, 204.8, AXES),
    "sample_log_small.ulg": ({}, 204.6, AXES),
}


@pytest.mark.parametrize("name", FILES)
def test_a_public_file_goes_in_unchanged(mirror, name):
    path = Path(mirror) / "formats" / name
    if not path.is_file():
        pytest.skip(f"no {name} in the folder of real logs")
    if path.suffix == ".ulg":
        pytest.importorskip("pyulog")
    options, rate, columns = FILES[name]
    found = read(path, RecordingSettings(**options))
    table = found.table
    assert tuple(table.columns) == columns
    assert 1 / np.median(np.diff(table.index)) == pytest.approx(rate, rel=0.05)
    assert found.recognised
    if set(ACCEL) <= set(columns):
        assert np.median(np.linalg.norm(table[list(ACCEL)], axis=1)) == pytest.approx(9.8, rel=0.2)
        assert gravity(table) is not None
    if set(GYRO) <= set(columns):
        assert np.median(np.abs(table[list(GYRO)])) < 3

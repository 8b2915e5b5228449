"""Discovery on recordings of real devices."""

from pathlib import Path

import pytest

from imugap import cli
from imugap.discovery.device import Settings
from imugap.discovery.inputs import Files, discover_files

pytestmark = [pytest.mark.slow, pytest.mark.long]

PUBLISHED = {"gyro_x": -0.00216, "gyro_y": 0.02078, "gyro_z": 0.07581}
"""Means of the biases in the truth of EuRoC V1_02, by its publisher [rad/s]."""


def bias(model, axis):
    return next(one.value for one in model[axis] if one.name == "bias")


def test_euroc_has_the_biases_of_its_publisher_and_no_false_answer_to_the_motion(tmp_path, mirror):
    folder = Path(mirror) / "euroc_v1_02"
    if not folder.is_dir():
        pytest.skip("the files of euroc_v1_02 are not here")
    ideal = tmp_path / "ideal.parquet"
    poses, measured = str(folder / "V1_02_medium.csv"), folder / "V102.txt"
    assert cli.main(["reference", poses, "--log", str(measured), "--out", str(ideal)]) == 0
    found = discover_files(Files((measured,), reference=ideal), Settings(workers=2)).found
    assert found.band is not None
    assert {one.name for one in found.findings} <= {"resolution", "time_offset"}
    for axis, value in PUBLISHED.items():
        assert bias(found.final, axis) == pytest.approx(value, abs=1e-3)
    assert not found.distances["distribution"].farther

"""Integers of several scales are refused by every command, with the axis or run, the factor, and the next step."""

import numpy as np
import pandas as pd
import pytest

import imugap
from imugap.io.recording import read, stream
from imugap.log import AXES, GYRO, TIME, LogError
from imugap.stream import stream as random_stream

COUNT = 3000
STEPS = dict(zip(AXES, np.repeat([np.radians(1 / 131), 9.80665 / 16384], 3), strict=True))


def recorded(run=0, factors=None):
    """Counts of a device at rest in SI, some axes times a factor."""
    rng = random_stream(52, "scales", run)
    columns = {}
    for axis, step in STEPS.items():
        level = {"accel_z": -16384.0}.get(axis, rng.normal(0, 50))
        noise = rng.uniform(5, 8) if axis in GYRO else 50.0
        columns[axis] = np.rint(level + noise * rng.standard_normal(COUNT)) * step * (factors or {}).get(axis, 1.0)
    return pd.DataFrame(columns, index=pd.Index(np.arange(COUNT) / 50, name=TIME))


@pytest.mark.parametrize("axis", ["gyro_y", "accel_x", "accel_z"])
@pytest.mark.parametrize("factor", [16, 256, 65536, 1 / 16])
def test_an_axis_of_another_scale_is_refused_with_its_factor(tmp_path, axis, factor):
    recorded(0, {axis: factor}).to_csv(tmp_path / "log.csv")
    times = f"{factor} times" if factor > 1 else "1/16 of"
    expected = f"rescale {axis} in the file.*found lattice step and noise of {axis} {times} those of the two others"
    for reader in (read, stream):
        with pytest.raises(LogError, match=rf"log\.csv: columns {axis[:-2]}_x to {axis[:-2]}_z: .*{expected}"):
            reader(tmp_path / "log.csv")


def test_what_gravity_contradicts_names_the_axis_and_no_unit():
    """Values without a lattice: the norm alone would be gravity in feet."""
    log = recorded() + 1e-7 * random_stream(52, "fine").standard_normal((COUNT, 6))
    log["accel_x"] = 256 * (log["accel_x"] + 0.2)
    with pytest.raises(LogError, match=r"one of several scales: accel_x has .* times the noise of the two others"):
        imugap.read(log)


def test_a_run_of_another_scale_is_refused_by_all_that_join_runs():
    runs = [recorded(0), recorded(1, dict.fromkeys(GYRO, 1 / 16)), recorded(2)]
    for join in (lambda: imugap.indices(*runs), lambda: imugap.discover(runs)):
        with pytest.raises(
            LogError, match=r"column gyro_x: .*rescale.*found lattice step and noise 1/16 of those there"
        ):
            join()
    assert imugap.indices(recorded(0), recorded(1), recorded(2)).runs == 3


@pytest.mark.parametrize("reader", [read, lambda path: list(stream(path)[1])])
def test_what_no_device_measures_is_refused_as_such(tmp_path, reader):
    log = recorded()
    log.iloc[100:120, 5] *= 1e300
    log.to_csv(tmp_path / "log.csv")
    with pytest.raises(LogError, match=r"line 102, column accel_z: expected a number of at most 1e\+12 either way"):
        reader(tmp_path / "log.csv")


def test_a_table_without_rows_is_refused(tmp_path):
    recorded().iloc[:0].to_parquet(tmp_path / "log.parquet")
    for reader in (read, stream):
        with pytest.raises(LogError, match=r"log\.parquet: rows: expected at least 2 samples; found 0"):
            reader(tmp_path / "log.parquet")

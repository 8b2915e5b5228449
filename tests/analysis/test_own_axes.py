"""A log with other axes than the canonical ones: the table names them, and tools of ROS get those of the log."""

import xml.etree.ElementTree as ET

import numpy as np
import pandas as pd
import pytest

import imugap as ig
from imugap.log import AXES, TIME
from imugap.stream import stream

GYRO_BIAS, ACCEL_BIAS = (1e-3, 2e-3, -3e-3), 0.04
DENSITIES = (1e-4, 2e-4, 4e-4, 1e-3, 1e-3, 1e-3)
COUNT, RATE = 4000, 100.0


def estimated(up):
    """Estimate of a log at rest with an axis up, biases as in the log."""
    samples = stream(7, "own axes").standard_normal((COUNT, 6)) * np.array(DENSITIES) * np.sqrt(RATE)
    samples[:, :3] += GYRO_BIAS
    samples[:, 3:] += (9.80665 + ACCEL_BIAS) * np.asarray(up)
    table = pd.DataFrame(samples, columns=list(AXES), index=pd.Index(np.arange(COUNT) / RATE, name=TIME))
    return ig.estimate(table, terms=["white_noise"])


@pytest.fixture(scope="module", params=[(0, 0, 1), (1, 0, 0), (0, 0, -1)], ids=["z up", "x up", "z down"])
def case(request):
    return request.param, estimated(request.param)


def test_gazebo_gets_the_biases_and_the_noise_of_the_axes_of_the_log(case):
    up, fit = case
    tree = ET.fromstring(fit.export("gazebo"))
    read = {
        f"{kind}_{axis}": {one.tag: float(one.text) for one in tree.find(f"{name}/{axis}/noise")}
        for kind, name in (("gyro", "angular_velocity"), ("accel", "linear_acceleration")) for axis in "xyz"
    }  # fmt: skip
    for axis, bias, density in zip(AXES, (*GYRO_BIAS, *(ACCEL_BIAS * np.asarray(up))), DENSITIES, strict=True):
        assert read[axis]["mean"] == pytest.approx(bias, abs=1e-3 if axis.startswith("accel") else 1e-4)
        assert read[axis]["stddev"] == pytest.approx(density * np.sqrt(RATE), rel=0.1)


def test_other_tools_get_them_in_the_axes_of_the_model(case):
    up, fit = case
    line = next(one for one in fit.export("kf-gins").splitlines() if one.startswith("initgyrbias"))
    z = np.radians(float(line.split("[")[1].split("]")[0].split(",")[2])) / 3600
    expected = {(0, 0, 1): -GYRO_BIAS[2], (1, 0, 0): -GYRO_BIAS[0], (0, 0, -1): GYRO_BIAS[2]}[up]
    assert z == pytest.approx(expected, abs=1e-4)


@pytest.mark.parametrize("target", ["cpp", "python", "genesis", "kf-gins"])
def test_a_file_in_the_axes_of_the_model_says_which_they_are(case, target):
    up, fit = case
    text = fit.export(target)
    assert ("Axes and the signs of biases: x forward, y right, z down" in text) == (up != (0, 0, -1))


def test_the_head_of_the_table_names_the_axes(case):
    up, fit = case
    heads = {
        (0, 0, 1): "Axes: x forward, y right, z down; y and z of the log are reversed.",
        (1, 0, 0): "Axes: x forward, y right, z down, which are z, y, -x of the log.",
    }
    assert (heads[up] in str(fit)) if up in heads else "Axes: " not in str(fit)


def test_a_result_prints_as_the_command_does(case):
    _, fit = case
    said, _, table = str(fit).partition("\n\n")
    assert said == fit.verdict
    row = next(line for line in table.splitlines() if line.startswith("gyro_x"))
    value, low, _, high = row.split()[3:7]
    assert float(low) < float(value) < float(high)
    bound = next(line for line in table.splitlines() if "random_walk K" in line)
    assert "< " in bound
    assert "upper bound" in bound
    assert "is identified: zero is not in it." in table
    assert "Upper bound: the log does not show" in table
    assert "gyroscopes: white noise known to" in said

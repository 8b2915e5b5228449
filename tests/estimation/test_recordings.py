"""Estimates from recordings that are disturbed; skipped where they are not at hand."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy.io import loadmat

from imugap.effects import GaussMarkov, WhiteNoise
from imugap.estimation.report import EstimatorSettings, estimate_axis
from imugap.estimation.screening import screen
from imugap.stream import stream


@pytest.fixture
def recording(mirror):
    """The path of a file of the mirror; skips a test of a file that is not there."""

    def path(name):
        found = Path(mirror) / name
        if not found.is_file():
            pytest.skip(f"the mirror has no {name}")
        return found

    return path


def matrix(path):
    rdata = pytest.importorskip("rdata")
    return np.asarray(next(iter(rdata.read_rda(path).values())), float)


def screened(values):
    return screen(values, stream(1, "recording"))


def estimated(values, interval):
    return estimate_axis("gyro_x", values, interval, EstimatorSettings())


def stretches(result, kind, interval):
    return [
        (first * interval, end * interval)
        for one in result.disturbances
        if one.kind == kind
        for first, end in one.stretches
    ]


def test_arduplane_at_rest_is_estimated_without_its_knocks(recording):
    """At rest for 165 s with knocks at about 2 and 13 s; the quiet end shows the ramp of gyro_y."""
    table = loadmat(recording("arduplane_testlog2/TestLog2.mat"))["IMU"]
    table = table[table[:, 1] < table[0, 1] + 165e3]
    for column in range(2, 8):
        places = stretches(screened(table[:, column]), "knock", 0.02)
        assert any(first < 13 < end for first, end in places)
    found = estimated(table[:, 3], 0.02)
    ramp = next(one for one in found.fit.estimates if one.effect == "rate_ramp")
    assert ramp.value == pytest.approx(1.85e-5, rel=0.4)
    assert "Left out: 2 knocks" in found.verdict()


@pytest.mark.filterwarnings("ignore")
def test_contaminated_gyro_is_white_and_its_outliers_are_counted(recording):
    values = matrix(recording("contaminated_gyro/cont.imu1.rda")).ravel()
    found = estimated(values, 0.01)
    assert any(isinstance(one, WhiteNoise) for one in found.fit.model)
    assert all(one.correlation_time > 0.01 for one in found.fit.model if isinstance(one, GaussMarkov))
    assert np.mean(screened(values).replaced) == pytest.approx(0.06, abs=0.02)
    assert "outliers" in found.verdict()


@pytest.mark.parametrize("number", [1, 2])
def test_xsens_dot_has_white_noise_on_every_axis(recording, number):
    """The first row is zero, one value is infinite, and one sample of x_stat_1 is 317 standard deviations off."""
    table = pd.read_csv(recording(f"xsens_dot/x_stat_{number}.csv"), low_memory=False)
    for name, scale, low, high in (("w", np.pi / 180, 7.5e-5, 1.15e-4), ("f", 1.0, 8.5e-4, 1.7e-3)):
        for axis in "xyz":
            values = scale * pd.to_numeric(table[f"{name}_{axis}"], errors="coerce").to_numpy(float)
            found = estimated(values, 1 / 120)
            (white,) = (one for one in found.fit.model if isinstance(one, WhiteNoise))
            assert low < white.density < high
            assert all(one.correlation_time > 1 / 120 for one in found.fit.model if isinstance(one, GaussMarkov))


def test_memsense_is_sound(recording):
    for values in np.load(recording("memsense_turnon/memsense_test_real.npy"))[0]:
        assert screened(values).disturbances == ()


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")
def test_adis16405_was_knocked_twice(recording):
    values = matrix(recording("adis16405/adis_16405_imu4.rda"))[:, 5]
    places = stretches(screened(values), "knock", 0.01)
    for time in (4045, 5146):
        assert any(abs(first - time) < 8 for first, _ in places)

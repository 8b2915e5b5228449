"""Size of a known effect for the test that knows it."""

import numpy as np
import pytest

from imu_benchmark.sealing.detection_limits import Z
from imugap import log
from imugap.effects import RateRamp, Temperature, WhiteNoise
from imugap.log import TEMPERATURE
from imugap.study.discovery.oracle_size import sizes_in_limits

INTERVAL, COUNT, DENSITY = 0.1, 4000, 1e-3


def test_beside_white_noise_it_is_the_root_of_the_energy_over_the_deviation_of_a_sample():
    time = INTERVAL * np.arange(COUNT)
    white = DENSITY / np.sqrt(INTERVAL) * np.random.default_rng(1).standard_normal((2, COUNT))
    logs = [log.from_samples({"accel_z": values}, INTERVAL) for values in white]
    for number, one in enumerate(logs):
        one[TEMPERATURE] = 20.0 + np.sin(time / 30.0 + number)
    for known, signals in (
        (RateRamp(1e-5), [1e-5 * time] * 2),
        (Temperature(2e-4, 20.0), [2e-4 * np.sin(time / 30.0 + number) for number in range(2)]),
    ):
        sizes = sizes_in_limits(logs, "accel_z", [WhiteNoise(DENSITY), known], known)
        expected = [np.linalg.norm(one - one.mean()) / (DENSITY / np.sqrt(INTERVAL)) / Z for one in signals]
        assert sizes == pytest.approx(expected, rel=0.05)

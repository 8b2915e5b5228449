"""Noise whose size follows the temperature is no change of variance in time; a change in time keeps its name."""

import numpy as np
import pandas as pd
import pytest
from scipy.stats import chi2, kstest

from imugap.discovery.checks.variance import temperature_gain
from imugap.discovery.device import Settings, discover

COUNT, INTERVAL = 15_000, 0.04
TIME = INTERVAL * np.arange(COUNT)
SWING = 25 + 6 * np.sin(2 * np.pi * TIME / 420)
WARMING = 20 + 15 * (1 - np.exp(-TIME / 150))


def found_with(factor, degrees, seed):
    noise = 5e-4 * np.random.default_rng(seed).standard_normal(COUNT) * np.sqrt(factor)
    log = pd.DataFrame({"gyro_x": noise, "temperature": degrees}, index=pd.Index(TIME, name="time"))
    return discover([log], Settings(seed=seed, replicates=39, simulations=4))


def test_the_gain_of_a_steady_noise_has_the_law_of_one_parameter():
    rng = np.random.default_rng(1)
    gains = [2 * temperature_gain(rng.standard_normal(COUNT) ** 2, SWING) for _ in range(300)]
    assert kstest(gains, chi2(1).cdf).pvalue > 1e-3


def test_the_gain_grows_as_that_of_the_matched_test():
    """To second order it is the sum of squares of half the logarithm of the variance."""
    rng, log_variance = np.random.default_rng(2), 0.02 * (SWING - SWING.mean())
    gains = [temperature_gain(rng.standard_normal(COUNT) ** 2 * np.exp(log_variance), SWING) for _ in range(100)]
    expected = 0.25 * np.sum(log_variance**2) + 0.5
    assert abs(np.mean(gains) - expected) < 4 * np.std(gains) / 10 + 0.03 * expected


@pytest.mark.parametrize(
    ("degrees", "reason"),
    [(SWING, "the variance goes with the temperature"), (WARMING, "4 of them")],  # more changes than have the name
    ids=["swing", "warming"],
)
def test_noise_that_follows_the_temperature_is_not_named_a_change_in_time(degrees, reason):
    found = found_with(np.exp(0.15 * (degrees - degrees.mean())), degrees, 3)
    assert "variance_change" not in [one.name for one in found.findings]
    assert reason in [one.reason for one in found.withheld]


@pytest.mark.parametrize("degrees", [SWING, WARMING], ids=["swing", "warming"])
@pytest.mark.parametrize("begin", [60, 250])
def test_a_change_in_time_keeps_its_name_while_the_temperature_varies(degrees, begin):
    found = found_with(np.where((begin < TIME) & (begin + 150 > TIME), 1.5, 1.0), degrees, 4)
    assert [one.name for one in found.findings] == ["variance_change"]

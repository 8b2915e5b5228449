"""The true values of a process are as far from the log as chance has it, however little the log determines."""

import numpy as np
import pytest
from scipy.stats import binom, chi2

from imugap.discovery.fit.axis_fit import fit
from imugap.discovery.fit.description import Description
from imugap.discovery.preparation.sequence import AxisSequence
from imugap.discovery.start_comparison.noise_profile import NoiseProfile
from imugap.effects import GaussMarkov, RandomWalk, WhiteNoise
from imugap.effects.conditions import Conditions
from imugap.effects.effect import AxisModel

WHITE = WhiteNoise(1e-3)
COUNT, INTERVAL = 4000, 0.1
CONDITIONS = Conditions(INTERVAL * np.arange(COUNT), INTERVAL, None, "gyro_x")


def profile_of(*effects, seed=1, start=None):
    values = AxisModel(effects).simulate(np.zeros(COUNT), CONDITIONS, seed, "profile")
    sequence = AxisSequence(values, CONDITIONS)
    return NoiseProfile.of([fit(sequence, Description.known(*(start or effects)))])


def log_of(name):
    return lambda effect: np.log(getattr(effect, name))


def log_drive(markov):
    return np.log(markov.driving_psd) / 2


LOGS = 60
"""Number of simulated logs."""


@pytest.mark.slow
@pytest.mark.parametrize(
    "slow",
    [GaussMarkov(2e-3, 20.0), GaussMarkov(2e-3, 130.0), GaussMarkov(2e-3, 2000.0), GaussMarkov(3e-4, 20.0)],
)
def test_right_values_are_rejected_as_often_as_stated(slow):
    rejected = dict.fromkeys(("std", "correlation_time", "drive", "together"), 0)
    functions = {"std": log_of("std"), "correlation_time": log_of("correlation_time"), "drive": log_drive}
    for seed in range(LOGS):
        profile = profile_of(WHITE, slow, seed=seed)
        far = {name: profile.at(1, function, function(slow)) for name, function in functions.items()}
        together = profile.deviance(profile.holding(1, slow.parameters()))
        for name, deviance in (far | {"together": together}).items():
            rejected[name] += chi2.sf(deviance, 2 if name == "together" else 1) < 0.1
    assert max(rejected.values()) <= binom.isf(1e-4, LOGS, 0.1)


def test_the_interval_ends_where_the_deviance_is_the_given_one():
    profile = profile_of(WHITE, GaussMarkov(2e-3, 10.0))
    for function in (log_of("correlation_time"), log_drive):
        low, high = profile.interval(1, function, 3.84)
        assert low < function(profile.noise.effects[1]) < high
        for end in (low, high):
            assert profile.at(1, function, end) == pytest.approx(3.84, rel=0.02)


def test_a_correlation_time_beyond_the_log_has_no_upper_end_but_the_drive_has():
    profile = profile_of(WHITE, RandomWalk(1e-4), start=(WHITE, GaussMarkov(3e-3, 1000.0)))
    low, high = profile.interval(1, log_of("correlation_time"), 3.84)
    assert np.isfinite(low)
    assert high == np.inf
    low, high = profile.interval(1, log_drive, 3.84)
    assert low < np.log(1e-4) < high < low + 2


def test_a_process_that_is_not_there_has_a_largest_size():
    start = GaussMarkov(2e-3, 60.0)
    profile = profile_of(WHITE, start=(WHITE, start))
    size = profile.sized(1, start, "std", 6.6, none=True)
    assert size.low == 0
    assert size.high < 0.2 * start.std
    assert size.deviance > 40
    assert profile.sized(1, GaussMarkov(size.high, 60.0), "std", 6.6, none=True).deviance == pytest.approx(
        6.6, rel=0.02
    )

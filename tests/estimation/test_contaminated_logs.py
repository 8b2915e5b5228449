"""Estimates from disturbed logs: efficient and covered where nothing is wrong, right where something is."""

import numpy as np
import pytest
from scipy.stats import binom

from imugap.effects import Conditions, GaussMarkov, RandomWalk, Temperature, WhiteNoise
from imugap.effects.effect import AxisModel
from imugap.estimation.cramer_rao import bound
from imugap.estimation.report import EstimatorSettings, estimate_axis
from imugap.stream import stream

COUNT, INTERVAL, DENSITY = 12_000, 0.02, 1e-3
WHITE = WhiteNoise(DENSITY)
WALK = WHITE + RandomWalk(1e-3)
STD = DENSITY / np.sqrt(INTERVAL)


def simulate(of, *labels, count=COUNT):
    return of.simulate(np.zeros(count), Conditions(np.arange(count) * INTERVAL, INTERVAL), 71, *labels)


def outliers(values, rng, share, burst):
    hit = rng.choice(len(values) - burst, int(share * len(values) / burst), replace=False)
    for first, size in zip(hit, np.exp(rng.uniform(*np.log([10, 1000]), len(hit))), strict=True):
        values[first : first + burst] += size * STD * rng.choice([-1, 1], burst)
    return values


def knock(values, rng, size):
    first = int(rng.integers(1000, len(values) - 1000))
    after = np.arange(len(values) - first)
    values[first:] += size * STD * np.exp(-after / 25) * np.cos(0.9 * after)
    return values


def stuck(values, rng, share):
    first, length = int(rng.integers(1000, 5000)), int(share * len(values))
    values[first : first + length] = values[first]
    return values


DISTURBANCES = {
    "none": lambda values, rng: values,
    "single outliers": lambda values, rng: outliers(values, rng, 0.05, 1),
    "bursts": lambda values, rng: outliers(values, rng, 0.05, 20),
    "knock": lambda values, rng: knock(values, rng, 1e4),
    "stuck": lambda values, rng: stuck(values, rng, 0.3),
    "all": lambda values, rng: stuck(knock(outliers(values, rng, 0.02, 1), rng, 100), rng, 0.2),
}


def estimated(values, *kinds, **options):
    return estimate_axis("gyro_x", values, INTERVAL, EstimatorSettings(kinds or None), **options)


def white(estimate):
    return next(one for one in estimate.fit.estimates if one.effect == "white_noise")


@pytest.mark.parametrize("name", DISTURBANCES)
@pytest.mark.parametrize("model", [AxisModel((WHITE,)), WALK], ids=["white", "walk"])
def test_white_noise_is_within_3_per_cent_of_that_of_the_sound_log(name, model):
    values = simulate(model, "sound")
    sound = white(estimated(values.copy(), *map(type, model)))
    found = white(estimated(DISTURBANCES[name](values.copy(), stream(1, name)), *map(type, model)))
    assert found.value / sound.value == pytest.approx(1, abs=0.03)


@pytest.mark.slow
@pytest.mark.parametrize("name", DISTURBANCES)
def test_intervals_cover_with_and_without_disturbances(name):
    """Two-sided: of 60 logs as many as the binomial law of 95 % gives but once in a thousand times on either side."""
    runs, covered = 60, {"white_noise": 0, "random_walk": 0}
    truth = {"white_noise": DENSITY, "random_walk": 1e-3}
    for run in range(runs):
        values = DISTURBANCES[name](simulate(WALK, "cover", run), stream(2, name, run))
        for one in estimated(values, WhiteNoise, RandomWalk).fit.estimates:
            covered[one.effect] += one.low < truth[one.effect] < one.high
    low, high = binom.ppf([1e-3, 1 - 1e-3], runs, 0.95)
    assert all(low <= count <= high for count in covered.values()), covered


@pytest.mark.slow
def test_sound_logs_are_estimated_as_well_as_the_bound_allows():
    """Root mean square error over the Cramer-Rao bound, with three standard errors of 200 runs."""
    runs, least = 200, bound(WALK, INTERVAL, COUNT)
    fits = [estimated(simulate(WALK, "bound", run), WhiteNoise, RandomWalk).fit.model for run in range(runs)]
    for kind, true in ((WhiteNoise, DENSITY), (RandomWalk, 1e-3)):
        values = np.array([next(iter(one.parameters().values())) for fit in fits for one in fit if type(one) is kind])
        ratio = np.sqrt(np.mean((values / true - 1) ** 2)) / least.xs(kind.name, level="effect").iloc[0]
        assert ratio < 1.05 * (1 + 3 / np.sqrt(2 * runs))


def test_noise_faster_than_the_samples_is_white():
    """Noise correlated over less than a sample has the density that its spectrum has at low frequencies."""
    fast = GaussMarkov(1.0, 0.4 * INTERVAL)
    found = estimated(simulate(AxisModel((fast,)), "fast", count=40_000))
    times = [one.correlation_time for one in found.fit.model if isinstance(one, GaussMarkov)]
    assert all(time > INTERVAL for time in times)
    expected = np.sqrt(float(fast.sampled_psd(1e-3, INTERVAL)))
    assert white(found).value == pytest.approx(expected, rel=0.05)
    assert "as by vibration or an output filter" in found.verdict()


def test_temperature_explains_a_bias_that_follows_it():
    time = INTERVAL * np.arange(COUNT)
    readings = 25 + 12 * (1 - np.exp(-time / 60)) + stream(3, "thermometer").normal(0, 0.02, COUNT)
    values = simulate(AxisModel((WHITE,)), "warm") + 3e-3 * (readings - 25)
    found = estimated(values, temperature=readings)
    (term,) = (one for one in found.fit.model if isinstance(one, Temperature))
    assert term.coefficient == pytest.approx(3e-3, rel=0.02)
    assert not any(isinstance(one, RandomWalk) for one in found.fit.model)
    assert "The temperature of the log explains a part of the bias" in found.verdict()


def test_a_walk_beside_a_drifting_temperature_is_a_walk():
    for run in range(4):
        readings = 25 + simulate(AxisModel((RandomWalk(0.1),)), "ambient", run)
        found = estimated(simulate(WALK, "apart", run), temperature=readings)
        assert not any(isinstance(one, Temperature) for one in found.fit.model)

import numpy as np
import pandas as pd
import pytest
from tests.estimation.setting import COUNT, INTERVAL, kinds, model, simulate, truth

from imugap.effects import BiasInstability, GaussMarkov, Quantization, RandomWalk, RateRamp, WhiteNoise
from imugap.effects.effect import AxisModel
from imugap.estimation.cramer_rao import bound
from imugap.estimation.likelihood import log_likelihood
from imugap.estimation.maximum_likelihood import fit, quantile
from imugap.estimation.result import Identifiability
from imugap.stream import stream

SEED = 11


def test_estimates_are_those_of_the_highest_likelihood():
    of = model(20.0)
    sequence = simulate(of, 20_000, SEED, "top")
    found = fit(sequence, INTERVAL, kinds(of))
    assert found.converged
    assert found.objective == pytest.approx(log_likelihood(found.model, sequence, INTERVAL))
    for effect in found.model:
        others = [other for other in found.model if other is not effect]
        for key, value in effect.parameters().items():
            for factor in (0.97, 1.03):
                moved = type(effect)(**(effect.parameters() | {key: value * factor}))
                assert log_likelihood(AxisModel((*others, moved)), sequence, INTERVAL) < found.objective


def test_intervals_end_where_the_profile_has_fallen_by_half_the_quantile():
    of = AxisModel((WhiteNoise(5e-3),))
    sequence = simulate(of, 500, SEED, "profile")
    found = fit(sequence, INTERVAL, kinds(of)).estimates[0]
    for end in (found.low, found.high):
        fallen = log_likelihood(AxisModel((WhiteNoise(found.value),)), sequence, INTERVAL) - log_likelihood(
            AxisModel((WhiteNoise(end),)), sequence, INTERVAL
        )
        assert fallen == pytest.approx(3.8415 / 2, rel=5e-3)


def test_process_that_is_not_there_gets_an_upper_bound():
    sequence = simulate(AxisModel((WhiteNoise(5e-3),)), 50_000, SEED, "only white")
    found = fit(sequence, INTERVAL, (WhiteNoise, RandomWalk)).table()
    walk = found.loc[("random_walk", 1, "density_k")]
    assert walk["low"] == 0
    assert walk["verdict"] == Identifiability.UPPER_BOUND
    assert 0 < walk["high"] < 1e-4
    assert found.loc[("white_noise", 1, "density"), "verdict"] == Identifiability.IDENTIFIED


def test_ramp_is_not_taken_for_a_walk():
    of = WhiteNoise(5e-3) + RandomWalk(1e-4)
    tilted = simulate(of, 20_000, SEED, "ramp") + 1e-3 * INTERVAL * np.arange(20_000)
    assert fit(tilted, INTERVAL, kinds(of)).model.effects[1].density_k > 5e-4
    walk = fit(tilted, INTERVAL, kinds(of), ramp=True).estimates[1]
    assert walk.low < 1e-4 < walk.high


def test_slope_is_estimated_with_the_model():
    of = WhiteNoise(5e-3) + RandomWalk(1e-4) + RateRamp(1e-3)
    found = fit(simulate(of, 20_000, SEED, "slope"), INTERVAL, (WhiteNoise, RandomWalk), ramp=True)
    row = found.table().loc[("rate_ramp", 1, "slope")]
    assert row["verdict"] == Identifiability.IDENTIFIED
    assert row["low"] < 1e-3 < row["high"]
    assert found.model.effects[-1] == RateRamp(row["value"])
    assert row["error"] * row["value"] < (row["high"] - row["low"]) / (2 * 1.96)  # wider than with a known model


def test_slope_of_no_ramp_is_bounded():
    found = fit(simulate(AxisModel((WhiteNoise(5e-3),)), 20_000, SEED, "level"), INTERVAL, (WhiteNoise,), ramp=True)
    row = found.table().loc[("rate_ramp", 1, "slope")]
    assert row["verdict"] == Identifiability.UPPER_BOUND
    assert row["low"] < 0 < row["high"]
    expected = 5e-3 * np.sqrt(12 / 2000.0**3)  # of white noise alone
    assert (row["high"] - row["low"]) / (2 * 1.96 * expected) == pytest.approx(1, rel=0.03)


def test_a_composition_is_fitted_at_least_as_well_as_its_parts():
    """Flicker and quantization beside processes that need neither, and a process that has to stand for white noise."""
    of = WhiteNoise(5e-3) + GaussMarkov(3e-3, 3.0) + GaussMarkov(3e-3, 100.0)
    sequence = simulate(of, 20_000, SEED, "parts")
    small = fit(sequence, INTERVAL, kinds(of)).objective
    for extra in (BiasInstability, Quantization):
        assert fit(sequence, INTERVAL, (extra, *kinds(of))).objective > small - 1e-3
    three = fit(sequence, INTERVAL, (BiasInstability, *[GaussMarkov] * 3)).objective
    assert three > small - 1.0


@pytest.mark.slow
@pytest.mark.parametrize("density", [0.0, 5e-5, 1e-4, 1e-3])
def test_intervals_of_the_slope_cover(density):
    """At least the level, within three binomial standard errors of 150 runs; a weak walk makes them cautious.

    At most as wide as a walk would make them that white noise of this length just hides, and no wider than with a
    known model where the walk is plain (12 and 6/5: variances of the slope beside white noise and random walk).
    """
    runs, of = 150, WhiteNoise(5e-3) + RandomWalk(density) + RateRamp(1e-4)
    logs = [simulate(of, 4000, SEED, "cover", density, run) for run in range(runs)]
    slopes = [fit(one, INTERVAL, (WhiteNoise, RandomWalk), True).estimates[-1] for one in logs]
    covered = np.mean([one.low < 1e-4 < one.high for one in slopes])
    assert covered > 0.95 - 3 * np.sqrt(0.95 * 0.05 / runs)
    hidden = 1.5e-4  # the spectra, N^2 and K^2/(2 pi f)^2, cross at two periods in the length of the log
    walk = density if density > hidden else np.hypot(density, hidden)
    known = np.sqrt(12 * 5e-3**2 / 400**3 + 1.2 * walk**2 / 400)
    width = np.median([one.high - one.low for one in slopes]) / (2 * 1.96 * known)
    assert width < 1.1
    assert density < hidden or width > 0.9


def test_quantile_of_a_mixture():
    rng = stream(11, "mixture")
    weights, means, deviations = np.array([0.2, 0.5, 0.3]), np.array([-1.0, 0.0, 2.0]), np.array([3.0, 0.5, 1.0])
    of = rng.choice(3, 200_000, p=weights)
    drawn = means[of] + deviations[of] * rng.standard_normal(len(of))
    for probability in (0.025, 0.5, 0.975):
        share = np.mean(drawn < quantile(probability, weights, means, deviations))
        assert abs(share - probability) < 4 * np.sqrt(probability * (1 - probability) / len(of))
    assert quantile(0.975, np.ones(1), np.array([5.0]), np.array([2.0])) == pytest.approx(5 + 2 * 1.959964)


def test_flicker_is_estimated():
    of = WhiteNoise(5e-3) + BiasInstability(2e-3)
    logs = [simulate(of, 20_000, SEED, "flicker", run) for run in range(40)]
    ratio = [fit(one, INTERVAL, kinds(of)).estimates[1].value / 2e-3 for one in logs]
    expected = bound(of, INTERVAL, 20_000)["bias_instability", 1, "density_b"]
    assert abs(np.mean(ratio) - 1) < 4 * expected / np.sqrt(40)
    assert 0.7 < np.std(ratio) / expected < 1.35


@pytest.mark.slow
@pytest.mark.parametrize("walk", [False, True])
@pytest.mark.parametrize("time", [10, 50, 200])
def test_estimates_reach_the_bound_and_intervals_cover(time, walk):
    """Tolerances are three standard errors of 60 runs about the nominal value (RMSE 1.0 to 1.1 bounds)."""
    runs, of = 60, model(time, walk)
    fits = [fit(simulate(of, COUNT, SEED, time, walk, run), INTERVAL, kinds(of)) for run in range(runs)]
    assert all(found.converged for found in fits)
    tables = pd.concat([found.table() for found in fits])
    expected, least = truth(of), bound(of, INTERVAL, COUNT)
    for key, rows in tables.groupby(level=[0, 1, 2]):
        relative = rows["value"] / expected[key] - 1
        covered = (rows["low"] <= expected[key]) & (rows["high"] >= expected[key])
        assert covered.mean() > 0.86
        if least[key] < 0.2:
            assert abs(relative.mean()) < 3 * least[key] / np.sqrt(runs) + 0.1 * least[key]
            assert 0.7 < np.sqrt((relative**2).mean()) / least[key] < 1.1 + 3 / np.sqrt(2 * runs)

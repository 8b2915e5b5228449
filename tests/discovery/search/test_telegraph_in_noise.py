"""Telegraph noise beside other slow noise: told by its samples, and taken out of them."""

import numpy as np
import pytest
from scipy.stats import chi2, multivariate_normal
from tests.discovery.simulated import LOG_ALPHA, WHITE, fitted, names, result_of, sequence

from imugap.discovery.fit.axis_fit import fit
from imugap.discovery.fit.description import Description
from imugap.discovery.fit.telegraph_likelihood import filtered
from imugap.discovery.search.search import Search
from imugap.discovery.search.telegraph import told_apart
from imugap.discovery.search.telegraph_in_noise import drawn_values, stationary_markov, switching
from imugap.effects import BiasStep, GaussMarkov, RandomTelegraph, RandomWalk, VarianceChange, WhiteNoise
from imugap.stream import stream

SWITCHES, REVERTS = RandomTelegraph(2e-2, 0.06), GaussMarkov(4e-3, 6.0)


def with_markov(data):
    return fitted(data, GaussMarkov(6e-3, 8.0))


def test_without_switches_the_filter_is_that_of_a_gauss_markov_process():
    """The dense normal density of a process in white noise, with half a step of nothing."""
    values = stream(1, "filter").standard_normal(40)
    decay, std, white = 0.8, 1.3, 0.4
    lag = np.abs(np.subtract.outer(np.arange(40), np.arange(40)))
    covariance = std**2 * decay**lag + white**2 * np.eye(40)
    expected = multivariate_normal(np.zeros(40), covariance).logpdf(values)
    found = filtered(values, 1, 0.0, 0.1, 0.1, np.full(40, white), *stationary_markov(std, decay))
    assert found[0].sum() == pytest.approx(expected, rel=1e-9)
    np.testing.assert_allclose(found[1][:, 0, 0], found[1][:, 1, 0], atol=1e-9)


@pytest.mark.parametrize("kept", [1, 2])
def test_odds_of_either_value_are_those_of_all_paths(kept):
    """Two values in white noise alone: a hidden Markov chain, summed over every path."""
    values, half, change, white = stream(2, "odds").standard_normal(8), 0.7, 0.3, np.repeat([0.9, 2.0], 4)
    stay = 0.5 * (1 + np.exp(-2 * change))
    paths = np.array(np.meshgrid(*[[-1, 1]] * 8)).reshape(8, -1).T
    moves = np.where(paths[:, 1:] == paths[:, :-1], stay, 1 - stay).prod(axis=1) / 2
    weights = (
        moves * np.exp(-0.5 * ((values - half * paths) / white) ** 2).prod(axis=1) / (np.sqrt(2 * np.pi) * white).prod()
    )
    densities, known = filtered(values, 1, half, change, change, white, *stationary_markov(1e-9, 0.5), kept)
    assert densities.sum() == pytest.approx(np.log(weights.sum()), rel=1e-9)
    last = np.log(weights[paths[:, -1] > 0].sum() / weights[paths[:, -1] < 0].sum())
    p_values = np.exp(known[-1, :, 0])
    assert np.log(p_values[:kept].sum() / p_values[kept:].sum()) == pytest.approx(last, rel=1e-6)
    rng, count = stream(3, "draws"), 20_000
    draws = ((rng.random(8), rng.standard_normal(8)) for _ in range(count))
    drawn = np.mean([drawn_values(known, np.exp(-2 * change), 0.5, 1e-9, *draw) for draw in draws], axis=0)
    expected = weights @ (paths > 0) / weights.sum()
    assert np.all(np.abs(drawn - expected) < 4.5 * np.sqrt(expected * (1 - expected) / count))


@pytest.mark.parametrize("run", range(3))
def test_what_switches_is_taken_out_and_what_reverts_stays(run):
    """Of 160 correlation times: the standard deviation to 6 %, the time to 12 %; four times as much is allowed."""
    data, clean = (sequence(*effects, label=f"out {run}") for effects in ((SWITCHES, REVERTS), (REVERTS,)))
    found = with_markov(data)
    told_apart = switching(found, found.description.noise.effects[1:], LOG_ALPHA)
    for name, value in SWITCHES.parameters().items():
        low, high = np.log(told_apart.intervals[name])
        assert abs(np.log(value) - (low + high) / 2) < 2 * (high - low) / 2
    rest = told_apart.without(data)
    reverts = with_markov(rest).description.noise.effects[1]
    assert reverts.std == pytest.approx(REVERTS.std, rel=0.24)
    assert reverts.correlation_time == pytest.approx(REVERTS.correlation_time, rel=0.48)
    assert np.std(rest.values - clean.values) < 0.5 * SWITCHES.step / 2


@pytest.mark.long
@pytest.mark.slow
def test_a_process_half_as_large_as_the_step_leaves_its_interval_true():
    """Of some 60 switches the rate is known to one in sqrt(60), or a little less; the intervals of the step are alike.

    One Gaussian for each value had several tops there, and intervals of a fifth of the error.
    """
    white, switches, reverts = WhiteNoise(2.3e-3), RandomTelegraph(2.1e-2, 0.025), GaussMarkov(1.05e-2, 23.5)
    errors, off = [], []
    for run in range(6):
        data = sequence(switches, reverts, label=f"large {run}", count=60_000, white=white)
        found = fit(data, Description.known(white).adding(GaussMarkov(1.5e-2, 22.0)))
        told_apart = switching(found, found.description.noise.effects[1:], LOG_ALPHA)
        low, high = np.log([told_apart.intervals[name] for name in ("step", "rate")]).T
        errors.append((high - low) / 2 / 1.96)
        off.append((np.log([switches.step, switches.rate]) - (low + high) / 2) / errors[-1])
    assert np.all(np.max(errors, axis=0) < 1.6 * np.min(errors, axis=0))
    assert np.all(np.abs(np.array(errors)[:, 1] * np.sqrt(60) - 1) < 0.3)
    assert np.all(np.abs(off) < 3.5)
    assert np.all(np.sum(np.square(off), axis=0) < chi2.ppf(0.999, 6))


@pytest.mark.parametrize("effects", [(REVERTS,), (SWITCHES,), (SWITCHES, RandomWalk(3e-4)), (RandomWalk(1e-3),)])
def test_nothing_is_taken_out_where_no_two_values_stand_beside_what_reverts(effects):
    found = with_markov(sequence(*effects, label="alone"))
    assert switching(found, found.description.noise.effects[1:], LOG_ALPHA) is None


@pytest.mark.slow
@pytest.mark.parametrize("run", range(2))
def test_telegraph_noise_and_a_markov_process_on_one_axis_are_both_named(run):
    data = sequence(SWITCHES, REVERTS, label=f"pair {run}")
    result = result_of(data, BiasStep, GaussMarkov, RandomWalk)
    assert names(result) == ["gauss_markov", "random_telegraph"]
    for finding in result.findings:
        truth = (SWITCHES if finding.name == "random_telegraph" else REVERTS).parameters()
        for name, interval in finding.parameters.items():
            assert 0.5 * interval.low < truth[name] < 2 * interval.high


@pytest.mark.slow
def test_switches_in_noise_that_changes_are_named_beside_the_change():
    """The spectrum has either another noise within the change or another step: the samples tell."""
    change = VarianceChange(500.0, 700.0, 8.0)
    data = sequence(SWITCHES, change, label="changed")
    result = result_of(data, BiasStep, GaussMarkov, RandomWalk, VarianceChange)
    found = {finding.name: finding.parameters for finding in result.findings}
    assert sorted(found) == ["random_telegraph", "variance_change"]
    for name, value in SWITCHES.parameters().items():
        assert 0.5 * found["random_telegraph"][name].low < value < 2 * found["random_telegraph"][name].high
    within, without = 5000, 19_000  # samples, whose variances scatter by sqrt(2 / n)
    allowed = 4.5 * np.sqrt(2 / within + 2 / without)
    assert found["variance_change"]["ratio"].value == pytest.approx(change.ratio, rel=allowed)


@pytest.mark.parametrize("number", [VarianceChange.most, VarianceChange.most + 1])
def test_switches_for_which_slow_noise_of_the_start_model_and_changes_of_variance_stand_are_told(number):
    data = sequence(SWITCHES, label="stands for")
    known = Description.known(WHITE, RandomWalk(1e-3))
    changes = tuple(VarianceChange(start, start + 20.0, 1.1) for start in 100.0 + 150.0 * np.arange(number))
    search = Search(known, (BiasStep, GaussMarkov, RandomWalk, VarianceChange), LOG_ALPHA)
    found = told_apart(search, fit(data, known.adding(*changes)))
    assert found.has(RandomTelegraph) == (number > VarianceChange.most)


@pytest.mark.slow
@pytest.mark.parametrize("run", range(4))
def test_a_cluster_of_switches_is_no_change_of_the_noise(run):
    """Two switches within a fifth of a second, in noise of a third of the step."""
    data = sequence(RandomTelegraph(1.5e-2, 0.1), label=f"cluster {run}")
    values = data.values.copy()
    values[12_000:12_005] += 1.5e-2 * (1 if values[11_990:12_000].mean() < values.mean() else -1)
    result = result_of(data.with_values(values), RandomWalk, GaussMarkov, VarianceChange)
    assert [finding.name for finding in result.findings] == ["random_telegraph"]

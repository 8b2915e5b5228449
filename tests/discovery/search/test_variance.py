from dataclasses import replace

import numpy as np
import pytest
from tests.discovery.simulated import (
    COUNT,
    INTERVAL,
    KINDS,
    KNOWN,
    LOG_ALPHA,
    WHITE,
    names,
    result_of,
    searched,
    sequence,
    told_of,
)

from imugap.discovery.fit.axis_fit import fit
from imugap.discovery.fit.description import Description
from imugap.discovery.search.search import Search
from imugap.effects import BiasInstability, BiasStep, GaussMarkov, Outliers, RandomTelegraph, VarianceChange
from imugap.stream import stream

LOUDER = VarianceChange(1000.0, 1200.0, 2.4)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("change", "label"),
    [
        *((LOUDER, f"louder {run}") for run in range(3)),
        (replace(LOUDER, stop=1100.0, ratio=4.5), "louder 4.5"),
        (replace(LOUDER, stop=2000.0, ratio=10.0), "louder 10.0"),
    ],
)
def test_outliers_beside_a_louder_stretch_have_their_share_and_size_and_it_its_ratio(change, label):
    """Its noise is not taken for small outliers, nor they for noise."""
    outliers = Outliers(5e-4, 0.1)
    data = sequence(outliers, change, count=100_000, label=label)
    result = result_of(data, Outliers, VarianceChange, GaussMarkov)
    assert names(result) == ["outliers", "variance_change"]
    found = {name: interval for finding in result.findings for name, interval in finding.parameters.items()}
    for name, truth in {**outliers.parameters(), "ratio": change.ratio}.items():
        error = (found[name].high - found[name].low) / 3.92
        assert abs(found[name].value - truth) < 3 * error < truth


@pytest.mark.parametrize(
    "change", [VarianceChange(200.0, 290.0, 1.3), VarianceChange(0.0, 960.0, depth=0.15, frequency=0.01, phase=1.0)]
)
def test_a_change_of_variance_is_weighed_again_as_it_was_taken(change):
    search = Search(KNOWN, (VarianceChange,), LOG_ALPHA)
    before = search.fitted(sequence(change), search.start)
    taken = min(search.trials(before, LOG_ALPHA), key=lambda trial: trial.log_p)
    again = search.added(taken.fit)[0].trial
    assert (again.parameters, again.trials) == (taken.parameters, taken.trials)
    assert again.log_p == pytest.approx(taken.log_p)
    assert search.refined(taken.fit).description.changes


@pytest.mark.slow
@pytest.mark.parametrize("apart", [2, 5, 30])
def test_one_outlier_far_beyond_the_others_is_no_change_of_the_variance(apart):
    data, rng = sequence(BiasInstability(3e-4)), stream(apart, "outliers")
    places, white = rng.choice(COUNT, 20, replace=False), WHITE.density / np.sqrt(INTERVAL)
    data.values[places] += np.r_[40.0, np.full(19, 10.0)] * white * rng.choice([-1.0, 1.0], 20)
    assert names(result_of(data)) == ["bias_instability", "outliers"]


@pytest.mark.slow
@pytest.mark.parametrize("change", [VarianceChange(360.0, 372.0, 4.0), VarianceChange(200.0, 290.0, 1.5)])
def test_a_change_of_variance_keeps_its_name_beside_outliers(change):
    """Outliers take it from no draw of the noise that shows it without them."""
    outliers = Outliers(1e-3, 0.1)
    assert names(told_of(outliers, change, label="beside")) == ["outliers", "variance_change"]
    assert names(told_of(outliers, change)) == ["outliers", *names(told_of(change))]


@pytest.mark.slow
@pytest.mark.parametrize("number", [VarianceChange.most, VarianceChange.most + 1])
def test_beside_more_changes_of_the_variance_than_have_a_name_nothing_else_is_looked_for(number):
    changes = tuple(VarianceChange(start, start + 50.0, 3.0) for start in 100.0 + 200.0 * np.arange(number))
    data = sequence(*changes, BiasStep(480.0, 2e-3), label="restless")
    search = Search(KNOWN, KINDS, LOG_ALPHA)
    found = search.explore(fit(data, search.start.adding(*changes)))
    assert found.has(BiasStep) == (number == VarianceChange.most)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("beside", "step"),
    [
        (GaussMarkov(6e-3, 2.0), 0.0),
        (RandomTelegraph(1.2e-2, 0.3), 0.0),
        (BiasInstability(4e-3), 0.0),
        (GaussMarkov(3e-3, 2.0), 1.2e-2),
    ],
    ids=["gauss_markov", "random_telegraph", "bias_instability", "on a coarse lattice"],
)
def test_outliers_in_noise_that_is_not_white_have_their_size(beside, step):
    """In the residual made white they are one over the mean of 1/sqrt(S), not over the root of the mean of S."""
    data, rng = sequence(beside, count=100_000, label="coloured"), stream(1, "coloured")
    outliers = 0.06 * rng.standard_normal(400)
    data.values[rng.choice(100_000, 400, replace=False)] += outliers
    values = step * np.rint(data.values / step) if step else data.values
    before = fit(replace(data, values=values, step=step), Description.known(WHITE, beside))
    assert (before.cells is not None) == (step > 0)
    cleaned = Search(before.description, (), LOG_ALPHA).without_outliers(before)
    assert cleaned.effect.std == pytest.approx(np.sqrt(np.mean(outliers**2)), rel=0.06)


def test_a_change_that_ends_with_the_training_part_does_not_go_on():
    end = 0.8 * COUNT * INTERVAL
    found = searched(sequence(VarianceChange(500.0, end, 1.7), label="ends"), VarianceChange)
    (change,) = found.training_fit.description.changes
    assert abs(change.stop - end) < 10.0

"""Laws that hold for every estimator of a sum of processes."""

import numpy as np
import pytest
from tests.estimation.setting import COUNT, INTERVAL, kinds, model, simulate

from imugap.effects import GaussMarkov, WhiteNoise
from imugap.estimation import maximum_likelihood
from imugap.estimation.gmwm import estimator
from imugap.estimation.result import Identifiability

estimators = pytest.mark.parametrize(
    ("fit", "seed"), [(maximum_likelihood.fit, 11), (estimator.fit, 23)], ids=["likelihood", "wavelet"]
)


@pytest.mark.parametrize(
    ("fit", "seed", "rtol"),
    [(maximum_likelihood.fit, 11, 5e-3), (estimator.fit, 23, 1e-4)],
    ids=["likelihood", "wavelet"],
)
@pytest.mark.parametrize("scale", [1e-7, 1e4])
def test_units_and_constant_do_not_matter(fit, seed, rtol, scale):
    sequence = simulate(model(20.0), 20_000, seed, "units")
    one = fit(sequence, INTERVAL, kinds(model(20.0))).table()
    other = fit(scale * (sequence + 3.0), INTERVAL, kinds(model(20.0))).table()
    power = np.array([0 if key == "correlation_time" else 2 if key == "driving_psd" else 1 for *_, key in one.index])
    for column in ("value", "low", "high"):
        np.testing.assert_allclose(other[column], one[column] * scale**power, rtol=rtol)


@estimators
def test_correlation_time_beyond_the_log_gets_a_lower_bound(fit, seed):
    of = WhiteNoise(5e-3) + GaussMarkov(0.1, 1e5)
    found = fit(simulate(of, 30_000, seed, "long"), INTERVAL, kinds(of)).table()
    time = found.loc[("gauss_markov", 1, "correlation_time")]
    assert time["verdict"] == Identifiability.LOWER_BOUND
    assert 100 < time["low"] < 1e5
    driving = found.loc[("gauss_markov", 1, "driving_psd")]
    assert driving["verdict"] == Identifiability.IDENTIFIED
    assert driving["low"] < 2e-7 < driving["high"]


@estimators
def test_two_gauss_markov_processes_are_told_apart_and_ordered(fit, seed):
    of = WhiteNoise(1e-3) + GaussMarkov(2e-2, 60.0) + GaussMarkov(1e-2, 2.0)
    found = fit(simulate(of, COUNT, seed, "two"), INTERVAL, kinds(of)).table().sort_index()
    for ordinal, (std, time) in enumerate([(1e-2, 2.0), (2e-2, 60.0)], start=1):
        rows = found.loc[("gauss_markov", ordinal)]
        assert (rows["verdict"] == Identifiability.IDENTIFIED).all()
        assert abs(rows.loc["std", "value"] / std - 1) < 4 * rows.loc["std", "error"]
        assert abs(rows.loc["correlation_time", "value"] / time - 1) < 4 * rows.loc["correlation_time", "error"]

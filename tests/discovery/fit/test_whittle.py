"""The climb of Whittle's likelihood: one top from wherever it begins, and a top it is."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.discovery import simulated

from imugap.discovery.fit.axis_fit import cosine_coefficients
from imugap.discovery.fit.whittle import Noise, NoiseSpectra, damped_step, fit, limits
from imugap.discovery.preparation.cosine_bins import Bins
from imugap.effects import (
    BiasInstability,
    GaussMarkov,
    OutputFilter,
    Quantization,
    RandomTelegraph,
    RandomWalk,
    WhiteNoise,
)
from imugap.stream import stream

COUNT, INTERVAL = 20000, 0.02
BINS = Bins(COUNT, INTERVAL)
TRUTH = Noise((WhiteNoise(1e-3), RandomWalk(1e-4), GaussMarkov(2e-3, 8.0)))


def power(noise, seed):
    """Sums of squared coefficients of the variances of a noise."""
    return noise.variance(BINS) * stream(seed, "noise").chisquare(BINS.number)


@pytest.mark.parametrize("faint", [1e-9, 1e-7, 1e-5])
def test_a_process_too_faint_to_matter_does_not_hold_up_the_others(faint):
    loud = Noise((WhiteNoise(1e-2), RandomWalk(faint)))
    found = fit(Noise((WhiteNoise(1e-4), RandomWalk(faint))), BINS, power(loud, 2))
    assert found.noise.effects[0].density == pytest.approx(1e-2, rel=5 / np.sqrt(COUNT))


@settings(deadline=None, max_examples=40)
@given(st.lists(st.floats(-6, 6), min_size=3, max_size=3), st.booleans())
def test_from_every_start_sizes_end_at_the_same_top(away, absent):
    """Without walk in the truth too: then it ends at or near its lower limit, and the others where they belong."""
    truth = Noise((WhiteNoise(1e-3), BiasInstability(3e-4), RandomWalk(1e-9 if absent else 1e-4)))
    seen = power(truth, 4)
    tops = [fit(truth.at(truth.theta() + shift), BINS, seen).log_likelihood for shift in (np.zeros(3), away)]
    assert tops[1] == pytest.approx(tops[0], abs=0.05)


@pytest.mark.parametrize("behind", [None, OutputFilter(5.0, 2)])
def test_the_end_of_a_climb_is_level_but_where_limits_stop_it(behind):
    truth = Noise(TRUTH.effects, behind)
    seen = power(truth, 3)
    found = fit(truth.at(truth.theta() + 0.7), BINS, seen)
    theta, (low, high) = found.noise.theta(), limits(truth, BINS, seen)
    gradient = NoiseSpectra(truth, BINS).expand(theta, seen)[1]
    inside = (theta > low + 1e-9) & (theta < high - 1e-9)
    assert inside.sum() >= 3
    score = gradient[inside] / np.sqrt(np.diag(found.information)[inside])
    assert np.abs(score).max() < 0.02


@pytest.mark.parametrize(
    "noise",
    [
        Noise((simulated.WHITE, BiasInstability(2e-4), RandomWalk(1e-5))),
        Noise((simulated.WHITE, GaussMarkov(3e-4, 8.0), Quantization(1e-5)), OutputFilter(6.0, 2)),
        Noise((simulated.WHITE, RandomTelegraph(1e-3, 0.1))),
    ],
)
def test_gradient_of_the_spectral_likelihood(noise):
    data = simulated.sequence(GaussMarkov(3e-4, 5.0), count=5000)
    power = data.bins.sums(cosine_coefficients(data.values) ** 2)
    spectra, theta = NoiseSpectra(noise, data.bins), noise.theta()
    _, gradient, information = spectra.expand(theta, power)
    for step in 1e-5 * np.eye(len(theta)):
        above, below = spectra.expand(theta + step, power)[0], spectra.expand(theta - step, power)[0]
        assert (above - below) / 2e-5 == pytest.approx(gradient @ step / 1e-5, rel=1e-4, abs=1e-3)
    assert np.all(np.linalg.eigvalsh(information) > 0)


def test_the_limits_of_a_correlation_time_are_those_of_the_log():
    data = simulated.sequence(RandomWalk(1e-6))
    noise = Noise((WhiteNoise(1e-8), GaussMarkov(1e-8, 100.0)))
    low, high = limits(noise, data.bins, data.bins.sums(cosine_coefficients(1e-5 * data.values) ** 2))
    assert np.exp([low[-1], high[-1]]) == pytest.approx([simulated.INTERVAL, 30 * simulated.COUNT * simulated.INTERVAL])


@pytest.mark.parametrize("count", [20, 24_000])
def test_noise_beneath_a_spectrum_does_not_rise_above_it(count):
    """Also where a log is too short to have a frequency below the cutoff: it touches the first that there are."""
    data = simulated.sequence(count=count)
    power = data.bins.sums(cosine_coefficients(data.values) ** 2)
    noise = Noise((simulated.WHITE,), OutputFilter(0.2, 1)).beneath(data.bins, power)
    asked = slice(max(8, np.sum(data.bins.frequency < 0.2)))
    over = power[asked] / data.bins.number[asked] / noise.variance(data.bins)[asked]
    assert np.mean(over >= 1 - 1e-9) >= 0.5
    assert over.min() <= 1 + 1e-9


INFORMATION = np.array([[4.0, 1.0], [1.0, 1.0]])


def test_a_step_within_the_box_is_that_to_the_top():
    step = damped_step(np.array([0.5, 0.2]), INFORMATION, 0.0, np.full(2, -1.0), np.ones(2))
    np.testing.assert_allclose(INFORMATION @ step, [0.5, 0.2], rtol=1e-8)


def test_what_leads_out_of_the_box_stays_at_its_end_and_the_rest_follows():
    step = damped_step(np.array([0.5, 1.5]), INFORMATION, 0.0, np.full(2, -1.0), np.ones(2))
    np.testing.assert_allclose(step, [(0.5 - 1.0) / 4, 1.0], rtol=1e-8)


@pytest.mark.parametrize("place", [0, 1])
def test_a_quadratic_that_is_not_finite_has_no_step(place):
    parts = [np.ones(2), INFORMATION.copy()]
    parts[place].flat[0] = np.nan
    assert np.isnan(damped_step(*parts, 0.1, np.full(2, -1.0), np.ones(2))).all()

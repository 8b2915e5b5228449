"""Two values or a continuum: the likelihoods against all paths and the covariance, estimates against truth."""

from itertools import product

import numpy as np
import pytest
from scipy.special import logsumexp
from scipy.stats import multivariate_normal
from tests.discovery import simulated

from imugap.discovery.fit.axis_fit import fit
from imugap.discovery.fit.description import Description
from imugap.discovery.fit.telegraph_likelihood import (
    BLOCKS_PER_TIME,
    Blocks,
    compare,
    continuum_log_densities,
    filtered,
)
from imugap.discovery.preparation.sequence import AxisSequence
from imugap.effects import GaussMarkov, OutputFilter, RandomTelegraph, RandomWalk, WhiteNoise
from imugap.effects.conditions import Conditions
from imugap.stream import stream

COUNT = 9


def wandering(white, walk, wide):
    """Covariance of blocks of a walk, of which the begin has the variance ``wide``, in white noise."""
    number = np.arange(1, COUNT + 1)
    return wide + walk**2 * np.minimum.outer(number, number) + white**2 * np.eye(COUNT)


@pytest.mark.parametrize("walk", [0.0, 0.3])
def test_a_continuum_has_the_density_of_its_covariance(walk):
    means = stream(1, "continuum").standard_normal(COUNT)
    lags = np.abs(np.subtract.outer(np.arange(COUNT), np.arange(COUNT)))
    covariance = wandering(0.5, walk, 40.0) + 0.8**2 * 0.9**lags
    law = multivariate_normal(np.full(COUNT, means.mean()), covariance)
    assert continuum_log_densities(means, 0.8, 0.9, np.full(COUNT, 0.5), walk, 40.0).sum() == pytest.approx(
        law.logpdf(means), abs=1e-9
    )


@pytest.mark.parametrize("width", [1, 4])
@pytest.mark.parametrize(
    ("walk", "wide", "kept", "tolerance"),
    [(0.0, 1e-12, 1, 1e-6), (0.0, 1e-12, 2, 1e-6), (0.05, 0.25, 1, 0.3), (0.05, 0.25, 2, 2e-3)],
)
def test_two_values_have_the_density_of_all_their_paths(walk, wide, kept, tolerance, width):
    """A mean of four samples has none, one, two or three of them before a switch; one may come ahead of all."""
    half, rise, fall, white = 1.0, 0.02, 0.01, 0.4
    means = white * stream(2, "paths").standard_normal(COUNT) + np.where(np.arange(COUNT) < 5, half, -half)
    up, same = rise / (rise + fall), np.exp(-(rise + fall))
    change = np.array([[1 - up * (1 - same), up * (1 - same)], [(1 - up) * (1 - same), 1 - (1 - up) * (1 - same)]])
    logs = []
    for path in product((0, 1), repeat=COUNT + 1):
        log_p = np.log([1 - up, up][path[0]]) + np.sum(np.log(change[path[:-1], path[1:]]))
        signs, switched = 2 * np.array(path[1:]) - 1, np.diff(path) != 0
        within = half * (1 - 2 * np.arange(width) / width)
        levels = signs * np.where(switched, within.mean(), half)
        law = multivariate_normal(
            means.mean() + levels, wandering(white, walk, wide) + np.diag(within.var() * switched)
        )
        logs.append(log_p + law.logpdf(means))
    slow = 1.0, walk**2, means.mean(), wide
    found = filtered(means, width, half, rise, fall, np.full(COUNT, white), *slow, kept)[0].sum()
    assert found == pytest.approx(logsumexp(logs), abs=tolerance)


def sequence(seed, beside, step=2e-4, passes=None, count=60000, interval=0.02):
    conditions = Conditions(np.arange(count) * interval, interval)
    rng = stream(seed, "telegraph")
    effects = (WhiteNoise(1e-4), RandomTelegraph(step, 0.1), *beside)
    values = sum(effect.sample(conditions, rng) for effect in effects)
    if passes is not None:
        values = passes.apply(values, conditions, rng)
    return AxisSequence(values, conditions), effects


@pytest.mark.slow
@pytest.mark.parametrize(
    ("beside", "step", "passes"),
    [
        ((), 2e-4, None),
        ((RandomWalk(3e-6),), 2e-4, None),
        ((), 3e-3, None),
        ((RandomWalk(3e-6),), 3e-3, None),
        ((), 2.5e-3, OutputFilter(5.0, 2)),
        ((), 2.5e-3, OutputFilter(1.5, 2)),
    ],
    ids=["alone", "on a walk", "strong", "strong on a walk", "strong behind a filter", "strong behind a slow filter"],
)
def test_the_estimates_hold_the_truth_as_often_as_they_say(beside, step, passes):
    hits, errors = 0, []
    for seed in range(12):
        one, effects = sequence(seed, beside, step, passes)
        found = fit(one, Description.known(*effects, *filter(None, [passes])))
        comparison = compare(found, tuple(found.description.noise.effects[1:2]))
        assert comparison.gain > 0
        truth = (step, 0.1)
        hits += sum(low <= true <= high for true, (low, high) in zip(truth, comparison.intervals, strict=True))
        errors.append(np.log([comparison.effect.step / truth[0], comparison.effect.rate / truth[1]]))
    assert 20 <= hits <= 24
    spread = np.std(errors, axis=0) / np.sqrt(len(errors))
    assert np.all(np.abs(np.mean(errors, axis=0)) < 3.5 * spread)


def test_a_process_slower_than_the_log_has_blocks_too():
    values = stream(1, "slower").standard_normal(5000)
    data = AxisSequence(values, Conditions(0.04 * np.arange(5000), 0.04, axis="gyro_x"))
    found = fit(data, Description.known(WhiteNoise(0.2)).adding(GaussMarkov(1.0, 10.0)))
    slow = GaussMarkov(1.0, 1e6)
    assert len(Blocks.of(found, (slow,)).means) >= BLOCKS_PER_TIME


def test_a_continuum_is_told_from_two_values():
    one, effects = sequence(3, ())
    conditions = one.conditions
    smooth = (WhiteNoise(1e-4), GaussMarkov(1e-4, 5.0))
    values = sum(effect.sample(conditions, stream(4, "smooth")) for effect in smooth)
    other = AxisSequence(values, conditions, one.flawed)
    gains = [
        compare(fit(log, Description.known(*noise)), (noise[1],)).gain
        for log, noise in ((one, (effects[0], effects[1].equivalent)), (other, smooth))
    ]
    assert gains[0] > 5
    assert gains[1] < 0


@pytest.mark.parametrize(("exponent", "seed"), [(3, 1), (4, 2), (4, 6)])
def test_what_never_switches_is_weighed_all_the_same(exponent, seed):
    """The likelihood of telegraph noise for a smooth curve has its top where it does not switch at all."""
    count, interval = 6000, 0.04
    conditions = Conditions(np.arange(count) * interval, interval)
    rng = stream(seed, "smooth")
    frequency = np.fft.rfftfreq(2 * count)
    frequency[0] = np.inf
    curve = np.fft.irfft(np.fft.rfft(rng.standard_normal(2 * count)) * frequency ** (-exponent / 2))[:count]
    values = WhiteNoise(1e-3).sample(conditions, rng) + 4e-3 * (curve - curve.mean()) / curve.std()
    data = AxisSequence(values, conditions)
    found = fit(data, Description.known(WhiteNoise(1e-3)).adding(RandomWalk(1e-4)))
    comparison = compare(found, tuple(found.description.noise.effects[1:]))
    assert np.isfinite([comparison.gain, comparison.uneven]).all()


def test_two_values_are_told_from_a_continuum():
    for effect, sign in ((RandomTelegraph(2e-3, 0.05), 1), (GaussMarkov(1e-3, 10.0), -1)):
        found = simulated.fitted(simulated.sequence(effect), GaussMarkov(1e-3, 10.0))
        assert sign * compare(found, found.description.noise.effects[1:]).gain > 6

"""White noise that is not normal: its samples have the law that its parameter says, and show it."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.stats import gamma, kurtosis, skew
from tests.chance import mean_is
from tests.effects.simulated import conditions

from imugap.effects import SkewedNoise, UniformNoise, WhiteNoise
from imugap.effects.conditions import Run
from imugap.numerics.samples.white_samples import WhiteSamples
from imugap.stream import stream

RUNS, COUNT = 200, 2000


def samples(effect, runs=RUNS, count=COUNT):
    return np.array([effect.sample(conditions(count), stream(3, effect.name, run)) for run in range(runs)])


def shown(values, share=1.0):
    """The noise of each kind that values show."""
    found = (kind.shown(WhiteSamples.of(values, share), 0.1) for kind in (UniformNoise, SkewedNoise))
    return [one.effect for one in found if one is not None]


@pytest.mark.parametrize("share", [0.0, 0.4, 1.0])
def test_uniform_noise_has_the_kurtosis_of_its_share(share):
    drawn = samples(UniformNoise(0.1, share))
    assert mean_is(np.square(drawn).mean(axis=1), 1.0, share=0.01)
    assert mean_is(kurtosis(drawn, axis=1), -1.2 * share**2 - 6 / COUNT * (share == 0))


def test_uniform_noise_has_ends():
    drawn = samples(UniformNoise(0.1), runs=10)
    assert np.sqrt(3) * 0.99 < np.abs(drawn).max() < np.sqrt(3)


@pytest.mark.parametrize("skewness", [-2.0, 0.0, 0.5, 1.5, 3.0])
def test_skewed_noise_has_its_skewness(skewness):
    drawn = samples(SkewedNoise(0.1, skewness))
    assert mean_is(drawn.mean(axis=1) + 1, 1.0)
    assert mean_is(np.square(drawn).mean(axis=1), 1.0, share=0.02)
    assert mean_is((drawn**3).mean(axis=1) + 4, skewness + 4)


def test_skewed_noise_is_nearly_of_a_gamma_law():
    drawn, probability = samples(SkewedNoise(0.1, 1.0)), np.linspace(0.001, 0.999, 999)
    quantiles = (gamma.ppf(probability, 4.0) - 4) / 2
    np.testing.assert_allclose(np.quantile(drawn, probability), quantiles, atol=0.04)


@pytest.mark.parametrize("effect", [UniformNoise(0.1, 0.6), SkewedNoise(0.1, -0.7)], ids=lambda one: one.name)
def test_parts_are_drawn_as_the_whole(effect):
    at = conditions(COUNT)
    step = effect.in_parts(Run(COUNT, at.interval, lambda: iter([at])), stream(3, "parts"))
    ends = (0, 300, 301, COUNT)
    parts = [step(np.zeros(b - a), conditions(b - a)) for a, b in pairwise(ends)]
    np.testing.assert_array_equal(np.concatenate(parts), effect.sample(at, stream(3, "parts")))


LAWS = {
    "normal": lambda rng, n: rng.standard_normal(n),
    "two humps": lambda rng, n: 0.5 * rng.standard_normal(n) + rng.choice([-0.85, 0.85], n),
    "a sine": lambda rng, n: np.sin(rng.uniform(0, 2 * np.pi, n)),
    "a sum of two uniform numbers": lambda rng, n: rng.random(n) + rng.random(n),
    "heavy tails": lambda rng, n: rng.laplace(size=n),
    "outliers": lambda rng, n: rng.standard_normal(n) * np.where(rng.random(n) < 2e-3, 10, 1),
    "outliers of one sign": lambda rng, n: rng.standard_normal(n) + 6 * (rng.random(n) < 0.02),
    "two levels": lambda rng, n: 0.5 * rng.standard_normal(n) + 2 * (rng.random(n) < 0.3),
}


@pytest.mark.parametrize("law", LAWS)
def test_other_laws_are_neither(law):
    for run in range(5):
        assert not shown(LAWS[law](stream(3, law, run), 20_000)), run


SKEWED = {
    "exponential": lambda rng, n: rng.exponential(size=n),
    "gamma": lambda rng, n: -rng.gamma(2.0, size=n),
    "log-normal": lambda rng, n: np.exp(0.4 * rng.standard_normal(n)),
    "Rayleigh": lambda rng, n: rng.rayleigh(size=n),
    "Gumbel": lambda rng, n: rng.gumbel(size=n),
    "normal beyond zero": lambda rng, n: np.abs(rng.standard_normal(n)),
}


@pytest.mark.parametrize("law", SKEWED)
def test_all_skewed_laws_are_skewed_noise(law):
    values = SKEWED[law](stream(3, law), 20_000)
    (one,) = shown(values)
    assert type(one) is SkewedNoise
    assert one.skewness == pytest.approx(skew(values))


def test_normal_noise_in_the_samples_is_told_apart():
    share, rng = 0.97, stream(3, "share")
    mixed = share * UniformNoise(0.1).sample(conditions(200_000), rng)
    mixed += np.sqrt(1 - share**2) * WhiteNoise(0.1).sample(conditions(200_000), rng)
    (one,) = shown(mixed, share)
    assert one.share == pytest.approx(1.0, abs=0.01)


def test_a_tone_of_any_course_is_dependent_and_noise_is_not():
    time = np.linspace(0, 1, 20_000)
    tone = np.cos(3000 * time + 5000 * time**3)
    assert WhiteSamples.of(tone + 0.3 * stream(3, "tone").standard_normal(20_000), 1.0).dependent
    assert not WhiteSamples.of(stream(3, "exponential").exponential(size=20_000), 1.0).dependent

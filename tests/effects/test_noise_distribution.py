import numpy as np
import pytest
from tests.effects.simulated import conditions

from imugap.effects import NoiseDistribution, WhiteNoise
from imugap.effects.effect import AxisModel
from imugap.effects.noise_distribution import PROBABILITIES
from imugap.stream import stream

COUNT = 200_000
LAWS = {
    "uniform": lambda rng: rng.random(COUNT),
    "skewed": lambda rng: rng.gamma(2.0, size=COUNT),
    "two humps": lambda rng: np.where(rng.random(COUNT) < 0.5, -1, 1) + 0.4 * rng.standard_normal(COUNT),
    "heavy": lambda rng: rng.laplace(size=COUNT),
}


@pytest.mark.parametrize("law", LAWS)
def test_noise_has_the_distribution_of_the_values_it_was_made_from(law):
    values = LAWS[law](stream(3, law))
    model = AxisModel((WhiteNoise(0.2), NoiseDistribution.of(values, 0.2 / np.sqrt(0.01))))
    found = model.simulate(np.zeros(COUNT), conditions(COUNT), 1)
    scaled = 2.0 * (values - values.mean()) / values.std()
    below = np.searchsorted(np.sort(found), np.quantile(scaled, PROBABILITIES)) / COUNT
    expected = np.array(PROBABILITIES)
    assert (np.abs(below - expected) < 5 * np.sqrt(2 * expected * (1 - expected) / COUNT) + 1e-4).all()
    assert found.std() == pytest.approx(2.0, rel=0.04)  # it is linear between quantiles
    assert abs(np.corrcoef(found[1:], found[:-1])[0, 1]) < 0.01


def test_the_quantiles_of_normal_noise_change_nothing():
    values = stream(4).standard_normal(1000)
    np.testing.assert_allclose(NoiseDistribution(1.0).apply(values, conditions(1000), stream(1)), values, atol=1e-12)


def test_quantiles_that_fall_are_refused():
    with pytest.raises(ValueError, match="expected quantiles that do not fall"):
        NoiseDistribution(1.0, q_50=2.0)

import numpy as np
import pytest
from tests.chance import mean_is
from tests.effects.simulated import allan_variances, draws, tapered_power

from imugap.effects import PowerLaw, RandomWalk
from imugap.effects.bias_instability import FractionalFlicker


@pytest.mark.parametrize("exponent", [0.1, 0.6, 1.0, 2.0, 2.4, 2.8, 3.0, 3.6])
@pytest.mark.parametrize("count", [600, pytest.param(601, marks=pytest.mark.slow)])
def test_noise_of_any_slope_has_its_spectrum_down_to_the_slowest(exponent, count):
    """Differences of samples are stationary, or their differences are; where an Allan variance is, it is theirs."""
    law, averaging = PowerLaw(0.4, exponent), np.array([1, 7, 100])
    sequences = draws(law, 4000, count, exponent)
    order = 2 if exponent >= 3 else 1
    power, frequency = tapered_power(np.diff(sequences, order, axis=1))
    for band in (slice(6, 12), slice(60, 90), slice(280, 295)):
        expected = law.sampled_psd(frequency[band], 0.01) * (2 * np.sin(np.pi * frequency[band] * 0.01)) ** (2 * order)
        assert mean_is((power[:, band] / expected).mean(axis=1), 1.0, share=0.03)
    theirs = law.sampled_allan_variance(averaging, 0.01)
    assert np.isinf(theirs).all() == (order == 2)
    if order == 1:
        assert mean_is(allan_variances(sequences, averaging), theirs, share=0.03)


@pytest.mark.parametrize(("process", "exponent"), [(FractionalFlicker(0.4), 1.0), (RandomWalk(0.4), 2.0)], ids=str)
def test_noise_of_a_slope_that_has_a_name_is_that(process, exponent):
    averaging, law = np.array([1, 8, 300]), PowerLaw(0.4, exponent)
    for interval in (0.01, 1.0):
        frequency = np.array([1e-4, 0.01, 0.5]) / interval
        np.testing.assert_allclose(law.sampled_psd(frequency, interval), process.sampled_psd(frequency, interval))
        theirs = process.sampled_allan_variance(averaging, interval)
        np.testing.assert_allclose(law.sampled_allan_variance(averaging, interval), theirs)

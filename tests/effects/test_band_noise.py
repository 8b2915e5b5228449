import numpy as np
import pytest
from scipy.integrate import quad
from tests.chance import mean_is
from tests.effects.simulated import RUNS, allan_variances, draws, tapered_power

from imugap.effects import BandNoise

BAND = BandNoise(0.3, 12.0, 6.0)


def test_samples_have_the_power_of_the_band_within_it_and_none_outside():
    power, frequency = tapered_power(draws(BAND, RUNS, 2000, "band"))
    inside, outside = (frequency > 9.5) & (frequency < 14.5), (frequency < 8) | (frequency > 16)
    assert mean_is(power[:, inside].mean(axis=1), BAND.density**2, share=0.03)
    assert power[:, outside].mean() < 1e-3 * BAND.density**2


def test_samples_have_the_allan_variance_of_the_covariance():
    averaging = np.array([1, 2, 7, 30])
    found = allan_variances(draws(BAND, 400, 2000, "allan"), averaging)
    assert mean_is(found, BAND.sampled_allan_variance(averaging, 0.01), share=0.03)


@pytest.mark.parametrize(
    ("band", "tau"), [*((BAND, tau) for tau in (1e-3, 0.05, 0.4, 20.0)), (BandNoise(0.3, 0.0, 4e-9), 3.0)]
)
def test_allan_variance_is_the_spectral_integral(band, tau):
    def of(f):
        return 4 * band.density**2 * np.pi**2 * (f * tau) ** 2 * np.sinc(f * tau) ** 4

    assert band.allan_variance(tau) == pytest.approx(quad(of, *band.edges, limit=2000)[0], rel=1e-9)


def test_bands_that_touch_are_one_band():
    parts, tau = [BandNoise(0.3, 10.5, 3.0), BandNoise(0.3, 13.5, 3.0)], np.geomspace(1e-3, 1e2, 9)
    whole = sum(one.allan_variance(tau) for one in parts)
    np.testing.assert_allclose(BAND.allan_variance(tau), whole, rtol=1e-9)
    samples = sum(one.sampled_allan_variance(np.array([1, 5, 40]), 0.01) for one in parts)
    np.testing.assert_allclose(BAND.sampled_allan_variance(np.array([1, 5, 40]), 0.01), samples, rtol=1e-9)


def test_there_is_no_noise_below_zero_frequency_and_beyond_half_the_rate():
    assert BandNoise(1.0, 1.0, 6.0).edges == (0.0, 4.0)
    beyond = BandNoise(1.0, 80.0, 20.0)
    assert not draws(beyond, 3, 500, "beyond").any()
    assert beyond.sampled_allan_variance(4, 0.01) == pytest.approx(0.0, abs=1e-12)

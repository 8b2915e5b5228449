import numpy as np
import pytest
from tests.chance import mean_is
from tests.effects.simulated import allan_variances, conditions

from imugap.effects import Quantization
from imugap.stream import stream


def test_quantization_is_what_rounding_of_the_angle_does_to_the_rate():
    lsb, rng = 1e-3, stream(7, "angle")
    rate = 0.5 + rng.standard_normal((200, 500))
    angle = np.cumsum(rate, axis=1) * 0.01
    rounded = np.rint(angle / lsb) * lsb
    errors = np.diff(rounded - angle, axis=1) / 0.01
    process = Quantization(lsb / np.sqrt(12))
    averaging = np.array([1, 4, 50])
    found = allan_variances(errors, averaging)
    assert mean_is(found, process.sampled_allan_variance(averaging, 0.01), share=0.03)
    assert np.abs(process.sample(conditions(1000), stream(7, "bound"))).max() <= lsb / 0.01


def test_quantization_has_the_slope_and_gain_of_ieee_952():
    tau = np.array([1.0, 10.0])
    np.testing.assert_allclose(np.sqrt(Quantization(2.0).allan_variance(tau)), np.sqrt(3) * 2.0 / tau, rtol=1e-14)


def test_quantization_has_no_spectrum_without_an_interval():
    with pytest.raises(NotImplementedError, match="expected a sampling interval"):
        Quantization(1.0).psd(np.ones(2))

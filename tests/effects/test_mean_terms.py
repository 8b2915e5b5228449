import numpy as np
import pytest
from tests.effects.simulated import conditions, draws, sharp_std

from imugap.effects import Bias, BiasStep, Conditions, RateRamp, Sinusoid, Temperature, TurnOnBias, WarmUp
from imugap.estimation.variances import allan
from imugap.stream import stream


def test_bias_is_its_value_at_every_sample():
    np.testing.assert_array_equal(Bias(-0.3).sample(conditions(4), stream(1)), [-0.3] * 4)


def test_turn_on_bias_is_held_within_a_run_and_has_its_deviation_over_runs():
    sequences = draws(TurnOnBias(0.2), 10_000, 3, "runs")
    np.testing.assert_array_equal(sequences, sequences[:, :1] * np.ones(3))
    assert sharp_std(sequences[:, 0], 0.2)


def test_temperature_is_proportional_to_the_distance_from_the_reference():
    effect = Temperature(2e-3, reference=30.0)
    sequence = effect.sample(conditions(3, temperature=np.array([30.0, 31.0, 25.0])), stream(1))
    np.testing.assert_allclose(sequence, [0.0, 2e-3, -1e-2], rtol=1e-15)


def test_temperature_needs_a_temperature():
    with pytest.raises(ValueError, match="expected conditions with a temperature"):
        Temperature(1.0).sample(conditions(3), stream(1))


def test_ramp_has_the_allan_variance_of_ieee_952_at_every_averaging_time():
    ramp, averaging = RateRamp(-0.3), np.array([1, 2, 17, 400])
    sequence = ramp.sample(conditions(1000), stream(1))
    assert sequence[-1] == pytest.approx(-0.3 * 9.99)
    np.testing.assert_allclose(allan.variance(sequence, averaging), (0.3 * averaging * 0.01) ** 2 / 2, rtol=1e-8)
    np.testing.assert_allclose(ramp.sampled_allan_variance(averaging, 0.01), ramp.allan_variance(averaging * 0.01))


@pytest.mark.parametrize("frequency", [0.7, 12.3, 49.0, 73.0])
def test_sinusoid_has_the_allan_variance_of_the_mean_over_its_phase(frequency):
    averaging = np.array([1, 2, 7, 50])
    phases = np.linspace(0, 2 * np.pi, 12, endpoint=False)
    runs = [Sinusoid(frequency, 0.5, phase).sample(conditions(400), stream(1)) for phase in phases]
    found = np.mean([allan.variance(run, averaging) for run in runs], axis=0)
    expected = Sinusoid(frequency, 0.5).sampled_allan_variance(averaging, 0.01)
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-15)


def test_sinusoid_has_the_lobes_of_ieee_952():
    line, tau = Sinusoid(2.0, 0.5), np.array([1e-4, 0.1, 0.25, 0.5, 1.3])
    expected = (0.5 * np.sin(2 * np.pi * tau) ** 2 / (2 * np.pi * tau)) ** 2
    np.testing.assert_allclose(line.allan_variance(tau), expected, rtol=1e-9, atol=1e-30)
    assert line.allan_variance(0.5) == pytest.approx(0, abs=1e-25)
    fine = line.sampled_allan_variance(np.array([25_000]), 1e-5)
    np.testing.assert_allclose(fine, line.allan_variance(np.array([0.25])), rtol=1e-8)


def test_sinusoid_has_its_amplitude_frequency_and_phase():
    sequence = Sinusoid(5.0, 0.5, 1.0).sample(conditions(1000), stream(1))
    line = np.fft.rfft(sequence) / 500
    expected = np.zeros(501, complex)
    expected[50] = 0.5 * np.exp(1j)
    np.testing.assert_allclose(line, expected, atol=1e-12)


@pytest.mark.parametrize("interval", [0.01, 1.0])
def test_a_sinusoid_at_the_sampling_rate_is_a_constant(interval):
    line = Sinusoid(1 / interval, 1.0)
    np.testing.assert_allclose(line.sampled_allan_variance(np.array([1, 10]), interval), 0, atol=1e-20)


def test_bias_step_is_there_from_its_time_on():
    at = Conditions(np.array([0.0, 0.1, 0.2, 0.3]), 0.1)
    np.testing.assert_array_equal(BiasStep(0.2, -0.4).sample(at, stream(1)), [0.0, 0.0, -0.4, -0.4])


def test_warm_up_relaxes_from_its_amplitude_with_its_time_constant():
    at = conditions(400)
    sequence = WarmUp(-0.8, 0.5).sample(at, stream(1))
    assert sequence[0] == -0.8
    np.testing.assert_allclose(np.gradient(sequence, at.time)[1:-1], -sequence[1:-1] / 0.5, rtol=1e-4)


def test_temperature_has_a_curvature_and_a_rate_term():
    temperature = 20 + 0.5 * np.arange(5)
    at = conditions(5, interval=0.1, temperature=temperature)
    curved = Temperature(0.0, 21.0, quadratic=2.0).sample(at, stream(1))
    np.testing.assert_allclose(curved, [2.0, 0.5, 0.0, 0.5, 2.0], atol=1e-14)
    np.testing.assert_allclose(Temperature(0.0, rate=0.3).sample(at, stream(1)), np.full(5, 1.5), rtol=1e-12)
    whole = Temperature(1.5, 21.0, 2.0, 0.3).sample(at, stream(1))
    np.testing.assert_allclose(whole, Temperature(1.5, 21.0).sample(at, stream(1)) + curved + 1.5, rtol=1e-12)

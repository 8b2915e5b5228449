from itertools import product

import numpy as np
import pytest
from scipy.fft import irfft, rfft, rfftfreq
from scipy.signal import lfilter
from tests.chance import mean_is
from tests.effects.simulated import RUNS, conditions, draws, tapered_power

from imugap.effects import OutputFilter, WhiteNoise
from imugap.stream import stream


@pytest.mark.parametrize("order", [1, 2, 5, 8])
@pytest.mark.parametrize(
    ("cutoff", "form"),
    [*product((1, 10, 45), (0, 1, 2, 3)), *product((99,), (1, 2, 3))],
)
def test_filter_has_the_gain_that_it_says(cutoff, order, form):
    effect, count = OutputFilter(cutoff, order, form), 40_000
    pulse = np.zeros(count)
    pulse[count // 2] = 1.0
    response = effect.apply(pulse, conditions(count), stream(1))
    frequency = np.fft.rfftfreq(count, 0.01)
    gain, expected = np.abs(np.fft.rfft(response)) ** 2, effect.gain(frequency, 0.01)
    inside = frequency < (49 if form > 1 else 51)  # an analogue signal has no phase at half the rate
    np.testing.assert_allclose(gain[inside], expected[inside], atol=1e-4 if form > 1 else 1e-9)
    np.testing.assert_allclose(np.abs(effect.response(frequency, 0.01)) ** 2, expected, rtol=1e-6, atol=1e-9)
    assert effect.gain(0.0, 0.01) == 1.0
    half = effect.gain(cutoff, 0.01)
    if form == 3:
        alias = (effect.cutoff + 100 * np.arange(-8, 9)) / effect.cutoff
        zero = 100 * np.arange(-8, 9) / effect.cutoff
        assert half == pytest.approx(np.sum(1 / (1 + alias ** (2 * order))) / np.sum(1 / (1 + zero ** (2 * order))))
    else:
        assert half > 0.5 if form == 1 else half == pytest.approx(0.5, rel=1e-12)


@pytest.mark.parametrize("cutoff", [1.0, 10.0, 49.0, 80.0])
def test_the_filter_of_one_pole_is_an_rc_element_sampled(cutoff):
    frequency, aliases = np.linspace(0, 50, 30), 100 * np.arange(-20_000, 20_001)
    analogue = np.sum(1 / (1 + ((frequency[:, None] + aliases) / cutoff) ** 2), axis=1)
    gain = OutputFilter(cutoff, 1, 1).gain(frequency, 0.01)
    np.testing.assert_allclose(gain, analogue / analogue[0], rtol=2e-5)


@pytest.mark.parametrize("order", [2, 3, 5])
@pytest.mark.parametrize("cutoff", [1.0, 10.0, 49.0, 80.0])
def test_samples_behind_an_analogue_filter_have_the_spectrum_of_all_that_folds_back(cutoff, order):
    """White noise through the filter at 16 times the rate, of which every sixteenth sample is taken."""
    runs, count, kept, fine = 40, 4096, 16, OutputFilter(cutoff, order, 2)
    rng, frequency = stream(5, "folded", cutoff, order), rfftfreq(count * kept, 0.01 / kept)
    white = rfft(rng.standard_normal((runs, count * kept)))
    samples = irfft(white * fine.response(frequency, 0.01 / kept))[:, ::kept]
    at_zero = count / kept * np.sum(fine.gain(100.0 * np.arange(-7, 9), 0.01 / kept))
    power = np.mean(np.abs(rfft(samples)[:, 1:-1]) ** 2, axis=0) / at_zero
    gain = OutputFilter(cutoff, order, 3).gain(rfftfreq(count, 0.01)[1:-1], 0.01)
    for measured, said in zip(np.array_split(power, 12), np.array_split(gain, 12), strict=True):
        assert abs(measured.sum() - said.sum()) < 5 * np.sqrt(np.sum(said**2) / runs)


@pytest.mark.parametrize("form", [1, 2, 3])
@pytest.mark.parametrize("order", [1, 2, 8])
@pytest.mark.parametrize("cutoff", [1e4, 1e6])
def test_a_filter_far_beyond_the_rate_changes_nothing(cutoff, order, form):
    values, effect = stream(3, "open").standard_normal(500), OutputFilter(cutoff, order, form)
    np.testing.assert_allclose(effect.passed(values, 0.01), values, atol=0.1)
    np.testing.assert_allclose(effect.gain(np.linspace(0, 50, 9), 0.01), 1.0, atol=1e-3)


@pytest.mark.parametrize("weight", [0.1, 0.5, 0.8, 0.99])
def test_the_filter_of_one_pole_is_exponential_smoothing(weight):
    cutoff = -100 * np.log(1 - weight) / (2 * np.pi)
    values = stream(3).standard_normal(500)
    output = OutputFilter(cutoff, 1, 1).apply(values, conditions(500), stream(1))
    smoothed, _ = lfilter([weight], [1, weight - 1], values, zi=[(1 - weight) * values[0]])
    np.testing.assert_allclose(output, smoothed, rtol=1e-9)


@pytest.mark.parametrize("order", [1, 4])
def test_filter_colours_white_noise_by_its_gain(order):
    interval, noise, effect = 0.01, WhiteNoise(0.3), OutputFilter(10.0, order)
    white = draws(noise, RUNS, 1024, "filter", order, interval=interval)
    power, frequency = tapered_power(np.array([effect.apply(one, conditions(1024), stream(1)) for one in white]))
    for band in (slice(8, 40), slice(95, 110), slice(180, 220)):
        expected = noise.sampled_psd(frequency[band], interval) * effect.gain(frequency[band], interval)
        assert mean_is((power[:, band] / expected).mean(axis=1), 1.0, share=0.03), band


def test_filter_starts_in_its_steady_state():
    output = OutputFilter(3.0, 4).apply(np.full(200, 9.8), conditions(200), stream(1))
    np.testing.assert_allclose(output, 9.8, rtol=1e-9)


@pytest.mark.parametrize("order", [1, 4])
def test_a_filter_lets_go_of_what_was_before_the_log_as_its_decay_says(order):
    smooth, values = OutputFilter(3.0, order), stream(11, "decay").standard_normal((400, 2))
    long = smooth.passed(np.concatenate([np.full((500, 2), [9.8, -0.4]), values]), 0.01)[500:]
    begun = smooth.passed(np.concatenate([np.zeros((500, 2)), values]), 0.01)[500:]
    np.testing.assert_allclose(long - begun, np.outer(smooth.decay(400, 0.01), [9.8, -0.4]), atol=1e-9)


@pytest.mark.parametrize("cutoff", [50.0, 80.0])
def test_a_cutoff_beyond_half_the_rate_is_refused(cutoff):
    message = r"output_filter\.cutoff: expected less than half the rate, 50 Hz; found"
    with pytest.raises(ValueError, match=message):
        OutputFilter(cutoff).apply(np.zeros(9), conditions(9), stream(1))
    with pytest.raises(ValueError, match=message):
        OutputFilter(cutoff).gain(1.0, 0.01)


@pytest.mark.parametrize(("order", "form"), list(product((1, 2, 8), (0, 1))))
def test_the_lowest_cutoff_still_passes_a_constant_and_a_lower_one_is_refused(order, form):
    flat = np.full(500, 9.8)
    passed = OutputFilter(1.1e-4, order, form).apply(flat, conditions(500, 0.01), stream(1))
    np.testing.assert_allclose(passed, flat, rtol=1e-3)
    with pytest.raises(
        ValueError, match=r"output_filter\.cutoff: expected at least 0\.0001 Hz at 100 Hz, .*; found 1e-08"
    ):
        OutputFilter(1e-8, order, form).apply(flat, conditions(500, 0.01), stream(1))
    with pytest.raises(ValueError, match=r"output_filter\.cutoff: expected at least"):
        OutputFilter(1e-8, order, form).block(0.01, "gyro_x")


@pytest.mark.parametrize("form", [2, 3])
def test_a_filter_far_below_the_rate_passes_nothing_and_says_so_in_numbers(form):
    closed = OutputFilter(1e-25, 8, form)
    assert np.all(closed.gain(np.array([1.0, 49.0]), 0.01) < 1e-100)
    assert np.all(np.abs(closed.response(np.array([1.0, 49.0]), 0.01)) < 1e-50)

from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import quad
from tests.effects.simulated import PUBLISHED, RUNS, allan_variances, conditions, draws

from imugap.effects import BiasInstability
from imugap.effects.bias_instability import FLOOR, FractionalFlicker


def test_flicker_floor_is_that_of_ieee_952():
    assert np.sqrt(BiasInstability(1.0).allan_variance(123.0)) == pytest.approx(0.664, abs=5e-4)


def test_flicker_is_no_periodic_sequence():
    sequences = draws(BiasInstability(1.0), RUNS, 512, "ends")
    ends = sequences[:, -1] - sequences[:, 0]
    steps = np.diff(sequences, axis=1)
    assert np.mean(ends**2) > 2 * np.mean(steps**2)


@pytest.mark.parametrize("device", ["accel", "gyro_a", "gyro_b"])
def test_floors_of_the_tutorial_are_those_of_its_bias_instability(device):
    row = PUBLISHED.loc[f"{device}_B"]
    floors = [np.sqrt(BiasInstability(row["value"] + k * row["half_digit"]).allan_variance(1.0)) for k in (-1, 1)]
    assert floors[0] - PUBLISHED["half_digit"][f"{device}_floor"] < PUBLISHED["value"][f"{device}_floor"]
    assert floors[1] + PUBLISHED["half_digit"][f"{device}_floor"] > PUBLISHED["value"][f"{device}_floor"]
    assert PUBLISHED["value"][f"{device}_floor"] / FLOOR == pytest.approx(row["value"], rel=6e-3)


class OneAtATime:
    """A source of "random" numbers that are zero but for one: samples are linear in them."""

    def __init__(self, chosen):
        self.chosen, self.drawn = chosen, 0

    def standard_normal(self, count):
        numbers = np.zeros(count)
        if 0 <= self.chosen - self.drawn < count:
            numbers[self.chosen - self.drawn] = 1.0
        self.drawn += count
        return numbers


@pytest.mark.parametrize("form", [BiasInstability, FractionalFlicker])
@pytest.mark.parametrize("n", [1, 2, 7, 300])
def test_allan_variance_of_flicker_is_the_integral_of_its_sampled_spectrum(form, n):
    def integrand(angle):
        gain = 2 * np.sin(n * angle) ** 4 / (n * np.sin(angle)) ** 2
        return gain * float(form(0.4).sampled_psd(angle / (np.pi * 0.01), 0.01))

    lobes = np.linspace(0, np.pi / 2, n + 1)
    expected = sum(2 * quad(integrand, low, high)[0] for low, high in pairwise(lobes)) / (np.pi * 0.01)
    assert form(0.4).sampled_allan_variance(n, 0.01) == pytest.approx(expected, rel=1e-8)


def test_samples_of_fractional_flicker_have_its_allan_variance():
    process, n = FractionalFlicker(0.4), np.array([1, 4, 16])
    found = np.mean(allan_variances(draws(process, RUNS, 1024, "fractional"), n), axis=0)
    np.testing.assert_allclose(found, process.sampled_allan_variance(n, 0.01), rtol=0.02)


def test_both_forms_of_flicker_differ_towards_half_the_sampling_rate_alone():
    frequency = np.array([0.01, 1.0, 10.0, 50.0])
    ratio = FractionalFlicker(0.4).sampled_psd(frequency, 0.01) / BiasInstability(0.4).sampled_psd(frequency, 0.01)
    assert ratio == pytest.approx([1, 1.0002, 1.0166, np.pi / 2], abs=1e-4)


@pytest.mark.parametrize("n", [64, 32, 16])
def test_flicker_of_a_run_lacks_only_the_power_below_its_first_line(n):
    count, weights = 256, np.repeat([-1.0, 1.0], n) / n
    responses = [BiasInstability(1.0).sample(conditions(count), OneAtATime(k)) for k in range(4 * count)]
    exact = np.sum((np.array(responses)[:, 5 : 5 + 2 * n] @ weights) ** 2) / 2
    missing = BiasInstability(1.0).sampled_allan_variance(n, 0.01) - exact
    assert missing == pytest.approx(np.pi / 6 * (n / (4 * count)) ** 2, rel=0.05)

from dataclasses import fields, replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import quad
from tests.chance import mean_is
from tests.effects.simulated import (
    NAMES,
    PROCESSES,
    RUNS,
    SAMPLED,
    SAMPLED_NAMES,
    allan_variances,
    conditions,
    draws,
    sharp_std,
    tapered_power,
)

from imugap.effects import BiasInstability, GaussMarkov, RandomWalk
from imugap.effects.bias_instability import FractionalFlicker
from imugap.stream import stream


def spectral_integral(psd, tau, periods=40):
    """Allan variance from the two-sided PSD (Farrell et al. 2022, eq. 16), u = pi f tau; sin^4 averages 3/8 far out."""
    density = lambda u: float(psd(u / (np.pi * tau)))  # noqa: E731
    lobes = [quad(lambda u: density(u) * np.sin(u) ** 4 / u**2, k * np.pi, (k + 1) * np.pi)[0] for k in range(periods)]
    tail = quad(lambda u: density(u) * 3 / 8 / u**2, periods * np.pi, np.inf)[0]
    return 4 / (np.pi * tau) * (sum(lobes) + tail)


@pytest.mark.parametrize("process", PROCESSES, ids=NAMES)
@pytest.mark.parametrize("tau", [1e-3, 0.05, 0.378, 4.0, 300.0])
def test_allan_variance_is_the_spectral_integral(process, tau):
    assert process.allan_variance(tau) == pytest.approx(spectral_integral(process.psd, tau), rel=2e-4)


@pytest.mark.parametrize("process", SAMPLED, ids=SAMPLED_NAMES)
def test_the_spectrum_goes_with_the_square_of_the_size(process):
    frequency, interval = np.geomspace(1e-3, 0.5, 20), 1.0
    tripled = replace(process, **{process.size(): 3 * getattr(process, process.size())})
    np.testing.assert_allclose(
        tripled.sampled_psd(frequency, interval), 9 * process.sampled_psd(frequency, interval), rtol=1e-9
    )


@pytest.mark.parametrize("process", SAMPLED[:-1], ids=SAMPLED_NAMES[:-1])
@pytest.mark.parametrize("interval", [0.01, 0.005])
def test_sampled_sequences_have_the_allan_variance_of_the_closed_form(process, interval):
    averaging = np.array([16, 40, 100, 250])  # samples, or the sampled process is not the averaged one
    sequences = draws(process, RUNS, 4000, "allan", interval, interval=interval)
    expected = process.allan_variance(averaging * interval)
    assert mean_is(allan_variances(sequences, averaging), expected, share=0.03)


@pytest.mark.parametrize("process", PROCESSES, ids=NAMES)
def test_sampled_sequences_have_the_spectrum(process):
    steps = np.diff(draws(process, RUNS, 1025, "psd"), axis=1)  # a difference is stationary, whatever the process
    power, frequency = tapered_power(steps)
    for band in (slice(8, 16), slice(20, 40)):  # below a twelfth of the sampling rate: no aliasing to speak of
        expected = process.psd(frequency[band]) * 4 * np.sin(np.pi * frequency[band] * 0.01) ** 2
        assert mean_is((power[:, band] / expected).mean(axis=1), 1.0, share=0.03), band


@pytest.mark.parametrize("process", PROCESSES, ids=NAMES)
def test_spectrum_is_even_and_scales_with_the_square_of_the_density(process):
    frequency = np.logspace(-4, 3, 15)
    first = fields(process)[0].name
    doubled = type(process)(**process.parameters() | {first: 2 * getattr(process, first)})
    np.testing.assert_allclose(process.psd(-frequency), process.psd(frequency), rtol=1e-14)
    np.testing.assert_allclose(doubled.psd(frequency), 4 * process.psd(frequency), rtol=1e-13)
    np.testing.assert_allclose(doubled.allan_variance(frequency), 4 * process.allan_variance(frequency), rtol=1e-9)


@pytest.mark.parametrize("process", SAMPLED, ids=SAMPLED_NAMES)
def test_zero_density_is_silence(process):
    silent = type(process)(**process.parameters() | {fields(process)[0].name: 0.0})
    np.testing.assert_array_equal(silent.sample(conditions(50), stream(1)), np.zeros(50))


@pytest.mark.parametrize("process", SAMPLED, ids=SAMPLED_NAMES)
@pytest.mark.parametrize("count", [1, 2, 7, 100])
def test_a_sample_has_the_length_of_the_run(process, count):
    assert process.sample(conditions(count), stream(1)).shape == (count,)


def test_random_walk_variance_grows_by_the_driving_density_each_second():
    steps = np.diff(draws(RandomWalk(0.2), 400, 201, "steps"), axis=1)
    assert sharp_std(steps, 0.2 * np.sqrt(0.01))
    assert sharp_std(steps.sum(axis=1), 0.2 * np.sqrt(2.0))


def autocovariance(process, count, interval=0.01):
    """Covariance matrix of the samples of a process that has one."""
    lag = np.abs(np.subtract.outer(np.arange(count), np.arange(count)))
    time = interval * (1 + np.minimum.outer(np.arange(count), np.arange(count)))
    return {
        "white_noise": lambda p: p.density**2 / interval * (lag == 0),
        "random_walk": lambda p: p.density_k**2 * time,
        "gauss_markov": lambda p: p.std**2 * np.exp(-lag * interval / p.correlation_time),
        "random_telegraph": lambda p: p.step**2 / 4 * np.exp(-2 * p.rate * lag * interval),
        "uniform_noise": lambda p: p.density**2 / interval * (lag == 0),
        "skewed_noise": lambda p: p.density**2 / interval * (lag == 0),
        "common_mode": lambda p: (p.density * p.loading) ** 2 / interval * (lag == 0),
        "band_noise": lambda p: p.density**2 / interval * (lag == 0),  # the band is all that the samples can show
        "quantization": lambda p: (p.q / interval) ** 2 * (2.0 * (lag == 0) - (lag == 1)),
    }[process.name](process)


def sampled_spectral_integral(process, n, interval=0.01):
    """Allan variance from the sampled PSD: gain 2 sin^4(n u)/(n sin u)^2, u = pi f interval, lobe by lobe."""
    density = lambda u: float(process.sampled_psd(u / (np.pi * interval), interval))  # noqa: E731
    gain = lambda u: 2 * np.sin(n * u) ** 4 / (n * np.sin(u)) ** 2  # noqa: E731
    edges = np.linspace(0, np.pi / 2, n + 1)
    lobes = [quad(lambda u: density(u) * gain(u), a, b, epsabs=0, epsrel=1e-12)[0] for a, b in pairwise(edges)]
    return 2 * sum(lobes) / (np.pi * interval)


@pytest.mark.parametrize("process", SAMPLED, ids=SAMPLED_NAMES)
def test_samples_have_exactly_the_sampled_allan_variance(process):
    averaging = np.array([1, 2, 3, 7, 30])
    found = allan_variances(draws(process, 500, 600, "sampled"), averaging)
    assert mean_is(found, process.sampled_allan_variance(averaging, 0.01), share=0.03)


@pytest.mark.parametrize("process", SAMPLED, ids=SAMPLED_NAMES)
@pytest.mark.parametrize("band", [slice(8, 16), slice(100, 200), slice(300, 400), slice(480, 510)], ids=str)
def test_samples_have_exactly_the_sampled_spectrum_up_to_the_end(process, band):
    power, frequency = tapered_power(np.diff(draws(process, RUNS, 1025, "sampled psd"), axis=1))
    expected = process.sampled_psd(frequency[band], 0.01) * 4 * np.sin(np.pi * frequency[band] * 0.01) ** 2
    assert mean_is((power[:, band] / expected).mean(axis=1), 1.0, share=0.03)


@pytest.mark.parametrize("process", SAMPLED, ids=SAMPLED_NAMES)
@pytest.mark.parametrize("n", [1, 2, 5, 64, 500])
def test_sampled_allan_variance_is_the_integral_of_the_sampled_spectrum(process, n):
    assert process.sampled_allan_variance(n, 0.01) == pytest.approx(sampled_spectral_integral(process, n), rel=1e-9)


@pytest.mark.parametrize(
    "process", [p for p in SAMPLED if p.name not in ("bias_instability", "power_law")], ids=lambda p: p.name
)
@pytest.mark.parametrize("n", [1, 2, 5, 60])
def test_sampled_allan_variance_is_the_quadratic_form_of_the_covariance(process, n):
    weights = np.repeat([-1.0, 1.0], n) / n
    expected = weights @ autocovariance(process, 2 * n) @ weights / 2
    assert process.sampled_allan_variance(n, 0.01) == pytest.approx(expected, rel=1e-10)


STATIONARY = [process for process in SAMPLED if process.name not in ("random_walk", "bias_instability", "power_law")]


@pytest.mark.parametrize("process", STATIONARY, ids=lambda p: p.name)
def test_sampled_spectrum_integrates_to_the_variance_of_a_sample(process):
    power = 2 * quad(lambda f: float(process.sampled_psd(f, 0.01)), 0, 50, limit=200)[0]
    assert power == pytest.approx(autocovariance(process, 1)[0, 0], rel=1e-9)


@pytest.mark.parametrize(
    "process",
    [RandomWalk(0.2), GaussMarkov(0.7, 0.2), BiasInstability(0.4), FractionalFlicker(0.4)],
    ids=lambda p: type(p).__name__,
)
def test_sampled_allan_variance_tends_to_the_continuous_one_with_the_square_of_the_interval(process):
    excess = [process.sampled_allan_variance(n, 1.0 / n) - process.allan_variance(1.0) for n in (100, 200, 400)]
    assert abs(excess[0]) < 1e-3 * process.allan_variance(1.0)
    for coarse, fine in pairwise(excess):  # of flicker with log(n)/n^2
        assert 3.5 < coarse / fine < 4.05

from dataclasses import FrozenInstanceError, fields, replace
from itertools import pairwise, product
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.fft import irfft, rfft, rfftfreq
from scipy.integrate import quad
from scipy.linalg import toeplitz
from scipy.optimize import minimize_scalar
from scipy.signal import lfilter
from scipy.spatial.transform import Rotation
from scipy.stats import binom, chi2, norm

import imugap.effects
from imugap import log
from imugap.effects import (
    CATALOGUE,
    AdditiveEffect,
    Bias,
    BiasInstability,
    BiasStep,
    ClockScale,
    CommonMode,
    Conditions,
    GaussMarkov,
    GSensitivity,
    LeverArm,
    Misalignment,
    Outliers,
    OutputFilter,
    PowerLaw,
    Quantization,
    RandomTelegraph,
    RandomWalk,
    RateRamp,
    Resolution,
    SampleLoss,
    Saturation,
    ScaleFactor,
    Sinusoid,
    StabilityRestoration,
    StanceMotion,
    StochasticEffect,
    StuckSamples,
    Temperature,
    TimeOffset,
    TimestampJitter,
    TurnOnBias,
    VarianceChange,
    VibrationRectification,
    WarmUp,
    WhiteNoise,
)
from imugap.effects.bias_instability import FLOOR, FractionalFlicker
from imugap.effects.effect import AxisModel, SystematicEffect
from imugap.effects.gauss_markov import FLAT_TOP
from imugap.estimation import allan
from imugap.integrity.timestamps import stamps
from imugap.numerics.bias_stability import bias_stability
from imugap.stream import stream

PUBLISHED = pd.read_csv(
    Path(__file__).parents[1] / "reference" / "farrell2022_gauss_markov.csv", comment="#", index_col="quantity"
)
PROCESSES = (
    WhiteNoise(0.3),
    RandomWalk(0.2),
    GaussMarkov(0.7, 0.2),
    BiasInstability(0.4),
    RandomTelegraph(1.4, 2.5),
    CommonMode(0.3, -0.5),
    PowerLaw(0.4, 1.5),
)
NAMES = [process.name for process in PROCESSES]
SAMPLED = (*PROCESSES, Quantization(0.003))
"""All processes: quantization has a spectrum only once it is sampled."""
SAMPLED_NAMES = [process.name for process in SAMPLED]
RUNS = 330
EXAMPLES = {
    effect.name: effect
    for effect in (
        *SAMPLED,
        Bias(-0.3),
        TurnOnBias(0.2),
        RateRamp(-0.3),
        Sinusoid(3.0, 0.5, 1.0),
        Outliers(0.05, 2.0),
        BiasStep(0.2, -0.4),
        WarmUp(0.8, 0.1),
        Temperature(0.02, 24.0, 1e-3, -0.1),
        VarianceChange(0.1, 0.3, 4.0),
        StabilityRestoration(0.1, 0.05),
        OutputFilter(10.0, 3),
        Saturation(0.2),
        Resolution(0.05),
        StuckSamples(0.1, 3.0),
        SampleLoss(0.1, 3.0),
        TimestampJitter(1e-3),
        ClockScale(1.01),
        ScaleFactor(0.01, -0.02, 0.03),
        Misalignment(0.01, -0.02, 0.0),
        GSensitivity(1e-3, -2e-3, 3e-3),
        VibrationRectification(0.04),
        LeverArm(0.1, -0.2, 0.3),
        TimeOffset(2e-3),
        StanceMotion(0.01, -0.002),
    )
}
"""One of every effect, at home on gyro_z, accel_z or time."""


def conditions(count, interval=0.01, temperature=None):
    return Conditions(interval * np.arange(count), interval, temperature)


def motion(count, interval=0.01):
    """An error-free log of every axis at its own frequency, around its own mean."""
    time = interval * np.arange(count)
    phases = [2 * np.pi * (0.3 + 0.1 * k) * time + k for k in range(6)]
    columns = {axis: 0.3 * k + (1 + k) * np.sin(phases[k]) for k, axis in enumerate(log.AXES)}
    return log.from_samples(columns | {"temperature": 20 + 5 * time**2}, interval)


def moving(count, axis, interval=0.01):
    """Conditions of an axis under motion."""
    ideal = motion(count, interval)
    return Conditions(ideal.index.to_numpy(), interval, ideal["temperature"].to_numpy(), axis, ideal)


def draws(effect, runs, count, *labels, interval=0.01):
    """Sequences of an effect, shape (runs, count)."""
    at = conditions(count, interval)
    return np.array([effect.sample(at, stream(11, effect.name, *labels, run)) for run in range(runs)])


def published(quantity):
    """A published value with the tolerance that its digits leave."""
    row = PUBLISHED.loc[quantity]
    return pytest.approx(row["value"], abs=row["half_digit"])


def spectral_integral(psd, tau, periods=40):
    """Allan variance from the two-sided PSD (Farrell et al. 2022, eq. 16), u = pi f tau; sin^4 averages 3/8 far out."""
    density = lambda u: float(psd(u / (np.pi * tau)))  # noqa: E731
    lobes = [quad(lambda u: density(u) * np.sin(u) ** 4 / u**2, k * np.pi, (k + 1) * np.pi)[0] for k in range(periods)]
    tail = quad(lambda u: density(u) * 3 / 8 / u**2, periods * np.pi, np.inf)[0]
    return 4 / (np.pi * tau) * (sum(lobes) + tail)


def inside(variances, truth, power=0.03):
    """Whether the mean of independent estimates agrees with the truth; the estimate has to be sharp enough to tell."""
    error = variances.std(ddof=1) / np.sqrt(len(variances))
    assert error < power * truth
    return abs(variances.mean() - truth) < 4 * error


def sharp_std(samples, std, alpha=1e-4):
    """Whether independent zero-mean Gaussian samples have this standard deviation (chi-square, two-sided)."""
    low, high = chi2.ppf([alpha / 2, 1 - alpha / 2], samples.size)
    return low < np.sum(samples**2) / std**2 < high


@pytest.mark.parametrize("process", PROCESSES, ids=NAMES)
@pytest.mark.parametrize("tau", [1e-3, 0.05, 0.378, 4.0, 300.0])
def test_allan_variance_is_the_spectral_integral(process, tau):
    assert process.allan_variance(tau) == pytest.approx(spectral_integral(process.psd, tau), rel=2e-4)


@pytest.mark.parametrize("process", SAMPLED, ids=SAMPLED_NAMES)
@pytest.mark.parametrize("interval", [0.01, 0.005])
def test_sampled_sequences_have_the_allan_variance_of_the_closed_form(process, interval):
    averaging = np.array([16, 40, 100, 250])  # samples, or the sampled process is not the averaged one
    sequences = draws(process, RUNS, 4000, "allan", interval, interval=interval)
    found = np.array([allan.variance(sequence, averaging) for sequence in sequences])
    for column, tau in zip(found.T, averaging * interval, strict=True):
        assert inside(column, process.allan_variance(tau)), tau


@pytest.mark.parametrize("process", PROCESSES, ids=NAMES)
def test_sampled_sequences_have_the_spectrum(process):
    count, interval = 1024, 0.01
    steps = np.diff(draws(process, RUNS, count + 1, "psd"), axis=1)  # a difference is stationary, whatever the process
    taper = np.hanning(count)
    power = np.abs(np.fft.rfft(steps * taper)) ** 2 * interval / np.sum(taper**2)
    frequency = np.fft.rfftfreq(count, interval)
    for band in (slice(8, 16), slice(20, 40)):  # below a twelfth of the sampling rate: no aliasing to speak of
        expected = process.psd(frequency[band]) * 4 * np.sin(np.pi * frequency[band] * interval) ** 2
        assert inside((power[:, band] / expected).mean(axis=1), 1.0), band


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


@pytest.mark.parametrize("exponent", [0.1, 0.6, 1.0, 2.0, 2.4, 2.8, 3.0, 3.6])
@pytest.mark.parametrize("count", [600, 601])
def test_noise_of_any_slope_has_its_spectrum_down_to_the_slowest(exponent, count):
    """Differences of samples are stationary, or their differences are; where an Allan variance is, it is theirs."""
    law, averaging = PowerLaw(0.4, exponent), np.array([1, 7, 100])
    sequences = draws(law, 4000, count, exponent)
    order = 2 if exponent >= 3 else 1
    taper = np.hanning(count - order)
    power = np.abs(np.fft.rfft(np.diff(sequences, order, axis=1) * taper)) ** 2 * 0.01 / np.sum(taper**2)
    frequency = np.fft.rfftfreq(count - order, 0.01)
    for band in (slice(6, 12), slice(60, 90), slice(280, 295)):
        expected = law.sampled_psd(frequency[band], 0.01) * (2 * np.sin(np.pi * frequency[band] * 0.01)) ** (2 * order)
        assert inside((power[:, band] / expected).mean(axis=1), 1.0)
    theirs = law.sampled_allan_variance(averaging, 0.01)
    assert np.isinf(theirs).all() == (order == 2)
    if order == 1:
        found = np.array([allan.variance(sequence, averaging) for sequence in sequences])
        assert all(inside(column, expected) for column, expected in zip(found.T, theirs, strict=True))


@pytest.mark.parametrize(("process", "exponent"), [(FractionalFlicker(0.4), 1.0), (RandomWalk(0.4), 2.0)], ids=str)
def test_noise_of_a_slope_that_has_a_name_is_that(process, exponent):
    averaging, law = np.array([1, 8, 300]), PowerLaw(0.4, exponent)
    for interval in (0.01, 1.0):
        frequency = np.array([1e-4, 0.01, 0.5]) / interval
        np.testing.assert_allclose(law.sampled_psd(frequency, interval), process.sampled_psd(frequency, interval))
        theirs = process.sampled_allan_variance(averaging, interval)
        np.testing.assert_allclose(law.sampled_allan_variance(averaging, interval), theirs)


def test_flicker_floor_is_that_of_ieee_952():
    assert np.sqrt(BiasInstability(1.0).allan_variance(123.0)) == pytest.approx(0.664, abs=5e-4)


def test_flicker_is_no_periodic_sequence():
    sequences = draws(BiasInstability(1.0), RUNS, 512, "ends")
    ends = sequences[:, -1] - sequences[:, 0]
    steps = np.diff(sequences, axis=1)
    assert np.mean(ends**2) > 2 * np.mean(steps**2)


def test_random_walk_variance_grows_by_the_driving_density_each_second():
    steps = np.diff(draws(RandomWalk(0.2), 400, 201, "steps"), axis=1)
    assert sharp_std(steps, 0.2 * np.sqrt(0.01))
    assert sharp_std(steps.sum(axis=1), 0.2 * np.sqrt(2.0))


def test_gauss_markov_starts_stationary_and_stays_so():
    sequences = draws(GaussMarkov(0.7, 0.2), 3000, 60, "stationary")
    for k in (0, 1, 20, 59):
        assert sharp_std(sequences[:, k], 0.7), k


@pytest.mark.parametrize("lag", [1, 5, 20, 40])
def test_gauss_markov_correlation_decays_over_the_correlation_time(lag):
    sequences = draws(GaussMarkov(1.0, 0.2), 4000, 41, "lag")
    products = sequences[:, 0] * sequences[:, lag]
    error = products.std() / np.sqrt(len(products))
    assert abs(products.mean() - np.exp(-lag * 0.01 / 0.2)) < 4 * error


@pytest.mark.parametrize("x", [1e-3, 0.1, 1.0, 1.89, 8.0])
def test_gauss_markov_allan_variance_is_the_quadratic_form_of_the_autocovariance(x):
    half = 800
    covariance = toeplitz(0.49 * np.exp(-x / half * np.arange(2 * half)))
    weights = np.repeat([-1.0, 1.0], half) / half
    found = weights @ covariance @ weights / 2
    assert GaussMarkov(0.7, 1.0).allan_variance(x) == pytest.approx(found, rel=1e-4)


@pytest.mark.parametrize("x", [1e-9, 1e-6, 1e-3, 9.99e-3, 1.001e-2, 2e-2])
def test_gauss_markov_allan_variance_survives_cancellation(x):
    scaled = GaussMarkov(1.0, 1.0).allan_variance(x) / (2 * x / 3)
    assert scaled == pytest.approx(1 - 0.75 * x, abs=0.36 * x**2 + 1e-12)
    assert scaled > 1 - 0.75 * x or x < 1e-6


def test_gauss_markov_allan_variance_has_no_step_where_its_series_takes_over():
    x = 1e-2 * (1 + 1e-6 * np.arange(-3, 4))
    ratio = GaussMarkov(1.0, 1.0).allan_variance(x) / x
    np.testing.assert_allclose(ratio, np.polyval(np.polyfit(x, ratio, 1), x), rtol=2e-9)


def test_gauss_markov_slopes_are_those_of_a_walk_below_and_of_white_noise_above():
    process = GaussMarkov(0.7, 10.0)
    driving = process.driving_psd
    assert process.allan_variance(1e-4) == pytest.approx(RandomWalk(np.sqrt(driving)).allan_variance(1e-4), rel=1e-4)
    assert process.allan_variance(1e6) == pytest.approx(WhiteNoise(10 * np.sqrt(driving)).allan_variance(1e6), rel=1e-4)


def test_gauss_markov_flat_top_is_the_published_one():
    process = GaussMarkov(1.0, 1.0)
    top = minimize_scalar(lambda x: -process.allan_variance(x), bounds=(0.5, 5), method="bounded")
    assert top.x == published("flat_top_tau_over_T")
    assert np.sqrt(-top.fun / process.driving_psd) == published("flat_top_deviation_over_sqrt_SB_TB")
    assert published("flat_top_tau_over_T") == FLAT_TOP


def test_accelerometer_of_the_tutorial_has_its_published_gauss_markov_process():
    value = PUBLISHED["value"]
    time = value["accel_floor_tau"] / FLAT_TOP
    process = GaussMarkov(np.sqrt(value["accel_S_B"] * time / 2), time)
    assert time == published("accel_T_B")
    assert process.driving_psd == pytest.approx(value["accel_S_B"], rel=1e-12)
    assert np.sqrt(process.allan_variance(value["accel_floor_tau"])) == published("accel_floor")


@pytest.mark.parametrize("device", ["accel", "gyro_a", "gyro_b"])
def test_floors_of_the_tutorial_are_those_of_its_bias_instability(device):
    row = PUBLISHED.loc[f"{device}_B"]
    floors = [np.sqrt(BiasInstability(row["value"] + k * row["half_digit"]).allan_variance(1.0)) for k in (-1, 1)]
    assert floors[0] - PUBLISHED["half_digit"][f"{device}_floor"] < PUBLISHED["value"][f"{device}_floor"]
    assert floors[1] + PUBLISHED["half_digit"][f"{device}_floor"] > PUBLISHED["value"][f"{device}_floor"]
    assert PUBLISHED["value"][f"{device}_floor"] / FLOOR == pytest.approx(row["value"], rel=6e-3)


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


@given(st.lists(st.floats(-1e3, 1e3), min_size=1, max_size=20), st.floats(1e-3, 10))
def test_resolution_goes_to_the_nearest_point_of_the_lattice_and_stays_there(values, step):
    values = np.array(values)
    rounded = Resolution(step).apply(values, conditions(len(values)), stream(1))
    assert np.all(np.abs(rounded - values) <= step / 2 * (1 + 1e-9))
    np.testing.assert_allclose(rounded / step, np.rint(rounded / step), atol=1e-9)
    np.testing.assert_array_equal(Resolution(step).apply(rounded, conditions(len(values)), stream(1)), rounded)


def test_resolution_adds_the_variance_of_a_uniform_law():
    values = stream(3, "resolution").uniform(-50, 50, 20_000)
    errors = Resolution(0.4).apply(values, conditions(len(values)), stream(1)) - values
    assert inside(errors**2, 0.4**2 / 12)


@given(st.integers(30, 400), st.floats(1e-6, 1e3), st.floats(-10, 10))
def test_restoration_gives_the_sequence_its_stability_and_keeps_its_mean(count, stability, offset):
    sequence = offset + stream(5, count).standard_normal(count)
    restored = StabilityRestoration(stability, 0.1).apply(sequence, conditions(count), stream(1))
    assert bias_stability(restored, 0.01, 0.1) == pytest.approx(stability, rel=1e-9)
    assert restored.mean() == pytest.approx(sequence.mean(), abs=1e-9 * max(stability * 100, 10))


def test_restoration_of_a_constant_sequence_is_refused():
    with pytest.raises(ValueError, match="stability"):
        StabilityRestoration(1e-5, 1.0).apply(np.zeros(1000), conditions(1000), stream(1))


def test_catalogue_has_one_effect_per_file():
    files = {path.stem for path in Path(imugap.effects.__file__).parent.glob("*.py")} - {
        "__init__",
        "effect",
        "conditions",
        "residual",
    }
    assert set(CATALOGUE) == files
    assert all(name == effect.name for name, effect in CATALOGUE.items())
    assert set(EXAMPLES) == set(CATALOGUE)


@pytest.mark.parametrize("effect", CATALOGUE.values(), ids=CATALOGUE)
def test_every_parameter_says_its_unit_and_meaning(effect):
    units = effect.units("rad/s")
    assert set(units) == {item.name for item in fields(effect)}
    assert all(item.metadata["meaning"] for item in fields(effect))
    assert not any("{" in unit for unit in units.values())


@pytest.mark.parametrize("effect", CATALOGUE.values(), ids=CATALOGUE)
def test_every_parameter_refuses_what_is_no_number_within_its_limits(effect):
    valid = {item.name: 1.0 for item in fields(effect)}
    for item in fields(effect):
        low, high = item.metadata["low"], item.metadata["high"]
        outside = [low - 1, high + 1, *([1.5] if item.metadata["whole"] else [])]
        for bad in (np.nan, np.inf, -np.inf, *filter(np.isfinite, outside)):
            with pytest.raises(ValueError, match=rf"{effect.name}\.{item.name}: expected .* found {bad}"):
                effect(**valid | {item.name: bad})


@pytest.mark.parametrize("effect", CATALOGUE.values(), ids=CATALOGUE)
def test_an_effect_is_a_frozen_value(effect):
    values = {item.name: 1.0 for item in fields(effect)}
    assert effect(**values) == effect(**values)
    assert len({effect(**values), effect(**values)}) == 1
    with pytest.raises(FrozenInstanceError):
        setattr(effect(**values), fields(effect)[0].name, 2.0)


@pytest.mark.parametrize(
    "effect", [e for e in EXAMPLES.values() if isinstance(e, AdditiveEffect)], ids=lambda e: e.name
)
def test_an_additive_effect_adds_what_it_samples(effect):
    at = moving(40, "accel_z" if effect.name == "lever_arm" else "gyro_z")
    before = stream(2, "before").standard_normal(40)
    added = effect.apply(before, at, stream(2, "effect")) - before
    np.testing.assert_allclose(added, effect.sample(at, stream(2, "effect")), atol=1e-12)


def test_units_follow_the_axis():
    assert WhiteNoise.units("rad/s") == {"density": "rad/s/sqrt(Hz)"}
    assert GaussMarkov.units("m/s^2") == {"std": "m/s^2", "correlation_time": "s"}


def test_text_in_place_of_a_number_names_the_parameter():
    with pytest.raises(ValueError, match=r"white_noise\.density"):
        WhiteNoise("1e-4")


@pytest.mark.parametrize("process", [e for e in CATALOGUE.values() if issubclass(e, StochasticEffect)])
def test_stochastic_effects_are_all_put_to_the_test(process):
    assert process.name in SAMPLED_NAMES


def autocovariance(process, count, interval=0.01):
    """Covariance matrix of the samples of a process that has one."""
    lag = np.abs(np.subtract.outer(np.arange(count), np.arange(count)))
    time = interval * (1 + np.minimum.outer(np.arange(count), np.arange(count)))
    return {
        "white_noise": lambda p: p.density**2 / interval * (lag == 0),
        "random_walk": lambda p: p.density_k**2 * time,
        "gauss_markov": lambda p: p.std**2 * np.exp(-lag * interval / p.correlation_time),
        "random_telegraph": lambda p: p.step**2 / 4 * np.exp(-2 * p.rate * lag * interval),
        "common_mode": lambda p: (p.density * p.loading) ** 2 / interval * (lag == 0),
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
    found = np.array([allan.variance(sequence, averaging) for sequence in draws(process, 500, 600, "sampled")])
    for column, expected in zip(found.T, process.sampled_allan_variance(averaging, 0.01), strict=True):
        assert inside(column, expected)


@pytest.mark.parametrize("process", SAMPLED, ids=SAMPLED_NAMES)
@pytest.mark.parametrize("band", [slice(8, 16), slice(100, 200), slice(300, 400), slice(480, 510)], ids=str)
def test_samples_have_exactly_the_sampled_spectrum_up_to_the_end(process, band):
    count, interval = 1024, 0.01
    steps = np.diff(draws(process, RUNS, count + 1, "sampled psd"), axis=1)
    taper = np.hanning(count)
    power = np.abs(np.fft.rfft(steps * taper)) ** 2 * interval / np.sum(taper**2)
    frequency = np.fft.rfftfreq(count, interval)[band]
    expected = process.sampled_psd(frequency, interval) * 4 * np.sin(np.pi * frequency * interval) ** 2
    assert inside((power[:, band] / expected).mean(axis=1), 1.0)


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


@pytest.mark.parametrize("n", [1, 3, 1000])
@pytest.mark.parametrize("ratio", [1e-12, 1e-9, 1e-5])
def test_sampled_gauss_markov_survives_cancellation_where_it_is_a_random_walk(n, ratio):
    process = GaussMarkov(1.0, 0.01 / ratio)
    walk = RandomWalk(np.sqrt(process.driving_psd))
    expected = pytest.approx(walk.sampled_allan_variance(n, 0.01), rel=2 * n * ratio + 1e-12)
    assert process.sampled_allan_variance(n, 0.01) == expected


def test_sampled_gauss_markov_has_no_step_where_its_series_take_over():
    shorter, longer = (GaussMarkov(1.0, 0.02 * (1 + k * 1e-13)) for k in (-1, 1))
    for averaging in (np.array([1]), np.array([2, 7])):
        found = [process.sampled_allan_variance(averaging, 0.01) for process in (shorter, longer)]
        np.testing.assert_allclose(*found, rtol=2e-12)


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
    found = np.mean([allan.variance(run, n) for run in draws(process, RUNS, 1024, "fractional")], axis=0)
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


def test_quantization_is_what_rounding_of_the_angle_does_to_the_rate():
    lsb, rng = 1e-3, stream(7, "angle")
    rate = 0.5 + rng.standard_normal((200, 500))
    angle = np.cumsum(rate, axis=1) * 0.01
    rounded = np.rint(angle / lsb) * lsb
    errors = np.diff(rounded - angle, axis=1) / 0.01
    process = Quantization(lsb / np.sqrt(12))
    for n in (1, 4, 50):
        found = np.array([allan.variance(sequence, np.array([n]))[0] for sequence in errors])
        assert inside(found, process.sampled_allan_variance(n, 0.01)), n
    assert np.abs(process.sample(conditions(1000), stream(7, "bound"))).max() <= lsb / 0.01


def test_quantization_has_the_slope_and_gain_of_ieee_952():
    tau = np.array([1.0, 10.0])
    np.testing.assert_allclose(np.sqrt(Quantization(2.0).allan_variance(tau)), np.sqrt(3) * 2.0 / tau, rtol=1e-14)


def test_quantization_has_no_spectrum_without_an_interval():
    with pytest.raises(NotImplementedError, match="expected a sampling interval"):
        Quantization(1.0).psd(np.ones(2))


def test_ramp_has_the_allan_variance_of_ieee_952_at_every_averaging_time():
    ramp, averaging = RateRamp(-0.3), np.array([1, 2, 17, 400])
    sequence = ramp.sample(conditions(1000), stream(1))
    assert sequence[-1] == pytest.approx(-0.3 * 9.99)
    np.testing.assert_allclose(allan.variance(sequence, averaging), (0.3 * averaging * 0.01) ** 2 / 2, rtol=1e-8)
    np.testing.assert_allclose(ramp.sampled_allan_variance(averaging, 0.01), ramp.allan_variance(averaging * 0.01))


def test_a_model_sums_what_its_effects_say_of_their_samples():
    ramp = RateRamp(0.1)
    model = AxisModel((*SAMPLED, ramp, Bias(1.0), Resolution(0.1)))
    averaging, frequency = np.array([1, 8, 64]), np.array([0.1, 1.0, 50.0])
    expected = sum(effect.sampled_allan_variance(averaging, 0.01) for effect in (*SAMPLED, ramp))
    np.testing.assert_allclose(model.sampled_allan_variance(averaging, 0.01), expected, rtol=1e-13)
    expected = sum(effect.sampled_psd(frequency, 0.01) for effect in SAMPLED)
    np.testing.assert_allclose(model.sampled_psd(frequency, 0.01), expected, rtol=1e-13)


def shares(hits, probability, alpha=1e-4):
    """Whether the share of independent hits agrees with their probability, two-sided."""
    low, high = binom.ppf([alpha / 2, 1 - alpha / 2], hits.size, probability)
    return low <= hits.sum() <= high


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


def test_telegraph_has_two_values_and_starts_at_either():
    sequences = draws(RandomTelegraph(1.4, 2.5), 4000, 3, "values")
    assert set(np.unique(sequences)) == {-0.7, 0.7}
    assert shares(sequences[:, 0] > 0, 0.5)


def test_telegraph_switches_between_uneven_stamps_as_a_poisson_process_does():
    time = np.array([0.0, 0.01, 0.3, 0.5, 4.0])
    at = Conditions(time, 0.01)
    process = RandomTelegraph(2.0, 2.5)
    signs = np.array([process.sample(at, stream(11, "uneven", run)) for run in range(8000)])
    for k, gap in enumerate(np.diff(time)):
        assert shares(signs[:, k] != signs[:, k + 1], (1 - np.exp(-2 * 2.5 * gap)) / 2), gap


def test_telegraph_is_no_gaussian_process_and_has_no_state_space():
    with pytest.raises(ValueError, match="random_telegraph: expected a process with a state space"):
        RandomTelegraph(1.0, 1.0).state_space()


def test_outliers_come_with_their_probability_and_deviation():
    sequence = Outliers(0.05, 2.0).sample(conditions(100_000), stream(11, "outliers"))
    hit = sequence != 0
    assert shares(hit, 0.05)
    assert sharp_std(sequence[hit], 2.0)
    squares = np.square(sequence)
    assert inside(squares, 0.05 * 2.0**2)


@pytest.mark.parametrize("probability", [0.0, 1.0])
def test_outliers_at_the_limits_of_their_probability(probability):
    hit = Outliers(probability, 1.0).sample(conditions(100), stream(1)) != 0
    assert np.all(hit == (probability == 1))


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


def test_variance_change_scales_the_white_noise_and_nothing_else():
    at = conditions(12_000)
    slow = GaussMarkov(7.0, 0.2) + Bias(4.0)
    model = slow + WhiteNoise(0.3) + VarianceChange(40.0, 80.0, 4.0)
    noise = model.simulate(np.zeros(12_000), at, 1) - slow.simulate(np.zeros(12_000), at, 1)
    assert sharp_std(noise[4000:8000], 2 * 0.3 / np.sqrt(0.01))
    assert sharp_std(np.r_[noise[:4000], noise[8000:]], 0.3 / np.sqrt(0.01))


def test_variance_change_includes_its_begin_and_not_its_end():
    at = Conditions(np.array([0.0, 1.0, 2.0, 3.0]), 1.0)
    np.testing.assert_array_equal(VarianceChange(1.0, 3.0, 4.0).apply(np.ones(4), at, stream(1)), [1, 2, 2, 1])


def test_a_change_that_ends_before_it_begins_is_refused():
    with pytest.raises(ValueError, match=r"variance_change\.stop: expected a time >= start = 2\.0; found 1\.0"):
        VarianceChange(2.0, 1.0, 4.0)


def test_common_mode_takes_its_loading_with_the_sign():
    one, other = (CommonMode(0.3, loading).sample(conditions(50), stream(1)) for loading in (1.0, -2.0))
    np.testing.assert_allclose(other, -2 * one, rtol=1e-14)


def test_common_mode_is_white_noise_to_a_filter_of_one_axis():
    assert CommonMode(0.3, -0.5).state_space().output_psd == pytest.approx(0.15**2)


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
    np.testing.assert_allclose(
        OutputFilter(cutoff, 1, 1).apply(values, conditions(500), stream(1)),
        lfilter([weight], [1, weight - 1], values, zi=[(1 - weight) * values[0]])[0],
        rtol=1e-9,
    )


@pytest.mark.parametrize("order", [1, 4])
def test_filter_colours_white_noise_by_its_gain(order):
    count, interval, noise, effect = 1024, 0.01, WhiteNoise(0.3), OutputFilter(10.0, order)
    at, taper = conditions(count, interval), np.hanning(count)
    white = draws(noise, RUNS, count, "filter", order, interval=interval)
    power = np.abs(np.fft.rfft([effect.apply(one, at, stream(1)) * taper for one in white])) ** 2
    frequency = np.fft.rfftfreq(count, interval)
    for band in (slice(8, 40), slice(95, 110), slice(180, 220)):
        expected = noise.sampled_psd(frequency[band], interval) * effect.gain(frequency[band], interval)
        relative = power[:, band] * interval / np.sum(taper**2) / expected
        assert inside(relative.mean(axis=1), 1.0), band


def test_filter_starts_in_its_steady_state():
    np.testing.assert_allclose(
        OutputFilter(3.0, 4).apply(np.full(200, 9.8), conditions(200), stream(1)), 9.8, rtol=1e-9
    )


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


def test_saturation_puts_the_tails_on_its_limits_and_leaves_the_rest():
    values = stream(11, "saturation").standard_normal(50_000)
    clipped = Saturation(1.5).apply(values, conditions(len(values)), stream(1))
    assert shares(clipped == 1.5, norm.sf(1.5))
    assert shares(clipped == -1.5, norm.sf(1.5))
    within = np.abs(values) < 1.5
    np.testing.assert_array_equal(clipped[within], values[within])
    variance = 1 - 2 * (1.5 * norm.pdf(1.5) + norm.sf(1.5)) + 2 * 1.5**2 * norm.sf(1.5)
    assert inside(clipped**2, variance)


def test_stuck_samples_repeat_the_last_value_for_their_length():
    values = stream(11, "stuck").standard_normal(100_000)
    stuck = StuckSamples(0.02, 5.0).apply(values, conditions(len(values)), stream(12, "stuck"))
    repeated = np.r_[False, np.diff(stuck) == 0]
    np.testing.assert_array_equal(stuck[~repeated], values[~repeated])
    begins = repeated[1:] & ~repeated[:-1]
    assert shares(begins[~repeated[:-1]], 0.02)
    assert shares(~repeated[1:][repeated[:-1]], 1 / 5.0)


def test_certainly_stuck_samples_repeat_every_other_value():
    stuck = StuckSamples(1.0, 1.0).apply(np.arange(5.0), conditions(5), stream(1))
    np.testing.assert_array_equal(stuck, [0, 0, 2, 2, 4])


def test_lost_samples_leave_the_others_with_their_stamps():
    table = motion(20_000)
    kept = SampleLoss(0.02, 5.0).keep(table, stream(11, "loss"))
    assert kept.equals(table.loc[kept.index])
    steps = np.rint(np.diff(kept.index) / 0.01)
    assert shares(steps > 1, 0.02)
    gaps = steps[steps > 1] - 1
    error = np.sqrt(5.0 * 4.0 / len(gaps))
    assert abs(gaps.mean() - 5.0) < 4 * error


def test_a_loss_that_leaves_no_log_is_refused():
    with pytest.raises(ValueError, match="sample_loss: expected at least 2 samples that are left; found 1"):
        SampleLoss(1.0, 1e9).keep(motion(50), stream(11, "nothing"))


def test_jitter_displaces_stamps_by_its_deviation_and_no_sample():
    table = motion(5000)
    kept = TimestampJitter(5e-4).keep(table, stream(11, "jitter"))
    assert sharp_std(kept.index.to_numpy() - table.index.to_numpy(), 5e-4)
    np.testing.assert_array_equal(kept.to_numpy(), table.to_numpy())
    assert log.check(kept) is kept


@pytest.mark.parametrize("share", [0.002, 0.3])
def test_the_interval_of_a_jitter_in_ticks_holds_its_deviation(share):
    """A share of the stamps is a tick early or late: the fewer, the less is known of the deviation."""
    tick, held = 1e-4, 0
    for run in range(200):
        rng = stream(12, "ticks", run)
        ticks = rng.choice([-1, 0, 1], size=5000, p=[share / 2, 1 - share, share / 2])
        found = TimestampJitter.found(stamps(np.arange(5000) / 97.3 + tick * ticks))
        low, high = found.intervals["std"]
        held += low <= tick * np.sqrt(share) <= high
    assert binom.ppf(0.001, 200, 0.91) <= held < 200


@pytest.mark.parametrize("std", [0.01, 1.0])
def test_jitter_beyond_the_interval_keeps_the_order(std):
    kept = TimestampJitter(std).keep(motion(2000), stream(11, "order"))
    assert np.all(np.diff(kept.index) > 0)
    assert kept.index.name == "time"


class Still:
    """A source of "random" numbers that puts two stamps on the same place."""

    def standard_normal(self, count):
        return np.r_[1.0, 0.0, np.zeros(count - 2)]


def test_jitter_parts_stamps_that_coincide():
    table = log.from_samples({"gyro_x": np.arange(4.0)}, 1.0)
    kept = TimestampJitter(1.0).keep(table, Still())
    np.testing.assert_array_equal(kept.index, [1.0, np.nextafter(1.0, 2.0), 2.0, 3.0])


def test_clock_scale_multiplies_the_stamps_and_touches_no_sample():
    table = motion(100)
    kept = ClockScale(1.01).keep(table, stream(1))
    assert log.rate(kept) == pytest.approx(100 / 1.01)
    np.testing.assert_array_equal(kept.to_numpy(), table.to_numpy())
    assert kept.index.name == "time"


def test_samples_lost_on_one_axis_have_no_value():
    values = AxisModel((SampleLoss(0.1, 2.0),)).simulate(np.zeros(20_000), conditions(20_000), 1)
    share = 0.1 / (0.1 + 1 / 2.0)
    assert np.isnan(values).mean() == pytest.approx(share, abs=4 * np.sqrt(3 * share / 20_000))
    assert not values[~np.isnan(values)].any()


@pytest.mark.parametrize("effect", [TimestampJitter(0.1), ClockScale(1.1)], ids=lambda e: e.name)
def test_an_effect_of_the_clock_refuses_a_sequence(effect):
    with pytest.raises(ValueError, match=rf"{effect.name}: expected a whole log"):
        AxisModel((effect,)).simulate(np.zeros(9), conditions(9), 1)


def held(axis, **values):
    """Conditions of an axis under constant inputs."""
    columns = {name: np.full(200, values.get(name, 0.0)) for name in log.AXES}
    ideal = log.from_samples(columns, 0.01)
    return Conditions(ideal.index.to_numpy(), 0.01, None, axis, ideal)


@pytest.mark.parametrize(("u", "expected"), [(2.0, 0.02 + 0.06 + 0.4), (-2.0, -0.02 + 0.06 + 0.4), (0.0, 0.0)])
def test_scale_factor_depends_on_the_own_input(u, expected):
    sequence = ScaleFactor(0.01, 0.03, 0.1).sample(held("gyro_y", gyro_y=u, gyro_x=5.0), stream(1))
    np.testing.assert_allclose(sequence, expected, rtol=1e-12, atol=1e-15)


def test_misalignment_takes_its_share_of_the_other_axes_of_the_triad():
    at = held("accel_y", accel_x=1.0, accel_y=50.0, accel_z=2.0, gyro_x=100.0)
    np.testing.assert_allclose(Misalignment(x=0.01, z=-0.02).sample(at, stream(1)), 0.01 - 0.04, rtol=1e-12)


def test_misalignment_to_the_own_axis_is_refused():
    with pytest.raises(ValueError, match=r"misalignment\.x: expected 0 on its own axis gyro_x; found 0\.1"):
        Misalignment(x=0.1).sample(held("gyro_x"), stream(1))


def test_misalignment_needs_only_the_axes_that_it_leans_to():
    ideal = log.from_samples({"gyro_x": np.zeros(5), "gyro_y": np.ones(5)}, 0.01)
    at = Conditions(ideal.index.to_numpy(), 0.01, None, "gyro_x", ideal)
    np.testing.assert_allclose(Misalignment(y=0.1).sample(at, stream(1)), 0.1)
    np.testing.assert_array_equal(Misalignment().sample(at, stream(1)), np.zeros(5))
    with pytest.raises(ValueError, match="misalignment: expected an error-free log with gyro_z; found none"):
        Misalignment(z=0.1).sample(at, stream(1))


def test_g_sensitivity_is_linear_in_the_specific_force():
    at = held("gyro_x", accel_x=1.0, accel_y=2.0, accel_z=-9.8)
    expected = 1e-3 - 2e-3 * 2 - 3e-3 * 9.8
    np.testing.assert_allclose(GSensitivity(1e-3, -2e-3, 3e-3).sample(at, stream(1)), expected, rtol=1e-12)


def test_vibration_rectification_is_the_coefficient_times_the_power_of_the_vibration():
    runs, count, std = 200, 401, np.array([0.5, 1.0, 2.0])
    found = np.empty((runs, count))
    for run in range(runs):
        force = std * stream(11, "vibration", run).standard_normal((count, 3)) + [0.0, 3.0, -9.8]
        ideal = log.from_samples(dict(zip(log.ACCEL, force.T, strict=True)), 0.01)
        at = Conditions(ideal.index.to_numpy(), 0.01, None, "accel_z", ideal)
        found[run] = VibrationRectification(0.04).sample(at, stream(1))
    expected = 0.04 * np.sum(std**2)
    assert inside(found[:, 200], expected * 100 / 101)  # centred: 50 samples on either side
    assert inside(found[:, 0], expected * 50 / 51)
    assert inside(found[:, -1], expected * 50 / 51)


def test_vibration_rectification_of_a_shock_lasts_for_its_window():
    shock = np.zeros(9)
    shock[4] = 1.0
    ideal = log.from_samples({"accel_x": shock, "accel_y": np.zeros(9), "accel_z": np.full(9, -9.8)}, 0.25)
    sequence = VibrationRectification(1.0).sample(
        Conditions(ideal.index.to_numpy(), 0.25, None, "gyro_x", ideal), stream(1)
    )
    np.testing.assert_allclose(sequence, [0, 0, *[0.2 * 0.8] * 5, 0, 0], atol=1e-12)


def test_vibration_rectification_of_the_own_component_knows_no_other():
    at = moving(400, "accel_y")
    alone = at.ideal.assign(accel_x=0.0, accel_z=-9.8)
    own = VibrationRectification(0.04, own=1).sample(at, stream(1))
    np.testing.assert_allclose(own, VibrationRectification(0.04).sample(replace(at, ideal=alone), stream(1)))


def test_motion_slower_than_the_window_is_no_vibration():
    at = moving(400, "accel_y")
    buzz = stream(11, "buzz").standard_normal(400)
    shaken = replace(at, ideal=at.ideal.assign(accel_y=at.ideal["accel_y"] + buzz))
    still = replace(at, ideal=at.ideal.assign(accel_y=buzz))
    short = VibrationRectification(1.0, window=0.05, own=1)
    np.testing.assert_allclose(short.sample(shaken, stream(1)), short.sample(still, stream(1)), rtol=0.25)


def test_vibration_rectification_of_a_constant_force_is_zero():
    np.testing.assert_allclose(
        VibrationRectification(1.0).sample(held("gyro_x", accel_z=-9.8), stream(1)), 0, atol=1e-12
    )


def test_lever_arm_is_the_acceleration_of_the_point_that_turns_with_the_body():
    interval, axis, arm = 1e-3, np.array([1.0, -2.0, 2.0]) / 3, np.array([0.1, -0.2, 0.3])
    time = interval * np.arange(2000)
    angle = 0.8 * np.sin(3 * time)
    rate = 0.8 * 3 * np.cos(3 * time)[:, None] * axis
    turns = Rotation.from_rotvec(angle[:, None] * axis)
    acceleration = np.gradient(np.gradient(turns.apply(arm), time, axis=0), time, axis=0)
    expected = turns.inv().apply(acceleration)
    columns = dict(zip(log.GYRO, rate.T, strict=True)) | {name: np.zeros(len(time)) for name in log.ACCEL}
    ideal = log.from_samples(columns, interval)
    for k, name in enumerate(log.ACCEL):
        at = Conditions(time, interval, None, name, ideal)
        found = LeverArm(*arm).sample(at, stream(1))
        np.testing.assert_allclose(found[5:-5], expected[5:-5, k], atol=1e-4)


def test_lever_arm_on_a_turntable_is_centripetal():
    sampled = {name: LeverArm(0.2, 0.0, 0.1).sample(held(name, gyro_z=3.0), stream(1)) for name in log.ACCEL}
    np.testing.assert_allclose(sampled["accel_x"], -(3.0**2) * 0.2, rtol=1e-12)
    np.testing.assert_allclose(sampled["accel_y"], 0.0, atol=1e-14)
    np.testing.assert_allclose(sampled["accel_z"], 0.0, atol=1e-14)


@pytest.mark.parametrize("offset", [0.0034, -0.0127])
def test_time_offset_delays_the_input(offset):
    at = moving(1000, "gyro_y")
    moved = TimeOffset(offset).sample(at, stream(1)) + at.ideal["gyro_y"].to_numpy()
    expected = 0.3 + 2 * np.sin(2 * np.pi * 0.4 * (at.time - offset) + 1)
    np.testing.assert_allclose(moved[5:-5], expected[5:-5], atol=1e-6)


def test_time_offset_of_whole_samples_shifts_and_holds_the_end():
    at = moving(50, "accel_x")
    input = at.ideal["accel_x"].to_numpy()
    late = TimeOffset(0.03).sample(at, stream(1)) + input
    np.testing.assert_allclose(late, np.r_[np.full(3, input[0]), input[:-3]], atol=1e-9)
    early = TimeOffset(-0.03).sample(at, stream(1)) + input
    np.testing.assert_allclose(early, np.r_[input[3:], np.full(3, input[-1])], atol=1e-9)


SYSTEMATIC = [effect for effect in EXAMPLES.values() if isinstance(effect, SystematicEffect)]
STEP_SHARE = 1e-5


@pytest.mark.parametrize("effect", SYSTEMATIC, ids=lambda effect: effect.name)
def test_slopes_are_the_limits_of_difference_quotients(effect):
    at = moving(400, "accel_z" if effect.name == "lever_arm" else "gyro_z")
    for name, slope in effect.slopes(at).items():
        value = getattr(effect, name)
        step = STEP_SHARE * abs(value)
        ends = [replace(effect, **{name: value + side * step}).sample(at, None) for side in (1, -1)]
        quotient = (ends[0] - ends[1]) / (2 * step)
        np.testing.assert_allclose(slope, quotient, rtol=1e-6, atol=1e-6 * np.abs(slope).max(), err_msg=name)


def test_systematic_effects_are_all_put_to_the_test():
    assert {type(effect) for effect in SYSTEMATIC} == {
        kind for kind in CATALOGUE.values() if issubclass(kind, SystematicEffect)
    }


def test_misalignment_has_no_slope_to_its_own_axis():
    assert set(Misalignment().slopes(moving(9, "accel_y"))) == {"x", "z"}


def test_a_delay_has_no_slope_where_the_input_is_held():
    slope = TimeOffset(0.03).slopes(moving(50, "accel_x"))["offset"]
    np.testing.assert_array_equal(slope[:3], 0.0)
    assert np.all(slope[3:] != 0)


def test_stance_motion_leaves_the_log_alone():
    values = stream(1).standard_normal(9)
    np.testing.assert_array_equal(StanceMotion(0.1, 0.2).apply(values, conditions(9), stream(1)), values)


MOVED = (
    ScaleFactor(0.1),
    Misalignment(x=0.1),
    GSensitivity(0.1, 0.1, 0.1),
    LeverArm(0.1, 0.1, 0.1),
    TimeOffset(0.1),
)


@pytest.mark.parametrize("effect", MOVED, ids=lambda effect: effect.name)
def test_an_effect_of_the_input_says_what_it_misses(effect):
    axis = "accel_z" if effect.name == "lever_arm" else "gyro_z"
    with pytest.raises(ValueError, match=rf"{effect.name}: expected conditions with an axis; found none"):
        effect.sample(conditions(9), stream(1))
    with pytest.raises(ValueError, match=rf"{effect.name}: expected conditions with an error-free log; found none"):
        effect.sample(Conditions(np.arange(9.0), 1.0, None, axis), stream(1))
    poor = log.from_samples({"accel_y": np.zeros(9)}, 1.0)
    with pytest.raises(ValueError, match=rf"{effect.name}: expected an error-free log with .*; found none"):
        effect.sample(Conditions(np.arange(9.0), 1.0, None, axis, poor), stream(1))


def test_vibration_rectification_needs_all_three_components():
    poor = log.from_samples({"accel_x": np.zeros(9), "accel_y": np.zeros(9)}, 1.0)
    with pytest.raises(
        ValueError, match="vibration_rectification: expected an error-free log with accel_z; found none"
    ):
        VibrationRectification(1.0).sample(Conditions(np.arange(9.0), 1.0, None, "gyro_x", poor), stream(1))


@pytest.mark.parametrize("axis", ["accel_x", "time"])
def test_g_sensitivity_is_one_of_gyroscopes(axis):
    with pytest.raises(ValueError, match=rf"g_sensitivity: expected one of gyro_x, gyro_y, gyro_z; found {axis}"):
        GSensitivity(0.0, 0.0, 0.0).check_axis(axis)


@pytest.mark.parametrize("axis", ["gyro_x", "time"])
def test_lever_arm_is_one_of_accelerometers(axis):
    with pytest.raises(ValueError, match=rf"lever_arm: expected one of accel_x, accel_y, accel_z; found {axis}"):
        LeverArm(0.0, 0.0, 0.0).check_axis(axis)


def test_samples_lost_on_one_axis_are_nan_there():
    kept = SampleLoss(0.1, 3.0).apply(np.ones(20_000), conditions(20_000), stream(8, "lost"))
    assert np.isnan(kept).mean() == pytest.approx(0.1 / (0.1 + 1 / 3), rel=0.1)
    assert np.all(kept[np.isfinite(kept)] == 1.0)


def test_no_effect_is_found_in_plain_noise_and_each_in_its_own():
    noise, at = stream(8, "noise").standard_normal(5000), conditions(5000)
    for effect in (Resolution(0.2), Saturation(2.0), StuckSamples(0.01, 3.0)):
        assert type(effect).found(noise, at) is None
        found = type(effect).found(effect.apply(noise, at, stream(8, effect.name)), at)
        for name, value in effect.parameters().items():
            low, high = found.intervals[name]
            assert low < value < high, (effect, name)


def test_two_samples_of_no_lattice_at_one_extreme_are_a_full_scale():
    """Equal to the last digit at two times; rounded to a lattice, two of many tell nothing."""
    noise, at = stream(8, "noise").standard_normal(5000), conditions(5000)
    clipped = np.minimum(noise, np.sort(noise)[-2])
    assert Saturation.found(clipped, at).effect.limit == clipped.max()
    assert Saturation.found(np.round(clipped, 2), at) is None


def test_a_single_flat_top_is_a_full_scale_and_a_flat_slope_is_stuck():
    """A smooth motion that is clipped once, and one whose output sticks on its way up."""
    time = np.arange(20_000) * 0.01
    motion = np.sin(0.2 * time) + 0.3 * np.sin(1.3 * time) + 1e-3 * stream(12, "flat").standard_normal(len(time))
    clipped = np.minimum(motion, np.sort(motion)[-6])
    stuck = motion.copy()
    stuck[5001:5006] = stuck[5000]
    place = conditions(len(time))
    assert Saturation.found(clipped, place).effect.limit == clipped.max()
    assert Saturation.found(stuck, place) is None
    assert StuckSamples.found(stuck, place) is not None


@pytest.mark.parametrize("sign", [1, -1])
def test_a_full_scale_that_one_side_shows_holds_where_the_other_reaches_it_once(sign):
    """A smooth motion with several peaks above the full scale, and a single one below it, which could be stuck."""
    time = np.arange(20_000) * 0.01
    noise = 1e-3 * stream(12, "flat").standard_normal(len(time))
    motion = 0.35 + np.sin(0.35 * time) - 0.8 * np.exp(-(((time - 100.0) / 3) ** 2)) + noise
    clipped = sign * np.clip(motion, -0.7, 0.7)
    found = Saturation.found(clipped, conditions(len(time)))
    np.testing.assert_array_equal(found.flawed, np.abs(clipped) == 0.7)
    below = np.flatnonzero(sign * clipped == -0.7)
    assert len(below) > 5
    assert np.ptp(below) == len(below) - 1


def test_equal_ends_on_both_sides_are_a_full_scale():
    """One stay at either end, each of which alone could be stuck; at two places one magnitude to the last digit."""
    time = np.arange(20_000) * 0.01
    noise = 1e-3 * stream(12, "flat").standard_normal(len(time))
    swing = np.sin(0.11 * time) * np.where(np.abs(time - 100) < 55, 1.0, 0.5) + noise
    found = Saturation.found(np.clip(swing, -0.999, 0.999), conditions(len(time)))
    assert found.effect.limit == 0.999
    assert {-0.999, 0.999} == set(np.clip(swing, -0.999, 0.999)[found.flawed])


@pytest.mark.parametrize("effects", [(), (ScaleFactor(0.02, -0.01, 0.01),)])
def test_one_sample_that_falls_short_of_a_known_motion_is_clipped_and_a_lone_outlier_is_not(effects):
    """A motion so rough that a single sample is beyond the full scale, by a sixth of the input."""
    count = 6000
    rough = stream(13, "rough").standard_normal(count)
    largest = int(np.argmax(np.abs(rough)))
    rough[largest] *= 1.2
    ideal = log.from_samples({"gyro_z": rough}, 0.01)
    place = Conditions(ideal.index.to_numpy(), 0.01, None, "gyro_z", ideal)
    values = AxisModel((WhiteNoise(1e-4), *effects)).simulate(rough, place, 1, "short")
    assert Saturation.found(values, place) is None
    clipped = np.clip(values, *(side * 0.85 * abs(values[largest]) for side in (-1, 1)))
    found = Saturation.found(clipped, place)
    assert np.flatnonzero(found.flawed) == [largest]
    assert found.effect.limit == np.abs(clipped).max()
    assert found.log_p < np.log(1e-4)
    for where in (largest - 1, int(np.argsort(np.abs(rough))[-2])):
        outlier = values.copy()
        outlier[where] -= 0.1 * np.sign(rough[where])
        assert Saturation.found(outlier, place) is None


@pytest.mark.parametrize("place", [0.0, 0.2, 0.5])
@pytest.mark.parametrize("step", [0.3, 1.0, 2.0, 3.0])
def test_rounded_normal_values_tell_mean_and_deviation_of_those_ahead(step, place):
    lattice, mean, std, count = Resolution(step), (7 + place) * step, 1.0, 200_000
    rounded = step * np.rint((mean + std * stream(9, "rounded", step, place).standard_normal(count)) / step)
    expected = lattice.moments(mean, std)
    assert rounded.mean() == pytest.approx(expected[0], abs=5 * np.sqrt(expected[1] / count))
    assert rounded.var() == pytest.approx(expected[1], rel=0.02)
    assert lattice.mean_ahead(expected[0], std) == pytest.approx(mean, abs=1e-6 * step)
    assert lattice.std_ahead(*expected) == pytest.approx(std, rel=0.02)

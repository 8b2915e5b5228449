from dataclasses import FrozenInstanceError, fields
from itertools import pairwise
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.linalg import toeplitz
from scipy.optimize import minimize_scalar
from scipy.stats import chi2

import imugap.effects
from imugap import allan, log
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
from imugap.effects.bias_instability import FLOOR
from imugap.effects.gauss_markov import FLAT_TOP
from imugap.model import AxisModel
from imugap.stability import bias_stability
from imugap.stream import stream

PUBLISHED = pd.read_csv(
    Path(__file__).parent / "reference" / "farrell2022_gauss_markov.csv", comment="#", index_col="quantity"
)
PROCESSES = (
    WhiteNoise(0.3),
    RandomWalk(0.2),
    GaussMarkov(0.7, 0.2),
    BiasInstability(0.4),
    RandomTelegraph(1.4, 2.5),
    CommonMode(0.3, -0.5),
)
NAMES = [process.name for process in PROCESSES]
SAMPLED = (*PROCESSES, Quantization(0.003))
"""All processes: quantization has a spectrum only once it is sampled."""
SAMPLED_NAMES = [process.name for process in SAMPLED]
RUNS = 300
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
    files = {path.stem for path in Path(imugap.effects.__file__).parent.glob("*.py")} - {"__init__", "effect"}
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
    lobes = [quad(lambda u: density(u) * gain(u), a, b)[0] for a, b in pairwise(edges)]
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


@pytest.mark.parametrize("process", [p for p in SAMPLED if p.name != "bias_instability"], ids=lambda p: p.name)
@pytest.mark.parametrize("n", [1, 2, 5, 60])
def test_sampled_allan_variance_is_the_quadratic_form_of_the_covariance(process, n):
    weights = np.repeat([-1.0, 1.0], n) / n
    expected = weights @ autocovariance(process, 2 * n) @ weights / 2
    assert process.sampled_allan_variance(n, 0.01) == pytest.approx(expected, rel=1e-10)


STATIONARY = [process for process in SAMPLED if process.name not in ("random_walk", "bias_instability")]


@pytest.mark.parametrize("process", STATIONARY, ids=lambda p: p.name)
def test_sampled_spectrum_integrates_to_the_variance_of_a_sample(process):
    power = 2 * quad(lambda f: float(process.sampled_psd(f, 0.01)), 0, 50, limit=200)[0]
    assert power == pytest.approx(autocovariance(process, 1)[0, 0], rel=1e-9)


@pytest.mark.parametrize(
    "process", [RandomWalk(0.2), GaussMarkov(0.7, 0.2), BiasInstability(0.4)], ids=lambda p: p.name
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

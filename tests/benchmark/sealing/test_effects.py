from dataclasses import replace
from functools import partial

import numpy as np
import pandas as pd
import pytest
from scipy.fft import dct
from scipy.signal import butter, freqz, sosfilt
from scipy.spatial.transform import Rotation
from scipy.stats import norm, poisson
from tests.chance import as_often_as, mean_is

from imu_benchmark.sealing import additive, inertial, output, unnamed
from imu_benchmark.sealing import detection_limits as limits
from imu_benchmark.sealing.hidden_effect import AxisRun, ParameterSource
from imu_benchmark.sealing.motion import MOTIONS, rest
from imu_benchmark.sealing.noise import BaseNoise, fractional, rounded, summed
from imugap.estimation.variances import allan
from imugap.log import ACCEL, AXES, GYRO, from_samples
from imugap.stream import stream

INTERVAL = 0.02
COUNT = 2048
WHITE = BaseNoise(density=1.0)


def axis_run(noise=WHITE, count=COUNT, motion=None, axis="gyro_x", seed=1):
    time = INTERVAL * np.arange(count)
    moving = MOTIONS[motion](stream(seed, "motion")) if motion else rest()
    degrees = 25 + 3 * np.sin(2 * np.pi * time / time[-1])
    return AxisRun(axis, time, INTERVAL, noise, degrees, moving if motion else None, moving.ideal(time), 0.0)


within = partial(mean_is, share=0.05)


def mode_powers(draw, runs, *labels):
    return np.array([dct(draw(stream(3, *labels, run)), norm="ortho")[1:] ** 2 for run in range(runs)])


@pytest.mark.parametrize(
    "noise",
    [BaseNoise(density=2.0), BaseNoise(density_b=2.0), BaseNoise(density_k=2.0), BaseNoise(q=2.0)],
    ids=["white", "flicker", "walk", "quantization"],
)
@pytest.mark.parametrize("modes", [slice(0, 4), slice(20, 200), slice(200, None)], ids=["low", "middle", "high"])
def test_noise_of_a_base_device_has_the_mode_variances_that_limits_take_for_it(noise, modes):
    def draw(rng):
        return noise.white(COUNT, INTERVAL, rng) + noise.coloured(COUNT, INTERVAL, rng)

    powers = mode_powers(draw, 1500 if modes.start == 0 else 60, "base")[:, modes]
    ratio = (powers / noise.mode_variance(COUNT, INTERVAL)[modes]).mean(axis=1)
    # the lowest cosines of flicker noise are no eigenvectors of it: a few per cent
    truth = ratio.mean() if noise.density_b and modes.start == 0 else 1.0
    assert 0.85 < truth < 1.15
    assert within(ratio, truth)


def test_fractional_noise_of_exponent_one_has_the_allan_variance_of_flicker():
    found = [allan.variance(fractional(COUNT, 1.0, stream(4, run)), np.array([64]))[0] for run in range(300)]
    assert within(found, 2 * np.log(2) / np.pi, sigmas=5)


def test_fractional_noise_of_exponent_two_is_a_cumulated_sum():
    steps = np.diff(fractional(COUNT, 2.0, stream(5)))
    assert within(steps**2, 1.0)
    assert abs(np.corrcoef(steps[1:], steps[:-1])[0, 1]) < 4 / np.sqrt(COUNT)


def test_a_sum_grows_as_its_steps_and_begins_at_zero():
    ends = [summed(101, stream(6, run)) for run in range(3000)]
    assert all(one[0] == 0 for one in ends)
    assert within([one[-1] ** 2 for one in ends], 100.0)


def test_rounding_errors_are_differences_of_uniform_unit_errors():
    errors = np.cumsum(rounded(200_000, stream(7)))
    errors -= errors.mean()
    assert errors.var() == pytest.approx(1.0, abs=4 * np.sqrt(0.8 / 200_000))
    assert np.ptp(errors) == pytest.approx(np.sqrt(12), rel=1e-3)
    assert abs(np.corrcoef(errors[1:], errors[:-1])[0, 1]) < 4 / np.sqrt(200_000)


SPECTRA = [
    additive.HiddenWhiteNoise(2.0),
    additive.HiddenBiasInstability(2.0),
    additive.HiddenRandomWalk(2.0),
    additive.HiddenQuantization(2.0),
    additive.HiddenGaussMarkov(2.0, 1.0),
    additive.HiddenRandomTelegraph(2.0, 0.5),
    unnamed.HiddenFractionalNoise(amplitude=2.0),
]


@pytest.mark.parametrize("effect", SPECTRA, ids=lambda effect: effect.name)
@pytest.mark.parametrize("modes", [slice(10, 80), slice(80, 400), slice(1000, None)], ids=["low", "middle", "high"])
def test_stationary_effects_have_their_spectra(effect, modes):
    place = axis_run()
    powers = mode_powers(lambda rng: effect.sample(place, rng), 200, effect.name)
    density = effect.psd(place.frequencies(), INTERVAL) / INTERVAL
    if effect.name == "quantization":
        density += (effect.q / INTERVAL) ** 2 * 4 / COUNT  # what its two ends leak
    ratio = (powers / density)[:, modes].mean(axis=1)
    bias = 0.05 if effect.name in ("gauss_markov", "random_telegraph") else 0.0
    assert within(ratio, ratio.mean())
    assert abs(ratio.mean() - 1) < bias + 4 * ratio.std(ddof=1) / np.sqrt(200)


def test_gauss_markov_noise_has_an_exponential_autocovariance():
    effect, place = additive.HiddenGaussMarkov(2.0, 1.0), axis_run()
    runs = np.array([effect.sample(place, stream(8, run)) for run in range(400)])
    for lag in (0, 25, 50, 100):
        products = (runs[:, : COUNT - lag] * runs[:, lag:]).mean(axis=1)
        truth = 4 * np.exp(-lag * INTERVAL / 1.0)
        assert within(products, truth, share=0.1)


def test_telegraph_noise_has_two_values_and_switches_at_its_rate():
    effect, place = additive.HiddenRandomTelegraph(3.0, 0.5), axis_run()
    runs = [effect.sample(place, stream(9, run)) for run in range(300)]
    assert {float(value) for one in runs for value in np.unique(one)} == {-1.5, 1.5}
    # a pair of switches within an interval is not seen: share 1 - exp(-2 rate interval) over 2 of the intervals
    seen = (COUNT - 1) * -np.expm1(-2 * 0.5 * INTERVAL) / 2
    assert within([np.count_nonzero(np.diff(one)) for one in runs], seen)


def test_outliers_come_as_often_and_as_large_as_they_should():
    effect, place = additive.HiddenOutliers(0.01, 5.0), axis_run()
    drawn = np.concatenate([effect.sample(place, stream(10, run)) for run in range(100)])
    assert as_often_as(drawn != 0, 0.01, 2e-4)
    assert within(drawn[drawn != 0] ** 2, 25.0)


def test_axes_with_a_common_mode_share_it_and_others_do_not():
    effect = additive.HiddenCommonMode(2.0)
    one, other = (effect.sample(axis_run(axis=axis), stream(11)) for axis in ("gyro_x", "gyro_y"))
    assert effect.shared
    assert np.array_equal(one, other)
    assert within(one**2, 4 / INTERVAL)


def test_turn_on_biases_differ_by_their_standard_deviation():
    drawn = np.array([additive.HiddenTurnOnBias(3.0).sample(axis_run(count=2), stream(12, run)) for run in range(2000)])
    assert (drawn[:, 0] == drawn[:, 1]).all()
    assert within(drawn[:, 0] ** 2, 9.0)


@pytest.mark.parametrize(
    ("effect", "closed"),
    [
        (additive.HiddenRateRamp(1.0), lambda t: np.sqrt(12 / t**3)),
        (additive.HiddenSinusoid(3.3), lambda t: np.sqrt(2 / t)),
        (additive.HiddenBiasStep(0.3 * COUNT * INTERVAL), lambda t: 1 / np.sqrt(t * 0.3 * 0.7)),
    ],
    ids=lambda value: getattr(value, "name", ""),
)
def test_limits_of_waveforms_in_white_noise_are_the_closed_forms(effect, closed):
    place = axis_run(BaseNoise(density=0.7))
    assert effect.limit([place]) == pytest.approx(limits.Z * 0.7 * closed(place.duration), rel=3e-3)


@pytest.mark.parametrize("noise", [BaseNoise(1.0), BaseNoise(1.0, density_k=1.0)], ids=["white", "walk"])
@pytest.mark.parametrize(
    "effect",
    [
        additive.HiddenWarmUp(1.0, 5.0),
        additive.HiddenChirp(0.5, 0.1),
        unnamed.HiddenSawtooth(7.0),
        unnamed.HiddenSweep(0.5, 3.0),
    ],
)
def test_at_the_limit_the_matched_test_has_half_its_power_and_at_zero_one_per_cent(effect, noise):
    place = axis_run(noise)
    variance = place.mode_variance()
    signal = dct(effect.of_size(1.0, [place]).shape(place), norm="ortho")[1:]
    norm_of = np.sqrt(np.sum(signal**2 / variance))
    runs = 1000
    noises = mode_noises(place, runs)
    quiet, loud = (noises @ (signal / variance) / norm_of, (noises + signal) @ (signal / variance) / norm_of)
    for statistic, rate in ((quiet, 0.01), (loud, 0.5)):
        assert as_often_as(statistic > limits.Z, rate, 2e-4)


def mode_noises(place, runs):
    def draw(rng):
        white = place.noise.white(place.count, INTERVAL, rng)
        return dct(white + place.noise.coloured(place.count, INTERVAL, rng), norm="ortho")[1:]

    return np.array([draw(stream(13, run)) for run in range(runs)])


def test_the_divergence_ignores_a_common_factor_and_is_that_of_scaled_gaussians():
    rng = stream(14)
    ratio = np.exp(rng.normal(size=50))
    assert limits.divergence(ratio) == pytest.approx(limits.divergence(7 * ratio))
    assert limits.divergence(np.full(9, 3.0)) == pytest.approx(0.0, abs=1e-12)
    draws = rng.normal(size=(100_000, 50)) * np.sqrt(ratio)
    gain = norm.logpdf(draws, scale=np.sqrt(ratio)) - norm.logpdf(draws, scale=np.sqrt(ratio.mean()))
    assert within(gain.sum(axis=1), limits.divergence(ratio))


@pytest.mark.parametrize("effect", SPECTRA[1:], ids=lambda effect: effect.name)
def test_the_limit_of_a_spectrum_is_where_the_divergence_is_the_gain_of_the_matched_test(effect):
    place = axis_run()
    at_limit = replace(effect, **dict.fromkeys(effect.size_parameters, 1.0)).of_size(1.0, [place])
    extra = at_limit.psd(place.frequencies(), INTERVAL) / INTERVAL
    assert limits.divergence(1 + extra / place.mode_variance()) == pytest.approx(norm.isf(0.01) ** 2 / 2, rel=1e-3)


def test_the_divergence_of_outliers_is_their_mean_log_likelihood_ratio():
    effect = additive.HiddenOutliers(0.02, 1.0)
    rng = stream(15)
    values = rng.normal(size=2_000_000) * np.where(rng.random(2_000_000) < 0.02, np.hypot(1, 4.0), 1)
    mixture = 0.98 * norm.pdf(values) + 0.02 * norm.pdf(values, scale=np.hypot(1, 4.0))
    gain = np.log(mixture) - norm.logpdf(values, scale=np.sqrt(1 + 0.02 * 16))
    assert within(gain, effect.divergence(4.0))


def test_modulated_noise_at_its_limit_is_as_far_off_as_the_matched_test_needs():
    place, effect = axis_run(), output.HiddenVarianceChange(5.0, 15.0)
    at_limit = effect.of_size(1.0, [place])
    assert limits.divergence(at_limit.variance(place)) == pytest.approx(norm.isf(0.01) ** 2 / 2, rel=1e-3)


@pytest.mark.parametrize("size", [1.0, 10.0])
def test_as_many_samples_are_in_a_dead_zone_as_its_size_says(size):
    place = axis_run(BaseNoise(1.0))
    ideal = pd.DataFrame({place.axis: 20 * np.sin(0.7 * place.time)})
    moving = replace(place, ideal=ideal)
    zone = output.HiddenDeadZone().of_size(size, [moving])
    noises = (place.noise.white(place.count, INTERVAL, stream(23, run)) for run in range(400))
    counts = [np.count_nonzero(zone.act(ideal[place.axis].to_numpy() + one, moving, None) == 0) for one in noises]
    assert within(counts, size * limits.GAIN, share=0.1)


def test_a_sweep_gains_as_many_octaves_in_equal_times():
    place = axis_run()
    sweep = unnamed.HiddenSweep(0.5, 4.0).shape(place)
    ups = place.time[1:][(sweep[:-1] < 0) & (sweep[1:] >= 0)]
    frequency = 1 / np.diff(ups)
    middle = (ups[1:] + ups[:-1]) / 2
    np.testing.assert_allclose(frequency, 0.5 * 8 ** (middle / place.duration), rtol=0.05)


@pytest.mark.parametrize("order", [1, 2, 3, 4, 5])
def test_the_filter_is_the_butterworth_filter_of_the_bilinear_transform(order):
    effect = output.HiddenOutputFilter(8.0, order)
    frequency = np.linspace(0.1, 24, 200)
    b, a = butter(order, 8.0, fs=1 / INTERVAL)
    expected = freqz(b, a, frequency, fs=1 / INTERVAL)[1]
    assert np.allclose(effect.response(frequency, INTERVAL), expected, atol=1e-8)
    values = 9.81 + stream(16).normal(size=COUNT)
    filtered = effect.act(values, axis_run(), stream(17))
    sections = butter(order, 8.0, fs=1 / INTERVAL, output="sos")
    assert np.allclose(filtered, values[0] + sosfilt(sections, values - values[0]), atol=1e-6)


def test_a_larger_size_is_a_lower_cutoff_and_a_smaller_full_scale():
    place = axis_run(BaseNoise(density=1e-3), motion="hand")
    cutoffs = [output.HiddenOutputFilter(order=2).of_size(size, [place]).cutoff for size in (0.3, 3, 30)]
    assert 25 > cutoffs[0] > cutoffs[1] > cutoffs[2] > 0
    scales = [output.HiddenSaturation().of_size(size, [place]).full_scale for size in (0.3, 3, 30)]
    assert np.abs(place.ideal["gyro_x"]).max() > scales[0] > scales[1] > scales[2] > 0


@pytest.mark.parametrize("bias", [0.0, -0.3])
def test_the_clipped_excess_is_as_strong_as_asked(bias):
    place = replace(axis_run(BaseNoise(density=1e-3), motion="hand"), bias=bias)
    values = place.ideal["gyro_x"].to_numpy() + bias
    effect = output.HiddenSaturation().of_size(10.0, [place])
    clipped = effect.act(values, place, stream(18))
    assert np.abs(clipped).max() == effect.full_scale == effect.parameters()["limit"]
    assert np.linalg.norm(clipped - values) / place.std == pytest.approx(10 * norm.isf(0.01), rel=1e-3)


def test_a_resolution_leaves_multiples_at_most_half_a_step_away():
    values = stream(19).normal(size=COUNT)
    found = output.HiddenResolution(0.3).act(values, axis_run(), stream(20))
    assert np.allclose(found / 0.3, np.rint(found / 0.3), atol=1e-9)
    assert np.abs(found - values).max() <= 0.15 + 1e-12
    assert np.abs(found - values).max() > 0.14


def test_at_the_limit_a_lattice_moves_the_distribution_by_the_critical_value():
    place = axis_run()
    step = output.HiddenResolution().of_size(1.0, [place]).step
    grid = step * np.arange(-2000, 2000)
    moved = norm.cdf(grid + step / 2, scale=place.std) - norm.cdf(grid, scale=place.std)
    assert np.sqrt(COUNT) * moved.max() == pytest.approx(1.63, rel=5e-3)


def test_stuck_values_repeat_and_come_as_often_as_they_should():
    values = np.arange(200_000.0)
    found = output.HiddenStuckSamples(1e-3, 4.0).act(values, axis_run(), stream(21))
    stuck = np.diff(found, prepend=-1) == 0
    begins = np.count_nonzero(stuck & ~np.r_[False, stuck[:-1]])
    lengths = np.count_nonzero(stuck) / begins
    assert poisson.ppf(1e-4, 200) < begins < poisson.ppf(1 - 1e-4, 200)
    assert lengths == pytest.approx(4.0, abs=4 * np.sqrt(12 / 200))
    assert np.array_equal(found[~stuck], values[~stuck])


def test_lost_rows_leave_the_others_as_they_were():
    table = from_samples({"gyro_x": np.arange(100_000.0)}, INTERVAL)
    found = output.HiddenSampleLoss(1e-3, 4.0).act(table, stream(22))
    assert found.equals(table.loc[found.index])
    gaps = np.rint(np.diff(found.index) / INTERVAL) - 1
    assert poisson.ppf(1e-4, 100) < np.count_nonzero(gaps) < poisson.ppf(1 - 1e-4, 100)
    assert gaps[gaps > 0].mean() == pytest.approx(4.0, abs=4 * np.sqrt(12 / 100) + 0.1)
    assert found.index[[0, -1]].equals(table.index[[0, -1]])


def test_jittered_stamps_increase_and_scatter_as_they_should():
    table = from_samples({"gyro_x": np.zeros(50_000)}, INTERVAL)
    found = output.HiddenTimestampJitter(5e-4, 1e-4).act(table, stream(23))
    off = (found.index - table.index).to_numpy()
    assert (np.diff(found.index) > 0).all()
    assert np.allclose(off / 1e-4, np.rint(off / 1e-4), atol=1e-3)
    assert off.var() == pytest.approx(25e-8 + 1e-8 / 12, rel=4 * np.sqrt(2 / 50_000))


def test_stamps_wildly_displaced_keep_their_order():
    table = from_samples({"gyro_x": np.zeros(2000)}, INTERVAL)
    found = output.HiddenTimestampJitter(0.1, 1e-4).act(table, stream(24))
    assert (np.diff(found.index) > 0).all()


def test_at_its_limit_half_of_the_logs_have_a_displaced_stamp():
    place = axis_run(count=500)
    effect = output.HiddenTimestampJitter(tick=1e-4).of_size(1.0, [place])
    table = from_samples({"gyro_x": np.zeros(500)}, INTERVAL)
    moved = [not effect.act(table, stream(25, run)).index.equals(table.index) for run in range(400)]
    assert as_often_as(moved, 0.5, 2e-4)


def test_the_limit_of_a_clock_is_the_scatter_of_a_fitted_frequency():
    place = axis_run(BaseNoise(1.0, amplitude=3.0, frequency=5.0))
    runs = []
    for run in range(300):
        values = place.noise.line(place.time, rng := stream(26, run)) + place.noise.white(COUNT, INTERVAL, rng)
        runs.append(fitted(values, place.time, 5.0))
    relative = np.std(runs, ddof=1) / 5.0
    assert relative == pytest.approx(output.line_pull(place), rel=4 / np.sqrt(2 * 300))


def fitted(values, time, near):
    """The frequency of a line: three steps of Gauss and Newton on the phase of the demodulated values."""
    found = near
    for _ in range(3):
        turned = values * np.exp(-2j * np.pi * found * time)
        centred = time - time.mean()
        mean = turned.mean()
        slope = np.sum(centred * (turned / mean).imag) / np.sum(centred**2)
        found += slope / (2 * np.pi)
    return found


@pytest.mark.parametrize("motion", ["hand", "vehicle"])
def test_motions_obey_kinematics(motion):
    moving = MOTIONS[motion](stream(27))
    time, step = np.arange(0, 20, 0.05), 1e-4

    def attitude(at):
        return Rotation.from_euler("ZYX", (moving.start[:, None] + moving.angles.at(at))[::-1].T)

    turned = (attitude(time - step / 2).inv() * attitude(time + step / 2)).as_rotvec() / step
    rates = [moving.ideal(time + shift)[list(GYRO)].to_numpy() for shift in (0, step, -step)]
    assert np.allclose(rates[0], turned, atol=1e-5)
    assert np.allclose(moving.angular_acceleration(time).T, (rates[1] - rates[2]) / (2 * step), atol=1e-4)
    force = attitude(time).apply(moving.ideal(time)[list(ACCEL)].to_numpy(copy=True))
    assert np.allclose(force.T, moving.acceleration.at(time) - [[0], [0], [9.81]], atol=1e-9)


def test_the_lever_arm_adds_the_acceleration_of_the_arm():
    moving, step = MOTIONS["hand"](stream(28)), 3e-4
    time, arm = np.arange(0, 10, 0.1), np.array([0.1, -0.2, 0.3])

    def at(shift):
        euler = moving.start[:, None] + moving.angles.at(time + shift)
        return Rotation.from_euler("ZYX", euler[::-1].T)

    curved = (at(step).apply(arm) - 2 * at(0).apply(arm) + at(-step).apply(arm)) / step**2
    assert np.allclose(moving.arm(time) @ arm, at(0).inv().apply(curved), atol=1e-4)


def test_rest_reads_gravity_and_nothing_else():
    ideal = rest().ideal(np.arange(5.0))
    assert list(ideal.columns) == list(AXES)
    assert np.allclose(ideal.to_numpy(), [0, 0, 0, 0, 0, -9.81])


def test_a_delayed_input_is_the_input_of_the_earlier_time():
    place = axis_run(motion="hand")
    delayed = place.ideal["gyro_x"] + inertial.HiddenTimeOffset(2 * INTERVAL).sample(place, stream(29))
    assert np.allclose(delayed[2:], place.ideal["gyro_x"][:-2], atol=1e-12)
    small = inertial.HiddenTimeOffset(1e-6)
    assert np.allclose(small.sample(place, stream(30)), small.shape(place), atol=1e-3 * np.ptp(small.shape(place)))


def test_scale_factor_misalignment_and_g_sensitivity_are_linear_in_their_inputs():
    place = axis_run(motion="hand")
    ideal = place.ideal
    found = inertial.HiddenScaleFactor(1.0, 2.0, 3.0).shape(place)
    assert np.allclose(found, ideal["gyro_x"] + 2 * ideal["gyro_x"].abs() + 3 * ideal["gyro_x"] ** 2)
    assert np.allclose(inertial.HiddenMisalignment(0, 2.0, 3.0).shape(place), 2 * ideal["gyro_y"] + 3 * ideal["gyro_z"])
    assert np.allclose(inertial.HiddenGSensitivity(0, 0, 3.0).shape(place), 3 * ideal["accel_z"])
    for axis, own in zip(AXES, "xyzxyz", strict=True):
        drawn = inertial.HiddenMisalignment.draw(ParameterSource(replace(place, axis=axis), {}, stream(31)))
        assert getattr(drawn, own) == 0


def test_the_running_variance_is_that_of_a_second():
    values = stream(32).normal(size=400)
    half = int(0.5 / INTERVAL)
    expected = [values[max(row - half, 0) : row + half + 1].var() for row in range(400)]
    assert np.allclose(inertial.running_variance(values, INTERVAL), expected)


def test_the_van_der_pol_cycle_is_the_known_one():
    _, cycle = unnamed.HiddenVanDerPol(mu=5.0).cycle()
    half = len(cycle) // 2
    assert np.abs(cycle).max() == pytest.approx(2.0216, abs=1e-3)
    assert np.allclose(cycle[: half + 1], -cycle[half:], atol=2e-3)


def test_hysteresis_tells_warming_from_cooling():
    effect = unnamed.HiddenHysteresis(width=0.5, amplitude=2.0)
    place = axis_run()
    found, slope = effect.shape(place), np.gradient(place.temperature)
    late = np.abs(place.temperature - 25) < 2
    assert np.abs(found).max() <= 2 + 1e-12
    assert np.allclose(found[late & (place.time > 5)], 2 * np.sign(slope)[late & (place.time > 5)])


def test_bursts_decay_by_their_time():
    effect, place = unnamed.HiddenBursts(1, 2.0, 3.0), axis_run()
    found = effect.at(np.array([10.0]), place)
    assert found[place.time < 10].max() == 0
    assert found[600] == pytest.approx(3 * np.exp(-1.0))


def test_sizes_are_multiples_of_the_limit():
    place = axis_run()
    for effect in (
        *SPECTRA[1:5],
        additive.HiddenRateRamp(1.0),
        additive.HiddenOutliers(0.01),
        output.HiddenResolution(),
    ):
        once, thrice = (getattr(effect.of_size(size, [place]), effect.size_parameters[0]) for size in (1.0, 3.0))
        assert thrice == pytest.approx(3 * once)
    change = output.HiddenVarianceChange(5.0, 15.0)
    once, thrice = (change.of_size(size, [place]).ratio - 1 for size in (1.0, 3.0))
    assert thrice == pytest.approx(3 * once)


def test_several_axes_lower_the_limit_of_what_they_have_in_common():
    places = [axis_run(BaseNoise(density=1e-3), motion="hand", axis=axis) for axis in AXES]
    alone = [inertial.HiddenTimeOffset().limit([place]) for place in places]
    assert inertial.HiddenTimeOffset().limit(places) == pytest.approx(np.sum(np.array(alone) ** -2.0) ** -0.5)
    two, three = (additive.HiddenCommonMode().limit([axis_run()] * axes) for axes in (2, 3))
    assert three < two

from pathlib import Path

import allantools
import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numba import njit
from scipy.stats import binom
from tests.chance import as_often_as, mean_is
from tests.wavelet_coefficients import by_definition

from imugap.effects import BiasInstability, Conditions, GaussMarkov, Quantization, RandomWalk, RateRamp, WhiteNoise
from imugap.effects.effect import AxisModel
from imugap.estimation.variances import wavelet_variance
from imugap.io.catalogue.readers import read_raw
from imugap.numerics.spectra.daubechies import WIDTHS, depth, length
from imugap.stream import stream
from imugap.units import from_si

ROOT = Path(__file__).parents[3]
INTERVAL = 0.01
PROCESSES = (WhiteNoise(0.1), RandomWalk(0.2), GaussMarkov(0.5, 0.3), BiasInstability(0.3))
MODEL = AxisModel((WhiteNoise(0.1), RandomWalk(0.05), GaussMarkov(0.3, 2.0)))


def sampled(count, *effects, label=0):
    """One sequence of a sum of effects."""
    at = Conditions(INTERVAL * np.arange(count), INTERVAL)
    return sum(effect.sample(at, stream(61, label, effect)) for effect in effects)


def noise(count, *labels):
    return stream(62, *labels).standard_normal(count)


@pytest.mark.parametrize("width", [1, 3, 10])
def test_a_width_without_a_filter_is_refused(width):
    with pytest.raises(ValueError, match=f"expected a width among 2, 4, 6, 8; found {width}"):
        wavelet_variance.variance(noise(100), width=width)


def test_more_levels_than_the_samples_leave_are_refused():
    with pytest.raises(ValueError, match="expected 1 to 4 levels of 50 samples; found 5"):
        wavelet_variance.variance(noise(50), 5, 4)
    with pytest.raises(ValueError, match="expected 1 to 5 levels of 50 samples; found 6"):
        wavelet_variance.variance(noise(50), 6)


@settings(deadline=None)  # the first call compiles
@given(st.integers(30, 400), st.sampled_from(WIDTHS))
def test_the_transform_conserves_energy(count, width):
    sequence = noise(count, "energy")
    coefficients, smooth = wavelet_variance.modwt(sequence, depth(count, width), width)
    assert np.sum(coefficients**2) + np.sum(smooth**2) == pytest.approx(np.sum(sequence**2), rel=1e-12)


@pytest.mark.parametrize("width", WIDTHS)
@pytest.mark.parametrize("count", [61, 20_000])
def test_coefficients_and_variances_are_those_of_the_definition(width, count):
    sequence, levels = noise(count, "definition"), min(depth(count, width), 7)
    coefficients, _ = wavelet_variance.modwt(sequence, levels, width)
    expected = [by_definition(sequence, level, width) for level in range(1, levels + 1)]
    for level in range(levels):
        free = coefficients[level, length(level + 1, width) - 1 :]
        np.testing.assert_allclose(free, expected[level], atol=1e-12)
    found = wavelet_variance.variance(sequence, levels, width)
    np.testing.assert_allclose(found, [np.mean(w**2) for w in expected], rtol=1e-11)


@pytest.mark.parametrize("count", [1000, 100_003])
def test_haar_variance_is_half_the_overlapping_allan_variance(count):
    sequence = 5.0 + np.cumsum(noise(count, "haar")) * 0.01 + noise(count, "haar white")
    found = wavelet_variance.variance(sequence)
    n = 2 ** np.arange(len(found))
    tau, deviation, _, _ = allantools.oadev(sequence, rate=1.0, data_type="freq", taus=n[2 * n < count])
    np.testing.assert_array_equal(tau, n[: len(tau)])
    np.testing.assert_allclose(found[: len(tau)], deviation**2 / 2, rtol=1e-9)


@njit
def plain_loop(sequence, levels):
    angle = np.zeros(len(sequence) + 1)
    for k in range(len(sequence)):
        angle[k + 1] = angle[k] + sequence[k]
    result = np.zeros(levels)
    for level in range(levels):
        n = 1 << level
        for k in range(len(angle) - 2 * n):
            result[level] += ((angle[k + 2 * n] - 2 * angle[k + n] + angle[k]) / (2 * n)) ** 2
        result[level] /= len(angle) - 2 * n
    return result


def test_all_haar_levels_of_a_million_samples_are_those_of_a_plain_loop():
    sequence = noise(1_000_000, "million")
    np.testing.assert_allclose(wavelet_variance.variance(sequence), plain_loop(sequence, 19), rtol=1e-9)


def test_real_wavelet_variances_and_intervals_are_those_of_gmwm(sets, mirror):
    published = pd.read_csv(ROOT / "tests/reference/gmwm_wavelet_variance.csv", comment="#").set_index("axis")
    dataset = sets["adis16405"]
    log = read_raw(dataset.file(1).place(mirror), dataset, 1)
    for axis, unit in zip(log.columns, dataset.units, strict=True):
        found = wavelet_variance.curve(from_si(log[axis].to_numpy(), unit), INTERVAL)
        expected = published.loc[axis]
        np.testing.assert_array_equal(2 * found["tau"] / INTERVAL, expected["scale_samples"])
        for ours, theirs in (("variance", "wv"), ("low", "ci_low"), ("high", "ci_high")):
            np.testing.assert_allclose(found[ours], expected[theirs], rtol=1e-10)


def test_reference_of_gmwm_has_intervals_on_these_degrees_of_freedom():
    published = pd.read_csv(ROOT / "tests/reference/gmwm_wavelet_variance.csv", comment="#")
    for _, axis in published.groupby("axis"):
        edf = wavelet_variance.edf_octave(1_000_000, len(axis))
        low, high = wavelet_variance.limits(axis["wv"].to_numpy(), edf)
        np.testing.assert_allclose(low, axis["ci_low"], rtol=1e-10)
        np.testing.assert_allclose(high, axis["ci_high"], rtol=1e-10)


@pytest.mark.parametrize("width", [4, 6, 8])
def test_implied_variance_is_exact_where_the_covariance_is_known(width):
    decay, levels = np.exp(-INTERVAL / 0.3), 6
    found = {
        "white": wavelet_variance.implied(WhiteNoise(0.1), INTERVAL, levels, width),
        "walk": wavelet_variance.implied(RandomWalk(0.2), INTERVAL, levels, width),
        "markov": wavelet_variance.implied(GaussMarkov(0.5, 0.3), INTERVAL, levels, width),
        "rounding": wavelet_variance.implied(Quantization(1e-3), INTERVAL, levels, width),
    }
    for level in range(1, levels + 1):
        size = length(level, width)
        impulse = np.zeros(2 * size - 1)
        impulse[size - 1] = 1
        taps = by_definition(impulse, level, width)
        lag = np.arange(-size + 1, size)
        products = np.correlate(taps, taps, "full")
        expected = {
            "white": 0.1**2 / INTERVAL * taps @ taps,
            "walk": 0.2**2 * INTERVAL * np.sum(np.cumsum(taps) ** 2),
            "markov": 0.5**2 * products @ decay ** np.abs(lag),
            "rounding": (1e-3 / INTERVAL) ** 2 * np.sum(np.diff(np.r_[0, taps, 0]) ** 2),
        }
        for name, value in expected.items():
            assert found[name][level - 1] == pytest.approx(value, rel=1e-10), (name, level)


@pytest.mark.parametrize("width", [2, 4])
@pytest.mark.parametrize("process", PROCESSES, ids=lambda p: p.name)
def test_estimates_have_the_implied_mean_and_the_covariance(process, width):
    count, runs = 500, 3000
    levels = depth(count, width)
    found = np.array(
        [wavelet_variance.variance(sampled(count, process, label=run), levels, width) for run in range(runs)]
    )
    truth = wavelet_variance.implied(process, INTERVAL, levels, width)
    assert mean_is(found, truth, 4.5)
    deviation = found - truth
    products = deviation[:, :, None] * deviation[:, None, :]
    expected = wavelet_variance.covariance(process, INTERVAL, count, levels, width)
    assert mean_is(products, expected, 4.5)
    error = products.std(axis=0) / np.sqrt(runs)
    assert np.all(np.diag(error) < 0.25 * np.diag(expected))  # sharp enough to tell
    assert np.all(np.diag(error)[:-2] < 0.08 * np.diag(expected)[:-2])


@pytest.mark.parametrize("width", [2, 4, 8])
@pytest.mark.parametrize("model", [MODEL, Quantization(1e-3), BiasInstability(0.3)], ids=["sum", "rounding", "flicker"])
def test_covariance_of_a_long_sequence_is_close_to_the_exact_one(monkeypatch, model, width):
    count = 20_000
    levels = depth(count, width)
    found = wavelet_variance.covariance(model, INTERVAL, count, levels, width)
    monkeypatch.setattr(wavelet_variance, "EXACT", count)
    exact = wavelet_variance.covariance(model, INTERVAL, count, levels, width)
    scale = np.sqrt(np.diag(exact))
    np.testing.assert_allclose(found / np.outer(scale, scale), exact / np.outer(scale, scale), atol=2e-3)
    np.testing.assert_allclose(np.diag(found)[:-1], np.diag(exact)[:-1], rtol=1e-3)


def test_covariance_of_a_long_sequence_takes_a_few_thousand_values_of_the_spectrum():
    taken = []

    class Counted(AxisModel):
        def sampled_psd(self, frequency, interval):
            taken.append(np.size(frequency))
            return super().sampled_psd(frequency, interval)

    model = Counted((WhiteNoise(5e-3), GaussMarkov(1 / 180, 50.0), RandomWalk(1 / 21600)))
    wavelet_variance.covariance(model, 0.1, 108_000, 16)
    assert 0 < sum(taken) < 4000


@pytest.mark.parametrize("process", [WhiteNoise(0.1), RandomWalk(0.2)], ids=lambda p: p.name)
def test_covariance_with_a_ramp_is_that_of_sequences_with_one(process):
    count, runs, ramp = 500, 3000, RateRamp(0.3)
    found = np.array([wavelet_variance.variance(sampled(count, process, ramp, label=run), 8) for run in range(runs)])
    deviation = found - wavelet_variance.implied(process + ramp, INTERVAL, 8)
    products = deviation[:, :, None] * deviation[:, None, :]
    expected = wavelet_variance.covariance(process + ramp, INTERVAL, count, 8)
    assert mean_is(products, expected, 4.5)
    assert expected[-1, -1] > 2 * wavelet_variance.covariance(process, INTERVAL, count, 8)[-1, -1]


def test_covariance_of_a_sum_is_that_of_a_positive_definite_matrix():
    covariance = wavelet_variance.covariance(MODEL, INTERVAL, 3000, 11)
    np.testing.assert_array_equal(covariance, covariance.T)
    scale = np.sqrt(np.diag(covariance))
    assert np.linalg.eigvalsh(covariance / np.outer(scale, scale)).min() > 0.01


def test_a_ramp_is_seen_by_haar_alone():
    model = AxisModel((WhiteNoise(0.1), RateRamp(0.4)))
    sequence = RateRamp(0.4).sample(Conditions(INTERVAL * np.arange(2000), INTERVAL), stream(1))
    extra = wavelet_variance.implied(model, INTERVAL, 9) - wavelet_variance.implied(WhiteNoise(0.1), INTERVAL, 9)
    np.testing.assert_allclose(wavelet_variance.variance(sequence, 9), extra, rtol=1e-7)
    for width in (4, 6, 8):
        assert wavelet_variance.variance(sequence, width=width).max() < 1e-20
        expected = wavelet_variance.implied(WhiteNoise(0.1), INTERVAL, 5, width)
        np.testing.assert_allclose(wavelet_variance.implied(model, INTERVAL, 5, width), expected, rtol=1e-14)


@pytest.mark.parametrize("width", [2, 6])
def test_intervals_on_the_degrees_of_freedom_of_the_model_cover_as_often_as_they_say(width):
    count, runs = 1000, 600
    levels = depth(count, width) - 1
    truth = wavelet_variance.implied(MODEL, INTERVAL, levels, width)
    edf = wavelet_variance.edf_model(MODEL, INTERVAL, count, levels, width)
    held = []
    for run in range(runs):
        found = wavelet_variance.variance(sampled(count, *MODEL, label=run), levels, width)
        low, high = wavelet_variance.limits(found, edf, 0.9)
        held.append((low < truth) & (truth < high))
    assert all(as_often_as(inside, 0.9) for inside in np.transpose(held))


def test_intervals_of_gmwm_are_cautious_and_those_of_the_robust_variance_too():
    count, runs = 1000, 300
    truth = wavelet_variance.implied(MODEL, INTERVAL, 7)
    plain, robust = np.zeros(7, int), np.zeros(7, int)
    for run in range(runs):
        sequence = sampled(count, *MODEL, label=run)
        for hits, efficiency in ((plain, 1.0), (robust, wavelet_variance.EFFICIENCY)):
            found = wavelet_variance.curve(sequence, INTERVAL, efficiency=efficiency).loc[:7]
            hits += (found["low"] < truth) & (truth < found["high"])
    for hits in (plain, robust):
        assert hits.min() > binom.ppf(1e-4, runs, 0.95)
        assert hits.min() < runs


def test_degrees_of_freedom_from_the_coefficients_agree_with_those_of_the_model():
    count, runs = 20_000, 20
    model = wavelet_variance.edf_model(MODEL, INTERVAL, count, 6)
    found = np.mean([wavelet_variance.edf_sample(sampled(count, *MODEL, label=run), 6) for run in range(runs)], axis=0)
    np.testing.assert_allclose(found, model, rtol=0.05)


def test_curve_of_the_plain_variance_is_that_of_a_table():
    sequence = noise(700, "curve")
    found = wavelet_variance.curve(sequence, 0.5, 4)
    np.testing.assert_array_equal(found.index, np.arange(1, depth(700, 4) + 1))
    np.testing.assert_array_equal(found["tau"], 0.5 * 2.0 ** (found.index - 1))
    np.testing.assert_array_equal(found["variance"], wavelet_variance.variance(sequence, width=4))
    assert np.all((found["low"] < found["variance"]) & (found["variance"] < found["high"]))


@pytest.mark.parametrize("width", [2, 4])
@pytest.mark.parametrize("efficiency", [0.6, 0.95])
def test_robust_variance_is_consistent_on_clean_gaussian_noise(width, efficiency):
    found = np.array(
        [wavelet_variance.robust_variance(noise(4000, "clean", r), 5, width, efficiency) for r in range(200)]
    )
    truth = wavelet_variance.implied(WhiteNoise(0.1), INTERVAL, 5, width)
    ratio = found / truth
    bias = np.array([0, 0, 0.003, 0.006, 0.012])  # of few degrees of freedom: a third of 1/edf
    error = ratio.std(axis=0) / np.sqrt(len(ratio))
    assert np.all(np.abs(ratio.mean(axis=0) - 1) < 4.5 * error + bias)
    assert np.all(error < 0.02)


def test_robust_variance_has_the_efficiency_that_it_is_asked_for():
    for efficiency in (0.4, 0.6, 0.9):
        found = [[wavelet_variance.biweight_scale(noise(400, "iid", run), efficiency) for run in range(3000)]]
        assert 2 / 400 / np.var(found) == pytest.approx(efficiency, rel=0.12)  # 4.5 standard errors, and 1/400


@pytest.mark.parametrize("size", [10.0, 100.0, 1e4])
def test_one_percent_of_outliers_moves_the_robust_variance_a_little_and_the_plain_one_far(size):
    count = 50_000
    clean = noise(count, "contaminated")
    hit = stream(62, "where").random(count) < 0.01
    dirty = clean + size * hit * noise(count, "outliers")
    truth = wavelet_variance.implied(WhiteNoise(0.1), INTERVAL, 1)
    assert wavelet_variance.variance(dirty, 1)[0] > 1.8 * truth[0]
    assert wavelet_variance.robust_variance(dirty, 1)[0] == pytest.approx(truth[0], rel=0.08)


def test_robust_variance_follows_the_unit_and_knows_silence():
    sequence = noise(500, "unit")
    np.testing.assert_allclose(
        wavelet_variance.robust_variance(1e-4 * sequence), 1e-8 * wavelet_variance.robust_variance(sequence), rtol=1e-8
    )
    np.testing.assert_array_equal(wavelet_variance.robust_variance(np.ones(64)), np.zeros(6))


@pytest.mark.parametrize("efficiency", [0.1, 1.0])
def test_an_efficiency_out_of_reach_is_refused(efficiency):
    with pytest.raises(ValueError, match=r"expected an efficiency in \[0.3, 0.99\]"):
        wavelet_variance.robust_variance(noise(100), efficiency=efficiency)


@pytest.mark.parametrize("process", [WhiteNoise(0.1), RandomWalk(0.2)], ids=lambda p: p.name)
def test_test_of_the_deepest_scale_has_its_size(process):
    count, runs = 1024, 1500
    p = [wavelet_variance.level_means(sampled(count, process, label=run))["p"] for run in range(runs)]
    for level in range(1, 10):
        assert as_often_as([value[level] < 0.1 for value in p], 0.1), level
    lost = [wavelet_variance.deepest(sampled(count, process, label=run)) < 9 for run in range(runs)]
    assert as_often_as(lost, 1 - (1 - 0.05 / 9) ** 9)


def test_test_of_the_deepest_scale_finds_a_ramp_where_it_outgrows_the_noise():
    flat, steep = (
        [sampled(4096, WhiteNoise(0.1), RateRamp(slope), label=run) for run in range(runs)]
        for slope, runs in ((0.2, 200), (2.0, 50))
    )
    levels = np.array([wavelet_variance.deepest(one) for one in flat])
    assert np.mean(levels < 11) > 0.99
    assert np.mean([wavelet_variance.deepest(one) for one in steep]) < np.mean(levels) - 1
    assert np.mean([wavelet_variance.deepest(one, 4) > 8 for one in steep]) > 0.8

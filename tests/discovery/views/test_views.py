"""Views: their statistics are standard under the model, and peak where something is hidden."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import kstest
from tests.discovery.simulated import simulated

from imugap import log
from imugap.discovery import views
from imugap.discovery.fit.axis_fit import fit
from imugap.discovery.fit.description import Description
from imugap.discovery.preparation.sequence import AxisSequence
from imugap.discovery.views.curve import block_maxima, block_starts, correlation_score, window_sums, windows
from imugap.discovery.views.spectral import implied_allan_variance
from imugap.effects import (
    BiasStep,
    CommonMode,
    GaussMarkov,
    Misalignment,
    Outliers,
    RandomWalk,
    ScaleFactor,
    Sinusoid,
    Temperature,
    TimeOffset,
    VarianceChange,
    WhiteNoise,
)
from imugap.effects.conditions import Conditions
from imugap.stream import stream

COUNT, INTERVAL = 20000, 0.01
TIME = INTERVAL * np.arange(COUNT)
WARMING = 25 + 8 * (1 - np.exp(-TIME / 60)) + 1.5 * np.sin(2 * np.pi * TIME / 80)
WHITE = WhiteNoise(1e-3)
CELLS = {"mean": 128, "variance": 128, "temperature": 24, "temperature_rate": 24, "marginal": 28}
"""Locations of each view that do not overlap; windows of several follow on them."""


def fitted(*effects, axis="gyro_x", ideal=None, seed=1, start=(WHITE,)):
    conditions = Conditions(TIME, INTERVAL, WARMING, axis, ideal)
    return fit(simulated((WHITE, *effects), conditions, seed, "views"), Description.known(*start))


def peak(curve):
    """Return the range of the location that is furthest off."""
    at = np.argmax(np.abs(curve.statistic))
    return curve.low[at], curve.high[at]


def seen(*effects, **kwargs):
    found = fitted(*effects, **kwargs)
    return views.curves(found, views.binnings(found.sequence))


def test_windows_hold_what_they_say():
    sums = stream(1, "windows").standard_normal(13)
    first, last = windows(13)
    np.testing.assert_allclose(
        window_sums(sums), [sums[i:j].sum() for i, j in zip(first, last, strict=True)], atol=1e-12
    )
    assert set(last - first) == {1, 2, 4}


def test_a_faint_window_beside_a_strong_one_keeps_its_sum():
    sums = np.r_[1e12, np.full(7, 1e-9)]
    first, last = windows(len(sums))
    np.testing.assert_allclose(window_sums(sums), [sums[i:j].sum() for i, j in zip(first, last, strict=True)])


@pytest.mark.filterwarnings("error")
def test_a_band_in_which_an_axis_is_silent_has_no_coherence():
    """Behind a steep filter the power beyond its cutoff is less than the rounding of all power."""
    one, other = fitted(seed=1), fitted(seed=2, axis="gyro_y")
    coefficients = np.where(np.arange(COUNT - 1) < 2000, 1.0, 1e-9) * one.coefficients
    coefficients[4000:8000] = 0.0
    silent = replace(one)
    object.__setattr__(silent, "coefficients", coefficients)
    curve = views.of_coherence(silent, other)
    resolution = 1 / (2 * COUNT * INTERVAL)
    inside = (curve.low > 4001 * resolution) & (curve.high < 8000 * resolution)
    assert inside.any()
    np.testing.assert_array_equal(curve.statistic[inside], 0.0)
    assert np.abs(curve.statistic).max() < 5


def test_highest_of_each_block():
    values = stream(1, "highest").standard_normal(1000)
    first = block_starts(1000, 7, 16)
    peaks, at = block_maxima(values, first)
    parts = np.split(values, first[1:])
    np.testing.assert_array_equal(peaks, [part.max() for part in parts])
    np.testing.assert_array_equal(at, first + [part.argmax() for part in parts])


@pytest.mark.parametrize("effect", [WHITE, RandomWalk(1e-4), GaussMarkov(1e-3, 2.0)])
def test_implied_allan_variance_is_the_closed_form(effect):
    averaging = np.array([1, 2, 5, 17, 130, 1000])
    frequency = np.arange(1, COUNT) / (2 * COUNT * INTERVAL)
    own = implied_allan_variance(effect.sampled_psd(frequency, INTERVAL) / INTERVAL, averaging)
    left_out = 1 - own / effect.sampled_allan_variance(averaging, INTERVAL)
    assert np.all(left_out < 0.8 * averaging / COUNT)
    assert np.all(left_out > -1e-3)


def test_signed_statistics_are_standard_under_the_model():
    rows = {}
    for seed in range(40):
        for key, curve in seen(seed=seed).items():
            rows.setdefault(key, []).append(curve.statistic)
    for (view, _), statistics in rows.items():
        if view in CELLS:
            cells = np.array(statistics)[:, : CELLS[view]]
            # the fit takes the mean, and of the counts in cells their sum and their width as well
            free = CELLS[view] - (3 if view == "marginal" else 1)
            error = 1 / np.sqrt(cells.size)
            assert abs(cells.mean()) < 5 * error
            assert abs(np.mean(cells**2) - free / CELLS[view]) < 5 * np.sqrt(2) * error


@pytest.mark.parametrize(
    ("view", "effect", "low", "high"),
    [
        ("line", Sinusoid(7.3, 1e-3, 1.0), 7.3, 7.3),
        ("change", BiasStep(120.0, 3e-3), 115, 125),
        ("variance", VarianceChange(50.0, 100.0, 1.5), 50, 100),
        ("extremes", Outliers(5e-4, 0.5), 0, 200),
        ("temperature", Temperature(5e-4), 25, 35),
        ("allan", GaussMarkov(2e-3, 2.0), 0.5, 8),
        ("spectrum", GaussMarkov(2e-3, 2.0), 0.0025, 1),
    ],
)
def test_what_is_hidden_shows_where_it_is(view, effect, low, high):
    curve, usual = seen(effect)[view, ""], seen()[view, ""]
    first, last = peak(curve)
    assert first <= high
    assert last >= low
    assert last - first <= 1.5 * (high - low) + 0.01
    assert np.abs(curve.statistic).max() > np.abs(usual.statistic).max() + 3


def test_outliers_make_a_peak_and_tails_and_lower_the_shoulders():
    curve = seen(Outliers(1e-2, 0.05))["marginal", ""]
    assert curve.statistic[(curve.low >= -0.5) & (curve.high <= 0.5)].min() > 1
    assert curve.statistic[(curve.low >= 1.5) & (curve.high <= 2.0)].max() < -1
    assert min(curve.statistic[0], curve.statistic[-1]) > 3


def test_flawed_samples_count_in_no_block():
    flawed = np.zeros(COUNT, bool)
    flawed[5000:6000] = True
    clean = fitted().sequence
    values = np.where(flawed, 100.0, clean.values)
    sequence = AxisSequence(values, clean.conditions).with_replaced(flawed, stream(1, "flaws"))
    curves = views.curves(fit(sequence, Description.known(WHITE)))
    assert np.abs(curves["variance", ""].statistic).max() < 6
    assert curves["extremes", ""].statistic.max() < 15
    assert curves["marginal", ""].statistic.max() < 6


def motion():
    """Return the error-free log of a device that swings about three axes."""
    swings = {axis: (1 + k) * np.sin(2 * np.pi * (0.3 + 0.07 * k) * TIME) for k, axis in enumerate(log.AXES)}
    return log.from_samples(swings, INTERVAL)


@pytest.mark.parametrize(
    ("key", "effect"),
    [
        (("rate", "gyro_x"), ScaleFactor(2e-3)),
        (("rate", "gyro_y"), Misalignment(0.0, 2e-3, 0.0)),
        (("time_shift", "gyro_x"), TimeOffset(2e-3)),
        (("full_scale", "gyro_x"), ScaleFactor(5e-3)),
    ],
)
def test_motion_shows_over_the_input_that_causes_it(key, effect):
    curves = seen(effect, ideal=motion())
    off = {other: np.abs(curve.statistic).max() for other, curve in curves.items() if other[1]}
    assert off[key] > 8
    assert max(value for (_, source), value in off.items() if source != key[1]) < 6
    assert off["time_shift", key[1]] < 6 or key[0] == "time_shift"
    name = "gyro_x" if key[1] == "gyro_x" else f"gyro_x,{key[1]}"
    assert curves[key].axis == name


def test_an_axis_is_seen_over_its_own_derivative_only():
    over = views.binnings(fitted(ideal=motion()).sequence)
    own = [item for item in over if item.applies_to("gyro_x")]
    assert {item.source for item in own if item.view in ("time_shift", "full_scale")} == {"gyro_x"}
    assert {item.source for item in own if item.view == "angular_acceleration"} == {"gyro_y", "gyro_z"}
    assert {item.source for item in own if item.view == "jerk"} == set(log.ACCEL)
    assert {item.source for item in own if item.view == "rate"} == set(log.GYRO)
    assert {item.source for item in own if item.view == "specific_force"} == set(log.ACCEL)


@pytest.mark.parametrize(("loading", "sign"), [(0.3, 1), (-0.3, -1)])
def test_common_noise_is_coherent_with_its_sign(loading, sign):
    one = fitted(CommonMode(1e-3, 0.3))
    other = fitted(CommonMode(1e-3, loading), axis="gyro_y")
    curve = views.of_coherence(one, other)
    widest = np.argmax(np.diff(np.array(curve.windows), axis=0)[0])
    correlation = 0.3**2 / (1 + 0.3**2)
    assert curve.axis == "gyro_x,gyro_y"
    assert sign * curve.statistic[np.argmax(np.abs(curve.statistic))] == pytest.approx(
        np.sqrt(0.5 * COUNT) * correlation * 1.3, rel=0.35
    )
    assert abs(curve.statistic[widest]) < sign * curve.statistic.max() + 1e-9 or sign < 0


@pytest.mark.parametrize("number", [2, 3, 24, 400])
def test_a_correlation_of_however_few_pairs_has_a_normal_score(number):
    one, other = stream(4, "pairs", number).standard_normal((2, 20_000, number))
    correlation = (one * other).sum(axis=1) / np.sqrt((one**2).sum(axis=1) * (other**2).sum(axis=1))
    score = correlation_score(correlation, np.full(len(correlation), number))
    assert kstest(score, "norm").pvalue > 1e-3
    assert np.abs(score).max() < 6
    assert np.isfinite(correlation_score(np.array([1.0, -1.0]), np.array([number, number]))).all()


def test_every_replicate_has_the_same_locations_however_many_of_its_samples_are_flawed():
    whole = fitted().sequence
    rng = stream(2, "flawed")
    counts = []
    for share in (0.0, 0.02, 0.5, 0.8):
        flawed = rng.random(COUNT) < share
        found = fit(AxisSequence(whole.values, whole.conditions, flawed), Description.known(WHITE))
        counts.append({key: len(curve.statistic) for key, curve in views.curves(found).items()})
    assert counts[1:] == counts[:1] * 3

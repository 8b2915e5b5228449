from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import chi2

from imugap.filters.consistency import root_mean_square
from imugap.interchange.augmentation import Chain, augmentation
from imugap.interchange.datasheet import MODELS, TRUTHS, DataSheet, Slow
from imugap.navigation import planar
from imugap.navigation.planar import (
    COLUMNS,
    QUANTITIES,
    SENSORS,
    PlanarDrive,
    PlanarExample,
    covariances,
    draw,
    filter_run,
    monte_carlo,
)
from imugap.numerics.state_space import StateSpace
from imugap.stream import stream

RECIPE = Path(__file__).parents[2] / "data/planar.yaml"
SHEETS = (DataSheet(5.8e-5, 4.85e-5, 60.0, 1e-6, 1e-3), *2 * [DataSheet(3.3e-3, 1.1e-3, 31.7, 1.4e-4, 0.01)])
START = np.array([1, 1, 0.2, 0.2, 0.02])
TURNING = {
    "speed_m_per_s": 15, "surge_m_per_s": 5, "surge_period_s": 40, "turn_rad_per_s": 0.2, "turn_period_s": 30,
    "lap_s": 700, "fix_interval_s": 1, "fix_std_m": 1,
}  # fmt: skip
RUNS = 60


def drive(heading=0.0, duration=200, outages=((120, 180),)):
    return PlanarDrive.winding(duration, 5, **TURNING, outages_s=outages, heading_rad=heading)


def models(slow, sheets=SHEETS):
    return tuple(sheet.model(slow) for sheet in sheets)


TRUTH = models(TRUTHS["gauss_markov"])


def run(of, modelled, turn):
    """One run of the filter, its starting error and fix errors turned by ``turn``."""
    errors, slow, start, fixes = draw(of, TRUTH, START, 7, "turn")
    start = np.r_[turn @ start[:2], turn @ start[2:4], start[4]]
    chain = Chain.of([augmentation(model) for model in modelled], of.interval)
    return filter_run(of, chain, START, errors, slow, start, fixes @ turn.T)


def test_a_circle_closes_and_keeps_its_radius():
    rate, speed, count = 0.1, 7.0, 20_000
    interval = 2 * np.pi / rate / count
    inputs = np.tile([rate, 0.0, speed * rate], (count, 1))
    states = planar.navigate(np.array([0, 0, speed, 0, 0]), inputs, interval)
    np.testing.assert_allclose(states[-1], [0, 0, speed, 0, 2 * np.pi], atol=1e-4)
    np.testing.assert_allclose(np.hypot(states[:, 0], states[:, 1] - speed / rate), speed / rate, rtol=1e-6)


def test_the_drive_does_not_slip():
    states = drive().states
    forward = np.column_stack([np.cos(states[:, 4]), np.sin(states[:, 4])])
    across = forward[:, 0] * states[:, 3] - forward[:, 1] * states[:, 2]
    assert np.abs(across).max() < 0.05  # m/s: that of the inputs, constant over 0.2 s


def test_fixes_end_at_the_start_of_an_outage_and_begin_after_its_end():
    of = drive(outages=((120, 180), (190, 195)))
    time = of.epochs()
    assert list(time[~of.aided]) == [*range(121, 181), *range(191, 196)]
    assert list(time[of.ends()]) == [180, 195]
    assert drive(outages=()).aided.all()


@pytest.mark.parametrize("slow", MODELS.values(), ids=MODELS)
def test_without_errors_the_navigation_is_exact(slow):
    nothing = models((), 3 * [DataSheet(0.0, 0.0, 1.0, 0.0, 0.0)])
    of = replace(drive(), fix_std=0.0)
    chain = Chain.of([augmentation(model) for model in models(slow)], of.interval)
    errors, slow_part, start, fixes = draw(of, nothing, np.zeros(5), 7)
    error, _, _ = filter_run(replace(of, fix_std=1.0), chain, START, errors, slow_part, start, fixes)
    np.testing.assert_allclose(error, 0, atol=1e-9)


@pytest.mark.parametrize("angle", [np.pi / 2, -2.0])
def test_turning_the_frame_turns_the_errors_and_changes_nothing_else(angle):
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    error, _, nees = run(drive(), TRUTH, np.eye(2))
    turned, _, turned_nees = run(drive(angle), TRUTH, turn)
    np.testing.assert_allclose(turned[:, :2], error[:, :2] @ turn.T, atol=1e-8)
    np.testing.assert_allclose(turned[:, 2:4], error[:, 2:4] @ turn.T, atol=1e-8)
    np.testing.assert_allclose(turned[:, 4:], error[:, 4:], atol=1e-8)
    np.testing.assert_allclose(turned_nees, nees, rtol=1e-6)


def test_the_filter_does_not_touch_what_is_drawn_and_more_runs_disturb_none():
    few = monte_carlo(drive(), TRUTH, models(MODELS["N"]), START, 2, 7, "draw")
    more = monte_carlo(drive(), TRUTH, models(MODELS["N"]), START, 3, 7, "draw")
    np.testing.assert_array_equal(few.error, more.error[:2])
    again = [draw(drive(), TRUTH, START, 7, "draw", 1) for _ in range(2)]
    for one, other in zip(*again, strict=True):
        np.testing.assert_array_equal(one, other)


def dense(heading, accel, sensors):
    """The error model of the vehicle and its sensors as one state space, for a heading that stands still."""
    states = sum(len(one.output) for one in sensors)
    dynamics, psd = np.zeros((2, 5 + states, 5 + states))
    turn = np.array([[np.cos(heading), -np.sin(heading)], [np.sin(heading), np.cos(heading)]])
    dynamics[:2, 2:4] = np.eye(2)
    dynamics[2:4, 4] = turn @ np.array([-accel[1], accel[0]])
    drives = np.zeros((5, 3))
    drives[4, 0], drives[2:4, 1:] = 1.0, turn
    first = 5
    for k, one in enumerate(sensors):
        own = slice(first, first + len(one.output))
        dynamics[:5, own] = np.outer(drives[:, k], one.output)
        dynamics[own, own], psd[own, own] = one.dynamics, one.process_psd
        psd[:5, :5] += one.output_psd * np.outer(drives[:, k], drives[:, k])
        first += len(one.output)
    return StateSpace(dynamics, psd, np.zeros(5 + states), 0.0, np.zeros((5 + states, 5 + states)))


@settings(max_examples=20)
@given(st.floats(-3, 3), st.floats(-5, 5), st.floats(-5, 5), st.floats(0.01, 2.0), st.integers(0, 99))
def test_a_step_is_the_exact_discretisation_of_the_error_model(heading, forward, right, interval, label):
    sensors = [augmentation(model) for model in models(MODELS["N + B + K"])]
    chain = Chain.of(sensors, interval)
    transition, noise = dense(heading, (forward, right), sensors).discretise(interval)
    mixing = stream(8, "covariance", label).standard_normal(transition.shape)
    start = mixing @ mixing.T
    state, sample = np.array([0, 0, 0, 0, heading]), np.array([0, forward, right])
    found, found_transition = planar.predict_covariance(start, state, sample, interval, chain.transition, chain.noise)
    np.testing.assert_allclose(found_transition, transition, atol=1e-12)
    expected = transition @ start @ transition.T + noise
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-12)


@given(st.integers(0, 99), st.floats(1e-3, 1e3))
def test_an_update_keeps_the_covariance_a_covariance_and_with_its_own_gain_takes_from_it(label, variance):
    mixing = stream(9, "update", label).standard_normal((8, 8))
    before = mixing @ mixing.T
    after = planar.update_covariance(before, planar.fix_gain(before, variance), variance)
    np.testing.assert_allclose(after, after.T, atol=1e-9)
    assert np.linalg.eigvalsh(after).min() > -1e-9
    assert np.linalg.eigvalsh(before - after).min() > -1e-9
    other = planar.update_covariance(before, 1.1 * planar.fix_gain(before, variance), variance)
    assert np.linalg.eigvalsh(other - after).min() > -1e-9


def test_covariance_analysis_of_the_right_model_is_what_the_filter_says():
    predicted, actual = covariances(drive(), TRUTH, TRUTH, START)
    np.testing.assert_allclose(predicted, actual, rtol=1e-6)


@pytest.mark.parametrize("title", ["N", "N + K", "N + B"])
def test_no_filter_does_better_than_that_of_the_right_model(title):
    best, _ = covariances(drive(), TRUTH, TRUTH, START)
    predicted, actual = covariances(drive(), TRUTH, models(MODELS[title]), START)
    assert np.all(actual[:, :5] > best[:, :5] * (1 - 1e-6))
    assert np.all(predicted[drive().ends()] < actual[drive().ends()])


def normalised(errors, variance, at):
    """Errors over standard deviation at the epochs ``at``, shape (runs, quantities of their own, members)."""
    return errors.error[:, at] / np.sqrt(variance[..., at, :])


@pytest.fixture(scope="module")
def right():
    return monte_carlo(drive(), TRUTH, TRUTH, START, RUNS, 7, "right")


@pytest.mark.slow
def test_filter_of_the_right_model_is_consistent_on_both_sides(right):
    """Sum of the NEES over runs at epochs far apart: chi-square, two-sided, level 1e-4 in all."""
    for k, states in enumerate((5, 8)):
        total = right.nees[:, [29, 119, 179], k].sum(axis=0)
        low, high = chi2.ppf([1e-4 / 12, 1 - 1e-4 / 12], RUNS * states)
        assert np.all((low < total) & (total < high))


@pytest.mark.slow
def test_filter_without_the_slow_processes_is_optimistic():
    of, found = drive(), monte_carlo(drive(), TRUTH, models(MODELS["N"]), START, RUNS, 7, "right")
    for quantity in ("position", "velocity", "gyro bias", "accel bias"):
        ratios = normalised(found, found.variance, of.ends())[..., list(QUANTITIES[quantity])]
        _, low, _ = root_mean_square(ratios.reshape(RUNS, -1), 1 - 1e-4)
        assert low > 1
    assert np.all(found.nees[:, of.ends()].mean(axis=0) > chi2.ppf(1 - 1e-4, RUNS * 5) / RUNS)


@pytest.mark.slow
@pytest.mark.parametrize("title", ["N", "N + K"])
def test_covariance_analysis_foretells_the_actual_error_of_the_wrong_filter(title):
    of, modelled = drive(), models(MODELS[title])
    found = monte_carlo(of, TRUTH, modelled, START, RUNS, 7, "right")
    _, actual = covariances(of, TRUTH, modelled, START)
    for column in range(len(COLUMNS)):
        ratio = normalised(found, actual, [59, 119, 179])[..., column]
        _, low, high = root_mean_square(ratio[..., None], 1 - 1e-4)
        assert np.all((low < 1) & (high > 1))


def test_flicker_has_no_covariance_analysis():
    with pytest.raises(ValueError, match="bias_instability"):
        covariances(drive(), models([Slow.FLICKER]), TRUTH, START)


def test_the_recipe_of_the_study_is_read():
    example = PlanarExample.read(RECIPE)
    assert len(example.sheets) == len(SENSORS)
    assert len(example.drive.ends()) == 3


@pytest.mark.parametrize("key", ["sensors", "drive", "start_std"])
def test_a_recipe_without_a_part_says_so(tmp_path, key):
    text = RECIPE.read_text().replace(f"\n{key}:", f"\n{key}_:")
    (tmp_path / "bad.yaml").write_text(text)
    with pytest.raises(ValueError, match=f"bad.yaml: expected sensors, drive and start_std; found '{key}'"):
        PlanarExample.read(tmp_path / "bad.yaml")

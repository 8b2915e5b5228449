"""The attitude filter against laws: what gravity shows and what it hides, and whether the covariance is honest."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from scipy.stats import chi2, norm

from imugap import log
from imugap.effects import GaussMarkov, RandomWalk, WhiteNoise
from imugap.effects.effect import AxisModel
from imugap.io.references import reference
from imugap.model import ErrorModel
from imugap.navigation.attitude import AttitudeAssumptions, InitialAttitude, estimate_attitude
from imugap.numerics.rotation import from_euler
from imugap.stream import stream

G, DT = 9.81, 0.02
GYRO_MODEL = WhiteNoise(7e-4) + GaussMarkov(5e-4, 20.0)
ACCEL_MODEL = WhiteNoise(2.5e-3) + RandomWalk(1e-3)
MODEL = ErrorModel({axis: GYRO_MODEL if axis in log.GYRO else ACCEL_MODEL for axis in log.AXES})
SILENT = ErrorModel({axis: AxisModel((WhiteNoise(1e-9),)) for axis in log.AXES})
BIAS_STD = (0.01, 0.05)


def assuming(memory=None, bias_std=(0.0, 0.0)):
    return AttitudeAssumptions(G, memory, bias_std)


def turning(rate, count, first):
    """Truth and ideal log of a body that turns about its own point at a constant body rate [rad/s].

    The specific force over an interval is the mean of gravity as it turns through the body, by Simpson's rule.
    """
    time = DT * np.arange(count + 1)
    at = first * Rotation.from_rotvec(np.outer(time, rate))
    middle = first * Rotation.from_rotvec(np.outer(time[1:] - DT / 2, rate))
    up = [0.0, 0.0, -G]
    force = (at[:-1].inv().apply(up) + 4 * middle.inv().apply(up) + at[1:].inv().apply(up)) / 6
    samples = dict(zip(log.AXES, np.column_stack([np.tile(rate, (count, 1)), force]).T, strict=True))
    return at[1:], log.from_samples(samples, DT, start_s=DT)


def tumbling(count, first):
    """Return truth and ideal log of a body that turns one way and then another, so that every bias shows."""
    rate = np.array([0.4, -0.3, 0.2])
    half = count // 2
    one, ideal = turning(rate, half, first)
    other, more = turning(rate[::-1], count - half, one[-1])
    joined = np.vstack([ideal.to_numpy(), more.to_numpy()])
    truth = Rotation.concatenate([one, other])
    return truth, log.from_samples(dict(zip(log.AXES, joined.T, strict=True)), DT, start_s=DT)


def measured(ideal, bias, *labels):
    return MODEL.simulate(ideal, 5, *labels) + bias


def error(solution, truth):
    return (reference.rotations(solution.attitude) * truth.inv()).as_rotvec()


def level_log(count, rate=(0.0, 0.0, 0.0)):
    return turning(np.asarray(rate), count, Rotation.identity())


# Without errors


@pytest.mark.parametrize("rate", [(0.0, 0.0, 1.0), (0.7, -1.3, 0.4)])
def test_a_constant_rate_is_followed_exactly_over_many_turns(rate):
    first = from_euler([0.3, -0.2, 1.0])
    truth, ideal = turning(np.array(rate), 20_000, first)
    solution = estimate_attitude(ideal, SILENT, InitialAttitude((0.3, -0.2, 1.0), (0.0, 0.0, 0.0)), assuming())
    assert np.linalg.norm(rate) * 400 > 60 * 2 * np.pi
    assert np.abs(error(solution, truth)).max() < 1e-6


def test_a_tilted_start_converges_to_the_vertical_and_keeps_its_heading():
    truth, ideal = level_log(2000)
    solution = estimate_attitude(ideal, MODEL, InitialAttitude((0.05, -0.04, 0.6), (0.1, 0.1, 0.1)), assuming())
    off = error(solution, truth)
    assert np.abs(off[0, :2]).max() < 0.005
    assert np.abs(off[-1, :2]).max() < 1e-4
    assert off[-1, 2] == pytest.approx(0.6, abs=2e-3)
    assert solution.std[-1, 2] >= 0.1


def test_the_heading_of_the_frame_does_not_matter():
    _, ideal = tumbling(1000, from_euler([0.1, 0.2, 0.0]))
    noisy = measured(ideal, 0.001, "turned")
    starts = [InitialAttitude((0.1, 0.2, heading), (0.02, 0.02, 0.02)) for heading in (0.0, 2.1)]
    solutions = [estimate_attitude(noisy, MODEL, start, assuming(1.0, BIAS_STD)) for start in starts]
    turned = Rotation.from_euler("z", 2.1) * reference.rotations(solutions[0].attitude)
    missed = (turned * reference.rotations(solutions[1].attitude).inv()).magnitude()
    assert missed.max() < 1e-10
    np.testing.assert_allclose(solutions[1].sensors, solutions[0].sensors, rtol=0, atol=1e-12)
    np.testing.assert_allclose(solutions[1].std[:, 2], solutions[0].std[:, 2], rtol=1e-6)


# What gravity shows


def test_level_gyro_biases_are_observed_and_the_vertical_one_is_not():
    truth, ideal = level_log(30_000)
    bias = np.array([0.004, -0.003, 0.005, 0, 0, 0])
    noisy = measured(ideal, bias, "level")
    solution = estimate_attitude(
        noisy, MODEL, InitialAttitude((0, 0, 0), (0.01, 0.01, 0.0)), assuming(bias_std=(0.005, 0.0))
    )
    std = solution.sensors_std.iloc[-1].to_numpy()
    shown = GaussMarkov(5e-4, 20.0).std
    assert (std[:2] < 2 * shown).all()
    assert std[2] == pytest.approx(np.hypot(0.005, shown), rel=0.01)
    assert solution.sensors.iloc[-1, 2] == pytest.approx(0.0, abs=1e-3)
    assert (np.abs(solution.sensors.iloc[-1, :2] - bias[:2]) < 5 * shown).all()
    drift = error(solution, truth)[-1, 2]
    assert drift == pytest.approx(bias[2] * 600, abs=4 * solution.std[-1, 2])
    assert solution.std[-1, 2] == pytest.approx(0.005 * 600, rel=0.05)


def test_a_level_accelerometer_bias_is_a_tilt_and_the_filter_says_so():
    truth, ideal = level_log(5000)
    noisy = measured(ideal, np.array([0, 0, 0, 0.05, 0, 0]), "tilted")
    solution = estimate_attitude(
        noisy, MODEL, InitialAttitude((0, 0, 0), (0.1, 0.1, 0.0)), assuming(bias_std=(0.0, 0.05))
    )
    assert error(solution, truth)[-1, 1] == pytest.approx(0.05 / G, rel=0.4)
    assert solution.std[-1, 1] == pytest.approx(0.05 / G, rel=0.05)


def test_rest_ahead_shows_the_gyro_biases_and_correlates_tilt_and_accelerometers():
    truth, ideal = level_log(3000)
    bias = np.array([0.02, -0.03, 0.05, 0.03, -0.02, 0.04])
    noisy = measured(ideal, bias, "rest")
    rest, ahead = noisy.iloc[:1500], noisy.iloc[1500:]
    solution = estimate_attitude(ahead, MODEL, InitialAttitude.at_rest(rest, 0.0), assuming(bias_std=(1.0, 0.05)))
    np.testing.assert_allclose(solution.sensors.iloc[0, :3], bias[:3], atol=4 * solution.sensors_std.iloc[0, :3].max())
    assert (solution.sensors_std.iloc[0, :3] < 2 * GaussMarkov(5e-4, 20.0).std).all()
    assert solution.sensors.iloc[0, 5] == pytest.approx(bias[5], abs=0.01)
    np.testing.assert_allclose(solution.std[0, :2], 0.05 / G, rtol=0.05)
    np.testing.assert_allclose(error(solution, truth[1500:])[0, :2], [0.02 / G, 0.03 / G], atol=5e-4)


# Consistency


RUNS = 100


@pytest.fixture(scope="module")
def ensemble():
    """Errors over their covariance of many runs with the true model: attitude (3), heading off the start."""
    squares, innovations = [], []
    for run in range(RUNS):
        rng = stream(6, "ensemble", run)
        first = from_euler([0.2, -0.3, 0.5])
        truth, ideal = tumbling(500, first)
        bias = rng.standard_normal(6) * np.repeat(BIAS_STD, 3)
        noisy = measured(ideal, bias, "ensemble", run)
        guess = Rotation.from_rotvec(0.02 * rng.standard_normal(3)) * first
        attitude = guess.as_euler("ZYX")[::-1]
        solution = estimate_attitude(
            noisy, MODEL, InitialAttitude(tuple(attitude), (0.02, 0.02, 0.02)), assuming(bias_std=BIAS_STD)
        )
        off = error(solution, truth)[-1]
        squares.append(off @ np.linalg.solve(solution.covariance[-1], off))
        innovations.append(solution.innovations[50:])
    return np.array(squares), np.array(innovations)


def test_the_squared_error_over_its_covariance_has_the_mean_of_chi_square(ensemble):
    squares, _ = ensemble
    low, high = chi2.ppf([0.0005, 0.9995], 3 * RUNS) / RUNS
    assert low < squares.mean() < high


def test_innovations_are_standard_normal_and_white(ensemble):
    _, innovations = ensemble
    count = innovations.size
    low, high = chi2.ppf([0.0005, 0.9995], count) / count
    assert low < (innovations**2).mean() < high
    neighbours = (innovations[:, 1:] * innovations[:, :-1]).mean()
    assert abs(neighbours) < norm.ppf(0.9995) / np.sqrt(count)


def test_a_model_without_slow_errors_is_caught_by_the_same_test():
    """The two-sided test has power: a filter that leaves the Gauss-Markov states out is far too sure of itself."""
    truth, ideal = level_log(3000)
    white = ErrorModel({axis: AxisModel((model.effects[0],)) for axis, model in MODEL.axes.items()})
    squares = []
    for run in range(30):
        noisy = measured(ideal, 0.0, "caught", run)
        off = error(estimate_attitude(noisy, white, InitialAttitude((0, 0, 0), (1e-4, 1e-4, 1e-4)), assuming()), truth)[
            -1, 2
        ]
        squares.append(off**2)
    ratio = np.mean(squares) / ((7e-4) ** 2 * DT * 3000 + 1e-8)
    assert ratio > chi2.ppf(0.9995, 30) / 30


# True acceleration


def test_a_turn_that_looks_level_is_not_believed():
    """15 s in a banked turn: the force points along the body's z; taken for gravity, it would lose the roll."""
    bank, speed = np.radians(25), 20.0
    turn = G * np.tan(bank) / speed
    count = 750
    time = DT * np.arange(1, count + 1)
    truth = from_euler(np.column_stack([np.full(count, bank), np.zeros(count), turn * time]))
    rate = np.array([0.0, turn * np.sin(bank), turn * np.cos(bank)])
    ideal = np.tile([*rate, 0.0, 0.0, -G / np.cos(bank)], (count, 1))
    noisy = MODEL.simulate(log.from_samples(dict(zip(log.AXES, ideal.T, strict=True)), DT), 5, "turn")
    start, biases = InitialAttitude((bank, 0, 0), (0.005, 0.005, 0.0)), (1e-4, 0.01)
    wary, credulous = (
        error(estimate_attitude(noisy, MODEL, start, assuming(memory, biases)), truth) for memory in (1.0, None)
    )
    assert np.abs(wary[-1, :2]).max() < np.radians(1)
    assert np.abs(credulous[-1, :2]).max() > np.radians(10)


def test_the_reading_of_the_acceleration_only_makes_the_filter_more_careful():
    _, ideal = tumbling(1500, from_euler([0.1, 0.0, 0.0]))
    noisy = measured(ideal, 0.0, "careful")
    start = InitialAttitude((0.1, 0.0, 0.0), (0.01, 0.01, 0.01))
    wary, sure = (estimate_attitude(noisy, MODEL, start, assuming(memory, BIAS_STD)) for memory in (1.0, None))
    assert (wary.std[100:, :2] > sure.std[100:, :2]).all()


# Input


def test_a_log_with_a_gap_or_without_an_axis_is_refused():
    _, ideal = level_log(100)
    with pytest.raises(log.LogError, match=r"steps of 0.02 s; found one of 0.2"):
        estimate_attitude(ideal.drop(ideal.index[20:29]), MODEL, InitialAttitude((0, 0, 0), (0, 0, 0)), assuming())
    with pytest.raises(log.LogError, match="no accel_y"):
        estimate_attitude(ideal.drop(columns="accel_y"), MODEL, InitialAttitude((0, 0, 0), (0, 0, 0)), assuming())

import numpy as np
import pytest

from imugap.filters.zero_velocity import MOVING, STANCE, STILL, Detector, Stand, Statistic, statistic
from imugap.stream import stream

GRAVITY = 9.81


def noise(*labels, count=400, gyro=0.01, accel=0.05):
    rng = stream(1, "zero velocity", *labels)
    up = np.array([0.0, 0.0, -GRAVITY])
    return gyro * rng.standard_normal((count, 3)), up + accel * rng.standard_normal((count, 3))


def test_each_statistic_is_the_mean_that_defines_it():
    gyro, accel = noise("definition", gyro=1.0, accel=3.0)
    for window in (2, 7, 50):
        found = {kind: statistic(kind, gyro, accel, window, 0.5, 0.3, GRAVITY) for kind in Statistic}
        for start in (0, 100, 400 - window):
            y, w = accel[start : start + window], gyro[start : start + window]
            mean = y.mean(axis=0)
            rate = np.mean(np.sum(w**2, axis=1)) / 0.3**2
            expected = {
                Statistic.GLRT: np.mean(np.sum((y - GRAVITY * mean / np.linalg.norm(mean)) ** 2, axis=1)) / 0.25 + rate,
                Statistic.RATE_ENERGY: rate,
                Statistic.MOVING_VARIANCE: np.mean(np.sum((y - mean) ** 2, axis=1)) / 0.25,
                Statistic.MAGNITUDE: np.mean((np.linalg.norm(y, axis=1) - GRAVITY) ** 2) / 0.25,
            }
            for kind, value in expected.items():
                assert found[kind][start] == pytest.approx(value, rel=1e-9)
    assert len(found[Statistic.GLRT]) == 351


def test_the_statistics_do_not_see_how_the_sensor_is_mounted():
    gyro, accel = noise("mounting", accel=2.0)
    turn = np.linalg.qr(stream(2, "turn").standard_normal((3, 3)))[0]
    for kind in Statistic:
        before = statistic(kind, gyro, accel, 9, 0.5, 0.3, GRAVITY)
        np.testing.assert_allclose(statistic(kind, gyro @ turn, accel @ turn, 9, 0.5, 0.3, GRAVITY), before, rtol=1e-8)


@pytest.mark.parametrize("kind", list(Statistic))
def test_of_noise_alone_a_statistic_has_the_mean_of_its_chi_square(kind):
    """With standard deviations that are true, W times the statistic is chi-square with the freedom given here."""
    gyro, accel = noise("chi-square", count=200_000)
    window = 8
    free = {
        Statistic.GLRT: 6 - 2 / window,  # the direction of gravity takes 2 of 3 W
        Statistic.RATE_ENERGY: 3,
        Statistic.MOVING_VARIANCE: 3 - 3 / window,
        Statistic.MAGNITUDE: 1,
    }[kind]
    values = statistic(kind, gyro, accel, window, 0.05, 0.01, GRAVITY)[::window]
    error = np.sqrt(2 * free / window / len(values))
    assert abs(values.mean() - free) < 4 * error + 1e-3


def walk(interval=0.005, still=0.02):
    """Two seconds of stand with a bias, a second of swing, half a second of stance that is less still, a swing."""
    count = [round(part / interval) for part in (2.0, 1.0, 0.5, 1.0)]
    rng = stream(3, "walk", interval)
    gyro = 0.002 * rng.standard_normal((sum(count), 3)) + [0.01, -0.02, 0.03]
    accel = 0.02 * rng.standard_normal((sum(count), 3)) - [0, 0, GRAVITY + 0.05]
    edges = np.cumsum(count)
    for first, last in ((edges[0], edges[1]), (edges[2], edges[3])):
        gyro[first:last] += 4 * np.sin(np.arange(last - first)[:, None] * interval * 7 + [1, 2, 3])
        accel[first:last] += 25 * rng.standard_normal((last - first, 3))
    gyro[edges[1] : edges[2]] += still
    return gyro, accel, edges


def test_the_stand_gives_gravity_bias_and_noise():
    gyro, accel, edges = walk()
    stand = Detector().stand(gyro, accel, 0.005)
    assert edges[0] - 60 < stand.count <= edges[0]
    assert stand.gravity == pytest.approx(GRAVITY + 0.05, abs=0.005)
    np.testing.assert_allclose(stand.bias, [0.01, -0.02, 0.03], atol=5e-4)
    assert stand.gyro_std == pytest.approx(0.002, rel=0.1)
    assert stand.accel_std == pytest.approx(0.02, rel=0.1)


@pytest.mark.parametrize("kind", list(Statistic))
@pytest.mark.parametrize("interval", [0.0025, 0.005, 0.01])
def test_a_stance_is_found_where_it_is_whatever_the_rate_and_the_statistic(kind, interval):
    """Edges may be off by half a window and a little."""
    detector = Detector(statistic=kind)
    gyro, accel, edges = walk(interval)
    phase = detector.phases(gyro, accel, interval, detector.stand(gyro, accel, interval))
    near = round(0.75 * detector.window_s / interval)
    assert (phase[: edges[0] - round(detector.still_s / interval)] == STILL).all()
    assert (phase[edges[0] + near : edges[1] - near] == MOVING).all()
    assert (phase[edges[1] + near : edges[2] - near] == STANCE).all()
    assert (phase[edges[2] + near :] == MOVING).all()


def test_a_foot_that_never_gets_quite_still_has_its_stances_by_the_lowest_of_its_strides():
    """At 1.2 rad/s no window is below 1, yet the stance stands out of the stride and is found; at 9 rad/s it is not."""
    found = []
    for still in (1.2, 9.0):
        gyro, accel, edges = walk(still=still)
        detector = Detector()
        phase = detector.phases(gyro, accel, 0.005, detector.stand(gyro, accel, 0.005))
        found.append(np.mean(phase[edges[1] : edges[2]] == STANCE))
        fixed = Detector(highest=1.0)
        assert not (fixed.phases(gyro, accel, 0.005, fixed.stand(gyro, accel, 0.005))[edges[1] : edges[2]] > 0).any()
    assert found[0] > 0.9
    assert found[1] == 0


def test_a_log_that_does_not_begin_with_a_stand_is_refused():
    gyro, accel, edges = walk()
    with pytest.raises(
        ValueError, match=r"walk: expected a stand of 0.2 s or more at the start \(or --heading-free\); found 0 s"
    ):
        Detector().stand(gyro[edges[0] :], accel[edges[0] :], 0.005)
    still = Detector().stand(gyro[: edges[0]], accel[: edges[0]], 0.005)
    assert isinstance(still, Stand)
    assert still.count == edges[0]


def test_without_a_stand_the_quietest_stance_takes_its_place():
    gyro, accel, edges = walk()
    begin = edges[0] + 40
    found = Detector().stand_or_stance(gyro[begin:], accel[begin:], 0.005, GRAVITY)
    assert not found.still
    assert found.bias == (0.0, 0.0, 0.0)
    assert edges[1] <= begin + found.first
    assert begin + found.rows.stop <= edges[2]
    whole = Detector().stand_or_stance(gyro, accel, 0.005, GRAVITY)
    assert whole == Detector().stand(gyro, accel, 0.005)

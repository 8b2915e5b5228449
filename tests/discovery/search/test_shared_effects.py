from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import chi2
from tests.chance import as_often_as

from imugap import log
from imugap.discovery.fit.axis_fit import fit
from imugap.discovery.fit.description import Description, Entry
from imugap.discovery.fit.start_model import described
from imugap.discovery.preparation.sequence import AxisSequence
from imugap.discovery.search.search import Search
from imugap.discovery.search.shared_effects import Estimate, agreeing, contradicts, joined, pooled
from imugap.effects import CATALOGUE, LeverArm, Misalignment, ScaleFactor, TimeOffset, WhiteNoise
from imugap.effects.conditions import Conditions
from imugap.stream import stream

INTERVAL, COUNT = 0.02, 5000
DENSITY = 1e-3
STD = DENSITY / np.sqrt(INTERVAL)
LOG_ALPHA = np.log(1e-4)
INERTIAL = tuple(CATALOGUE[name] for name in ("scale_factor", "misalignment", "lever_arm", "time_offset"))


def scene():
    """An error-free log whose axes swing at frequencies of their own."""
    time = INTERVAL * np.arange(COUNT)
    columns = {
        axis: sum(np.sin(2 * np.pi * (0.2 + 0.11 * k + 0.37 * j) * time + k * j) for j in range(3))
        for k, axis in enumerate(log.AXES)
    }
    return log.from_samples(columns, INTERVAL)


IDEAL = scene()


def under(axis, ideal):
    return Conditions(ideal.index.to_numpy(), INTERVAL, None, axis, ideal)


def device(hidden, run, ideal=IDEAL):
    """Fits and searches of the axes of a device with white noise; ``hidden``: effect of each axis."""
    fits, searches = {}, {}
    for axis in log.AXES:
        conditions = under(axis, ideal)
        values = STD * stream(31, "device", axis, run).standard_normal(COUNT)
        if axis in hidden:
            values += hidden[axis].sample(conditions, None)
        before = fit(AxisSequence(values, conditions), Description.known(WhiteNoise(DENSITY)))
        searches[axis] = Search(before.description, INERTIAL, LOG_ALPHA)
        fits[axis] = searches[axis].explore(before)
    return fits, searches


@pytest.mark.slow
def test_an_axis_that_does_not_tell_has_no_delay_where_its_sensor_has_none():
    """Accelerometers that are late, and gyros that are not; the third hardly turns, and would allow of either."""
    ideal = IDEAL.assign(gyro_z=0.01 * IDEAL["gyro_z"])
    for run in range(3):
        found = joined(*device(dict.fromkeys(log.ACCEL, TimeOffset(2e-3)), run, ideal))
        assert [joint.axes for joint in found.joints] == [log.ACCEL]


def test_what_the_start_model_has_is_no_news_and_hides_nothing():
    arm, scale = LeverArm(0.1, -0.2, 0.05), ScaleFactor(0.05)
    fits, searches = {}, {}
    for axis in log.ACCEL:
        conditions = under(axis, IDEAL)
        values = STD * stream(32, "known", axis).standard_normal(COUNT) + arm.sample(conditions, None)
        values += scale.sample(conditions, None) if axis == "accel_x" else 0.0
        sequence = AxisSequence(values, conditions)
        before = fit(sequence, described((arm, WhiteNoise(DENSITY)), sequence))
        searches[axis] = Search(before.description, INERTIAL, LOG_ALPHA)
        fits[axis] = searches[axis].explore(before)
    found = joined(fits, searches)
    assert found.joints == ()
    assert names(found) == {"accel_x": ["scale_factor"]}


def test_the_known_axes_of_a_triad_tell_a_misalignment():
    ideal = IDEAL[["gyro_x", "gyro_y"]]
    values = STD * stream(33, "pair").standard_normal(COUNT) + 0.05 * ideal["gyro_y"].to_numpy()
    before = fit(AxisSequence(values, under("gyro_x", ideal)), Description.known(WhiteNoise(DENSITY)))
    found = Search(before.description, INERTIAL, LOG_ALPHA).explore(before)
    (term,) = found.description.terms
    assert isinstance(term.effect, Misalignment)
    assert term.effect.y == pytest.approx(0.05, rel=0.1)


def names(found):
    """Names of the added effects of each axis that has one."""
    added = {axis: found.searches[axis].added(one) for axis, one in found.fits.items()}
    return {axis: [candidate.effect.name for candidate in some] for axis, some in added.items() if some}


def estimate(value, information, axis="gyro_x"):
    value = np.atleast_1d(value)
    free = ("x", "y", "z")[: len(value)]
    effect = LeverArm(*np.r_[value, np.zeros(3 - len(value))].tolist())
    return Estimate(axis, (Entry(effect, free),), np.atleast_2d(information))


def drawn(rng, truth, count):
    """Estimates of the same truth, shape (k,), each with an information of its own."""
    estimates = []
    for _ in range(count):
        root = rng.standard_normal((len(truth), len(truth) + 3))
        information = root @ root.T
        value = rng.multivariate_normal(truth, np.linalg.inv(information))
        estimates.append(estimate(value, information))
    return estimates


def test_two_estimates_are_pooled_by_their_weights():
    pool = pooled([estimate(1.0, 4.0), estimate(2.0, 12.0)])
    np.testing.assert_allclose(pool.value, 1.75)
    np.testing.assert_allclose(pool.covariance, 1 / 16)
    assert pool.distance == pytest.approx(1 / (1 / 4 + 1 / 12))
    assert pool.freedom == 1
    assert pool.gain == pytest.approx(0.5 * 1.75**2 * 16)


def test_what_one_axis_says_of_one_effect_helps_with_the_other():
    """The second knows the delay alone; the first takes an arm and a delay for each other."""
    delay, arm = Entry(TimeOffset(3.0), ("offset",)), Entry(LeverArm(1.0, 0.0, 0.0), ("x",))
    both = Estimate("accel_x", (delay, arm), np.array([[2.0, 1.0], [1.0, 2.0]]))
    pool = pooled([both, Estimate("gyro_x", (replace(delay, effect=TimeOffset(5.0)),), np.array([[4.0]]))])
    np.testing.assert_allclose(pool.information, [[6.0, 1.0], [1.0, 2.0]])
    np.testing.assert_allclose(pool.about(LeverArm).information, 2 - 1 / 6)
    np.testing.assert_allclose(both.about([LeverArm]).information, 2 - 1 / 2)
    np.testing.assert_allclose(pool.value, np.linalg.solve(pool.information, [2 * 3 + 1 + 4 * 5, 3 + 2]))
    assert pool.freedom == 1


def test_axes_that_see_different_components_cannot_disagree():
    pool = pooled([estimate([1.0, 0.0], np.diag([2.0, 0.0])), estimate([0.0, 3.0], np.diag([0.0, 5.0]))])
    np.testing.assert_allclose(pool.value, [1.0, 3.0])
    assert pool.freedom == 0
    assert pool.agreement == 1.0


def test_the_distance_of_agreeing_estimates_has_its_law():
    runs, rng = 400, stream(31, "pool")
    p_values = np.array([pooled(drawn(rng, [0.3, -1.0, 2.0], 3)).agreement for _ in range(runs)])
    for level in (0.05, 0.5):
        assert as_often_as(p_values < level, level, 1e-3)


def test_the_value_of_a_pool_has_its_covariance():
    truth, rng = np.array([0.3, -1.0, 2.0]), stream(31, "covariance")
    pools = [pooled(drawn(rng, truth, 3)) for _ in range(400)]
    squares = sum((pool.value - truth) @ pool.information @ (pool.value - truth) for pool in pools)
    low, high = chi2.interval(0.999, 3 * len(pools))
    assert low < squares < high


def test_an_axis_is_contradicted_as_often_as_the_level_says():
    rng, level = stream(31, "contradiction"), 0.1
    lists = (drawn(rng, [0.3, -1.0], 3) for _ in range(400))
    assert as_often_as([contradicts(last, pooled(others), level) for *others, last in lists], level, 1e-3)


def test_the_odd_one_out_is_left_out():
    estimates = [estimate(1.0, 100.0), estimate(1.1, 100.0), estimate(3.0, 100.0), estimate(0.9, 100.0)]
    assert [one.value[0] for one in agreeing(estimates)] == [1.0, 1.1, 0.9]


@pytest.mark.slow
def test_a_delay_is_that_of_all_axes_even_where_some_do_not_show_it():
    fits, searches = device({axis: TimeOffset(5e-5) for axis in log.AXES}, run=0)
    showing = {axis for axis, one in fits.items() if one.has(TimeOffset)}
    found = joined(fits, searches)
    assert showing < set(log.AXES)
    (joint,) = found.joints
    assert abs(joint.effect.offset - 5e-5) < 3 * np.sqrt(joint.pool.covariance[0, 0])
    assert set(found.fits) == set(log.AXES)
    assert all([term.effect for term in one.description.terms] == [joint.effect] for one in found.fits.values())


@pytest.mark.slow
def test_delays_that_differ_stay_apart():
    triads = {axis: TimeOffset(1e-3) for axis in log.GYRO} | {axis: TimeOffset(-2e-3) for axis in log.ACCEL}
    fits, searches = device(triads, run=1)
    found = joined(fits, searches)
    (joint,) = found.joints
    assert joint.axes in (log.GYRO, log.ACCEL)
    for axis, hidden in triads.items():
        (offset,) = (term.effect.offset for term in found.fits[axis].description.terms)
        assert offset == pytest.approx(hidden.offset, abs=5e-5)


@pytest.mark.slow
def test_a_delay_of_one_axis_is_not_that_of_the_others():
    fits, searches = device({"gyro_y": TimeOffset(1e-3)}, run=2)
    found = joined(fits, searches)
    assert found.joints == ()
    assert names(found) == {"gyro_y": ["time_offset"]}


@pytest.mark.slow
def test_an_arm_is_that_of_the_three_accelerometers():
    arm = LeverArm(2e-3, -1e-3, 3e-3)
    fits, searches = device(dict.fromkeys(log.ACCEL, arm), run=3)
    found = joined(fits, searches)
    (joint,) = found.joints
    assert joint.axes == log.ACCEL
    difference = joint.pool.value - [arm.x, arm.y, arm.z]
    assert difference @ joint.pool.information @ difference < chi2.isf(1e-3, 3)
    assert joint.pool.agreement > 1e-3


@pytest.mark.slow
def test_the_errors_of_an_arm_and_a_delay_that_are_told_together_have_their_law():
    """Without the gyroscopes, on inputs by which each accelerometer takes one for the other."""
    ideal = IDEAL.assign(accel_y=IDEAL["gyro_z"], accel_z=IDEAL["gyro_x"] + 0.5 * IDEAL["gyro_y"])
    arm, delay, noise = LeverArm(2e-2, -1e-2, 3e-2), TimeOffset(6e-3), Description.known(WhiteNoise(10 * DENSITY))
    squares = {LeverArm: [], TimeOffset: []}
    for run in range(40):
        fits, searches = {}, {}
        for axis in log.ACCEL:
            conditions = under(axis, ideal)
            values = 10 * STD * stream(34, "together", axis, run).standard_normal(COUNT)
            values += arm.sample(conditions, None) + delay.sample(conditions, None)
            sequence = AxisSequence(values, conditions)
            searches[axis] = Search(noise, INERTIAL, LOG_ALPHA)
            fits[axis] = fit(sequence, noise.adding(Entry(delay, ("offset",)), Entry(arm, ("x", "y", "z"))))
        for joint in joined(fits, searches).joints:
            true = arm if isinstance(joint.effect, LeverArm) else delay
            difference = joint.pool.value - [getattr(true, name) for name in joint.free]
            squares[type(joint.effect)].append(difference @ joint.pool.information @ difference)
    for kind, size in ((LeverArm, 3), (TimeOffset, 1)):
        low, high = chi2.interval(0.999, 40 * size)
        assert len(squares[kind]) == 40
        assert low < sum(squares[kind]) < high


@pytest.mark.slow
def test_nothing_is_joined_where_nothing_is_hidden():
    fits, searches = device({}, run=4)
    found = joined(fits, searches)
    assert found.joints == ()
    assert names(found) == {}

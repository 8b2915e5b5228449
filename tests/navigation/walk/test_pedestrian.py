from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.special import bdtr, bdtrc

from imugap.analysis.walk import DEFAULT_MODEL, INDOORS, NavigatedWalk
from imugap.effects import Bias
from imugap.effects.effect import AxisModel
from imugap.filters.consistency import nees_band
from imugap.filters.zero_velocity import MOVING, STANCE, STILL
from imugap.integrity.timestamps import filled
from imugap.io.catalogue.readers import read_positions, read_raw, read_strides
from imugap.io.references import reference
from imugap.kinematics.strapdown import ATTITUDE, POSITION, VELOCITY
from imugap.log import ACCEL, AXES, GYRO, LogError
from imugap.model import ErrorModel
from imugap.navigation.walk.pedestrian import LEVER_ARM, WalkAssumptions, navigate
from imugap.navigation.walk.walk_physics import StanceFit
from imugap.numerics.rotation import from_euler
from imugap.simulation.camera_track import compare_with_cameras
from imugap.simulation.walk import Walk, WalkCourse, WalkLeg
from imugap.stream import stream

ROOT = Path(__file__).parents[3]
SEED = 21
RUNS = 150
EXACT = StanceFit(0.0, 0.0, 1.0, 0, 0.0, 0.0)
"""Fit of a walk whose assumptions hold."""
MIDDLE = 2925
"""A sample in the middle of a swing of the walk that is simulated."""


@pytest.fixture(scope="module")
def walk():
    """Go out, turn, and halfway back; the stand at the end is too short for one (see the module's docstring).

    The device has no fixed biases, so that its ideal log is that of a device whose errors happen to be none.
    """
    recipe = Walk.read(ROOT / "data" / "walk.yaml")
    axes = recipe.model.axes.items()
    random = {axis: AxisModel(tuple(one for one in model if not isinstance(one, Bias))) for axis, model in axes}
    course = WalkCourse(4.4, (WalkLeg(12), WalkLeg(3, turn_deg=60.0, share=0.0), WalkLeg(12)), 0.4)
    return replace(
        recipe,
        model=ErrorModel(random),
        course=course,
        gait=replace(recipe.gait, drift_m_per_s=0.0, impact_m_per_s2=0.0),
    )


@pytest.fixture(scope="module")
def matched(walk):
    """WalkAssumptions that hold in the simulation, every one."""
    return WalkAssumptions(
        gravity=walk.site.gravity,
        velocity_std=0.015,
        motion_std=0.0,
        rate_std=0.0,
        blind_gyro=0.0,
        blind_accel=0.0,
        tilt_std=1e-4,
    )


def drawn(walk, matched, run):
    """Return a log, the measured velocity of a point at an arm that is drawn, with noise, and the arm."""
    truth, ideal = walk.truth(0, SEED), walk.ideal(0, SEED)
    rng = stream(SEED, "measured", run)
    arm = matched.arm_std * rng.standard_normal(3)
    point = np.cross(ideal[list(GYRO)].to_numpy(), arm)
    velocity = truth[list(VELOCITY)].to_numpy(float) + reference.rotations(truth).apply(point)
    std = np.sqrt(2 * matched.velocity_std**2 * matched.correlation_s * walk.rate_hz)
    velocity += std * rng.standard_normal(velocity.shape)
    return walk.model.simulate(ideal, SEED, "device", run), velocity, arm


def error(solution, truth, row):
    """Return the error of position, velocity and attitude at a row, shape (9,)."""
    found, true = solution.trajectory.iloc[row], truth.iloc[row]
    turn = from_euler(found[list(ATTITUDE)].to_numpy()) * reference.rotations(truth.iloc[[row]])[0].inv()
    linear = [*POSITION, *VELOCITY]
    return np.concatenate([(found[linear] - true[linear]).to_numpy(float), turn.as_rotvec()])


@pytest.fixture(scope="module")
def runs(walk, matched):
    truth, found = walk.truth(0, SEED), []
    for run in range(RUNS):
        log, velocity, arm = drawn(walk, matched, run)
        solution = navigate(log, walk.model, matched, velocity=velocity)
        off = solution.sensors[list(LEVER_ARM)].iloc[-1].to_numpy() - arm
        found.append((error(solution, truth, -1), off, solution))
    return found


def nees(errors, covariances):
    return np.mean([e @ np.linalg.solve(p, e) for e, p in zip(errors, covariances, strict=True)])


@pytest.mark.slow
@pytest.mark.parametrize("states", [slice(0, 9), slice(0, 3), slice(3, 6), slice(6, 9)])
def test_the_filter_errs_as_much_as_it_says(runs, states):
    """NEES at the end of the walk, of all navigation states and of each kind, between two-sided bounds."""
    low, high = nees_band(states.stop - states.start, RUNS, 0.99)
    errors, covariances = [one[0][states] for one in runs], [one[2].covariance[states, states] for one in runs]
    assert low < nees(errors, covariances) < high


@pytest.mark.slow
def test_the_arm_to_the_point_at_rest_is_found_as_exactly_as_it_says(runs):
    low, high = nees_band(3, RUNS, 0.99)
    assert low < nees([one[1] for one in runs], [one[2].covariance[-3:, -3:] for one in runs]) < high
    assert np.mean([one[2].sensors_std[list(LEVER_ARM)].iloc[-1].min() for one in runs]) < 0.05


@pytest.mark.slow
@pytest.mark.parametrize(("phase", "freedom"), [(STANCE, 3), (STILL, 6)])
def test_the_innovations_are_as_large_as_the_filter_expects_and_follow_their_law(runs, phase, freedom):
    """NIS is chi-square, independent from sample to sample: its mean and its share beyond 1 % on either side."""
    nis = np.concatenate([one[2].nis[1:][one[2].phase[1:] == phase] for one in runs])
    assert abs(nis.mean() / freedom - 1) < 4 * np.sqrt(2 / freedom / len(nis))
    for low, high in ((0.115, 11.345),) if freedom == 3 else ((0.872, 16.812),):
        for share in (np.mean(nis < low), np.mean(nis > high)):
            assert abs(share - 0.01) < 4 * np.sqrt(0.01 * 0.99 / len(nis))
    assert np.isnan(runs[0][2].nis[runs[0][2].phase == MOVING]).all()


@pytest.mark.slow
@pytest.mark.parametrize("level", [0.9, 0.99])
def test_the_ellipse_of_the_end_holds_the_truth_as_often_as_it_says(runs, level):
    inside = sum(e[:2] @ np.linalg.solve(s.horizontal[-1], e[:2]) < -2 * np.log(1 - level) for e, _, s in runs)
    assert bdtr(inside, RUNS, level) > 0.005
    assert bdtrc(inside - 1, RUNS, level) > 0.005


@pytest.mark.slow
def test_the_smoother_errs_as_much_as_it_says_and_less_than_the_filter(walk, matched):
    """In the middle of a swing, over runs; at the end both are one."""
    truth, smoothed, filtered = walk.truth(0, SEED), [], []
    for run in range(60):
        log, velocity, _ = drawn(walk, matched, run)
        both = [navigate(log, walk.model, matched, smooth, velocity) for smooth in (False, True)]
        assert both[1].phase[MIDDLE] == MOVING
        for found, solution in zip((filtered, smoothed), both, strict=True):
            found.append((error(solution, truth, MIDDLE)[:6], solution.trajectory_std.iloc[MIDDLE].to_numpy()[:6]))
        np.testing.assert_allclose(both[0].trajectory.iloc[-1], both[1].trajectory.iloc[-1], atol=1e-9)
        np.testing.assert_allclose(both[0].trajectory_std.iloc[-1], both[1].trajectory_std.iloc[-1], atol=1e-9)
        assert (both[1].trajectory_std - both[0].trajectory_std).max().max() < 1e-6
    low, high = nees_band(1, 60, 0.999)
    for found in (filtered, smoothed):
        squares = np.mean([np.square(e / std) for e, std in found], axis=0)
        assert (low < squares).all()
        assert (squares < high).all()
    size = [np.sqrt(np.mean([np.sum(e[3:] ** 2) for e, _ in found])) for found in (filtered, smoothed)]
    assert size[1] < 0.5 * size[0]


@pytest.mark.slow
def test_the_strides_err_as_much_as_they_are_said_to_and_so_does_their_sum(walk, matched):
    """Mean square of error over deviation, of each stride over runs, and of all by the spread over runs; none is 0."""
    truth, squares, sums = walk.truth(0, SEED)[list(POSITION)].to_numpy(float), [], []
    for run in range(60):
        log, velocity, _ = drawn(walk, matched, run)
        one = NavigatedWalk(navigate(log, walk.model, matched, True, velocity), EXACT)
        strides = one.strides()
        steps = np.subtract(*(truth[np.searchsorted(log.index, strides[name])] for name in ("end", "start")))
        lengths, headings = np.hypot(*steps[:, :2].T), np.degrees(np.arctan2(*steps[:, 1::-1].T))
        off = [strides["length"] - lengths, strides["rise"] + steps[:, 2], strides["heading"] - headings]
        off[2] = (off[2] + 180) % 360 - 180
        stds = strides[["length_std", "rise_std", "heading_std"]].to_numpy().T
        assert (stds > 0).all()
        squares.append((np.array(off) / stds) ** 2)
        sums.append((strides["length"].sum() - lengths.sum()) / one.summary()["distance_m_std"])
    low, high = nees_band(1, 60, 1 - 0.001 / len(lengths))
    assert (np.mean(squares, axis=0) > low).all()
    assert (np.mean(squares, axis=0) < high).all()
    of_runs = np.mean(squares, axis=2)
    assert (np.abs(of_runs.mean(axis=0) - 1) < 4 * of_runs.std(axis=0) / np.sqrt(60)).all()
    low, high = nees_band(1, 60, 0.999)
    assert low < np.mean(np.square(sums)) < high


def ideal_solution(walk, assumptions, **changes):
    walk = replace(walk, **changes)
    return walk, navigate(walk.ideal(0, SEED), walk.model, replace(assumptions, gravity=walk.site.gravity))


def test_a_walk_without_errors_is_navigated_without_errors(walk, matched):
    """But for what the point at rest really does at the edges of its stances."""
    found, solution = ideal_solution(walk, replace(matched, arm_std=0.0), contact_m=(0.0, 0.0, 0.0))
    apart = error(solution, found.truth(0, SEED), -1)
    assert np.abs(apart[:3]).max() < 0.02
    assert np.abs(apart[6:]).max() < 1e-3
    strides = solution.strides()
    assert len(strides) == 24
    np.testing.assert_allclose(strides["length"], found.gait.length_m, atol=0.01)
    assert len(solution.stances()) == 28


@pytest.mark.slow
def test_half_the_interval_changes_nothing(walk, matched):
    """What is believed of the end is the same, for densities and motions have no rate; so is where it is."""
    ends = [ideal_solution(walk, matched, rate_hz=rate)[1] for rate in (200, 400)]
    ratio = ends[1].trajectory_std.iloc[-1] / ends[0].trajectory_std.iloc[-1]
    np.testing.assert_allclose(ratio, 1, atol=0.03)
    apart = ends[1].trajectory.iloc[-1] - ends[0].trajectory.iloc[-1]
    assert apart[list(POSITION)].abs().max() < 0.02


def test_how_the_sensor_is_mounted_changes_nothing(walk, matched):
    log = walk.ideal(0, SEED)
    turned, turn = log.copy(), from_euler((0.4, -0.7, 0.0))
    for triad in (GYRO, ACCEL):
        turned[list(triad)] = turn.apply(log[list(triad)].to_numpy(copy=True))
    one, other = (navigate(some, walk.model, matched) for some in (log, turned))
    paths = [some.trajectory[list(POSITION)].to_numpy() for some in (one, other)]
    first = [np.arctan2(path[-1, 1] - path[0, 1], path[-1, 0] - path[0, 0]) for path in paths]
    c, s = np.cos(first[0] - first[1]), np.sin(first[0] - first[1])
    np.testing.assert_allclose(paths[1] @ [[c, s, 0], [-s, c, 0], [0, 0, 1]], paths[0], atol=1e-4)


def test_a_foot_that_rolls_over_its_sole_sinks_or_rises_unless_the_point_at_rest_is_sought(walk, matched):
    """The sensor goes forward and up at stance: taken to be at rest it loses length in every stride."""
    lengths = []
    for arm_std in (0.0, 0.1):
        found, solution = ideal_solution(walk, replace(matched, arm_std=arm_std))
        lengths.append(solution.strides()["length"].mean() - found.gait.length_m)
        if arm_std:
            off = solution.sensors[list(LEVER_ARM)].iloc[-1].to_numpy() - np.array(found.contact_m)
            assert (np.abs(off) < 2 * solution.sensors_std[list(LEVER_ARM)].iloc[-1]).all()
    assert abs(lengths[1]) < 0.5 * abs(lengths[0])


def heights(walk, assumptions, model, legs):
    """Return the errors of the height at the end [m] and what is said of them, shape (walks, 2)."""
    walk, found = replace(walk, course=WalkCourse(4.4, legs, 2.0)), []
    truth = walk.truth(0, SEED)["down"].iloc[-1]
    for run in range(12):
        log = model.simulate(walk.ideal(0, SEED), SEED, "heights", run)
        solution = navigate(log, DEFAULT_MODEL, replace(assumptions, gravity=walk.site.gravity))
        found.append((truth - solution.trajectory["down"].iloc[-1], solution.trajectory_std["down"].iloc[-1]))
    return np.array(found)


def test_samples_near_the_full_scale_are_doubted_and_no_others(walk):
    """Heel strikes that are clipped at half their height: the end is nearer, and stated to be less sure."""
    hard = replace(walk, course=WalkCourse(1.0, (WalkLeg(12),), 1.0), gait=replace(walk.gait, impact_m_per_s2=150.0))
    ideal, end = hard.ideal(0, SEED), hard.truth(0, SEED)[["north", "east"]].iloc[-1].to_numpy(float)
    limit = 0.5 * ideal[list(ACCEL)].abs().to_numpy().max()
    clipped = ideal.assign(**{axis: ideal[axis].clip(-limit, limit) for axis in ACCEL})

    def found(full_scale):
        assumptions = WalkAssumptions(gravity=hard.site.gravity, full_scale=full_scale)
        return navigate(clipped, DEFAULT_MODEL, assumptions, smooth=True)

    believed, doubted, out_of_reach = found(np.inf), found(limit), found(1.2 * limit)
    np.testing.assert_array_equal(believed.history.navigation, out_of_reach.history.navigation)
    apart = [np.linalg.norm(one.trajectory[["north", "east"]].iloc[-1] - end) for one in (believed, doubted)]
    assert apart[1] < 0.9 * apart[0]
    assert np.trace(doubted.horizontal[-1]) > np.trace(believed.horizontal[-1])


def test_gyroscopes_that_are_clipped_are_found_and_doubted(walk):
    """Half of the largest rate is beyond the full scale: the end is nearer, and stated to be less sure."""
    walk = replace(walk, course=WalkCourse(2.0, (WalkLeg(12),), 1.0))
    ideal, end = walk.ideal(0, SEED), walk.truth(0, SEED)[["north", "east"]].iloc[-1].to_numpy(float)
    limit = 0.7 * ideal[list(GYRO)].abs().to_numpy().max()
    clipped = ideal.assign(**{axis: ideal[axis].clip(-limit, limit) for axis in GYRO})
    known = WalkAssumptions(gravity=walk.site.gravity)
    found = {
        scale: navigate(clipped, DEFAULT_MODEL, replace(known, rate_full_scale=scale))
        for scale in (np.inf, limit, None)
    }
    np.testing.assert_allclose(found[None].history.navigation, found[limit].history.navigation, atol=1e-6)
    off = {scale: np.linalg.norm(one.trajectory[["north", "east"]].iloc[-1] - end) for scale, one in found.items()}
    assert off[None] < off[np.inf]
    assert np.trace(found[None].horizontal[-1]) > np.trace(found[np.inf].horizontal[-1])


@pytest.mark.slow
@pytest.mark.parametrize("begin_s", [4.6, 5.2], ids=["in a swing", "at a stance"])
def test_a_walk_that_begins_in_motion_errs_as_much_as_it_says(walk, matched, begin_s):
    """In the frame of the foot at the first sample: NEES of the end over devices, and the velocity at the start."""
    truth, free = walk.truth(0, SEED).loc[begin_s:], replace(matched, heading_free=True)
    frame = from_euler((0.0, 0.0, float(truth["heading"].iloc[0]))).inv()
    ends = truth[list(POSITION)].to_numpy(float)
    end, start = frame.apply(ends[-1] - ends[0]), frame.apply(truth[list(VELOCITY)].to_numpy(float)[1])
    squares = []
    for run in range(20):
        log, velocity, _ = drawn(walk, matched, run)
        late = log.loc[begin_s:]
        turned = frame.apply(velocity[-len(late) :])
        one = navigate(late, walk.model, free, smooth=True, velocity=turned)
        off = (one.trajectory[list(POSITION)].to_numpy()[-1] - end)[:2]
        squares.append(off @ np.linalg.solve(one.horizontal[-1], off))
        assert np.abs(one.trajectory[list(VELOCITY)].to_numpy()[1] - start).max() < 0.1
    low, high = nees_band(2, 20, 0.99)
    assert low < np.mean(squares) < high


@pytest.fixture(scope="module")
def tilted():
    """A device whose accelerometers have biases of 0.1 m/s^2: at stance a tilt of 10 mrad balances them."""
    return ErrorModel.from_mapping({axis: [{"turn_on_bias": {"std": 0.1}}] for axis in ACCEL})


@pytest.mark.slow
def test_a_level_floor_tells_the_height_that_zero_velocity_does_not(walk, tilted):
    """With as little said of it; and both errors are as large as they are said to be, or less."""
    alone, floor = (heights(walk, one, tilted, (WalkLeg(24),)) for one in (WalkAssumptions(), INDOORS))
    assert np.sqrt(np.mean(floor[:, 0] ** 2)) < 0.3 * np.sqrt(np.mean(alone[:, 0] ** 2))
    assert floor[:, 1].max() < 0.4 * alone[:, 1].min()
    for found in (alone, floor):
        assert (np.abs(found[:, 0]) < 3 * found[:, 1]).all()


@pytest.mark.slow
@pytest.mark.parametrize("rise_m", [0.08, -0.17])
def test_a_slope_and_a_stair_are_no_level_floor(walk, tilted, rise_m):
    """Half the walk is level, half is not: the height is that of the sensors, or better."""
    alone, floor = (
        heights(walk, one, tilted, (WalkLeg(12), WalkLeg(12, rise_m=rise_m))) for one in (WalkAssumptions(), INDOORS)
    )
    assert np.sqrt(np.mean(floor[:, 0] ** 2)) < np.sqrt(np.mean(alone[:, 0] ** 2))
    assert (np.abs(floor[:, 0]) < 3 * floor[:, 1]).all()


def test_the_states_of_the_filter_are_those_of_the_model_and_no_more(walk, matched):
    solution = navigate(walk.ideal(0, SEED).iloc[:2000], walk.model, replace(matched, arm_std=0.0))
    assert list(solution.sensors.columns) == list(AXES)
    assert solution.covariance.shape == (15, 15)
    scaled = replace(matched, scale_std=(0.01, 0.01))
    assert navigate(walk.ideal(0, SEED).iloc[:2000], walk.model, scaled).covariance.shape == (24, 24)


def test_a_scale_factor_is_found_where_it_is_a_state(walk, matched):
    """Of the accelerometer along which gravity lies, 1 % under a standard deviation of 1 %."""
    log = walk.ideal(0, SEED)
    log["accel_z"] *= 1.01
    plain = replace(matched, scale_std=(0.0, 0.01))
    solution = navigate(log, walk.model, plain)
    last, std = solution.sensors["accel_z_scale"].iloc[-1], solution.sensors_std["accel_z_scale"].iloc[-1]
    assert abs(last - 0.01) < 2 * std < 0.01


def test_a_log_that_lacks_an_axis_is_refused(walk):
    with pytest.raises(LogError, match="walk: columns: expected all of gyro_x"):
        navigate(walk.ideal(0, SEED).drop(columns="accel_y"), walk.model)


def real(mirror, dataset, run, smooth=False, assumptions=None):
    return navigate(filled(read_raw(dataset.file(run).place(mirror), dataset, run)), DEFAULT_MODEL, assumptions, smooth)


def test_the_real_loops_close_without_a_hand_on_any_of_them(sets, mirror):
    """Horizontal end error: half a per cent of the distance in the median, under one per cent on each."""
    shares = []
    for name in ("openshoe_kth", "xio_gait_tracking"):
        for run in sets[name].runs:
            solution = real(mirror, sets[name], run)
            end = np.hypot(*solution.trajectory[["north", "east"]].iloc[-1])
            shares.append(end / solution.strides()["length"].sum())
    assert np.median(shares) < 0.005
    assert max(shares) < 0.01


@pytest.mark.parametrize(("run", "publisher_m"), [(1, 0.082), (2, 0.421)])
def test_the_loops_close_in_space_better_than_with_the_program_of_their_publisher(sets, mirror, run, publisher_m):
    """Xio, gait tracking: the printed distances from begin to end."""
    solution = real(mirror, sets["xio_gait_tracking"], run, assumptions=INDOORS)
    assert np.linalg.norm(solution.trajectory[list(POSITION)].iloc[-1]) < publisher_m


def test_the_height_under_cameras_is_better_for_a_level_floor(sets, mirror):
    """In the median over the trials: the height at the end, against that which was seen."""
    dataset, ends = sets["pyshoe_vicon"], []
    for run in dataset.runs:
        seen = read_positions(dataset.file(run).place(mirror), dataset, run)["down"]
        found = [real(mirror, dataset, run, assumptions=one) for one in (WalkAssumptions(), INDOORS)]
        rises = np.array([one.trajectory["down"].iloc[-1] for one in found])
        ends.append(np.abs(rises - (seen.iloc[-1] - seen.iloc[0])))
    assert np.median(ends, axis=0)[1] < 0.5 * np.median(ends, axis=0)[0]


@pytest.mark.parametrize("run", [1, 2])
def test_the_strides_of_both_feet_are_as_long_as_the_cameras_saw(sets, mirror, run):
    """Root mean square error below that of the peer, 0.049 m; of the toe, whose marker is the steadiest."""
    dataset = replace(sets["gaitmap_2x20m"], positions=("L_TOE", "R_TOE"))
    found = real(mirror, dataset, run, smooth=True).trajectory
    seen = read_positions(dataset.file(run, "positions").place(mirror), dataset, run)
    strides = read_strides(dataset.file(run, "events").place(mirror), dataset, run)

    def lengths(table):
        ends = [[np.interp(strides[at], table.index, table[name]) for name in ("north", "east")] for at in strides]
        return np.hypot(*(np.array(ends[1]) - ends[0]))

    assert np.sqrt(np.mean((lengths(found) - lengths(seen)) ** 2)) < 0.049


@pytest.mark.parametrize("run", [1, 2])
def test_the_way_out_of_both_feet_is_as_long_as_the_cameras_saw(sets, mirror, run):
    """The largest distance from the begin, within 0.05 m; the peer is 0.110 m (left) and 0.053 m (right) off."""
    dataset = sets["gaitmap_2x20m"]
    solution = real(mirror, dataset, run, smooth=True, assumptions=replace(INDOORS, full_scale=dataset.full_scale))
    seen = read_positions(dataset.file(run, "positions").place(mirror), dataset, run)
    found, true = compare_with_cameras(solution, seen).reach()
    assert abs(found - true) < 0.05


def test_the_real_walks_under_cameras_end_where_they_were_seen_to(sets, mirror):
    """The distance from begin to end against that of the reference: within one per cent of the walk on each."""
    dataset = sets["pyshoe_vicon"]
    for run in dataset.runs:
        solution = real(mirror, dataset, run)
        seen = read_positions(dataset.file(run).place(mirror), dataset, run)[["north", "east"]]
        end = np.hypot(*solution.trajectory[["north", "east"]].iloc[-1])
        assert abs(end - np.hypot(*(seen.iloc[-1] - seen.iloc[0]))) < 0.01 * solution.strides()["length"].sum()

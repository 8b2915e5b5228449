"""The filter of a vehicle: right of itself in every state, the same however it is cut, and what the gates leave."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from tests.drives import navigation_error, true_state

from imugap import log
from imugap.effects import WhiteNoise
from imugap.effects.effect import AxisModel
from imugap.filters.alignment import biases_from_rest, level_sensitivity
from imugap.filters.consistency import nees_band
from imugap.filters.error_state import NAVIGATION
from imugap.filters.innovation_gate import FAILED, NO_CONTROL, RESET, SCHEMES, QualityControl
from imugap.io import gnss
from imugap.kinematics.strapdown import level
from imugap.model import ErrorModel
from imugap.navigation.drive.vehicle import DriveAssumptions, DriveInputs, InitialState, navigate
from imugap.navigation.drive.vehicle_alignment import align
from imugap.numerics.rotation import from_euler
from imugap.stream import stream

SEED = 51
RUNS = 120
OUTAGE = (150.0, 210.0)
BEGIN = 10.0
STD = np.array([2, 2, 3, 0.1, 0.1, 0.1, 0.005, 0.005, 0.05])


def start(lap, assumptions, run, *constants):
    """Return a start whose errors are drawn from the covariance that it says."""
    states = assumptions.states(lap.model)
    variance = np.array([*STD**2, *states.variance, *(std**2 for _, std in assumptions.constants())])
    linear, turn = true_state(lap, BEGIN)
    off = STD * stream(SEED, "start", run).standard_normal(NAVIGATION)
    navigation = np.concatenate([linear[0] + off[:6], (Rotation.from_rotvec(off[6:]) * turn[0]).as_quat()])
    return InitialState(BEGIN, navigation, np.zeros(len(variance) - NAVIGATION), np.diag(variance))


def drive(lap, assumptions, run, quality=NO_CONTROL, fixes=None, smooth=False, begin=None):
    fixes = lap.fixes(run, SEED) if fixes is None else fixes
    begin = start(lap, assumptions, run) if begin is None else begin
    inputs = DriveInputs(lap.record(run, SEED), fixes, lap.model, lap.ellipsoid, assumptions, quality)
    return navigate(inputs, begin, smooth)


def sensor_error(lap, solution, run, rows):
    at = np.rint(solution.time.to_numpy()[rows] * lap.rate_hz).astype(int)
    names = [name for name in solution.names if name.startswith(("gyro", "accel"))]
    true = lap.errors(run, SEED)[names].iloc[at].to_numpy()
    return solution.sensors[names].iloc[rows].to_numpy() - true


@pytest.fixture(scope="module")
def runs(lap, assumptions):
    """Filtered drives with an outage: NEES at the end of it and of the drive, NIS, drift over its deviation."""
    found = []
    for run in range(RUNS):
        fixes = lap.fixes(run, SEED)
        fixes = fixes[(fixes.index <= OUTAGE[0]) | (fixes.index > OUTAGE[1])]
        one = drive(lap, assumptions, run, fixes=fixes)
        rows = one.fix_row
        whole = np.hstack([navigation_error(lap, one, rows), sensor_error(lap, one, run, rows)])
        last = int(np.searchsorted(one.time, OUTAGE[1]))
        drift = navigation_error(lap, one, [last])[0, :2]
        found.append((whole, one.covariances, one.record, drift, one.horizontal[last]))
    return found


@pytest.mark.parametrize(
    "states", [slice(0, 3), slice(3, 6), slice(6, 9), slice(9, 15), slice(15, 21), slice(0, 9), slice(0, 21)], ids=str
)
@pytest.mark.parametrize("at", [100, -1])
def test_the_filter_errs_as_much_as_it_says(runs, states, at):
    """NEES over runs between two-sided bounds: each kind of state, and all 21."""
    size = states.stop - states.start
    low, high = nees_band(size, RUNS, 0.999)
    off, told = np.array([one[0][at, states] for one in runs]), [one[1][at][states, states] for one in runs]
    assert low < np.mean([e @ np.linalg.solve(p, e) for e, p in zip(off, told, strict=True)]) < high
    assert np.abs(off.mean(axis=0) / off.std(axis=0)).max() < 4.5 / np.sqrt(RUNS)


def test_the_drift_over_an_outage_is_as_large_as_it_says(runs):
    low, high = nees_band(2, RUNS, 0.999)
    assert low < np.mean([drift @ np.linalg.solve(told, drift) for *_, drift, told in runs]) < high


def test_innovations_are_white_and_as_large_as_expected(runs):
    """NIS: its mean; whitened components: variance one, no correlation from fix to fix, no false alarms beyond 1 %."""
    nis = np.concatenate([one[2].statistic for one in runs])
    assert abs(nis.mean() / 6 - 1) < 4 * np.sqrt(2 / 6 / len(nis))
    alarms = np.mean(nis > QualityControl(false_alarm=0.01).limits(6)[6])
    assert abs(alarms - 0.01) < 4 * np.sqrt(0.01 / len(nis))
    white = np.array([one[2].whitened for one in runs])
    count = white[..., 0].size
    assert np.abs(white.mean(axis=(0, 1))).max() < 4.5 / np.sqrt(count)
    assert np.abs(white.var(axis=(0, 1)) - 1).max() < 4.5 * np.sqrt(2 / count)
    assert np.abs((white[:, 1:] * white[:, :-1]).mean(axis=(0, 1))).max() < 4.5 / np.sqrt(count)


@pytest.mark.slow
def test_the_smoother_errs_as_much_as_it_says_and_less_than_the_filter(lap, assumptions):
    both, count, row = {False: [], True: []}, 40, 2000
    for run in range(count):
        ends = []
        for smooth, found in both.items():
            one = drive(lap, assumptions, run, smooth=smooth)
            found.append((navigation_error(lap, one, [row])[0], one.trajectory_std.iloc[row].to_numpy()))
            ends.append((one.history.navigation[-1], one.history.variances[-1]))
            assert (one.history.variances > 0).all()
        np.testing.assert_allclose(ends[0][0], ends[1][0], atol=1e-9)
        np.testing.assert_allclose(ends[0][1], ends[1][1], rtol=1e-6)
    low, high = nees_band(1, count, 0.9999)
    for found in both.values():
        squares = np.mean([np.square(off[:6] / std[:6]) for off, std in found], axis=0)
        assert (low < squares).all()
        assert (squares < high).all()
    size = {smooth: np.sqrt(np.mean([off**2 for off, _ in found], axis=0)) for smooth, found in both.items()}
    assert (size[True][:6] < 0.85 * size[False][:6]).all()


@pytest.mark.parametrize("louder", [10, 100])
def test_the_smoother_bears_exact_fixes_behind_a_long_outage(lap, assumptions, louder):
    """They take off all but 1e-13 of the variance: of the difference of both no digit is left in places."""
    place = lap.antenna()
    fixes = gnss.from_local(place.index.to_numpy(), place.to_numpy(), np.full((len(place), 6), 1e-3), lap.ellipsoid)
    fixes = fixes[(fixes.index <= OUTAGE[0]) | (fixes.index > OUTAGE[1])]
    model = {axis: [WhiteNoise(louder * one.density) if isinstance(one, WhiteNoise) else one for one in own]
             for axis, own in lap.model.axes.items()}  # fmt: skip
    noisy = replace(lap, model=ErrorModel({axis: AxisModel(tuple(own)) for axis, own in model.items()}))
    one = drive(noisy, assumptions, 1, fixes=fixes, smooth=True)
    inside = np.flatnonzero((one.time > OUTAGE[0]) & (one.time <= OUTAGE[1]))
    off = navigation_error(noisy, one, inside)[:, :3]
    std = np.sqrt(one.history.variances[inside, :3])
    assert (std > 0).all()
    assert (np.abs(off) < 6 * std + 0.01).all()


def test_with_all_gates_open_the_gated_filter_is_the_plain_one(lap, assumptions):
    """To the bit: a gate that never closes is none."""
    never = 1e-300
    plain = drive(lap, assumptions, 1)
    gated = drive(lap, assumptions, 1, replace(NO_CONTROL, false_alarm=never, gated=True))
    np.testing.assert_array_equal(plain.history.navigation, gated.history.navigation)
    np.testing.assert_array_equal(plain.history.errors, gated.history.errors)
    np.testing.assert_array_equal(plain.covariances, gated.covariances)


def test_a_closed_gate_holds_the_sensors_and_tells_what_that_costs(lap, assumptions):
    """A fix that shuts the gate: sensors keep their estimates; the covariance is that of a considered update."""
    assumptions = replace(assumptions, lever_m=(0.0, 0.0, 0.0))
    begin = start(lap, assumptions, 2)
    fixes = lap.fixes(2, SEED).loc[BEGIN + 0.5 : BEGIN + 3.5].copy()
    fixes.loc[fixes.index[-1], "latitude"] += 60 / 6.4e6
    shut = drive(lap, assumptions, 2, replace(NO_CONTROL, gated=True), fixes, begin=begin)
    plain = drive(lap, assumptions, 2, NO_CONTROL, fixes, begin=begin)
    assert shut.record.passed.tolist() == [True, True, False]
    row = shut.fix_row[-1]
    np.testing.assert_array_equal(shut.history.navigation[:row], plain.history.navigation[:row])
    np.testing.assert_allclose(shut.history.errors[row], shut.history.errors[row - 1], rtol=1e-3, atol=1e-12)
    assert np.abs(plain.history.errors[row] - shut.history.errors[row]).max() > 1e-5
    np.testing.assert_allclose(shut.history.navigation[row], plain.history.navigation[row], atol=1e-9)
    after, best = shut.covariances[-1], plain.covariances[-1]
    sensors = slice(NAVIGATION, None)
    np.testing.assert_allclose(after[:NAVIGATION, :NAVIGATION], best[:NAVIGATION, :NAVIGATION], rtol=1e-6, atol=1e-15)
    before = shut.history.variances[row - 1, sensors]
    np.testing.assert_allclose(np.diag(after)[sensors], before, rtol=1e-3)
    assert np.linalg.eigvalsh(after - best).min() > -1e-12 * np.trace(best)
    np.testing.assert_allclose(after, after.T, atol=1e-15)


@pytest.mark.parametrize("scheme", list(SCHEMES))
def test_gross_errors_are_met_as_each_scheme_says(lap, assumptions, scheme):
    """An isolated 60 m: without control it throws the filter by metres, with any control by less than a third of it."""
    fixes = lap.fixes(3, SEED)
    fixes.loc[100.0, "latitude"] += 60 / 6.4e6
    one = drive(lap, assumptions, 3, SCHEMES[scheme], fixes)
    clean = drive(lap, assumptions, 3, SCHEMES[scheme])
    at = one.fix_row[np.searchsorted(one.fix_time, 100.0)]
    thrown = np.linalg.norm(one.history.navigation[at, :2] - clean.history.navigation[at, :2])
    share = one.record.share[np.searchsorted(one.fix_time, 100.0), 0]
    events = one.events[one.events["time"] == 100.0]
    assert (events["event"] == FAILED).any()
    if scheme in ("none", "gate"):
        assert thrown > 3
        assert share == 1
    else:
        assert thrown < 1
        assert (share == 0) if scheme in ("remove", "separation") else (0 < share < 0.05)
        assert (events["component"] == ("position" if scheme == "separation" else "north")).any()


def test_a_soft_reset_brings_back_a_filter_that_is_lost(lap, assumptions):
    """Sure of itself and 400 m off: it takes no fix until the reset, and is right soon after."""
    begin = start(lap, assumptions, 4)
    lost = replace(begin, navigation=begin.navigation + np.eye(10)[0] * 400)
    remove = QualityControl(robust=False, reset_s=30.0, separation_s=None)
    one = drive(lap, assumptions, 4, remove, begin=lost)
    resets = one.events[one.events["event"] == RESET]
    assert len(resets) >= 1
    assert resets["time"].iloc[0] == pytest.approx(BEGIN + 32, abs=1.01)
    assert resets["statistic"].iloc[0] > 30
    assert np.abs(navigation_error(lap, one, [-1])[0, :2]).max() < 5
    still = drive(lap, assumptions, 4, replace(remove, reset_s=None), begin=lost)
    assert np.abs(navigation_error(lap, still, [-1])[0, 0]) > 50
    assert (drive(lap, assumptions, 4, remove, begin=lost, smooth=True).history.variances > 0).all()


def test_sensor_errors_out_of_proportion_start_again_at_a_reset(lap, assumptions):
    begin = start(lap, assumptions, 5)
    insane = begin.errors.copy()
    insane[3] = 1.0
    wrong = replace(begin, errors=insane, covariance=begin.covariance * np.where(np.arange(21) == 12, 1e-6, 1)[:, None])
    one = drive(lap, assumptions, 5, QualityControl(reset_s=20.0, separation_s=None), begin=wrong)
    first = one.fix_row[np.flatnonzero(one.record.reset)[0]]
    assert one.history.errors[first - 1, 3] > 0.5
    assert abs(one.history.errors[first + 200, 3]) < 0.15


def test_the_covariance_may_go_in_longer_epochs(lap, assumptions):
    """Of 0.05 s and of every sample: apart by little against what is not known."""
    whole, fine = (drive(lap, replace(assumptions, epoch_s=epoch), 6) for epoch in (0.05, 0.01))
    rows = whole.fix_row, fine.fix_row
    apart = np.abs(whole.history.navigation[rows[0], :6] - fine.history.navigation[rows[1], :6])
    std = np.sqrt(fine.history.variances[rows[1], :6])
    assert (apart < 0.02 * std).all()
    np.testing.assert_allclose(whole.history.variances[rows[0]], fine.history.variances[rows[1]], rtol=0.01)


def test_fixes_between_samples_are_taken_where_they_are(lap, assumptions):
    """A log of 20 Hz and exact fixes that fall anywhere between its samples: nothing is left of the innovations."""
    coarse = replace(lap, rate_hz=20, receiver=replace(lap.receiver, rate_hz=1))
    fine = replace(lap, receiver=replace(lap.receiver, rate_hz=100 / 97)).antenna()
    std = np.tile([0.01] * 3 + [0.01] * 3, (len(fine), 1))
    fixes = gnss.from_local(fine.index.to_numpy(), fine.to_numpy(), std, lap.ellipsoid)
    linear, turn = true_state(lap, BEGIN)
    begin = InitialState(BEGIN, np.concatenate([linear[0], turn[0].as_quat()]), np.zeros(12), np.diag([1e-6] * 21))
    one = navigate(DriveInputs(coarse.path[1], fixes, lap.model, lap.ellipsoid, assumptions, NO_CONTROL), begin)
    assert np.abs(one.record.innovation[:, :3]).max() < 0.01
    assert np.abs(one.record.innovation[:, 3:]).max() < 0.02
    assert len(np.unique(np.round(np.remainder(one.fix_time, 0.05), 6))) > 4


@pytest.mark.slow
@pytest.mark.parametrize("delay", [0.0, 0.137])
def test_the_time_offset_is_taken_off_or_estimated(lap, assumptions, delay):
    late = replace(lap, receiver=replace(lap.receiver, delay_s=delay))
    told = drive(late, replace(assumptions, time_offset_s=delay), 7)
    plain = drive(lap, assumptions, 7)
    np.testing.assert_allclose(told.history.navigation[-1], plain.history.navigation[-1], atol=1e-6)
    aware = replace(assumptions, time_offset_std=0.2)
    errors = []
    for run in range(30):
        one = drive(late, aware, run, begin=start(lap, aware, run))
        errors.append((one.sensors["offset"].iloc[-1] - delay) / one.sensors_std["offset"].iloc[-1])
        assert one.sensors_std["offset"].iloc[-1] < 0.02
    low, high = nees_band(1, 30, 0.999)
    assert low < np.mean(np.square(errors)) < high


@pytest.mark.slow
def test_the_lever_arm_is_estimated_as_exactly_as_it_says(lap, assumptions):
    aware = replace(assumptions, lever_m=(0.0, 0.0, 0.0), lever_std=1.0)
    errors = []
    for run in range(30):
        one = drive(lap, aware, run, begin=start(lap, aware, run))
        off = one.history.errors[-1, -3:] - lap.receiver.lever_m
        errors.append(off @ np.linalg.solve(one.covariances[-1][-3:, -3:], off))
        assert one.sensors_std[["lever_x", "lever_y"]].iloc[-1].max() < 0.4
    low, high = nees_band(3, 30, 0.999)
    assert low < np.mean(errors) < high


@pytest.mark.slow
@pytest.mark.parametrize("constants", [{}, {"lever_std": 0.1, "time_offset_std": 0.01}])
@pytest.mark.parametrize("rest", [True, False])
def test_the_start_is_as_right_as_it_says(lap, assumptions, rest, constants):
    """Levelled at rest, or in motion where the log begins there; position, velocity and attitude against the truth."""
    assumptions = replace(assumptions, **constants)
    found = []
    for run in range(60):
        samples, fixes = lap.record(run, SEED), lap.fixes(run, SEED)
        if not rest:
            samples, fixes = samples.loc[30.0:], fixes.loc[30.0:]
        one = align(DriveInputs(samples, fixes, lap.model, lap.ellipsoid, assumptions))
        linear, turn = true_state(lap, one.time)
        off = np.concatenate([
            one.navigation[:6] - linear[0], (Rotation.from_quat(one.navigation[6:]) * turn[0].inv()).as_rotvec()
        ])  # fmt: skip
        found.append(off / np.sqrt(np.diag(one.covariance)[:NAVIGATION]))
        if rest:
            assert np.sqrt(one.covariance[9, 9]) < 1e-4
    squares = np.mean(np.square(found), axis=0)
    assert (squares < nees_band(1, 60, 0.9999)[1]).all()
    assert (squares[:6] > nees_band(1, 60, 0.9999)[0]).all()


def test_a_drive_without_a_course_does_not_start(lap, assumptions):
    given = lap.record(1, SEED).loc[:10.0], lap.fixes(1, SEED).loc[:10.0]
    with pytest.raises(ValueError, match=r"start: expected a fix that tells the course within 5\.7 deg; found none"):
        align(DriveInputs(*given, lap.model, lap.ellipsoid, assumptions))


def test_a_start_outside_of_the_log_is_refused(lap, assumptions):
    late = replace(start(lap, assumptions, 1), time=1e4)
    with pytest.raises(ValueError, match="start: expected a time from 0 s to 300 s; found 10000 s"):
        drive(lap, assumptions, 1, begin=late)


def test_a_rest_tells_the_gyroscopes_what_the_best_estimate_is(lap):
    """Against the Gaussian posterior of a constant seen in white noise."""
    model = ErrorModel.from_mapping({axis: [{"white_noise": {"density": 1e-4}}, {"turn_on_bias": {"std": 1e-3}}]
                                     for axis in log.GYRO})  # fmt: skip
    states = DriveAssumptions(scale_std=(0.0, 0.0)).states(model)
    errors, covariance = biases_from_rest(np.array([1e-3, -2e-3, 5e-4]), 25.0, states, np.diag(states.variance))
    share = 1e-6 / (1e-6 + 1e-8 / 25)
    np.testing.assert_allclose(errors, share * np.array([1e-3, -2e-3, 5e-4]))
    np.testing.assert_allclose(np.diag(covariance), 1e-6 * (1 - share))


def test_what_accelerometers_are_off_tilts_the_level_across(lap, assumptions):
    """Against the levelling itself, by difference quotients; the error of the state is less what it leaves out."""
    states = assumptions.states(lap.model)
    turn = from_euler(np.array([0.03, -0.05, 1.0]))
    force = turn.inv().apply([0, 0, -9.8])
    rows = level_sensitivity(force, turn.as_matrix(), states, 9.8)
    for s in np.flatnonzero((states.axis >= 3) & ~states.scale):
        pushed = force + 1e-6 * np.eye(3)[states.axis[s] - 3]
        found = (from_euler(np.array([*level(pushed), 1.0])) * turn.inv()).as_rotvec()
        np.testing.assert_allclose(rows[:, s], -found[:2] / 1e-6, atol=1e-2 * np.abs(rows).max())


def test_noise_beyond_what_a_filter_can_hold_is_refused(lap, assumptions):
    model = ErrorModel(dict.fromkeys(log.AXES, AxisModel((WhiteNoise(1e28),))))
    inputs = DriveInputs(lap.record(1, SEED), lap.fixes(1, SEED), model, lap.ellipsoid, assumptions, NO_CONTROL)
    begin = start(lap, assumptions, 1)
    with pytest.raises(ValueError, match="drive: expected a path known to within"):
        navigate(inputs, begin)

"""Errors of position that stay: what a filter with solution separation doubts, what it keeps, and what it costs."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from imugap.filters.consistency import nees_band
from imugap.filters.innovation_gate import (
    ACCEPTED,
    CLOSED,
    EXCLUDED,
    NO_CONTROL,
    OPENED,
    RESET,
    SCHEMES,
    SET_ASIDE,
    QualityControl,
)
from imugap.filters.solution_separation import POSITION_OFFSETS, FilterState, restart_offset
from imugap.io.gnss import PLACE_STD
from imugap.kinematics.strapdown import POSITION, VELOCITY
from imugap.navigation.drive.vehicle import DriveInputs, navigate
from imugap.navigation.drive.vehicle_alignment import align
from imugap.simulation.gnss_faults import RAMP, STRETCH, FaultEvent, Faults
from imugap.stream import stream

ROOT = Path(__file__).parents[2]
SEED, RUNS, BEGIN = 81, 40, 120.0
RECIPE = ROOT / "data" / "drive.yaml"
ONLY = replace(NO_CONTROL, separation_s=30.0)
"""Solution separation and no other control."""


def drive(lap, assumptions, run, quality, fixes=None, smooth=False):
    record, good = lap.record(run, SEED), lap.fixes(run, SEED)
    inputs = DriveInputs(record, good, lap.model, lap.ellipsoid, assumptions, quality)
    fixes = good if fixes is None else fixes
    return navigate(replace(inputs, fixes=fixes), align(inputs), smooth)


def spoilt(lap, run, *events, velocity_per_s=0.0):
    faults = replace(Faults.read(RECIPE), velocity_per_s=velocity_per_s)
    return faults.apply(lap.fixes(run, SEED), events, lap.ellipsoid, SEED, run)


def sideways(size, *labels):
    """Return a shift of this length in a horizontal direction that is drawn."""
    angle = stream(SEED, *labels).uniform(0, 2 * np.pi)
    return float(size * np.cos(angle)), float(size * np.sin(angle)), 0.0


def off(lap, one, time):
    """Return the error of the horizontal position at a time, shape (2,), and its covariance."""
    row = int(np.searchsorted(one.time, time - 1e-6))
    truth = lap.path[0].iloc[round(one.time[row] * lap.rate_hz)]
    return one.history.navigation[row, :2] - truth[list(POSITION[:2])].to_numpy(float), one.horizontal[row]


def squared(errors):
    return np.mean([error @ np.linalg.solve(told, error) for error, told in errors])


def test_a_filter_that_never_doubts_is_the_plain_one(lap, assumptions):
    """The offset has no variance, and changes no number beyond rounding."""
    never = replace(ONLY, false_alarm=1e-150)
    plain, one = drive(lap, assumptions, 1, NO_CONTROL), drive(lap, assumptions, 1, never)
    states = len(plain.names)
    assert one.names == [*plain.names, *POSITION_OFFSETS]
    np.testing.assert_allclose(one.history.navigation, plain.history.navigation, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(one.history.errors[:, :states], plain.history.errors, rtol=1e-7, atol=1e-12)
    np.testing.assert_allclose(one.history.variances[:, : states + 9], plain.history.variances, rtol=1e-7)
    assert not one.history.errors[:, states:].any()
    assert not one.record.position_use.any()
    assert not one.record.offset_event.any()


@pytest.mark.slow
def test_good_fixes_are_set_aside_as_often_as_the_rate_says(lap, assumptions):
    alarm, found = 0.01, []
    for run in range(RUNS):
        record = drive(lap, assumptions, run, replace(ONLY, false_alarm=alarm)).record
        found += [*((record.position_use == EXCLUDED) | (record.offset_event == 1))]
    assert abs(np.mean(found) - alarm) < 4 * np.sqrt(alarm / len(found))


@pytest.mark.slow
def test_good_drives_are_nearly_untouched(lap, assumptions):
    """Seldom an offset, by fewer openings than the rate of single fixes would give; errors as without."""
    opened, fixes, sizes = 0, 0, []
    for run in range(RUNS):
        whole, plain = (drive(lap, assumptions, run, SCHEMES[name]) for name in ("separation", "reset"))
        opened += (whole.record.offset_event == 1).sum() + (whole.record.offset_event == 2).sum()
        fixes += len(whole.fix_time)
        sizes.append([np.linalg.norm(off(lap, one, 250.0)[0]) for one in (whole, plain)])
    assert opened < 1e-3 * fixes
    ratio = np.sqrt(np.mean(np.square(sizes), axis=0))
    assert 0.95 < ratio[0] / ratio[1] < 1.05


@pytest.mark.slow
@pytest.mark.parametrize("length", [10.0, 30.0, 60.0])
def test_a_stretch_leaves_the_position_within_what_it_says(lap, assumptions, length):
    """Biased by 20 m: errors at its end, and soon after, as large as told; the source's control is thrown."""
    during, after, thrown, told = [], [], [], []
    for run in range(RUNS):
        event = FaultEvent(STRETCH, BEGIN, BEGIN + length, sideways(20.0, "stretch", run))
        fixes = spoilt(lap, run, event)
        one = drive(lap, assumptions, run, SCHEMES["separation"], fixes)
        during.append(off(lap, one, BEGIN + length))
        after.append(off(lap, one, BEGIN + length + 10))
        thrown.append(off(lap, drive(lap, assumptions, run, SCHEMES["reset"], fixes), BEGIN + length))
        row = int(np.searchsorted(one.time, BEGIN + length - 1e-6))
        offset = one.sensors[list(POSITION_OFFSETS[:2])].iloc[row] - list(event.shift[:2])
        told.append(np.square(offset / one.sensors_std[list(POSITION_OFFSETS[:2])].iloc[row]).mean())
    low, high = nees_band(2, RUNS, 0.9999)
    assert low < squared(during) < high
    assert low < squared(after) < high
    assert squared(thrown) > high
    assert low / 2 < np.mean(told) < high / 2


@pytest.mark.slow
def test_velocities_that_are_worse_than_they_say_do_not_deceive_it(lap, assumptions):
    """In a stretch with velocities off by six of their standard deviations the filter goes on knowing itself."""
    errors = []
    for run in range(RUNS):
        event = FaultEvent(STRETCH, BEGIN, BEGIN + 50, sideways(50.0, "velocities", run))
        fixes = spoilt(lap, run, event, velocity_per_s=0.02)
        one = drive(lap, assumptions, run, SCHEMES["separation"], fixes)
        errors.append(off(lap, one, BEGIN + 50))
    low, high = nees_band(2, RUNS, 0.9999)
    assert low < squared(errors) < 1.5 * high


@pytest.mark.slow
def test_a_ramp_is_seen_by_looking_back(lap, assumptions):
    """It creeps, and no fix of it fails; all the same hardly any of it is in the position at its end."""
    seen, errors, plain = 0, [], []
    for run in range(RUNS):
        event = FaultEvent(RAMP, BEGIN, BEGIN + 50, sideways(0.3, "ramp", run))
        fixes = spoilt(lap, run, event)
        one = drive(lap, assumptions, run, SCHEMES["separation"], fixes)
        times = one.fix_time[one.record.offset_event == 2]
        seen += ((times > BEGIN) & (times < BEGIN + 50)).any()
        errors.append(np.linalg.norm(off(lap, one, BEGIN + 50)[0]))
        other = drive(lap, assumptions, run, SCHEMES["reset"], fixes)
        plain.append(np.linalg.norm(off(lap, other, BEGIN + 50)[0]))
    assert seen > 0.9 * RUNS
    assert np.mean(errors) < 2.5
    assert np.mean(plain) > 3 * np.mean(errors)


def without_velocities(lap, run):
    return lap.fixes(run, SEED).drop(columns=[*VELOCITY, *(f"sd_{name}" for name in VELOCITY)])


def test_an_outlier_is_set_aside_and_no_more(lap, assumptions):
    """As if that fix had not been there."""
    wild = lap.fixes(2, SEED)
    wild.loc[BEGIN, "latitude"] += 60 / 6.4e6
    one = drive(lap, assumptions, 2, ONLY, wild)
    other = drive(lap, assumptions, 2, NO_CONTROL, wild.drop(index=BEGIN))
    np.testing.assert_allclose(one.history.navigation, other.history.navigation, rtol=1e-9, atol=1e-8)
    assert one.events["event"].tolist().count(SET_ASIDE) == 1
    assert not one.record.offset_event.any()


def test_a_closed_offset_gives_back_all_that_the_fixes_had_told(lap, assumptions):
    """Two bad fixes, apart, open an offset; once closed the filter is where it were without these and the next."""
    fixes = without_velocities(lap, 3)
    wild = fixes.copy()
    wild.loc[BEGIN, "latitude"] += 500 / 6.4e6
    wild.loc[BEGIN + 1, "latitude"] -= 500 / 6.4e6
    one = drive(lap, assumptions, 3, ONLY, wild)
    turned = one.record.offset_event[one.record.offset_event > 0].tolist()
    assert turned == [1, 1, 3]
    closed = one.fix_time[one.record.offset_event == 3][0]
    assert closed == BEGIN + 5
    used = one.fix_time[(one.record.position_use == ACCEPTED)]
    blank = fixes.copy()
    blank.loc[~blank.index.isin(used), list(PLACE_STD)] = 1e6
    other = drive(lap, assumptions, 3, NO_CONTROL, blank)
    rows = one.time >= closed
    apart = np.abs(one.history.navigation[rows, :6] - other.history.navigation[rows, :6])
    assert (apart < 1e-3 * np.sqrt(other.history.variances[rows, :6])).all()  # linearised elsewhere in between
    np.testing.assert_allclose(one.history.variances[rows, :21], other.history.variances[rows], rtol=1e-3)


def test_what_it_does_is_logged_with_statistic_and_threshold(lap, assumptions):
    event = FaultEvent(STRETCH, BEGIN, BEGIN + 20, (30.0, 0.0, 0.0))
    quality = SCHEMES["separation"]
    one = drive(lap, assumptions, 4, quality, spoilt(lap, 4, event))
    found = one.events[one.events["component"] == "position"]
    inside = found[(found["time"] >= BEGIN) & (found["time"] < BEGIN + 30)]
    assert inside["event"].tolist() == [SET_ASIDE, OPENED, SET_ASIDE, OPENED, CLOSED]
    assert inside["time"].tolist() == [BEGIN + step for step in (0, 1, 21, 22, 24)]
    beyond = inside["event"] != CLOSED
    assert (inside["statistic"] > inside["threshold"])[beyond].all()
    assert (inside["statistic"] < inside["threshold"])[~beyond].all()
    assert inside["threshold"][~beyond].item() == quality.separation_limit > quality.limits(3)[3]


@pytest.mark.slow
def test_the_smoother_knows_what_the_filter_found_out(lap, assumptions):
    """With a stretch and a ramp it is as right as with good fixes, nearly; without solution separation it is not."""
    sizes = {"good": [], "separation": [], "reset": []}
    for run in range(10):
        events = (
            FaultEvent(STRETCH, 80.0, 120.0, sideways(30.0, "both", run)),
            FaultEvent(RAMP, 170.0, 220.0, (0.4, 0.0, 0.0)),
        )
        bad = spoilt(lap, run, *events)
        for name, given in (("good", None), ("separation", bad), ("reset", bad)):
            one = drive(lap, assumptions, run, SCHEMES["reset" if name == "good" else name], given, smooth=True)
            assert (one.history.variances[:, :21] > 0).all()
            assert np.isfinite(one.history.navigation).all()
            sizes[name] += [np.linalg.norm(off(lap, one, time)[0]) for time in (100.0, 120.0, 140.0, 200.0, 220.0)]
    good, known, plain = (np.sqrt(np.mean(np.square(one))) for one in sizes.values())
    assert good < known < 2.0 * good
    assert plain > 3 * known


def test_a_filter_that_starts_in_a_stretch_is_reset_once_the_fixes_are_right(lap, assumptions):
    """It takes the good fixes for shifted, until no fix has been trusted for too long."""
    fixes = spoilt(lap, 5, FaultEvent(STRETCH, 0.0, 60.0, (40.0, 0.0, 0.0)))
    inputs = DriveInputs(lap.record(5, SEED), fixes, lap.model, lap.ellipsoid, assumptions)
    start, found = align(inputs), {}
    for name, quality in (("reset", QualityControl(reset_s=60.0)), ("none", QualityControl(reset_s=None))):
        found[name] = navigate(replace(inputs, quality=quality), start)
    resets = found["reset"].events
    resets = resets[resets["event"] == RESET]
    assert len(resets) == 1
    assert resets["statistic"].item() == pytest.approx(61, abs=1.1)
    assert np.linalg.norm(off(lap, found["reset"], 200.0)[0]) < 5
    assert np.linalg.norm(off(lap, found["none"], 200.0)[0]) > 30
    smooth = navigate(replace(inputs, quality=QualityControl(reset_s=60.0)), start, smooth=True)
    assert (smooth.history.variances[:, :21] > 0).all()


def test_forgetting_leaves_no_trace_of_the_offset():
    root = stream(SEED, "restart_offset").standard_normal((24, 24))
    covariance, errors, transposed = root @ root.T, np.ones(15), np.ones((24, 24))
    before = covariance[:21, :21].copy()
    restart_offset(covariance, errors, 7.0, transposed)
    np.testing.assert_array_equal(covariance[:21, :21], before)
    np.testing.assert_array_equal(covariance[21:], np.hstack([np.zeros((3, 21)), 7.0 * np.eye(3)]))
    np.testing.assert_array_equal(covariance, covariance.T)
    assert errors[:12].all()
    assert not errors[12:].any()
    assert not transposed[:, 21:].any()
    assert transposed[:, :21].all()


def test_lanes_are_copies_of_the_first():
    one = FilterState(*(np.arange(6.0).reshape(2, 3) for _ in FilterState._fields))
    members = one.copy(3)
    assert all(field.shape == (3, 3) and (field == [0.0, 1.0, 2.0]).all() for field in members)
    members.clock[0, 0] = 9.0
    assert one.clock[0, 0] == 0.0
    assert members.clock[1, 0] == 0.0

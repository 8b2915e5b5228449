"""The start of a drive: lever arm and time offset that a filter estimates from it are as exact as it says."""

import re
from dataclasses import replace

import numpy as np
import pytest

from imugap.filters.consistency import nees_band
from imugap.filters.innovation_gate import NO_CONTROL
from imugap.integrity.rest import departure
from imugap.log import GYRO
from imugap.navigation.drive.vehicle import LEVER_ARM, DriveInputs, navigate
from imugap.navigation.drive.vehicle_alignment import align
from imugap.simulation.drive import DriveLeg

SEED = 58
LEVER = (1.5, -0.6, -1.2)
LEVEL = (
    DriveLeg(15, 0), DriveLeg(6, 9), DriveLeg(14, 12, 95), DriveLeg(12, 8, -60), DriveLeg(14, 13, -100),
    DriveLeg(12, 7, 70), DriveLeg(12, 12, -90), DriveLeg(10, 9, 95), DriveLeg(8, 12),
)  # fmt: skip
"""A level road with many turns."""


@pytest.fixture(scope="module")
def level(lap):
    """A survey receiver at 5 Hz on a level road without bank."""
    receiver = replace(
        lap.receiver, rate_hz=5, lever_m=LEVER, position_std=(0.02, 0.02, 0.04), velocity_std=(0.03, 0.03, 0.06)
    )
    return replace(lap, legs=LEVEL, bank=0.0, receiver=receiver)


def estimates(drive, assumptions, runs):
    """Return the last estimates of the constants over runs, and their covariances."""
    found = []
    for run in range(runs):
        inputs = DriveInputs(
            drive.record(run, SEED), drive.fixes(run, SEED), drive.model, drive.ellipsoid, assumptions, NO_CONTROL
        )
        one = navigate(inputs, align(inputs))
        count = len(assumptions.constants())
        found.append((one.history.errors[-1, -count:], one.covariances[-1][-count:, -count:]))
    return [np.array(column) for column in zip(*found, strict=True)]


def test_a_lever_arm_is_found_with_the_uncertainty_of_the_start(level, assumptions):
    """Two-sided NEES across and along; the component that a level road does not show stays nearly unknown."""
    runs = 12
    assumptions = replace(assumptions, lever_m=(0.0, 0.0, 0.0), lever_std=3.0)
    arms, covariances = estimates(level, assumptions, runs)
    off, std = arms - LEVER, np.sqrt(np.einsum("nii->ni", covariances))
    assert std[:, :2].max() < 0.05
    assert std[:, 2].min() > 0.5
    low, high = nees_band(3, runs, 0.9999)
    assert low < np.mean([e @ np.linalg.solve(p, e) for e, p in zip(off, covariances, strict=True)]) < high
    assert assumptions.constants()[0][0] == LEVER_ARM[0]


@pytest.mark.parametrize("delay", [0.3, -0.1])
def test_a_time_offset_is_followed_from_the_start(level, assumptions, delay):
    receiver = replace(level.receiver, delay_s=delay, lever_m=(0.0, 0.0, 0.0))
    assumptions = replace(assumptions, lever_m=(0.0, 0.0, 0.0), time_offset_std=0.3)
    runs = 6
    found, variance = estimates(replace(level, receiver=receiver), assumptions, runs)
    low, high = nees_band(1, runs, 0.9999)
    assert np.abs(found - delay).max() < 0.01
    assert low < np.mean((found[:, 0] - delay) ** 2 / variance[:, 0, 0]) < high


def test_a_receiver_without_a_vertical_velocity_starts_a_drive_as_early(lap, assumptions):
    """NMEA has speed and course alone."""
    log, fixes = lap.record(0, SEED), lap.fixes(0, SEED)
    starts = [
        align(DriveInputs(log, one, lap.model, lap.ellipsoid, assumptions)).time
        for one in (fixes, fixes.assign(vel_d=np.nan, sd_vel_d=np.nan))
    ]
    assert starts[1] - starts[0] <= 2.0


def test_a_rest_ends_where_the_samples_do_though_noisy_fixes_show_it_late(level, assumptions):
    """Places alone with 1.5 m of noise at 1 Hz tell a speed above 3 m/s, seconds after the departure."""
    receiver = replace(level.receiver, rate_hz=1, lever_m=(0.0, 0.0, 0.0), position_std=(1.5, 1.5, 3.0))
    drive = replace(level, receiver=receiver)
    fixes, record = drive.fixes(1, SEED), drive.record(1, SEED)
    places = fixes[[name for name in fixes if not name.startswith(("vel", "sd_vel"))]]
    inputs = DriveInputs(record, places, drive.model, drive.ellipsoid, assumptions, NO_CONTROL)
    start, states = align(inputs), assumptions.states(drive.model)
    assert departure(record.loc[: record.index[0] + 20]) == pytest.approx(record.index[0] + 15, abs=1.5)
    rates = record.loc[: record.index[0] + 12, list(GYRO)].mean().to_numpy()
    for axis, rate in enumerate(rates):
        bias = start.errors[: len(states)][(states.axis == axis) & ~states.scale].sum()
        assert abs(bias + states.fixed[axis] - rate) < 2e-4


def test_a_course_that_is_too_uncertain_names_the_setting_that_takes_it(level, assumptions):
    noisy = level.fixes(0, SEED).assign(sd_vel_n=3.0, sd_vel_e=3.0)
    inputs = DriveInputs(level.record(0, SEED), noisy, level.model, level.ellipsoid, assumptions, NO_CONTROL)
    with pytest.raises(ValueError, match=r"start: \{course_std_deg: \d+\} takes the best one") as refused:
        align(inputs)
    degrees = float(re.search(r"course_std_deg: (\d+)", str(refused.value))[1])
    taken = replace(inputs, alignment=replace(inputs.alignment, course_std=np.radians(degrees)))
    assert align(taken).time > level.legs[0].duration_s
    with pytest.raises(ValueError, match="a vehicle at rest shows none"):
        align(replace(inputs, fixes=level.fixes(0, SEED).loc[:14]))


def test_a_receiver_that_converges_at_rest_starts_no_drive_by_places_seconds_apart(level, assumptions):
    """Places alone, 2.5 s apart, move by 4.5 m/s at rest; the drive starts once the vehicle is on its way."""
    receiver = replace(level.receiver, rate_hz=0.4, lever_m=(0.0, 0.0, 0.0))
    drive = replace(level, legs=(DriveLeg(60, 0), DriveLeg(20, 40), DriveLeg(200, 40)), receiver=receiver)
    fixes, record = drive.fixes(0, SEED), drive.record(0, SEED)
    places = fixes[[name for name in fixes if not name.startswith(("vel", "sd_vel"))]]
    left = np.clip(40.0 - (places.index - record.index[0]), 0.0, None) * 4.5
    places = places.assign(latitude=places["latitude"] - left / 6.37e6)
    inputs = DriveInputs(record, places, drive.model, drive.ellipsoid, assumptions, NO_CONTROL)
    assert align(inputs).time > record.index[0] + 60

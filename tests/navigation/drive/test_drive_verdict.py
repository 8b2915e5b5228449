"""Device and fixes that contradict each other: the error is named and corrected or refused; sound drives pass."""

import re
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from scipy.signal import lfilter
from tests.navigation.drive.test_vehicle_alignment import LEVEL, LEVER

from imugap import cli, log
from imugap.analysis.drive import RecordedDrive, check, navigate_drive
from imugap.analysis.drive_settings import DriveSettings
from imugap.commands.drive import DISAGREES
from imugap.log import GYRO
from imugap.numerics.rotation import from_euler
from imugap.stream import stream

SEED = 60
PLAIN = (0.0, 0.0, 0.0)


@pytest.fixture(scope="module")
def level(lap):
    receiver = replace(
        lap.receiver, rate_hz=5, lever_m=PLAIN, position_std=(0.5, 0.5, 1.0), velocity_std=(0.05, 0.05, 0.1)
    )
    return replace(lap, legs=LEVEL, bank=0.0, receiver=receiver)


@pytest.fixture(scope="module")
def surveyed(level):
    """The drive with a survey receiver, which shows a lever arm."""
    receiver = replace(level.receiver, lever_m=LEVER, position_std=(0.02, 0.02, 0.04), velocity_std=(0.03, 0.03, 0.06))
    return replace(level, receiver=receiver)


def verdict(drive, fixes=None, record=None, lever=PLAIN):
    plain = DriveSettings()
    settings = replace(plain, assumptions=replace(plain.assumptions, lever_m=lever))
    record = drive.record(1, SEED) if record is None else record
    return navigate_drive(RecordedDrive(record, drive.fixes(1, SEED) if fixes is None else fixes, settings))


def later(fixes, seconds):
    return fixes.set_index(pd.Index(fixes.index + seconds, name=fixes.index.name))


@pytest.mark.parametrize("run", range(2))
@pytest.mark.parametrize("dropped", [(), pytest.param(("sd",), marks=pytest.mark.slow)])
def test_a_sound_drive_passes_without_a_word(level, run, dropped):
    fixes = level.fixes(run, SEED)
    fixes = fixes[[name for name in fixes if not name.startswith(dropped or "none")]]
    found = verdict(level, fixes[(fixes.index < 60) | (fixes.index > 75)], level.record(run, SEED)).verdict
    assert found.agrees
    assert found.factor == 1.0
    assert str(found) == "Device and fixes agree."


def test_a_sound_drive_with_a_stretch_of_gross_errors_says_what_share_of_the_fixes_does_not_fit(level):
    fixes = level.fixes(1, SEED)
    fixes.loc[(fixes.index >= 60) & (fixes.index < 62.5), "latitude"] += 40 / 6.4e6
    found = verdict(level, fixes).verdict
    assert found.agrees
    assert re.fullmatch(r"Device and fixes agree, but for [1-4]\.\d% of the fixes, which count .*", str(found))


def test_fixes_that_are_off_to_the_end_are_named(level):
    fixes = level.fixes(1, SEED)
    fixes.loc[fixes.index >= fixes.index[-1] - 12, "latitude"] += 40 / 6.4e6
    found = verdict(level, fixes).verdict
    assert not found.agrees
    assert found.offset_since == pytest.approx(fixes.index[-1] - 12, abs=3)
    answer, *_, lasting = str(found).splitlines()
    assert f"agree only until {found.offset_since:.10g} s" in answer
    assert lasting.startswith(f"From {found.offset_since:.10g} s to the end the path lies beside the fixes")


@pytest.mark.parametrize("seconds", [18.0, -7.3, 0.2])
def test_a_time_offset_is_named_and_corrected(level, seconds):
    found = verdict(level, later(level.fixes(1, SEED), seconds))
    assert found.verdict.corrections[0].error == "time offset"
    answer, mend = str(found.verdict).splitlines()
    assert answer == "Device and fixes do not fit as given: time offset. Corrected, they agree."
    assert re.search(r"\(time_offset: \{offset_s: -?\d", mend)
    assert not found.verdict.reasons
    assert found.summary()["time_offset_s"]["value"] == pytest.approx(-seconds, abs=0.02)
    assert ("as of GPS time" in str(found.verdict)) == (seconds == 18)


@pytest.mark.parametrize(("lever", "words"), [
    (tuple(-one for one in LEVER), "opposite sign"), (PLAIN, "m away from where the lever arm has it"),
])  # fmt: skip
def test_a_wrong_lever_arm_is_named_and_corrected(surveyed, lever, words):
    found = verdict(surveyed, lever=lever)
    (correction,) = found.verdict.corrections
    assert words in correction.found
    arm = found.summary()["lever_arm_m"]
    assert [arm[axis]["value"] for axis in "xy"] == pytest.approx(LEVER[:2], abs=0.1)
    assert found.summary()["nis"] < 1.3


def test_a_receiver_with_more_noise_than_stated_is_named(level):
    fixes = level.fixes(1, SEED)
    found = verdict(level, fixes.assign(**{name: fixes[name] / 4 for name in fixes if name.startswith("sd")}))
    assert [one.error for one in found.verdict.corrections] == ["receiver noise"]
    assert found.summary()["receiver_std"]["north"] == pytest.approx(0.5, rel=0.3)


def test_a_device_that_points_aside_is_named(level):
    record, turn = level.record(1, SEED), from_euler(np.array([0.0, 0.0, -np.pi / 2]))
    for triad in (GYRO, ("accel_x", "accel_y", "accel_z")):
        record = record.assign(**dict(zip(triad, turn.apply(record[list(triad)].to_numpy(copy=True)).T, strict=True)))
    (correction,) = verdict(level, record=record).verdict.corrections
    assert correction.error == "mounting"
    assert "90 deg to the left" in correction.found or "90 deg to the right" in correction.found


def at_rate(record, factor):
    """The record with intervals longer by a factor."""
    first = record.index[0]
    return record.set_index(pd.Index(first + factor * (record.index - first), name=record.index.name))


SAMPLES = {
    "as in deg/s": lambda one: one.assign(**{name: np.degrees(one[name]) for name in GYRO}),
    "converted twice": lambda one: one.assign(**{name: np.radians(one[name]) for name in GYRO}),
    "right-handed gyro_z": lambda one: one.assign(gyro_z=-one["gyro_z"]),
    "accel_y along": lambda one: one.assign(accel_y=-one["accel_y"]),
    "rates of half the turns": lambda one: one.assign(**{name: one[name] / 2 for name in GYRO}),
    "gyro_y and gyro_z exchanged": lambda one: one.assign(gyro_y=one["gyro_z"], gyro_z=one["gyro_y"]),
    "accel_x and accel_y exchanged": lambda one: one.assign(accel_x=one["accel_y"], accel_y=one["accel_x"]),
    "left-handed ones": lambda one: one.assign(gyro_y=-one["gyro_y"], accel_y=-one["accel_y"]),
    "the rate is half the stated one": lambda one: at_rate(one, 0.5),
    "gravity is removed": lambda one: one.assign(accel_z=one["accel_z"] / 3),
}


@pytest.mark.slow
@pytest.mark.parametrize(("words", "spoil"), SAMPLES.items(), ids=SAMPLES)
def test_a_wrong_unit_or_sign_of_the_samples_is_refused(level, words, spoil):
    with pytest.raises(ValueError, match=f"drive: expected .*{words}"):
        verdict(level, record=spoil(level.record(1, SEED)))


@pytest.mark.slow
@pytest.mark.parametrize("mirrored", [False, True])
def test_places_alone_show_an_exchange_or_a_sign(level, mirrored):
    fixes = level.fixes(1, SEED)[["latitude", "longitude", "height", "sd_n", "sd_e", "sd_d"]]
    exchanged = fixes.assign(latitude=fixes["longitude"], longitude=fixes["latitude"])
    with pytest.raises(ValueError, match=r"fixes: expected latitude, longitude in this order.*opposite sign"):
        verdict(level, fixes.assign(longitude=-fixes["longitude"]) if mirrored else exchanged)


@pytest.mark.slow
def test_a_sign_and_a_time_offset_at_once_are_named_together(level):
    record = level.record(1, SEED)
    with pytest.raises(ValueError, match=r"opposite sign of the turns.*stamps of the fixes that are 18\.0. s late"):
        verdict(level, later(level.fixes(1, SEED), 18.0), record.assign(gyro_z=-record["gyro_z"]))


@pytest.mark.parametrize("rate", [1e-2, 1e-3])
def test_a_clock_that_goes_too_fast_is_named_and_corrected(level, rate):
    drive = replace(level, legs=2 * LEVEL)
    found = verdict(drive, record=at_rate(drive.record(1, SEED), 1 - rate))
    (correction,) = found.verdict.corrections
    assert correction.error == "clock rate"
    assert found.inputs.assumptions.clock_rate == pytest.approx(rate, rel=0.1)
    assert not found.verdict.reasons


def test_a_clock_rate_of_the_configuration_is_used(level):
    record, fixes = at_rate(level.record(1, SEED), 0.99), level.fixes(1, SEED)
    found = navigate_drive(RecordedDrive(record, fixes, DriveSettings(clock_rate=1 / 0.99 - 1)))
    assert found.verdict.agrees
    assert found.table(found.smoothed).index[-1] == pytest.approx(record.index[-1], abs=0.1)


def test_a_clock_that_is_set_in_between_is_not_taken_for_a_drift(level):
    drive = replace(level, legs=2 * LEVEL)
    fixes = drive.fixes(1, SEED)
    time = fixes.index.to_numpy()
    found = verdict(drive, later(fixes, np.where(time > np.median(time), 0.4, 0.0))).verdict
    assert not found.agrees
    assert any("time offset of the fixes changes by 0.4" in reason for reason in found.reasons)


def test_an_offset_that_the_filter_gives_up_is_named(level):
    """From the middle on the fixes are 47 m lower, as above the geoid."""
    drive = replace(level, legs=2 * LEVEL)
    fixes = drive.fixes(1, SEED)
    middle = np.median(fixes.index)
    found = verdict(drive, fixes.assign(height=fixes["height"] - 47.0 * (fixes.index > middle)), drive.record(1, SEED))
    assert not found.verdict.agrees
    assert found.verdict.offsets[0].begin == pytest.approx(middle, abs=10)
    assert found.verdict.offsets[0].size == pytest.approx(47, abs=3)


def test_a_device_that_turns_in_its_mounting_is_not_explained_by_noise(level):
    record, turn = level.record(1, SEED), from_euler(np.array([0.0, 0.1, 0.2]))
    half = record.index > np.median(record.index)
    for triad in (GYRO, ("accel_x", "accel_y", "accel_z")):
        turned = turn.apply(record.loc[half, list(triad)].to_numpy(copy=True))
        record.loc[half, list(triad)] = turned
    found = verdict(level, record=record).verdict
    assert found.reasons
    assert str(found).startswith("Device and fixes do not agree")
    assert "which its samples do not show" in str(found).splitlines()[0]


@pytest.mark.slow
def test_slow_errors_of_a_receiver_that_states_its_noise_are_named(surveyed):
    drive = replace(surveyed, receiver=replace(surveyed.receiver, lever_m=PLAIN))
    fixes = drive.fixes(0, SEED)
    stated = slow(fixes, 0, (2.0, 2.0, 4.0), 60.0).assign(sd_n=2.0, sd_e=2.0, sd_d=4.0)
    stated = stated.assign(**{name: fixes[name] for name in fixes if name.startswith("sd_vel")})
    found = verdict(drive, stated, drive.record(0, SEED)).verdict
    assert "slow errors" in [one.error for one in found.corrections]


def test_a_scale_that_outliers_alone_show_is_named(level):
    drive = replace(level, legs=2 * LEVEL, receiver=replace(level.receiver, rate_hz=1))
    record = drive.record(1, SEED)
    found = verdict(drive, record=record.assign(gyro_z=1.15 * record["gyro_z"])).verdict
    assert "scale factor" in [one.error for one in found.corrections]


def test_places_alone_in_noise_show_no_exchange(surveyed):
    """With the noise of a receiver that states none, only an exchange would make the motion stand out."""
    fixes = surveyed.fixes(0, SEED)
    places = fixes[[name for name in fixes if not name.startswith(("sd", "vel"))]]
    assert verdict(surveyed, places, surveyed.record(0, SEED), LEVER).verdict.agrees


def test_strict_ends_with_a_code_of_its_own(level, tmp_path, capsys):
    fixes = later(level.fixes(1, SEED), 0.2)
    places = {name: np.degrees(fixes[name]) for name in ("latitude", "longitude")}
    log.write(level.record(1, SEED), tmp_path / "imu.csv")
    fixes.assign(**places).to_csv(tmp_path / "gnss.csv")
    line = ["drive", f"{tmp_path}/imu.csv", f"{tmp_path}/gnss.csv", "--strict", "--out", f"{tmp_path}/found"]
    assert cli.main(line) == DISAGREES
    assert "time_offset: {offset_s: -0." in capsys.readouterr().out


@pytest.mark.slow
def test_the_noise_of_places_that_state_none_is_estimated(level):
    """Three metres at 1 Hz, of which neighbours do not tell the course."""
    receiver = replace(level.receiver, rate_hz=1, position_std=(3.0, 3.0, 5.0))
    drive = replace(level, legs=3 * LEVEL, receiver=receiver)
    fixes = drive.fixes(1, SEED)
    found = verdict(drive, fixes[["latitude", "longitude", "height"]], drive.record(1, SEED))
    assert found.verdict.agrees
    assert found.summary()["receiver_std"]["north"] == pytest.approx(3.0, rel=0.3)


def slow(fixes, seed, std, correlation_s):
    """Fixes with Gauss-Markov errors of their position besides, without stated deviations."""
    rng, step = stream(SEED, "slow", seed), float(np.median(np.diff(fixes.index)))
    keep = np.exp(-step / correlation_s)
    driving = rng.normal(0.0, 1.0, (len(fixes), 3)) * np.array(std)
    driving[1:] *= np.sqrt(1 - keep**2)
    errors = lfilter([1.0], [1.0, -keep], driving, axis=0)
    place = {"latitude": errors[:, 0] / 6.37e6, "longitude": errors[:, 1] / 6.37e6 / np.cos(fixes["latitude"].iloc[0]),
             "height": -errors[:, 2]}  # fmt: skip
    names = [name for name in fixes if not name.startswith("sd")]
    return fixes[names].assign(**{name: fixes[name] + one for name, one in place.items()})


@pytest.mark.slow
@pytest.mark.parametrize("run", range(2))
def test_slow_errors_of_a_receiver_are_states_and_leave_the_time_offset_right(surveyed, run):
    """Errors of 2 m over 60 s and 3 cm from fix to fix; the stated interval of the time offset holds it."""
    level = replace(surveyed, receiver=replace(surveyed.receiver, lever_m=PLAIN))
    fixes = slow(later(level.fixes(run, SEED), 0.2), run, (2.0, 2.0, 4.0), 60.0)
    found = verdict(level, fixes, level.record(run, SEED))
    said = found.summary()
    assert [one.error for one in found.verdict.corrections] == ["time offset"]
    assert not found.verdict.reasons
    assert abs(said["time_offset_s"]["value"] + 0.2) < 4 * said["time_offset_s"]["std"] + 1e-3
    assert 0.5 < said["receiver_slow_std"]["north"] * np.sqrt(60.0 / said["receiver_slow_s"]) / 2.0 < 2.0
    assert said["receiver_std"]["north"] < 0.2


@pytest.mark.parametrize(("start", "shift", "words"), [
    (1.7e9, 18 - 315_964_800, r"seconds of GPS time against seconds since 1970 \(time_offset: {offset_s: 315964782}\)"),
    (1.7e9, 18 - 315_964_800 - 2288 * 604_800, "seconds of the GPS week against seconds since 1970"),
    (0.0, 345_600.0, r"are they on one clock\? time_offset: {offset_s: -345"),
])  # fmt: skip
def test_clocks_that_are_far_apart_are_named(level, start, shift, words):
    record, fixes = (later(one, start) for one in (level.record(1, SEED), level.fixes(1, SEED)))
    with pytest.raises(ValueError, match=f"expected fixes within the time of the log.*{words}"):
        check(RecordedDrive(record, later(fixes, shift), DriveSettings()))

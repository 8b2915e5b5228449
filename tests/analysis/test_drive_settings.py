"""Settings of a drive are written in the keys of their schema, and give the same drive again."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from tests.navigation.drive.test_drive_verdict import SEED, later, level, surveyed  # noqa: F401 (fixtures)

from imugap.analysis.drive import RecordedDrive, navigate_drive
from imugap.analysis.drive_settings import SCHEMA, DriveSettings
from imugap.filters.innovation_gate import QualityControl
from imugap.io.catalogue.public_drives import read_car
from imugap.io.configuration import configure
from imugap.io.gnss import PLACE, PLACE_STD, VELOCITY_STD
from imugap.log import ACCEL, GYRO
from imugap.navigation.drive.vehicle import AlignmentSettings, DriveAssumptions
from imugap.numerics.rotation import from_euler

ALL = DriveSettings(
    mounting=(0.1, -0.2, 3.0),
    assumptions=DriveAssumptions(
        (1.0, 2.0, 3.0), 0.5, -0.25, 0.3, 0.12, 2e-4, (0.01, 0.02), 100.0, (2.0, 2.0, 5.0), (0.5, 0.5, 0.7), 30.0,
        (0.2, 0.2, 0.4), (2.0, 3.0, 0.5, 1.5), 0.1, 0.1, 3.0, (-1.0, 0.1, 0.2),
    ),
    quality=QualityControl(4.0, False, 3.0, 1e-4, False, None, (30.0, 1.0, 0.05), None),
    alignment=AlignmentSettings(0.4, 5.0, 1.0, 0.2, 0.03, 0.01, 0.05),
    clock_rate=2e-4,
)  # fmt: skip


def again(settings, path):
    """Return the settings as read from the files that are written of them."""
    settings.model.write(path / "model.yaml")
    (path / "settings.yaml").write_text(settings.text("model.yaml"))
    return DriveSettings.read(path / "settings.yaml")


@pytest.mark.parametrize("settings", [ALL, DriveSettings()])
def test_every_setting_survives_its_text(tmp_path, settings):
    found = again(settings, tmp_path)
    assert found.model == settings.model
    assert found.quality == settings.quality
    assert found.mounting == pytest.approx(settings.mounting, rel=1e-12)
    for name in vars(settings.alignment):
        assert getattr(found.alignment, name) == pytest.approx(getattr(settings.alignment, name), rel=1e-12)
    assert found.assumptions == replace(settings.assumptions, clock_rate=0.0)
    assert found.clock_rate == pytest.approx(settings.clock_rate, rel=1e-12)


def test_defaults_are_left_out():
    assert DriveSettings.of(configure({}, SCHEMA), DriveSettings().model).mapping() == {}


def turned(record):
    """The log of a device that points to the left."""
    turn = from_euler(np.array([0.0, 0.0, -np.pi / 2])).inv()
    parts = [turn.apply(record[list(triad)].to_numpy(copy=True)) for triad in (GYRO, ACCEL)]
    return pd.DataFrame(np.hstack(parts), index=record.index, columns=[*GYRO, *ACCEL])


def late_velocities(fixes):
    return fixes.assign(**{
        name: np.interp(fixes.index - 0.3, fixes.index, fixes[name]) for name in ("vel_n", "vel_e", "vel_d")
    })  # fmt: skip


def without_noise(fixes):
    return fixes.drop(columns=[*PLACE_STD, *VELOCITY_STD])


DRIVES = {
    "time offset": ("level", lambda one: later(one, 0.2), None),
    "time offset and late velocities": ("level", lambda one: later(late_velocities(one), 0.2), None),
    "receiver noise": ("level", lambda one: one.assign(**{n: one[n] / 4 for n in (*PLACE_STD, *VELOCITY_STD)}), None),
    "no stated noise": ("level", without_noise, None),
    "lever arm": ("surveyed", None, None),
    "mounting": ("level", None, turned),
}


@pytest.mark.each
@pytest.mark.slow
@pytest.mark.parametrize(("drive", "spoil", "turn"), DRIVES.values(), ids=DRIVES)
def test_the_settings_in_use_give_the_same_path_again_and_then_fit(request, tmp_path, drive, spoil, turn):
    drive = request.getfixturevalue(drive)
    record, fixes = drive.record(1, SEED), drive.fixes(1, SEED)
    record, fixes = turn(record) if turn else record, spoil(fixes) if spoil else fixes
    first = navigate_drive(RecordedDrive(record, fixes, DriveSettings()))
    second = navigate_drive(RecordedDrive(record, fixes, again(first.settings, tmp_path)))
    assert second.verdict.agrees
    assert not first.verdict.reasons
    for one, other in ((first.filtered, second.filtered), (first.smoothed, second.smoothed)):
        np.testing.assert_allclose(other.history.navigation, one.history.navigation, atol=1e-6, rtol=0)


@pytest.mark.slow
def test_a_time_offset_and_a_delay_of_the_velocities_are_found_together(level):  # noqa: F811
    fixes = later(late_velocities(level.fixes(1, SEED)), 0.2)
    found = navigate_drive(RecordedDrive(level.record(1, SEED), fixes, DriveSettings()))
    used = found.settings.assumptions
    assert used.time_offset_s == pytest.approx(-0.2, abs=0.03)
    assert used.velocity_delay_s == pytest.approx(0.3, abs=0.03)
    named = {one.error: one.setting for one in found.verdict.corrections}
    assert "velocity_delay_s" in named["delay of velocities"]
    assert "offset_s: -0." in named["time offset"]


@pytest.mark.slow
def test_the_time_offset_of_the_real_car_is_the_same_by_positions_and_with_late_velocities(sets, mirror, tmp_path):
    """Fixes 0.1 s late, of a receiver whose velocities are late as well; the settings found give the same path."""
    dataset = sets["rtklibexplorer_drive"]
    car = read_car(*(dataset.file(1, content).place(mirror) for content in ("log", "clock", "fixes")), dataset)
    fixes = later(car.fixes, 0.1)
    whole, places = (
        navigate_drive(RecordedDrive(car.log, some, DriveSettings())) for some in (fixes, fixes[[*PLACE, *PLACE_STD]])
    )
    by_all, by_places = (one.settings.assumptions for one in (whole, places))
    assert by_places.time_offset_s == pytest.approx(-0.1, abs=0.02)
    assert by_all.time_offset_s == pytest.approx(by_places.time_offset_s, abs=0.01)
    assert by_all.velocity_delay_s == pytest.approx(0.13, abs=0.03)
    drifts = whole.outages.drifts.set_index("length_s")
    assert drifts.loc[10.0, "windows"] > 40
    assert 0.5 < drifts.loc[10.0, "ratio"] < 2.0
    second = navigate_drive(RecordedDrive(car.log, fixes, again(whole.settings, tmp_path)))
    np.testing.assert_allclose(second.filtered.history.navigation, whole.filtered.history.navigation, atol=1e-3, rtol=0)

"""Drift over outages: consistent on drives of the filter's own model, and shown where a device drifts more."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from tests.navigation.drive.test_drive_verdict import SEED, level  # noqa: F401 (fixture)

from imugap.analysis.drive import RecordedDrive, check, prepare, screen
from imugap.analysis.drive_settings import DriveSettings
from imugap.navigation.drive.outages import LENGTHS_S, SETTLING_S, Outages, outages_of

LAPS = 2


def inputs_of(drive, run, settings, spoil=lambda record: record):
    recorded = RecordedDrive(spoil(drive.record(run, SEED)), drive.fixes(run, SEED), settings)
    return prepare(check(screen(recorded))).inputs


@pytest.fixture(scope="module")
def drive(level):  # noqa: F811
    return replace(level, legs=LAPS * level.legs)


@pytest.fixture(scope="module")
def settings(drive):
    return replace(DriveSettings(), model=drive.model)


def test_windows_are_disjoint_as_long_as_they_say_and_as_many_as_the_drive_has_room_for(drive, settings):
    inputs = inputs_of(drive, 0, settings)
    windows = outages_of(inputs).windows
    first, last = inputs.log.index[0], inputs.fixes.index[-1]
    for length, own in windows.groupby("length_s"):
        taken = own["end"] - own["begin"]
        assert ((taken <= length + 1e-6) & (taken >= 0.9 * length)).all()
        assert (own["begin"].to_numpy()[1:] >= own["end"].to_numpy()[:-1]).all()
        room = last - first - SETTLING_S
        assert room / length - 2 - 20 / length < len(own) <= room / length
    assert set(windows["length_s"]) == set(LENGTHS_S)


@pytest.mark.slow
def test_the_drift_is_as_stated_for_a_filter_that_knows_its_errors(drive, settings):
    """Over all windows of some drives, the normalised square is in its band; either side fails."""
    runs = [outages_of(inputs_of(drive, run, settings)).windows for run in range(6)]
    together = Outages(pd.concat(runs))
    short = together.drifts.set_index("length_s").loc[10.0]
    assert short["ratio_low"] < short["ratio"] < short["ratio_high"]
    assert short["rms_m"] == pytest.approx(short["stated_rms_m"], rel=0.25)
    square, limit = together.test
    assert square < limit


def test_a_drift_beyond_what_is_stated_is_seen_and_one_below_as_well(drive, settings):
    """A rate of 0.5 deg/s that comes and goes is a drift; ten times the noise stated is a pessimistic filter."""

    def wander(record):
        return record.assign(gyro_z=record["gyro_z"] + np.radians(0.5) * np.sin(2 * np.pi * record.index / 40))

    spoilt = outages_of(inputs_of(drive, 0, settings, wander))
    assert spoilt.drifts["ratio"].max() > 2
    assert spoilt.test[0] > spoilt.test[1]
    cautious = replace(settings, model=DriveSettings().model)
    drifts = outages_of(inputs_of(drive, 0, cautious)).drifts.iloc[0]
    assert drifts["ratio"] < drifts["ratio_low"]


def test_a_fix_with_a_gross_error_ends_no_window(drive, settings):
    fixes = drive.fixes(0, SEED)
    off = (fixes.index > 80) & (fixes.index < 82)
    fixes = fixes.assign(latitude=fixes["latitude"] + 100 / 6.4e6 * off)
    inputs = prepare(check(screen(RecordedDrive(drive.record(0, SEED), fixes, settings)))).inputs
    windows = outages_of(inputs).windows
    assert not set(fixes.index[off]) & {*windows["begin"], *windows["end"]}


def test_a_drive_without_room_has_no_window(level, settings):  # noqa: F811
    inputs = inputs_of(level, 0, settings)
    short = replace(inputs, log=inputs.log.loc[:60])
    found = outages_of(short)
    assert found.windows.empty
    assert found.drifts.empty
    assert np.isnan(found.test[0])

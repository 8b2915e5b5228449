"""Fixes that no filter can use are left out, wrong units and orders refused by name; sound fixes pass."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from imugap.io import gnss
from imugap.navigation.drive.fix_screening import screen
from imugap.stream import stream

SEED = 59
STD = (1.5, 1.5, 3.0)
SPEEDS = ["vel_n", "vel_e", "vel_d"]


@pytest.fixture(scope="module", params=[1, 5, 10])
def fixes(lap, request):
    return replace(lap, receiver=replace(lap.receiver, rate_hz=request.param)).fixes(1, SEED)


@pytest.fixture(scope="module")
def sound(lap):
    return replace(lap, receiver=replace(lap.receiver, rate_hz=5)).fixes(2, SEED)


def test_sound_fixes_pass_with_outages_and_outliers(fixes):
    spoilt = fixes[(fixes.index < 150) | (fixes.index > 190)].copy()
    spoilt.iloc[60, 0] += 80 / 6.4e6
    for one in (fixes, spoilt, fixes.drop(columns=[name for name in fixes if "vel" in name])):
        found, _, corrections = screen(one, STD)
        assert found is one or found.equals(one)
        assert not corrections


@pytest.mark.parametrize("shift", [(3e-3, 0.0), (0.0, 3e-5), (-0.4, 2.0)])
def test_first_fixes_from_elsewhere_are_left_out(fixes, shift):
    wrong = fixes.copy()
    wrong.iloc[:8, 0] += shift[0]
    wrong.iloc[:8, 1] += shift[1]
    found, _, (correction,) = screen(wrong, STD)
    assert found.equals(wrong.iloc[8:])
    assert correction.error == "fixes from elsewhere"


@pytest.mark.parametrize("rows", [slice(0, 9), slice(100, 103)])
def test_fixes_at_zero_are_left_out(fixes, rows):
    wrong = fixes.copy()
    wrong.iloc[rows, :3] = 0
    found, _, (correction,) = screen(wrong, STD)
    assert len(found) == len(fixes) - (rows.stop - rows.start)
    assert correction.error == "fixes before lock"


@pytest.mark.parametrize("times", [2, 5, 10])
def test_held_fixes_are_kept_once(sound, times):
    own = sound.iloc[::5]
    held = own.loc[own.index.repeat(times)]
    held.index = held.index + np.tile(np.arange(times), len(own)) / times
    held.index.name = sound.index.name
    found, _, (correction,) = screen(held, STD)
    assert correction.error == "held fixes"
    assert np.isin(own.index, found.index).mean() > 0.99
    assert len(found) < 1.01 * len(own)


def test_a_receiver_that_stands_may_repeat_itself(sound):
    still = sound.copy()
    columns = [*gnss.PLACE, *SPEEDS]
    still.loc[:14.0, columns] = still[columns].iloc[0].to_numpy()
    still.loc[:14.0, SPEEDS] = 0.0
    assert not screen(still, STD).corrections


def turned(fixes, **columns):
    return fixes.assign(**{name: fixes[other] for name, other in columns.items()})


WRONG = {
    "as in km/h": lambda one: one.assign(**{name: 3.6 * one[name] for name in SPEEDS}),
    "as in knots": lambda one: one.assign(**{name: one[name] / 0.514444 for name in SPEEDS}),
    "as in cm/s": lambda one: one.assign(**{name: 100 * one[name] for name in SPEEDS}),
    "as in radians": lambda one: one.assign(**{name: np.radians(one[name]) for name in ("latitude", "longitude")}),
    "latitude and longitude in this order": lambda one: turned(one, latitude="longitude", longitude="latitude"),
    "vel_n and vel_e in this order": lambda one: turned(one, vel_n="vel_e", vel_e="vel_n"),
    "opposite to the displacements": lambda one: one.assign(vel_n=-one["vel_n"], vel_e=-one["vel_e"]),
    "positive to the east": lambda one: one.assign(longitude=-one["longitude"]),
    "vel_n positive to the north": lambda one: one.assign(vel_n=-one["vel_n"]),
    "as where minutes are written as decimals": lambda one: one.assign(
        **{name: one[name].iloc[0] + 0.6 * (one[name] - one[name].iloc[0]) for name in ("latitude", "longitude")}
    ),
}


@pytest.mark.parametrize(("message", "spoil"), WRONG.items(), ids=WRONG)
def test_a_wrong_unit_or_order_is_named(sound, message, spoil):
    with pytest.raises(ValueError, match=f"fixes: expected .*{message}|fixes: expected {message}"):
        screen(spoil(sound), STD)


def test_velocities_that_contradict_positions_are_left_out(sound):
    rng = stream(SEED, "contradiction")
    wrong = sound.assign(**{name: rng.normal(0, 10, len(sound)) for name in SPEEDS})
    found, _, (correction,) = screen(wrong, STD)
    assert correction.error == "velocities that contradict positions"
    assert not set(SPEEDS) & set(found.columns)


def test_velocities_of_no_known_unit_get_no_name(sound):
    """1.5 times the displacements: nearer to none of the units than a receiver errs."""
    *_, (correction,) = screen(sound.assign(**{name: 1.5 * sound[name] for name in SPEEDS}), STD)
    assert correction.error == "velocities that contradict positions"


@pytest.mark.parametrize("delay", [0.6, -0.4])
def test_the_delay_of_velocities_against_the_positions_is_estimated(sound, delay):
    late = sound.assign(**{name: np.interp(sound.index - delay, sound.index, sound[name]) for name in SPEEDS})
    found, estimate, (correction,) = screen(late, STD)
    assert correction.error == "delay of velocities"
    assert f"velocity_delay_s: {estimate:.3f}" in correction.setting
    assert estimate == pytest.approx(delay, abs=0.1)
    assert found.equals(late)
    again = screen(late, STD, estimate)
    assert again.delay_s == estimate
    assert not again.corrections


def test_a_vertical_velocity_that_is_not_measured_is_left_out(sound):
    found, _, (correction,) = screen(sound.assign(vel_d=0.0), STD)
    assert correction.error == "vertical velocity"
    assert found["vel_d"].isna().all()
    assert found[SPEEDS[:2]].equals(sound[SPEEDS[:2]])


def test_a_vertical_velocity_of_the_opposite_sign_is_seen_beyond_the_noise_of_the_heights(lap):
    noisy = replace(lap.receiver, rate_hz=1, position_std=(1.5, 1.5, 3.0))
    flat = replace(lap, receiver=noisy).fixes(1, SEED)
    phase = 2 * np.pi * flat.index.to_numpy() / 60
    fixes = flat.assign(
        height=flat["height"] + 8 * np.sin(phase), vel_d=flat["vel_d"] - 16 * np.pi / 60 * np.cos(phase)
    )
    screen(fixes, STD)
    with pytest.raises(ValueError, match="expected vel_d positive down"):
        screen(fixes.assign(vel_d=-fixes["vel_d"]), STD)


def test_held_fixes_are_known_by_their_place_not_by_their_digits(sound):
    own = sound.iloc[::5]
    held = own.loc[own.index.repeat(5)]
    held.index = held.index + np.tile(np.arange(5), len(own)) / 5
    held.index.name = sound.index.name
    found, _, (correction,) = screen(held.assign(latitude=held["latitude"] + 1e-11 * np.arange(len(held))), STD)
    assert correction.error == "held fixes"
    assert len(found) < 2 * len(own)


@pytest.mark.parametrize("times", [2, 5, 10])
def test_interpolated_fixes_are_left_out(sound, times):
    own = sound.iloc[::5]
    step = 1.0 / times
    stamps = np.round(np.arange(own.index[0], own.index[-1] + step / 2, step), 9)
    columns = {name: np.interp(stamps, own.index, own[name]) for name in own}
    found, _, (correction,) = screen(pd.DataFrame(columns, index=pd.Index(stamps, name=sound.index.name)), STD)
    assert correction.error == "interpolated fixes"
    assert len(found) < 1.2 * len(own)

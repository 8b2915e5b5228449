"""The published protocol: alignment and error of a track, figures over trials, settings of the other fold."""

import numpy as np
import pandas as pd
import pytest

from imugap.study.walk.walk_protocol import FIGURES, armse, cvar, distance_rms, held_out, summary


def track():
    time = np.linspace(0, 2 * np.pi, 500)
    return np.column_stack([3 * np.sin(time), 2 - 2 * np.cos(time)])


def turned(plane, angle):
    c, s = np.cos(angle), np.sin(angle)
    return plane @ [[c, s], [-s, c]]


def test_heading_and_origin_of_a_track_make_no_error():
    found = turned(track(), 2.0) + np.array([5.0, -3.0])
    assert armse(found, track()) < 1e-9
    assert distance_rms(found, track()) < 1e-9


def test_the_error_is_the_mean_over_samples_of_the_root_mean_square_of_both_axes():
    """A side step of 0.3 m over the second half, after the point at which headings are made equal."""
    side = np.where(np.arange(500) >= 250, 0.3, 0.0)
    found = track() + np.column_stack([side, np.zeros(500)])
    assert armse(found, track()) == pytest.approx(0.5 * 0.3 / np.sqrt(2), rel=1e-9)
    assert distance_rms(found, track()) == pytest.approx(0.3 * np.sqrt(0.5), rel=1e-9)


def test_samples_that_were_not_seen_are_left_out():
    seen = track()
    seen[100:140] = np.nan
    assert armse(track(), seen) < 1e-9


def test_a_scale_error_stays():
    assert armse(1.1 * track(), track()) > 0.05


def test_figures_of_known_errors():
    errors = np.arange(1.0, 101.0)
    assert cvar(errors, 0.9) == pytest.approx(95.5)
    assert {name: float(figure(errors)) for name, figure in FIGURES.items()} == pytest.approx(
        {"mean": 50.5, "median": 50.5, "p95": 95.05, "cvar90": 95.5}
    )
    for name, (value, low, high) in summary(errors, np.random.default_rng(1)).items():
        assert low < value < high or (name == "cvar90" and low < value <= high)


def test_the_setting_of_a_trial_is_chosen_on_the_other_fold():
    """a is best on odd trials, b on even ones: each trial gets the one that is worse for it."""
    trials = [f"t{number}" for number in range(8)]
    rows = [
        {"trial": trial, "setting": setting, "error": 1.0 + (("ab"[at % 2]) != setting)}
        for at, trial in enumerate(trials)
        for setting in "ab"
    ]
    kept = held_out(pd.DataFrame(rows))
    assert list(kept["trial"]) == trials
    assert list(kept["setting"]) == ["b", "a"] * 4
    assert (kept["error"] == 2.0).all()

"""Discrepancies: uniform p-values where nothing is hidden, a place where something is."""

from collections import defaultdict
from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import butter, lfilter
from scipy.stats import binomtest, kstest
from tests.discovery.simulated import simulated

from imugap import log
from imugap.discovery.fit.axis_fit import fit
from imugap.discovery.fit.description import Description, Entry
from imugap.discovery.views.curve import Curve
from imugap.discovery.views.discrepancies import (
    FIRST_REPLICATES,
    REPLICATES,
    SMALL_P_VALUE,
    ViewTest,
    find_discrepancies,
    place_level,
    replicate_groups,
    significant_discrepancies,
    threshold,
    view_tests,
)
from imugap.discovery.views.envelope import Envelope
from imugap.effects import (
    BiasInstability,
    BiasStep,
    CommonMode,
    Misalignment,
    Outliers,
    OutputFilter,
    RandomWalk,
    Resolution,
    Sinusoid,
    Temperature,
    VarianceChange,
    WhiteNoise,
)
from imugap.effects.conditions import Conditions
from imugap.stream import stream

COUNT, INTERVAL = 12000, 0.02
WHITE = WhiteNoise(1e-3)


def fits(hidden, start=None, count=COUNT, seed=1, ideal=None):
    """Return fits of a start description (white noise) to axes with effects that it may miss."""
    time = INTERVAL * np.arange(count)
    temperature = 25 + 8 * (1 - np.exp(-4 * time / time[-1])) + 1.5 * np.sin(14 * time / time[-1])
    found = {}
    for axis, effects in hidden.items():
        conditions = Conditions(time, INTERVAL, temperature, axis, ideal)
        described = (start or {}).get(axis, Description.known(WHITE))
        found[axis] = fit(simulated((WHITE, *effects), conditions, seed, "gaps test"), described)
    return found


def test_axes_that_use_different_shares_of_the_frequencies_are_compared_on_what_they_share():
    found = fits({"gyro_x": (), "gyro_y": (), "gyro_z": ()})
    narrow = replace(found["gyro_y"].sequence, share=0.5)
    found["gyro_y"] = fit(narrow, Description.known(WHITE))
    tests = {one.curve.axis: one for one in view_tests(found, 1, 19) if one.curve.view == "coherence"}
    assert set(tests) == {"gyro_x,gyro_y", "gyro_x,gyro_z", "gyro_y,gyro_z"}
    reach = {axes: one.curve.high.max() for axes, one in tests.items()}
    half = 0.5 / (2 * INTERVAL)
    assert reach["gyro_x,gyro_y"] == reach["gyro_y,gyro_z"] == pytest.approx(half, rel=1e-3)
    assert reach["gyro_x,gyro_z"] > 1.9 * half
    assert all(np.isfinite(one.p_value) for one in tests.values())


@pytest.mark.parametrize(
    ("p_values", "level"),
    [
        ([0.2, 0.5, 0.9], 0.0),
        ([0.001, 0.5, 0.9], 0.01 / 3),
        ([0.009, 0.006, 0.0099], 0.01),
        ([0.9, 0.002, 0.004, 0.006], 0.0075),
    ],
)
def test_false_discovery_threshold(p_values, level):
    assert threshold(np.array(p_values), 0.01) == pytest.approx(level)


@pytest.mark.parametrize("scale", [1.0, 8.0])
def test_a_view_has_places_where_its_curve_leaves_the_band_of_the_level(scale):
    """Whether many views leave their model or none: the band at the level is that of the places."""
    draws = stream(57, "level").normal(size=(100, 20, 12))
    tests = [ViewTest(Curve("mean", "gyro_x", grid, grid, "s", scale * one[0] if k < 5 else one[0], True),
                      Envelope(one[1:], True))
             for grid in [np.arange(12.0)] for k, one in enumerate(draws.transpose(1, 0, 2))]  # fmt: skip
    level = place_level(tests, 0.01)
    assert bool(significant_discrepancies(tests, 0.01)) == (scale > 1)
    for one in tests:
        low, high = one.envelope.bounds(level)
        outside = ((one.curve.statistic <= low) | (one.curve.statistic >= high)).any()
        assert outside == (one.p_value <= level)


@pytest.mark.parametrize(
    ("effect", "view", "low", "high"),
    [
        (Sinusoid(7.3, 1e-3, 1.0), "line", 7.3, 7.3),
        (BiasStep(150.0, 3e-3), "change", 148.0, 152.0),
        (VarianceChange(60.0, 120.0, 1.5), "variance", 60.0, 120.0),
        (RandomWalk(3e-4), "allan", 4.0, 60.0),
        (Temperature(5e-4), "temperature", 25.0, 35.0),
    ],
)
def test_what_is_hidden_is_found_on_its_axis(effect, view, low, high):
    found = find_discrepancies(fits({"gyro_x": (), "gyro_y": (effect,)}), 0.01, seed=1)
    places = [place for place in found if place.view == view]
    assert {place.axis for place in found} <= {"gyro_y", "gyro_x,gyro_y"}
    assert places
    assert places[0].axis == "gyro_y"
    assert places[0].p_value < 1e-4
    assert places[0].low <= high
    assert places[0].high >= low
    assert [place.p_value for place in found] == sorted(place.p_value for place in found)


def swings():
    """Return the error-free log of a device that turns about three axes at random."""
    slow = lfilter(*butter(2, 0.02), stream(3, "swings").standard_normal((3, COUNT)))
    return log.from_samples(dict(zip(log.GYRO, 20 * slow, strict=True)), INTERVAL)


def test_what_goes_with_the_input_of_another_axis_is_found_over_it():
    found = find_discrepancies(
        fits({"gyro_x": (), "gyro_y": (Misalignment(0.0, 0.0, 3e-4),)}, ideal=swings()), 0.01, seed=1
    )
    assert ("rate", "gyro_y,gyro_z") in {(place.view, place.axis) for place in found}
    assert all("gyro_y" in place.axis for place in found)


@pytest.mark.parametrize(
    ("view", "source", "hidden"),
    [
        ("rate_product", "gyro_y,gyro_z", lambda ideal: 4e-4 * ideal["gyro_y"] * ideal["gyro_z"]),
        ("angular_acceleration", "gyro_z", lambda ideal: 1e-4 * np.gradient(ideal["gyro_z"], INTERVAL)),
    ],
)
def test_what_goes_with_the_motion_of_other_axes_is_found_over_it(view, source, hidden):
    ideal = swings()
    quiet = fits({"gyro_x": (), "gyro_y": ()}, ideal=ideal)
    sequence = quiet["gyro_x"].sequence
    moved = sequence.with_values(sequence.values + np.asarray(hidden(ideal)))
    found = find_discrepancies(quiet | {"gyro_x": fit(moved, Description.known(WHITE))}, 0.01, seed=1)
    assert (view, f"gyro_x,{source}") in {(place.view, place.axis) for place in found}
    assert all("gyro_x" in place.axis for place in found)


@pytest.mark.parametrize(
    ("effect", "description"),
    [
        (
            Sinusoid(7.3, 1e-3, 1.0),
            Description.known(WHITE).adding(Entry(Sinusoid(7.3, 9e-4, 1.1), ("frequency", "amplitude", "phase"))),
        ),
        (BiasStep(150.0, 3e-3), Description.known(WHITE).adding(Entry(BiasStep(150.0, 0.0), ("step",)))),
        (RandomWalk(3e-4), Description.known(WHITE).adding(RandomWalk(1e-4))),
        (OutputFilter(8.0, 2), Description.known(WHITE).adding(OutputFilter(10.0, 2))),
        (VarianceChange(60.0, 120.0, 2.0), Description.known(WHITE).adding(VarianceChange(60.0, 120.0, 2.0))),
    ],
)
def test_what_is_described_is_no_discrepancy(effect, description):
    assert find_discrepancies(fits({"gyro_y": (effect,)}), 0.01, seed=1)
    assert find_discrepancies(fits({"gyro_y": (effect,)}, {"gyro_y": description}), 0.01, seed=1) == ()


def test_known_resolution_is_no_discrepancy():
    coarse = Resolution(0.01)
    found = fits({"gyro_x": (coarse,)})
    assert {place.view for place in find_discrepancies(found, 0.01, seed=1)} == {"marginal"}
    assert find_discrepancies(found, 0.01, seed=1, known={"gyro_x": (coarse,)}) == ()


def test_outliers_that_are_described_are_replaced_in_replicates_too():
    spikes = Outliers(1e-3, 0.1)
    found = fits({"gyro_x": (spikes,)})
    assert {"extremes", "marginal"} <= {place.view for place in find_discrepancies(found, 0.01, seed=1)}
    sequence = found["gyro_x"].sequence
    flagged = np.abs(sequence.values) > 0.03
    mended = sequence.with_replaced(flagged, np.random.default_rng(1))
    described = fit(mended, Description.known(WHITE).adding(spikes))
    assert not [place for place in find_discrepancies({"gyro_x": described}, 0.01, seed=1) if place.view == "variance"]


def test_common_mode_is_a_discrepancy_between_axes_until_it_is_described():
    hidden = {"gyro_x": (CommonMode(1e-3, 0.5),), "gyro_y": (CommonMode(1e-3, 0.5),), "gyro_z": ()}
    found = find_discrepancies(fits(hidden), 0.01, seed=1)
    assert {(place.view, place.axis) for place in found} == {("coherence", "gyro_x,gyro_y")}
    described = Description.known(WHITE).adding(CommonMode(1e-3, 0.5))
    assert find_discrepancies(fits(hidden, {"gyro_x": described, "gyro_y": described}), 0.01, seed=1) == ()


def test_axes_of_white_noise_share_replicates():
    walk = {"gyro_z": Description.known(WHITE).adding(RandomWalk(1e-4))}
    found = fits({"gyro_x": (), "gyro_y": (), "gyro_z": (RandomWalk(1e-4),)}, walk, count=2000)
    groups = [[member.sequence.conditions.axis for member in group.fits] for group in replicate_groups(found, {})]
    assert groups == [["gyro_x", "gyro_y"], ["gyro_z"]]
    known = [len(group.fits) for group in replicate_groups(found, {"gyro_x": (Resolution(0.01),)})]
    assert known == [1, 1, 1]


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_only_axes_that_the_first_replicates_put_in_doubt_have_all(seed):
    slow = RandomWalk(3e-4)
    start = {"gyro_x": Description.known(WHITE).adding(slow)}
    found = fits({"gyro_x": (slow,), "gyro_y": (Sinusoid(7.3, 1e-3, 1.0),)}, start, seed=seed)
    doubtful = set().union(*(one.axes for one in view_tests(found, 1, FIRST_REPLICATES) if one.p_value < SMALL_P_VALUE))
    assert "gyro_y" in doubtful
    counts = defaultdict(set)
    for one in view_tests(found, 1):
        counts[one.curve.axis].add(len(one.envelope.replicates))
    for axis in found:
        assert counts[axis] == {REPLICATES if axis in doubtful else FIRST_REPLICATES}


def test_the_seed_decides():
    found = fits({"gyro_x": ()}, count=2000)
    first, again, other = ([test.p_value for test in view_tests(found, seed, replicates=20)] for seed in (1, 1, 2))
    assert first == again
    assert first != other


@pytest.mark.slow
@pytest.mark.parametrize(
    ("model", "axes"),
    [
        ((WHITE,), ("gyro_x", "gyro_y")),
        ((WHITE, BiasInstability(1e-3)), ("gyro_x",)),
        ((WHITE, RandomWalk(5e-4)), ("gyro_x",)),
    ],
    ids=["white", "flicker", "walk"],
)
def test_p_values_are_uniform_and_discrepancies_rare_where_nothing_is_hidden(model, axes):
    logs, p_values, empty = 40, defaultdict(list), 0
    start = dict.fromkeys(axes, Description.known(*model))
    for seed in range(logs):
        found = fits(dict.fromkeys(start, model[1:]), start, count=1500, seed=seed)
        tests = view_tests(found, seed, replicates=39)
        for test in tests:
            p_values[test.curve.view].append(test.p_value)
        empty += threshold(np.array([test.p_value for test in tests]), 0.1) == 0
    for found in p_values.values():
        assert kstest(found, "uniform").pvalue > 0.001 / len(p_values)
    every = np.concatenate(list(p_values.values()))
    # views of one log are dependent: half as many independent ones, on the safe side
    for level in (0.5, 0.1, 0.02):
        assert binomtest(int(np.sum(every <= level) / 2), len(every) // 2, level).pvalue > 1e-3
    assert binomtest(logs - empty, logs, 0.1).pvalue > 1e-3

"""Axes of a sensor that do not tell their slow noise are taken to have that of the others."""

from collections import Counter

import numpy as np
import pytest
from tests.discovery import simulated
from tests.discovery.simulated import WHITE

from imugap.discovery.search.noise_agreement import PRIOR_LOG_ODDS, NoiseChoice, agreed, choice_of
from imugap.effects import BiasInstability, BiasStep, GaussMarkov, RandomWalk, RateRamp, WarmUp
from imugap.effects.conditions import Conditions
from imugap.log import ACCEL, GYRO

COUNT, INTERVAL = 12_000, 0.05
OF_TIME = (BiasStep, RateRamp, WarmUp)
KINDS = (BiasInstability, GaussMarkov, RandomWalk, *OF_TIME)


def explored(effects, label=0):
    """Return the search of each axis, and the fit that it ends with."""
    searches, fits = {}, {}
    for axis, some in effects.items():
        conditions = Conditions(INTERVAL * np.arange(COUNT), INTERVAL, axis=axis)
        data = simulated.simulated((WHITE, *some), conditions, label, "agreement")
        searches[axis], fits[axis] = simulated.explored(data, *KINDS)
    return fits, searches


def kinds(fits):
    effects = {axis: found.description.effects() for axis, found in fits.items()}
    return {axis: [type(one) for one in some if one.name != "white_noise"] for axis, some in effects.items()}


def test_an_axis_that_has_no_room_for_the_kind_of_the_others_keeps_its_own():
    found = object()
    assert NoiseChoice((GaussMarkov,), 0.0, found, object(), {}).alike(RandomWalk, -8.0) is found


@pytest.mark.slow
def test_faint_noise_is_of_one_kind_more_often_than_each_axis_tells():
    """Two axes tell a walk for certain; on the third it is faint."""
    alone, together = Counter(), Counter()
    for label in range(12):
        strong, faint = (RandomWalk(3e-4),), (RandomWalk(4e-5),)
        fits, searches = explored(dict(zip(GYRO, (strong, strong, faint), strict=True)), label)
        for count, found in ((alone, fits), (together, agreed(fits, searches))):
            count.update(kind.name for kind in kinds(found)[GYRO[2]])
    wrong = [sum(count.values()) - count["random_walk"] for count in (alone, together)]
    assert wrong[0] > 0
    assert wrong[1] < wrong[0]
    assert together["random_walk"] >= alone["random_walk"]


@pytest.mark.long
@pytest.mark.slow
def test_noise_too_faint_to_be_named_speaks_against_a_step_too():
    """Walks of all axes, seldom certain on any, now and then look like a step or a trend."""
    alone, together = Counter(), Counter()
    for label in range(16):
        fits, searches = explored({axis: (RandomWalk(6e-5),) for axis in GYRO}, label)
        for count, found in ((alone, fits), (together, agreed(fits, searches))):
            count.update(kind.name for some in kinds(found).values() for kind in some)
    means = [sum(count[kind.name] for kind in OF_TIME) for count in (alone, together)]
    assert means[0] > 3
    assert means[1] < means[0] / 2


@pytest.mark.slow
def test_a_step_beside_axes_with_nothing_stays():
    fits, searches = explored({"gyro_x": (), "gyro_y": (BiasStep(200.0, 1e-3),), "gyro_z": ()})
    assert kinds(fits) == {"gyro_x": [], "gyro_y": [BiasStep], "gyro_z": []}
    assert agreed(fits, searches) == fits


def test_what_an_axis_tells_for_certain_stays():
    clear = {"gyro_x": (RandomWalk(3e-4),), "gyro_y": (BiasStep(200.0, 3e-3),), "gyro_z": (RandomWalk(3e-4),)}
    fits, searches = explored(clear)
    assert kinds(fits) == {"gyro_x": [RandomWalk], "gyro_y": [BiasStep], "gyro_z": [RandomWalk]}
    assert kinds(agreed(fits, searches)) == kinds(fits)


def test_sensors_have_nothing_to_do_with_each_other():
    both = {GYRO[0]: (GaussMarkov(2e-3, 5.0),), ACCEL[0]: (RandomWalk(3e-4),)}
    fits, searches = explored(both)
    assert kinds(fits) == {GYRO[0]: [GaussMarkov], ACCEL[0]: [RandomWalk]}
    assert agreed(fits, searches) == fits


@pytest.mark.slow
def test_a_walk_beside_far_faster_processes_is_none_of_them():
    """A process slow enough is as good as a walk, but not one like those of the others."""
    fast, walk = (GaussMarkov(2e-3, 3.0),), (RandomWalk(7e-5),)
    fits, searches = explored({"gyro_x": fast, "gyro_y": walk, "gyro_z": fast}, 3)
    own = choice_of(searches["gyro_y"], fits["gyro_y"], searches["gyro_y"].added(fits["gyro_y"]))
    assert own.time(GaussMarkov) > 1000
    assert own.worth(GaussMarkov) > -PRIOR_LOG_ODDS
    assert agreed(fits, searches) == fits

"""Intervals of what a filter takes: those of the axes, combined, and as the file has them."""

from dataclasses import replace

import numpy as np
import pytest
import yaml
from scipy.stats import chi2

from imugap import log
from imugap.effects import BiasInstability, RandomWalk, WhiteNoise
from imugap.effects.effect import AxisModel
from imugap.interchange.conventions import Rule, Triad, reduced
from imugap.interchange.export import Target, exported
from imugap.interchange.limits import Limits, combined, ends_text
from imugap.model import ErrorModel
from imugap.stream import stream

RULE = Rule(rate=100.0)
DEGREES, LOGS = 12, 4000
TRUTH = np.array([1.0, 2.0, 0.5])


def axis(walk):
    return reduced("gyro_x", WhiteNoise(1e-4) + RandomWalk(walk), RULE)


def limits_of(value, low, high):
    return Limits.of(value, (0.9 * value.white, 1.1 * value.white), (low, high))


def test_the_interval_of_a_triad_covers_its_root_mean_square():
    """Variances of chi-square estimates of 12 degrees of freedom each."""
    draws = TRUTH**2 * stream(1, "triad").chisquare(DEGREES, (LOGS, 3)) / DEGREES
    ends = np.sqrt(draws[..., None] * DEGREES / chi2.ppf([0.975, 0.025], DEGREES))
    target, inside = np.sqrt(np.mean(TRUTH**2)), 0
    for values, intervals in zip(np.sqrt(draws), ends, strict=True):
        axes = [axis(value) for value in values]
        known = [limits_of(one, *end) for one, end in zip(axes, intervals, strict=True)]
        found = combined(axes, known, Triad.MEAN_SQUARE)
        inside += found.low.walk <= target <= found.high.walk
    assert 0.94 < inside / LOGS < 0.97


def test_alike_axes_narrow_the_interval_and_the_worst_keeps_the_widest():
    axes = [axis(1.0)] * 3
    known = [limits_of(one, 0.8, 1.25) for one in axes]
    mean, worst = (combined(axes, known, triad) for triad in Triad)
    assert 0.8 < mean.low.walk < 1 < mean.high.walk < 1.25
    assert (worst.low.walk, worst.high.walk) == (0.8, 1.25)


def test_the_process_that_replaces_a_walk_scales_with_it():
    one = axis(2.0)
    found = Limits.of(one, (one.white, one.white), (1.0, 4.0))
    assert found.high.markov == pytest.approx(2 * one.markov)
    assert found.low.markov == pytest.approx(one.markov / 2)


def test_an_interval_has_the_digits_that_its_width_needs():
    assert ends_text(1.19871e-4, 1.20024e-4) == "1.19871e-04 to 1.20024e-04"
    assert ends_text(0.0, 3e-6) == "0.00e+00 to 3.00e-06"
    assert ends_text(1e-6, np.inf) == "1.00e-06 to inf"


def flicker_file(bounds, target=Target.KALIBR):
    """File of flicker on the gyroscopes, and of bounds alone on the accelerometers."""
    axes = {
        name: WhiteNoise(1e-4) + BiasInstability(3e-5) if name in log.GYRO else AxisModel((WhiteNoise(1e-3),))
        for name in log.AXES
    }
    whole = {name: AxisModel((*one, *bounds.get(name, ()))) for name, one in axes.items()}
    known = {name: reduced(name, one, RULE) for name, one in whole.items()}
    limits = {
        name: Limits.of(one, (0.99 * one.white, 1.01 * one.white), (0.0 if name in bounds else one.walk / 2, one.walk))
        for name, one in known.items()
    }
    return exported(ErrorModel(axes), target, RULE, bounds, limits=limits).text


@pytest.mark.parametrize(("target", "walk"), [(Target.KALIBR, "gyroscope_random_walk"), (Target.VINS, "gyr_w")])
def test_a_file_has_intervals_and_the_walk_at_other_horizons(target, walk):
    text = flicker_file(dict.fromkeys(log.ACCEL, (RandomWalk(1e-5),)), target)
    value = yaml.safe_load(text)[walk]
    (line,) = (one for one in text.splitlines() if one.startswith(walk))
    low, high = map(float, line.rpartition("95 %: ")[2].split(" to "))
    assert low < value <= high * 1.01
    others = text.splitlines()[text.splitlines().index(line) + 1]
    assert "at 1 s" in others
    assert "at 100 s" in others
    at = [float(one.split()[0]) for one in others.partition(": ")[2].split(", ")]
    assert at[1] == pytest.approx(value, rel=0.01)
    np.testing.assert_allclose(np.array(at) / at[1], [np.sqrt(10), 1, np.sqrt(0.1)], rtol=0.03)


def test_a_bound_is_marked_in_its_own_line():
    every, some = (dict.fromkeys(axes, (RandomWalk(1e-5),)) for axes in (log.ACCEL, log.ACCEL[:1]))
    (line,) = (one for one in flicker_file(every).splitlines() if one.startswith("accelerometer_random_walk"))
    assert "upper bound: the log shows none" in line
    assert "95 %: 0.00e+00 to" in line
    (line,) = (one for one in flicker_file(some).splitlines() if one.startswith("accelerometer_random_walk"))
    assert "upper bound on accel_x: the log shows none" in line


def test_a_model_without_a_log_has_no_intervals():
    model = ErrorModel(dict.fromkeys(log.AXES, WhiteNoise(1e-4) + RandomWalk(1e-6)))
    text = exported(model, Target.KALIBR, replace(RULE, horizon=30.0)).text
    assert "95 %" not in text
    assert "with another horizon" not in text

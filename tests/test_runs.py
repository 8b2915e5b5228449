"""Runs of one device against each other: clocks from lines that all move alike."""

import numpy as np
import pytest

from imugap.discovery.axis import Description, Term, fit
from imugap.discovery.noise import Noise
from imugap.discovery.runs import clocks
from imugap.discovery.sequence import Sequence
from imugap.effects import Sinusoid, WhiteNoise
from imugap.effects.effect import Conditions
from imugap.stream import stream

INTERVAL = 0.02
LOG_ALPHA = np.log(1e-4)
FREE = ("frequency", "amplitude", "phase")


def run(number, ratio, lines, count=12000, label="clock"):
    """Fit a run whose true interval is ``1 / ratio`` of the nominal one; ``lines`` are in true time [Hz]."""
    fits = {}
    for axis, frequency in lines.items():
        rng = stream(number, label, axis)
        conditions = Conditions(np.arange(count) * INTERVAL, INTERVAL, axis=axis)
        line = Sinusoid(frequency / ratio, 3e-4, float(rng.uniform(0, 6)))
        noise = WhiteNoise(1e-4)
        values = line.sample(conditions, None) + noise.sample(conditions, rng)
        sequence = Sequence(values, conditions, np.zeros(count, bool))
        fits[axis] = fit(sequence, Description((Term(line, FREE),), Noise((noise,))))
    return fits


@pytest.mark.parametrize("ratio", [1.0001, 0.9995, 1.005])
def test_lines_of_two_axes_tell_the_clock(ratio):
    lines = {"gyro_x": 3.1, "accel_y": 11.7}
    (found,) = clocks([run(1, 1.0, lines), run(2, ratio, lines)], LOG_ALPHA)
    interval = found.parameters["ratio"]
    assert interval.low < ratio < interval.high
    assert interval.high - interval.low < 1e-4
    assert found.parameters["run"].value == 2
    assert next(iter(found.effects.values())).ratio == interval.value


def test_the_interval_of_the_clock_holds_the_truth_as_often_as_it_says():
    lines, ratio, inside = {"gyro_x": 3.1, "accel_y": 11.7}, 1.0001, []
    for number in range(40):
        pair = [run(number, 1.0, lines, label="first"), run(number, ratio, lines, label="second")]
        ratios = [found.parameters["ratio"] for found in clocks(pair, LOG_ALPHA)]
        inside += [one.low < ratio < one.high for one in ratios]
    assert len(inside) >= 37  # lines disagree by chance in one of a hundred
    assert 33 <= sum(inside) <= 40


def test_runs_of_one_clock_and_lines_that_move_by_themselves_name_no_clock():
    lines = {"gyro_x": 3.1, "accel_y": 11.7}
    same = [run(number, 1.0, lines) for number in (1, 2, 3)]
    assert clocks(same, LOG_ALPHA) == ()
    assert clocks([same[0], run(4, 1.0, {"gyro_x": 3.1, "accel_y": 11.75})], LOG_ALPHA) == ()


def test_only_the_run_that_is_off_is_named():
    lines = {"gyro_x": 3.1, "accel_y": 11.7}
    found = clocks([run(1, 1.0, lines), run(2, 1.0, lines), run(3, 1.0003, lines)], LOG_ALPHA)
    assert [one.parameters["run"].value for one in found] == [3]

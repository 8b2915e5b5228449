"""Differences between runs of one device: sampling clock and turn-on bias."""

import numpy as np
import pytest
from tests.discovery import simulated

from imugap.discovery.fit.axis_fit import fit
from imugap.discovery.fit.description import Description, Entry
from imugap.discovery.preparation.sequence import AxisSequence
from imugap.discovery.runs.between_runs import (
    clock_findings,
    fit_like_first,
    level_error,
    mean_variance,
    turn_on_findings,
)
from imugap.effects import GaussMarkov, PowerLaw, RandomWalk, RateRamp, Sinusoid, TurnOnBias, WarmUp, WhiteNoise
from imugap.effects.conditions import Conditions
from imugap.stream import stream

INTERVAL = 0.02
LOG_ALPHA = np.log(1e-4)
FREE = ("frequency", "amplitude", "phase")
LINES = {"gyro_x": 3.1, "accel_y": 11.7}
"""Frequencies of the lines of two axes [Hz]."""
WHITE = WhiteNoise(1e-4)


def at(count, interval=INTERVAL, axis="gyro_x"):
    return Conditions(np.arange(count) * interval, interval, axis=axis)


def run(number, ratio, lines, count=12000, label="clock"):
    """Fit a run whose true interval is ``1 / ratio`` of the nominal one; ``lines`` are in true time [Hz]."""
    fits = {}
    for axis, frequency in lines.items():
        rng = stream(number, label, axis)
        conditions = at(count, axis=axis)
        line = Sinusoid(frequency / ratio, 3e-4, float(rng.uniform(0, 6)))
        values = line.sample(conditions, None) + WHITE.sample(conditions, rng)
        fits[axis] = fit(AxisSequence(values, conditions), Description.known(WHITE).adding(Entry(line, FREE)))
    return fits


@pytest.mark.parametrize("ratio", [1.0001, 0.9995, 1.005])
def test_lines_of_two_axes_determine_the_clock_ratio(ratio):
    (found,) = clock_findings([run(1, 1.0, LINES), run(2, ratio, LINES)], LOG_ALPHA)
    interval = found.parameters["ratio"]
    assert interval.low < ratio < interval.high
    assert interval.high - interval.low < 1e-4
    assert found.parameters["run"].value == 2
    assert next(iter(found.effects.values())).ratio == interval.value


@pytest.mark.slow
def test_the_interval_of_the_clock_ratio_has_nominal_coverage():
    ratio, inside = 1.0001, []
    for number in range(40):
        pair = [run(number, 1.0, LINES, label="first"), run(number, ratio, LINES, label="second")]
        ratios = [found.parameters["ratio"] for found in clock_findings(pair, LOG_ALPHA)]
        inside += [one.low < ratio < one.high for one in ratios]
    assert len(inside) >= 37  # lines disagree by chance in one of a hundred
    assert 33 <= sum(inside) <= 40


def test_equal_clocks_and_independently_shifted_lines_give_no_finding():
    same = [run(number, 1.0, LINES) for number in (1, 2, 3)]
    assert clock_findings(same, LOG_ALPHA) == ()
    assert clock_findings([same[0], run(4, 1.0, {"gyro_x": 3.1, "accel_y": 11.75})], LOG_ALPHA) == ()


def test_only_the_run_of_another_clock_is_named():
    found = clock_findings([run(1, 1.0, LINES), run(2, 1.0, LINES), run(3, 1.0003, LINES)], LOG_ALPHA)
    assert [one.parameters["run"].value for one in found] == [3]


def test_correct_stamps_of_another_rate_are_no_clock_error():
    fits = []
    for number, interval in ((1, 0.01), (2, 0.0125)):
        conditions = at(20_000, interval)
        lines = [Entry(Sinusoid(frequency, 2e-4), FREE) for frequency in (17.7, 23.0, 31.3)]
        values = WHITE.sample(conditions, stream(number, "rates"))
        values += sum(line.effect.sample(conditions, None) for line in lines)
        fits.append({"gyro_x": fit(AxisSequence(values, conditions), Description.known(WHITE).adding(*lines))})
    assert clock_findings(fits, LOG_ALPHA) == ()


def levelled(number, levels, effects, noise, found=()):
    """Fit runs with the same ``effects`` at ``levels``; the first with the terms ``found``, as after a search."""
    fits, conditions, hidden = [], at(3000), (WHITE, *effects, *noise)
    for run, level in enumerate(levels):
        own = (one.sample(conditions, stream(number, "level", run, one.name)) for one in hidden)
        sequence = AxisSequence(level + sum(own), conditions)
        if fits:
            fits.append(fit_like_first(sequence, (), fits[0]))
        else:
            fits.append(fit(sequence, Description.known(WHITE).adding(*noise, *found)))
    return [{"gyro_x": one} for one in fits]


REPEATED = {
    "ramp": (RateRamp(2e-5), ("slope",)),
    "warm-up": (WarmUp(2e-3, 15.0), ("amplitude", "time_constant")),
}


@pytest.mark.parametrize("name", REPEATED)
def test_an_effect_in_every_run_is_no_turn_on_bias(name):
    effect, free = REPEATED[name]
    term = Entry(effect, free)
    assert turn_on_findings(levelled(1, (1e-3, 1e-3), (effect,), (), (term,)), LOG_ALPHA) == ()
    (found,) = turn_on_findings(levelled(1, (1e-3, 1e-3, 6e-3), (effect,), (), (term,)), LOG_ALPHA)
    assert found.parameters["std"].low < 5e-3 / np.sqrt(3) < found.parameters["std"].high


@pytest.mark.slow
@pytest.mark.parametrize("noise", [RandomWalk(2e-3), GaussMarkov(1e-2, 300.0), GaussMarkov(1e-2, 3.0)])
def test_the_false_alarm_rate_of_turn_on_bias_with_slow_noise_is_nominal(noise):
    level = np.log(0.05)
    false = [turn_on_findings(levelled(number, (0.0, 0.0), (), (noise,)), level) for number in range(60)]
    assert sum(map(len, false)) <= 9  # binomial: more than 9 of 60 at 5 % in 0.2 %


@pytest.mark.parametrize("duration", [100.0, 4000.0])
def test_the_mean_of_a_random_walk_has_a_third_of_its_final_variance(duration):
    assert mean_variance(RandomWalk(0.3), duration, 0.1) == pytest.approx(0.3**2 * duration / 3, rel=1e-3)


def test_the_level_error_is_infinite_with_noise_of_free_slope():
    conditions = Conditions(0.1 * np.arange(2000), 0.1, axis="gyro_x")
    values = stream(1, "slope").standard_normal(2000)
    noise = Description.known(WhiteNoise(0.3)).adding(PowerLaw(0.01, 1.2))
    assert np.isinf(level_error(fit(AxisSequence(values, conditions), noise)))


def test_turn_on_bias_of_several_runs():
    def runs(*effects):
        data = (simulated.sequence(*effects, count=4000, label=f"run{run}") for run in range(8))
        return [{"gyro_x": simulated.fitted(one)} for one in data]

    (finding,) = turn_on_findings(runs(TurnOnBias(1e-3)), simulated.LOG_ALPHA)
    assert finding.parameters["std"].low < 1e-3 < finding.parameters["std"].high
    assert turn_on_findings(runs(), simulated.LOG_ALPHA) == ()

import numpy as np
import pytest
from scipy.signal import butter, lfilter
from scipy.stats import binom, chi2
from tests.discovery.simulated import COUNT, INTERVAL, WHITE, fitted, sequence

from imugap.discovery.fit import matched_filters as scans
from imugap.discovery.fit.description import Entry
from imugap.discovery.fit.whittle import Noise
from imugap.effects import BiasInstability, OutputFilter, RandomWalk, RateRamp, Sinusoid
from imugap.stream import stream


def test_gain_of_every_step_is_that_of_its_column():
    found = fitted(sequence(BiasInstability(3e-4), count=4000), BiasInstability(3e-4))
    gains = found.steps.gains
    for place in (80, 777, 2000, 3500):
        column = (np.arange(4000) >= place).astype(float)
        assert gains[place] == pytest.approx(found.gains(found.whiten(column[:, None]))[0], rel=1e-6)


@pytest.mark.parametrize("output_filter", [None, OutputFilter(2.0, 2)])
def test_gain_of_every_step_is_that_beside_terms_which_move(output_filter):
    """Behind a filter what leaks over the ends of the log is left out of it."""
    terms = Entry(RateRamp(0.0), ("slope",)), Entry(Sinusoid(0.013, 1e-4, 0.4), ("frequency", "amplitude", "phase"))
    filters = () if output_filter is None else (output_filter,)
    found = fitted(sequence(*filters, count=4000), *terms, *filters)
    for place in (77, 700, 2000, 3200):
        column = found.whiten((np.arange(4000) >= place).astype(float)[:, None])
        gain, rank = found.joint_gain(column)
        assert rank == 1
        assert found.steps.gains[place] == pytest.approx(gain, rel=1e-6 if output_filter is None else 0.1, abs=0.05)


def test_power_of_lines_in_noise_is_exponential():
    _, power, _ = scans.lines(stream(3, "lines").standard_normal(20_000), 0.01)
    assert abs(power[::2].mean() - 1) < 4 / np.sqrt(len(power) / 2)
    assert abs(np.mean(power[::2] > 3) - np.exp(-3)) < 4 * np.sqrt(np.exp(-3) / (len(power) / 2))


def test_a_loud_band_has_no_lines_but_those_above_it():
    white = stream(3, "band").standard_normal(20_000)
    loud = white + lfilter(*butter(2, [0.2, 0.3], "bandpass"), 5 * stream(3, "loud").standard_normal(20_000))
    assert scans.lines(loud, 0.01)[1].max() < np.log(20_000) + 10
    line = np.cos(2 * np.pi * 12.5 * 0.01 * np.arange(20_000))
    frequency, gains, level = scans.lines(loud + line, 0.01)
    assert frequency[np.argmax(gains)] == pytest.approx(12.5, abs=0.01)
    assert 10 < level[np.argmax(gains)] < 30


def test_stretch_of_another_variance_is_the_best_of_all():
    w = stream(4, "stretch").standard_normal(4000)
    w[1200:1800] *= 1.5
    gain, first, last = scans.stretches(w)
    assert abs(first - 1200) < 40
    assert abs(last - 1800) < 40
    inside, outside = np.mean(w[first:last] ** 2), np.mean(np.r_[w[:first], w[last:]] ** 2)
    count = last - first
    by_hand = 0.5 * (4000 * np.log(np.mean(w**2)) - count * np.log(inside) - (4000 - count) * np.log(outside))
    assert gain == pytest.approx(by_hand, rel=1e-9)


@pytest.mark.parametrize("walk", [0.0, 1.0, 1e4])
def test_the_p_value_of_the_highest_step_is_uniform(walk):
    """From white noise to a walk, of which each increment is a step of its own."""
    noise = Noise((WHITE, RandomWalk(walk * 1e-3)) if walk else (WHITE,))
    data = sequence(count=4000)
    variance = data.bins.spread(noise.variance(data.bins))
    p_values = []
    for run in range(400):
        found = scans.steps(stream(run, "places").standard_normal(3999), variance, np.empty((3999, 0)))
        gain = found.gains.max()
        p_values.append(found.places(gain) * chi2.sf(2 * gain, 1))
    for level in (0.02, 0.1):
        assert binom.ppf(1e-4, 400, 0.5 * level) <= np.sum(np.array(p_values) < level) <= binom.isf(1e-4, 400, level)


@pytest.mark.parametrize("growth", [-4.0, 0.0, 4.0])
def test_a_variance_that_grows_is_no_swing_without_bounds(growth):
    """Less than half a cycle of a swing of any depth is what a trend of the variance looks like."""
    time = np.arange(COUNT) * INTERVAL
    whitened = np.exp(growth * time / time[-1] / 2) * stream(6, "grows").standard_normal(COUNT)
    frequency, depth, phase, gain = scans.swing(whitened, time)
    assert frequency >= 0.999 * scans.MIN_SWING_CYCLES / time[-1]
    assert 0 <= depth <= np.sqrt(2) * scans.MAX_SWING_DEPTH
    assert np.isfinite(phase)
    assert (gain > 100) == (growth != 0)


def test_a_variance_that_grows_late_has_no_swing_of_any_depth():
    """Of a swing of a small part of a cycle, depth and mean of the logarithm are one, and both may be of any size."""
    time = np.arange(COUNT) * INTERVAL
    growth = 0.6 * np.exp(-8 * (1 - time / time[-1]))
    whitened = np.exp(growth / 2) * stream(1, "grows").standard_normal(COUNT)
    frequency, depth, _, gain = scans.swing(whitened, time)
    assert depth < 1 < gain
    assert frequency * time[-1] > 0.49

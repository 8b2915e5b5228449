"""Noise on a coarse lattice, whose law has to be told from cells."""

from functools import partial

import numpy as np
import pytest
from scipy.stats import binom, kstest
from tests.discovery.simulated import result_of

from imugap.discovery.fit.axis_fit import fit
from imugap.discovery.fit.description import Description
from imugap.discovery.fit.rounded_samples import Cells, ahead
from imugap.discovery.preparation.rounding import unrounded
from imugap.discovery.preparation.sequence import AxisSequence
from imugap.discovery.search.search import log_p_of_gain
from imugap.effects import CATALOGUE, Outliers, OutputFilter, RandomWalk, Resolution, VarianceChange, WhiteNoise
from imugap.effects.conditions import Conditions
from imugap.stream import stream

COUNT, INTERVAL = 40_000, 0.01
CONDITIONS = Conditions(INTERVAL * np.arange(COUNT), INTERVAL, axis="gyro_x")
LOG_ALPHA = np.log(0.01 / 6 / len(CATALOGUE))
result = partial(result_of, log_alpha=LOG_ALPHA)
WHITE = WhiteNoise(float(np.sqrt(INTERVAL)))
"""White noise of unit deviation."""
STEPS = (1.0, 2.0, 2.5, 3.0)
"""Steps of lattices, in standard deviations of the noise."""


def rounded(step, label, *effects, walk=0.0):
    """White noise of unit deviation and effects about a mean somewhere between two levels, on a lattice."""
    rng = stream(label, "cells")
    values = rng.standard_normal(COUNT) + rng.uniform(-step, step) + walk * np.cumsum(rng.standard_normal(COUNT))
    for effect in effects:
        values = effect.apply(values, CONDITIONS, rng)
    return AxisSequence(Resolution(step).apply(values, CONDITIONS, rng), CONDITIONS, step=step)


def fitted(sequence, *effects):
    return fit(sequence, Description.known(WHITE, *effects))


def cells_of(found):
    return Cells.of(found.sequence, found.description.noise, found.residual, found.scale)


def passed(smooth, seed):
    """White noise of unit deviation behind a filter."""
    return smooth.passed(stream(seed, "filtered").standard_normal(COUNT), INTERVAL)


def lattice(values, step):
    """A sequence of values that are rounded to a lattice."""
    return AxisSequence(step * np.rint(values / step), CONDITIONS, step=step)


@pytest.mark.parametrize("step", STEPS)
def test_the_mean_ahead_of_the_rounding_is_that_of_rounded_normal_values(step):
    means = np.linspace(-2 * step, 2 * step, 33)
    levels = np.array([Resolution(step).moments(mean, 1.0)[0] for mean in means])
    np.testing.assert_allclose(ahead(levels, step, 1.0), means, atol=1e-3 * step)


@pytest.mark.parametrize("walk", [0.0, 0.01])
@pytest.mark.parametrize("step", STEPS)
def test_what_is_drawn_from_the_cells_is_normal(step, walk):
    log_ps = []
    for label in range(8):
        found = fitted(rounded(step, label, walk=walk), *([RandomWalk(10 * walk)] if walk else []))
        values = found.cells.drawn(stream(label, "drawn")) if found.cells else found.whitened
        log_ps.append(kstest(values[::10], "norm").pvalue)
    assert min(log_ps) > 1e-3 / 8


@pytest.mark.slow
@pytest.mark.parametrize("walk", [0.0, 0.01])
def test_rounding_to_a_coarse_lattice_makes_no_change_of_variance(walk):
    """As residuals of the rounded values some of these logs have one for certain, of a p-value of e-10 and less."""
    log_ps, as_they_are = [], []
    for label in range(20):
        found = fitted(rounded(3.0, label, walk=walk), *([RandomWalk(10 * walk)] if walk else []))
        starts = list(VarianceChange.starts(found))
        log_ps.append(min(log_p_of_gain(one.gain, len(one.free)) + np.log(one.trials) for one in starts))
        squares = found.whitened**2
        as_they_are.append(abs(np.std(squares) - np.sqrt(2)))
    assert min(log_ps) > LOG_ALPHA
    assert max(as_they_are) > 0.3


@pytest.mark.parametrize("step", STEPS)
def test_a_change_of_variance_on_a_coarse_lattice_is_found(step):
    change = VarianceChange(100.0, 220.0, 1.5)
    found = fitted(rounded(step, 1, change))
    start = next(VarianceChange.starts(found))
    assert log_p_of_gain(start.gain, 1) + np.log(start.trials) < LOG_ALPHA
    assert start.effect.start == pytest.approx(100.0, abs=10.0)
    assert start.effect.stop == pytest.approx(220.0, abs=10.0)


@pytest.mark.slow
@pytest.mark.parametrize("step", STEPS)
def test_tails_on_a_coarse_lattice_are_those_ahead_of_it(step):
    held = 0
    for label in range(10):
        found = fitted(rounded(step, label, Outliers(0.02, 6.0)))
        wide = found.cells.tails()
        unit = found.description.noise.effects[0].density / np.sqrt(INTERVAL)
        assert wide.gain > 300
        (low, high), (least, most) = wide.intervals
        held += int(low < 0.02 < high) + int(least * unit < 6.0 < most * unit)
    assert held >= binom.ppf(1e-3, 20, 0.95)


@pytest.mark.slow
@pytest.mark.parametrize("step", STEPS)
def test_normal_noise_on_a_coarse_lattice_has_no_tails(step):
    gains = [fitted(rounded(step, label)).cells.tails().gain for label in range(20)]
    assert max(gains) < 8.0
    assert min(gains) > -0.01


def test_cells_are_narrower_where_the_noise_is_louder():
    change = VarianceChange(100.0, 220.0, 4.0)
    found = fitted(rounded(2.0, 3, change), change)
    half = found.cells.half
    assert half[15_000] == pytest.approx(half[0] / 2)
    assert np.std(found.unrounded[10_000:22_000]) == pytest.approx(1.0, abs=0.03)


def test_nothing_is_asked_where_the_noise_is_not_told_from_the_rest():
    data = rounded(2.0, 1)
    assert cells_of(fitted(data, OutputFilter(10.0, 1.0))) is None
    assert cells_of(fitted(rounded(5.0, 1))) is None
    assert fitted(rounded(0.5, 1)).cells is None


@pytest.mark.slow
def test_outliers_on_a_coarse_lattice_have_their_name_and_size():
    (finding,) = result(rounded(1.9, 1, Outliers(0.05, 6.8))).findings
    assert finding.name == "outliers"
    assert finding.parameters["probability"].low < 0.05 < finding.parameters["probability"].high
    assert finding.parameters["std"].low < 6.8 < finding.parameters["std"].high


@pytest.mark.slow
@pytest.mark.parametrize("label", range(4))
def test_a_walk_through_a_coarse_lattice_is_a_walk_alone(label):
    assert [one.name for one in result(rounded(2.6, label, walk=0.01)).findings] == ["random_walk"]


@pytest.mark.slow
@pytest.mark.parametrize("step", [0.1, 0.3, 1.0, 1.5])
@pytest.mark.parametrize(("cutoff", "order"), [(30.0, 1), (10.0, 2)])
def test_a_filter_ahead_of_a_lattice_has_its_cutoff(cutoff, order, step):
    """Rounding comes behind the filter, and its white noise with it; the step is in deviations of the output."""
    smooth = OutputFilter(cutoff, order)
    output = passed(smooth, 7)
    found = result(lattice(output, step * output.std()))
    (finding,) = found.findings
    assert finding.effects["gyro_x"].order == order
    assert finding.parameters["cutoff"].low < cutoff < finding.parameters["cutoff"].high
    assert not found.withheld


def test_white_noise_behind_a_filter_is_fitted_beside_what_rounding_adds():
    smooth, step = OutputFilter(10.0, 2), 0.5
    data = lattice(passed(smooth, 8), step)
    found = fitted(data, smooth)
    effects = unrounded(found.description.effects(), (Resolution(step),), data)
    white = next(one for one in effects if isinstance(one, WhiteNoise))
    assert white.density == pytest.approx(np.sqrt(INTERVAL), rel=0.02)
    assert np.std(found.coefficients[: data.bins.last]) == pytest.approx(1.0, abs=0.02)

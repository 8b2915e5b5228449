"""Detection of tones that wander, are intermittent, or decay."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from scipy.stats import binom
from tests.chance import as_often_as
from tests.discovery import simulated
from tests.discovery.simulated import INTERVAL, TIME, WHITE, fitted, moved, result_of

from imugap.discovery.fit.axis_fit import fit
from imugap.discovery.fit.description import Description, Entry
from imugap.discovery.unnamed.tone_bursts import CELL_LOG_PS, LENGTHS, cell_log_p, find_tone_bursts, loudest_band
from imugap.effects import (
    BiasStep,
    GaussMarkov,
    OutputFilter,
    RandomTelegraph,
    RandomWalk,
    Sinusoid,
    VarianceChange,
)
from imugap.stream import stream

STD = 1e-3 / np.sqrt(INTERVAL)
sequence = partial(simulated.sequence, label="glints")


def wandering(low, high):
    """A tone whose frequency wanders between two."""
    knots = np.arange(0.0, TIME[-1] + 20, 20)
    frequency = stream(2, "wandering").uniform(low, high, len(knots))
    return np.cos(2 * np.pi * INTERVAL * np.cumsum(np.interp(TIME, knots, frequency)))


def ringing(frequency):
    """Ten shocks, each of which rings for three seconds."""
    since = TIME - stream(2, "ringing").uniform(0, TIME[-1], (10, 1))
    return np.sum(np.where(since > 0, np.exp(-np.maximum(since, 0) / 3), 0) * np.sin(2 * np.pi * frequency * since), 0)


@pytest.mark.parametrize("tone", [wandering(2.0, 4.0), 3 * ringing(3.0)], ids=["wandering", "ringing"])
def test_a_wandering_or_decaying_tone_is_found_as_a_band(tone):
    (band,) = find_tone_bursts(fitted(moved(sequence(), STD * tone)))
    assert 1.0 < band.low < 3.0 < band.high < 5.0


@pytest.mark.parametrize(
    "effect",
    [
        RandomWalk(3e-3),
        GaussMarkov(2e-2, 0.5),
        RandomTelegraph(5e-2, 0.1),
        OutputFilter(4.0, 2),
        VarianceChange(300.0, 500.0, 9.0),
    ],
    ids=lambda effect: effect.name,
)
def test_described_effects_leave_no_tone_bursts(effect):
    assert find_tone_bursts(fit(sequence(effect), Description.known(WHITE, effect))) == ()


def test_a_steady_line_and_a_step_are_no_tone_bursts():
    data = sequence(Sinusoid(3.0, STD), BiasStep(400.0, 20 * STD))
    assert find_tone_bursts(fitted(data)) == ()
    line = Entry(Sinusoid(3.0, STD), ("amplitude",))
    assert find_tone_bursts(fitted(data, line)) == ()


@pytest.mark.parametrize("share", [0.01, 0.1, 1.0])
def test_frequencies_that_the_fit_does_not_use_are_not_tested(share):
    data = replace(sequence(), share=share)
    assert find_tone_bursts(fitted(data)) == ()


def test_the_cell_p_value_of_white_noise_is_uniform():
    for length in LENGTHS:
        log_ps = cell_log_p(stream(3, "cells", length).standard_normal(400_000), length, 1.0)
        for level in CELL_LOG_PS:
            assert as_often_as((log_ps < level).ravel(), np.exp(level), 2e-4)


def test_the_false_alarm_rate_of_tone_bursts_is_at_most_nominal():
    log_p = [
        loudest_band(cell_log_p(stream(4, "chance", k).standard_normal(30_000), 512, 1.0), 1.0).log_p
        for k in range(300)
    ]
    for level in (0.01, 0.1):
        most = binom.isf(1e-3, len(log_p), level * (1 + len(CELL_LOG_PS)))
        assert np.count_nonzero(np.exp(log_p) < level) <= most


@pytest.mark.slow
def test_a_wandering_tone_is_named_neither_noise_nor_filter():
    found = result_of(moved(sequence(), 0.6 * STD * wandering(2.0, 4.0)))
    assert not found.findings
    assert found.bands

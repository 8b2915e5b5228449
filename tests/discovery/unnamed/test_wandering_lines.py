from dataclasses import replace

import numpy as np
import pytest
from tests.discovery import simulated
from tests.discovery.simulated import KINDS, LOG_ALPHA, explored, names, result_of

from imugap.discovery.fit.axis_fit import cosine_coefficients
from imugap.discovery.unnamed import wandering_lines
from imugap.discovery.unnamed.wandering_lines import Band
from imugap.effects import BiasInstability, BiasStep, Chirp, GaussMarkov, OutputFilter, Sinusoid
from imugap.stream import stream

COUNT, INTERVAL = 12_000, 0.1
LINE_HZ = 0.56


def sequence(*effects, line=0.0, label="unsteady"):
    """White noise and effects, and a line of given amplitude whose amplitude and phase wander within 150 s."""
    data = simulated.sequence(*effects, count=COUNT, interval=INTERVAL, axis="accel_x", label=label)
    return simulated.moved(data, line * wandering())


def wandering():
    rng = stream(4, "wandering")
    knots = np.arange(0.0, COUNT * INTERVAL + 50, 50)
    time = INTERVAL * np.arange(COUNT)
    phase, size = np.cumsum(0.8 * rng.standard_normal(len(knots))), 1 + 0.4 * rng.standard_normal(len(knots))
    return np.interp(time, knots, size) * np.cos(2 * np.pi * LINE_HZ * time + np.interp(time, knots, phase))


@pytest.mark.slow
def test_a_wandering_line_is_found_as_one_band():
    _, found = explored(sequence(line=4e-3), *KINDS)
    (band,) = wandering_lines.find_bands(found)
    assert LINE_HZ / 1.1 < band.low < LINE_HZ < band.high < 1.1 * LINE_HZ
    assert band.log_p < LOG_ALPHA


@pytest.mark.parametrize("effects", [(), (Sinusoid(LINE_HZ, 4e-3, 0.3),), (Sinusoid(0.3, 4e-3), Sinusoid(0.7, 4e-3))])
def test_steady_lines_are_not_found_as_wandering(effects):
    _, found = explored(sequence(*effects), *KINDS)
    assert wandering_lines.find_bands(found) == ()


def test_a_sweep_across_a_steady_line_is_no_wandering_line():
    data = sequence(Chirp(1.0, 1e-4, 2e-3), Sinusoid(1.06, 2e-3, 1.0))
    assert names(result_of(data, Chirp, Sinusoid)) == ["chirp", "sinusoid"]


def test_coefficients_outside_of_a_band_are_unchanged():
    data = sequence(line=4e-3)
    cleared = wandering_lines.without_bands(data, (Band(0.53, 0.59, -100.0),))
    frequency = np.arange(1, COUNT) / (2 * COUNT * INTERVAL)
    inside = (frequency >= 0.53) & (frequency <= 0.59)
    before, after = cosine_coefficients(data.values), cosine_coefficients(cleared.values)
    scale = np.abs(before).max()
    far = (frequency < 0.529) | (frequency > 0.591)
    assert np.abs(before - after)[far].max() < 1e-12 * scale
    excess = np.mean(after[inside] ** 2) / np.mean(after[far & (frequency > 0.3) & (frequency < 1.0)] ** 2)
    assert abs(excess - 1) < 4 * np.sqrt(2 / inside.sum()) + 0.05


def test_rounded_samples_stay_coarse_after_the_removal_of_a_band():
    data = sequence(line=4e-3)
    rounded = replace(data, values=0.02 * np.rint(data.values / 0.02))
    assert rounded.coarse
    assert wandering_lines.without_bands(rounded, (Band(0.53, 0.59, -100.0),)).coarse


@pytest.mark.long
@pytest.mark.slow
def test_other_effects_keep_their_names_next_to_a_wandering_line():
    result = result_of(sequence(BiasStep(700.0, 4e-3), BiasInstability(1e-3), line=4e-3))
    assert names(result) == ["bias_instability", "bias_step"]
    (band,) = result.bands
    assert band.low < LINE_HZ < band.high


@pytest.mark.slow
def test_a_wandering_line_is_not_named():
    result = result_of(sequence(line=4e-3), Sinusoid, GaussMarkov, OutputFilter)
    assert result.findings == ()
    assert len(result.bands) == 1


@pytest.mark.parametrize("jumps", [(400.0,), (200.0, 450.0, 700.0)])
def test_a_line_that_jumps_between_two_frequencies_has_no_name(jumps):
    data = sequence(label="jumping")
    frequency = np.where(np.searchsorted(jumps, data.conditions.time) % 2, 4.0, 3.0)
    line = 2e-3 * np.cos(2 * np.pi * INTERVAL * np.cumsum(frequency))
    result = result_of(simulated.moved(data, line))
    assert names(result) == []
    places = sorted((band.low, band.high) for band in result.bands)
    assert all(low < at < high for at, (low, high) in zip((3.0, 4.0), places, strict=True))

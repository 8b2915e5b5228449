from types import SimpleNamespace

import numpy as np
import pytest
from tests.discovery.simulated import KINDS, LOG_ALPHA, result_of

from imugap.discovery.checks import explained_by_bands
from imugap.discovery.fit.axis_fit import fit
from imugap.discovery.fit.description import Description
from imugap.discovery.preparation.sequence import AxisSequence
from imugap.discovery.search.search import Search
from imugap.discovery.unnamed.chirps import find_chirps
from imugap.discovery.unnamed.wandering_lines import Band
from imugap.effects import OutputFilter, Sinusoid, WhiteNoise
from imugap.effects.conditions import Conditions
from imugap.stream import stream

COUNT, INTERVAL = 30_000, 0.02
CONDITIONS = Conditions(INTERVAL * np.arange(COUNT), INTERVAL, axis="accel_y")
DENSITY = WhiteNoise(1e-2 * np.sqrt(INTERVAL))


def white(label, run=0):
    return stream(5, "sweeps", label, run).standard_normal(COUNT)


def chirp(begin, end, deviate):
    """Return a chirp with an amplitude in units of its standard deviation in white noise."""
    time, duration = INTERVAL * np.arange(COUNT), INTERVAL * COUNT
    angle = 2 * np.pi * (begin * time + (end - begin) * time**2 / (2 * duration))
    return deviate * np.sqrt(2 / COUNT) * np.cos(angle)


def found(values, log_alpha=LOG_ALPHA):
    sequence = SimpleNamespace(conditions=SimpleNamespace(interval=INTERVAL))
    return find_chirps(SimpleNamespace(whitened=values, sequence=sequence), log_alpha)


@pytest.mark.parametrize(("begin", "end"), [(1.0, 4.0), (6.0, 2.5), (20.0, 21.0), (1.5, 20.0)])
def test_a_chirp_is_found_as_the_band_of_its_frequencies(begin, end):
    (band,) = found(white("chirp") + chirp(begin, end, 15))
    low, high = sorted((begin, end))
    width = 8 / (INTERVAL * COUNT)
    assert abs(band.low - low) < 2 * width
    assert abs(band.high - high) < 2 * width


def test_noise_and_steady_lines_are_not_detected_as_chirps():
    time = INTERVAL * np.arange(COUNT)
    assert found(white("noise")) == ()
    assert found(white("noise") + 0.5 * np.cos(2 * np.pi * 3.3 * time)) == ()


@pytest.mark.slow
def test_the_false_alarm_rate_of_chirps_is_at_most_nominal():
    often = [found(white("chance", run), np.log(0.1)) for run in range(100)]
    assert sum(map(bool, often)) <= 17  # 0.1 of 100 and two standard deviations


@pytest.mark.slow
def test_a_sweep_of_changing_rate_is_located_and_not_named():
    cycles = 1.5 * INTERVAL * COUNT / np.log(4) * np.expm1(np.log(4) * np.arange(COUNT) / COUNT)
    sweep = 40 * np.sqrt(2 / COUNT) * np.cos(2 * np.pi * cycles)
    result = result_of(AxisSequence(1e-2 * (white("result") + sweep), CONDITIONS))
    assert result.findings == ()
    assert result.bands or result.withheld


@pytest.mark.parametrize(("cutoff", "misfitting"), [(24.6, True), (2.0, False)])
def test_a_filter_that_is_significant_only_within_the_band_of_a_chirp_is_withheld(cutoff, misfitting):
    """The chirp raises the power of its band, so that higher frequencies appear filtered."""
    noise, filtered = white("filter"), OutputFilter(cutoff, 1)
    noise = noise if misfitting else filtered.apply(noise, CONDITIONS, stream(1))
    data = AxisSequence(1e-2 * (noise + chirp(2.3, 18.1, 30)), CONDITIONS)
    known = Description.known(DENSITY)
    added = Search(known, KINDS, LOG_ALPHA).added(fit(data, known.adding(filtered)))
    misfits = explained_by_bands(added, [Band(2.3, 18.1, -500.0)])
    assert list(misfits) == (added if misfitting else [])


def test_a_steady_line_is_not_detected_as_a_chirp():
    line = Sinusoid(3.3, 1e-2, 0.3)
    data = AxisSequence(1e-2 * white("line") + line.sample(CONDITIONS, None), CONDITIONS)
    assert find_chirps(fit(data, Description.known(DENSITY)), LOG_ALPHA) == ()

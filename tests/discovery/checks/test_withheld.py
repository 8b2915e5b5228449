from dataclasses import replace

import numpy as np
import pytest
from tests.discovery.simulated import (
    INTERVAL,
    KINDS,
    KNOWN,
    LOG_ALPHA,
    TIME,
    WHITE,
    added_to,
    beside_white,
    explored,
    fitted,
    moved,
    names,
    result_of,
    sequence,
    simulated,
)

from imu_benchmark.sealing.noise import fractional
from imugap.discovery.checks import Misfit, misfits
from imugap.discovery.checks.all_checks import ambiguous_spectrum, ambiguous_terms
from imugap.discovery.checks.hysteresis import HYSTERESIS, terms_against_hysteresis
from imugap.discovery.checks.misfit import MAX_LOG_P
from imugap.discovery.fit.axis_fit import fit
from imugap.discovery.fit.description import Description, Entry
from imugap.discovery.preparation.sequence import AxisSequence
from imugap.discovery.search.search import Search
from imugap.discovery.unnamed.hysteresis import Hysteresis
from imugap.discovery.views.discrepancies import find_discrepancies
from imugap.effects import (
    BiasInstability,
    BiasStep,
    GaussMarkov,
    OutputFilter,
    RandomWalk,
    Sinusoid,
    Temperature,
    WarmUp,
)
from imugap.effects.conditions import Conditions
from imugap.stream import stream


def found_again(data, *kinds):
    """A search beside white noise as it is fitted, and the fit that it ends with."""
    return explored(data, *kinds, start=fitted(data).description)


@pytest.mark.slow
def test_a_line_that_drifts_by_equal_factors_is_unexplained_and_not_named():
    data = sequence(count=12_000)
    share = data.conditions.time / data.conditions.time[-1]
    turns = 0.5 * data.conditions.time[-1] * (5.0**share - 1) / np.log(5.0)  # from 0.5 to 2.5 Hz
    result = result_of(moved(data, 2.5e-3 * np.cos(2 * np.pi * turns)))
    assert names(result) == []
    places = find_discrepancies({"gyro_x": result.whole_fit}, 0.01, 0, 39)
    assert any(place.view == "spectrum" and place.low < 2.5 and place.high > 0.5 for place in places)


@pytest.mark.slow
def test_bursts_with_the_spectrum_of_noise_are_not_named_noise():
    """Exponential decays have the spectrum of a Gauss-Markov process, but a skewed and peaked driving process."""
    data, rng = sequence(count=12_000), stream(3, "bursts")
    since = data.conditions.time - rng.uniform(0, data.conditions.time[-1], (20, 1))
    heights = 4e-3 * rng.standard_exponential((20, 1))
    bursts = np.sum(heights * np.where(since >= 0, np.exp(-np.maximum(since, 0) / 6), 0), axis=0)
    process = GaussMarkov(float(bursts.std()), 6.0).sample(data.conditions, rng)
    reasons = []
    for added in (bursts, process):
        search, found = found_again(moved(data, added), GaussMarkov)
        assert found.has(GaussMarkov)
        reasons.append([misfit.reason for misfit in misfits(search, found).values()])
    assert reasons == [["it is stronger at some times than at others"], []]


@pytest.mark.parametrize(
    ("misfitting", "reason", "warm", "withheld"),
    [
        ("noise", "bursts", 2e-2, [BiasStep]),
        ("noise", "bursts", 2e-3, [BiasStep, WarmUp]),
        ("noise", HYSTERESIS, 2e-2, [BiasStep, WarmUp]),
        ("line", "drifts", 2e-3, []),
    ],
)
def test_means_that_misfitting_slow_noise_can_imitate_are_withheld(misfitting, reason, warm, withheld):
    step, warming, noise = BiasStep(200.0, 2e-2), WarmUp(warm, 20.0), GaussMarkov(1e-3, 6.0)
    line = Entry(Sinusoid(0.8, 5e-4, 0.3), ("amplitude",))
    terms = Entry(step, ("step",)), line, Entry(warming, ("amplitude",))
    added = added_to(fitted(sequence(step, warming, noise, count=12_000), *terms, noise))
    misfit = {added[3 if misfitting == "noise" else 1]: Misfit(reason, -20.0)}
    of_it = ambiguous_terms(added, misfit)
    assert [type(one.effect) for one in of_it] == withheld
    assert all(one.reason == reason for one in of_it.values())


def test_lines_and_filters_dominated_by_misfitting_noise_are_withheld():
    """A peak of an unknown spectrum is not necessarily a line."""
    lines = [Entry(Sinusoid(f, 5e-4, 0.3), ("amplitude",)) for f in (0.1, 9.0)]
    for cutoff, both in ((0.1, True), (9.0, False)):
        described = KNOWN.adding(*lines, GaussMarkov(1e-2, 1.0), OutputFilter(cutoff, 1))
        found = fit(sequence(GaussMarkov(1e-2, 1.0), count=12_000), described)
        line, other, noise, passes = added_to(replace(found, description=described))
        misfit = {noise: Misfit("bursts", -20.0)}
        nameless = ambiguous_spectrum([line, other, noise, passes], misfit)
        assert list(nameless) == ([line, passes] if both else [line])


def chirp(begin, end):
    """Return a chirp from one frequency to another [Hz]."""
    return 1.0e-3 * np.sin(2 * np.pi * (begin * TIME + 0.5 * (end - begin) * TIME**2 / TIME[-1]))


@pytest.mark.slow
def test_the_power_of_a_chirp_is_not_named_noise():
    result = result_of(moved(sequence(), chirp(0.5, 2.1)), GaussMarkov, Sinusoid)
    assert names(result) == []
    assert [one.reason for one in result.withheld] == ["a line that sweeps or wanders explains it"]
    (band,) = result.bands
    assert (band.low, band.high) == pytest.approx((0.5, 2.1), rel=0.05)


@pytest.mark.slow
def test_noise_outside_the_band_of_a_chirp_keeps_its_name():
    data = sequence(GaussMarkov(2e-3, 10.0))
    result = result_of(moved(data, chirp(2.0, 4.0)), GaussMarkov, Sinusoid)
    assert names(result) == ["gauss_markov"]
    assert len(result.bands) == 1


@pytest.mark.slow
def test_fractionally_differenced_flicker_keeps_its_name():
    """Fractionally differenced noise lies above 1/f towards half the rate; its slope is that of flicker."""
    data, rng = sequence(count=120_000), stream(1, "fractional")
    search, found = found_again(moved(data, 6e-3 * fractional(120_000, 1.0, rng)), BiasInstability)
    assert found.has(BiasInstability)
    assert misfits(search, found) == {}


@pytest.mark.slow
def test_hysteresis_is_not_named_random_walk():
    """The bias follows the temperature with play; a random walk of the same size keeps its name."""
    time = TIME[:16_000]
    warming = 25 + 4 * np.sin(2 * np.pi * time / 260) + 1.5 * np.sin(2 * np.pi * time / 97 + 1)
    conditions = Conditions(time, INTERVAL, warming, "gyro_x")
    dragged = [warming[0]]
    for value in warming[1:]:
        dragged.append(min(max(dragged[-1], value - 0.8), value + 0.8))
    white = WHITE.sample(conditions, stream(4, "white"))
    walk = RandomWalk(1e-4).sample(conditions, stream(4, "walk"))
    dragging = 2e-3 * (warming - np.array(dragged))
    loop, wandering = (result_of(AxisSequence(white + added, conditions)) for added in (dragging, walk))
    assert names(loop) == []
    assert loop.changed
    assert names(wandering) == ["random_walk"]


@pytest.mark.long
@pytest.mark.slow
@pytest.mark.parametrize(("constant", "period", "size"), [(200, 700, 9e-3), (100, 500, 6e-3), (120, 900, 9e-3)])
def test_hysteresis_during_warming_is_named_neither_temperature_nor_warm_up(constant, period, size):
    """A temperature effect and an independent warm-up keep their names."""
    warming = 25 + 5.5 * (1 - np.exp(-TIME / constant)) + np.sin(2 * np.pi * TIME / period)
    conditions = Conditions(TIME, INTERVAL, warming, "gyro_x")
    loop = Hysteresis(size, -size, 0.1).sample(conditions, None)
    both = Temperature(1e-3, 25.0).sample(conditions, None) + WarmUp(5e-3, 60.0).sample(conditions, None)
    white = WHITE.sample(conditions, stream(4, "white2"))
    of_loop, of_both = (result_of(AxisSequence(white + added, conditions)) for added in (loop, both))
    assert names(of_loop) == []
    assert of_loop.changed
    assert names(of_both) == ["temperature", "warm_up"]


@pytest.mark.slow
def test_noise_between_flicker_and_random_walk_is_seldom_named_gauss_markov():
    """A process of the same number of parameters has to be likelier than a power law to have its name."""
    white, named = sequence(count=60_000), []
    for run in range(8):
        noise = 1.2e-4 * fractional(60_000, 1.5, stream(run, "gml", "f"))
        search, found = found_again(moved(white, noise), GaussMarkov)
        assert found.has(GaussMarkov)
        named.append(not misfits(search, found))
    assert sum(named) <= 2


@pytest.mark.slow
@pytest.mark.parametrize("run", range(3))
def test_a_gauss_markov_process_keeps_its_name(run):
    data = sequence(GaussMarkov(1e-3, 5.0), count=60_000, label=f"markov {run}")
    search, found = found_again(data, GaussMarkov)
    assert found.has(GaussMarkov)
    assert misfits(search, found) == {}


def sawtooth(time, rng):
    return 7e-3 * (time / 93.0 % 1)


def triangle(time, rng):
    return 1.5e-2 * np.abs(time / 93.0 % 1 - 0.5)


def humming(time, rng):
    return 3e-3 * (time / 97.0 % 1 < 0.35) * np.sin(2 * np.pi * 4.7 * time)


def knocks(time, rng):
    since = time - np.array([[111.0], [402.0], [655.0], [838.0]])
    ringing = np.exp(-np.maximum(since, 0) / 4) * np.sin(2 * np.pi * 2.7 * np.maximum(since, 0))
    return 2e-2 * np.sum(np.where(since > 0, ringing, 0.0), axis=0)


def between_walk_and_flicker(time, rng):
    frequency = np.fft.rfftfreq(2 * len(time))
    frequency[0] = np.inf
    noise = np.fft.irfft(np.fft.rfft(rng.standard_normal(2 * len(time))) * frequency**-0.75)[: len(time)]
    return 6e-3 * (noise - noise.mean()) / noise.std()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("added", "view", "low", "high"),
    [
        (sawtooth, "line", 1 / 93, 1 / 93),
        (triangle, "line", 1 / 93, 1 / 93),
        (humming, "line", 4.7, 4.7),
        (knocks, "variance", 111, 113),
        (between_walk_and_flicker, "spectrum", 0.001, 0.01),
    ],
)
def test_signals_close_to_an_effect_are_located_and_not_named(added, view, low, high):
    result = result_of(beside_white(added))
    assert names(result) == []
    places = [one.location for one in result.withheld if one.location.view == view]
    assert all(place.axis == "gyro_x" and place.p_value < 0.01 for place in places)
    assert any(place.low <= low and high <= place.high for place in places)


@pytest.mark.parametrize(("shape", "reasons"), [("teeth", ["a wave of one period explains it better"]), ("step", [])])
def test_a_jump_of_a_periodic_term_is_not_named_step(shape, reasons):
    """The random walk of the start model absorbs all of the periodic term but one jump; a true step keeps its name."""
    known = RandomWalk(5e-5)
    data = sequence(known, label="jump")
    time = data.conditions.time
    added = {"teeth": 2e-3 * (time / 96.3 % 1), "step": -2e-3 * (time > 4 * 96.3)}[shape]
    jumping = moved(data, added)
    before = fit(jumping, Description.known(WHITE, known))
    step = Entry(BiasStep(4 * 96.3, -2e-3), ("step",))
    found = fit(jumping, before.description.adding(step))
    misfitting = misfits(Search(before.description, (BiasStep,), LOG_ALPHA), found)
    assert [misfit.reason for misfit in misfitting.values()] == reasons


def test_a_steady_line_has_no_misfit():
    data = sequence(Sinusoid(0.8, 5e-4, 0.3), count=12_000)
    search, found = found_again(data, *KINDS)
    assert [effect.name for effect in found.description.effects()] == ["sinusoid", "white_noise"]
    assert misfits(search, found) == {}


@pytest.mark.slow
def test_a_temperature_effect_with_random_walk_is_seldom_taken_for_hysteresis():
    count, interval, few = 3000, 0.2, []
    time = interval * np.arange(count)
    warming = 24 + 4 * (1 - np.exp(-time / 120)) + 0.5 * np.sin(2 * np.pi * time / 200)
    conditions, straight = Conditions(time, interval, warming, "gyro_x"), Temperature(1e-3, 25.0)
    described = KNOWN.adding(Entry(straight, ("coefficient",)), RandomWalk(4e-5))
    for run in range(60):
        found = fit(simulated((WHITE, RandomWalk(4e-5), straight), conditions, run, "nested"), described)
        few.append(terms_against_hysteresis(Search(KNOWN, (), LOG_ALPHA), found).log_p)
    assert np.sum(np.array(few) < MAX_LOG_P) <= 3
    assert 5 <= np.sum(np.array(few) < np.log(0.5)) <= 40

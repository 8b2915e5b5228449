import numpy as np
import pytest
from tests.discovery.simulated import (
    COUNT,
    INTERVAL,
    KINDS,
    LOG_ALPHA,
    WHITE,
    fitted,
    moved,
    names,
    result_of,
    sequence,
    simulated,
    told_of,
)

from imugap.discovery.fit.axis_fit import fit
from imugap.discovery.fit.description import Description
from imugap.discovery.preparation.sequence import AxisSequence
from imugap.discovery.search.search import Search, Trial
from imugap.effects import (
    BiasInstability,
    BiasStep,
    Chirp,
    GaussMarkov,
    Outliers,
    OutputFilter,
    Quantization,
    RandomTelegraph,
    RandomWalk,
    RateRamp,
    Sinusoid,
    Temperature,
    VarianceChange,
    WarmUp,
    WhiteNoise,
)
from imugap.effects.conditions import Conditions
from imugap.stream import stream


@pytest.mark.slow
@pytest.mark.parametrize(
    "effect",
    [
        RateRamp(2e-6),
        WarmUp(2e-3, 60.0),
        BiasStep(400.0, 1e-3),
        Sinusoid(2.7, 7e-4, 1.0),
        BiasInstability(1e-3),
        RandomWalk(1e-4),
        GaussMarkov(1e-3, 10.0),
        RandomTelegraph(2e-3, 0.05),
        Quantization(1e-4),
        OutputFilter(5.0, 2),
        OutputFilter(2.0, 1, 1),
        OutputFilter(15.0, 1, 1),
        OutputFilter(6.0, 4, 2),
        VarianceChange(200.0, 350.0, 1.6),
        VarianceChange(0.0, 960.0, depth=0.5, frequency=0.01, phase=1.0),
        Outliers(2e-3, 4e-2),
    ],
    ids=lambda effect: effect.name,
)
def test_an_effect_is_named_with_its_size(effect):
    result = told_of(effect)
    assert names(result) == [effect.name]
    for name, interval in result.findings[0].parameters.items():
        if name in ("phase", "time", "start", "stop") or interval.low == interval.high:
            continue
        wide = 2.0 * (interval.high - interval.low)
        assert interval.low - wide < getattr(effect, name) < interval.high + wide


@pytest.mark.slow
def test_a_pair_that_masquerades_as_one():
    assert names(told_of(BiasInstability(5e-4), RateRamp(4e-6))) == ["bias_instability", "rate_ramp"]


@pytest.mark.slow
def test_nothing_hidden_is_called_nothing():
    results = [told_of(count=6000, label=f"nothing{run}") for run in range(12)]
    assert sum(bool(result.findings) for result in results) == 0


@pytest.mark.slow
@pytest.mark.parametrize(
    ("hidden", "known"),
    [(GaussMarkov(4.4e-3, 18.0), RandomWalk(1.6e-5)), (BiasInstability(2e-3), RandomWalk(1e-5))],
)
def test_slow_noise_of_the_start_model_does_not_stand_for_what_is_missing(hidden, known):
    """It is free, and takes the place of what is hidden; beside it there is no room for the right name."""
    data = sequence(hidden, known)
    result = result_of(data, GaussMarkov, BiasInstability, start=(WHITE, known))
    assert names(result) == [hidden.name]


@pytest.mark.slow
@pytest.mark.parametrize("base", [RandomWalk(1.5e-4), BiasInstability(4e-4), GaussMarkov(1e-3, 20.0)])
def test_other_slow_noise_in_place_of_the_right_one_is_seldom_significant(base):
    surest = []
    for number in range(60):
        data = sequence(base, count=4000, label=f"instead {number}")
        before = fit(data, Description.known(WHITE, base))
        search = Search(before.description, (BiasInstability, GaussMarkov, RandomWalk), LOG_ALPHA)
        surest.append(min((trial.log_p for trial in search.trials(before, 0.0)), default=0.0))
    assert np.mean(np.array(surest) < np.log(0.03)) <= 0.03 + 3 * np.sqrt(0.03 / 60)


def switching(high, low, label):
    """Return samples with two values, and the mean times that they last [s]."""
    rng, place, up = stream(1, label), 0.0, False
    path = np.zeros(COUNT)
    while place < COUNT:
        end = place + rng.exponential(high if up else low) / INTERVAL
        path[int(place) : int(end)] = 4e-3 * up
        place, up = end, not up
    return moved(sequence(), path)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("high", "low", "expected"),
    [(6.0, 6.0, ["random_telegraph"]), (4.0, 9.0, ["random_telegraph"]), (0.5, 20.0, [])],
)
def test_two_values_are_one_telegraph_noise_if_they_are_about_as_frequent(high, low, expected):
    result = result_of(switching(high, low, "switching"))
    assert [finding.name for finding in result.findings if finding.name == "random_telegraph"] == expected


@pytest.mark.slow
@pytest.mark.parametrize("unit", [1e-4, 1e4])
def test_nothing_depends_on_the_unit(unit):
    data = sequence(GaussMarkov(3e-3, 5.0), RandomWalk(1e-4))
    here, there = (result_of(one) for one in (data, data.with_values(unit * data.values)))
    assert names(here) == names(there)
    for one, other in zip(here.findings, there.findings, strict=True):
        assert one.log_p == pytest.approx(other.log_p, rel=1e-3)
        sizes = [1.0 if name == "correlation_time" else unit for name in one.parameters]
        for size, a, b in zip(sizes, one.parameters.values(), other.parameters.values(), strict=True):
            assert [size * end for end in (a.value, a.low, a.high)] == pytest.approx([b.value, b.low, b.high], rel=2e-2)


@pytest.mark.slow
def test_beside_a_wave_of_another_shape_a_step_keeps_its_name():
    wave = Sinusoid(0.4, 2e-3, 0.3), Sinusoid(0.8, 1e-3, 1.0)
    assert names(told_of(*wave, BiasStep(250.0, 1e-3), count=12_000)) == ["bias_step"]


def two_terms(slope, coefficient, label):
    """Search a log with a ramp and a temperature effect that nearly cancel."""
    time = np.arange(12000) * 0.05
    warming = 20 + 8 * (1 - np.exp(-time / 200)) + np.sin(2 * np.pi * time / 450)
    conditions = Conditions(time, 0.05, warming, "gyro_x")
    values = RateRamp(slope).sample(conditions, None) + Temperature(coefficient).sample(conditions, None)
    values += WhiteNoise(1e-4).sample(conditions, stream(1, label))
    log = AxisSequence(values, conditions)
    before = fit(log, Description.known(WhiteNoise(1e-4)))
    return Search(before.description, KINDS, LOG_ALPHA).explore(before)


@pytest.mark.parametrize("number", [13, 63, 74])
def test_no_insignificant_effect_stays_beside_the_others(number):
    """A walk like a ramp: a second term makes the ramp look likelier, but is not significant itself."""
    count, interval = 3000, 0.2
    time = interval * np.arange(count)
    warming = 24 + 4 * (1 - np.exp(-time / 120)) + 0.5 * np.sin(2 * np.pi * time / 200)
    conditions = Conditions(time, interval, warming, "gyro_x")
    data = simulated((WHITE, RandomWalk(4e-5)), conditions, number, "couple")
    search = Search(fitted(data).description, (RateRamp, Temperature, WarmUp, BiasStep, Sinusoid), LOG_ALPHA)
    found = search.explore(fitted(data))
    assert search.added(found)
    assert all(candidate.significant for candidate in search.added(found))


def test_two_means_that_nearly_cancel_are_found_together():
    found = two_terms(-6e-7, 6e-5, "cancel").description.terms
    assert sorted(term.effect.name for term in found) == ["rate_ramp", "temperature"]


@pytest.mark.slow
@pytest.mark.parametrize("run", range(4))
def test_a_step_and_a_ramp_that_nearly_cancel_are_found_together(run):
    """A walk gains more than either of them alone, and hides both."""
    found = told_of(BiasStep(480.0, -1.2e-3), RateRamp(1.8e-6), label=f"saw {run}")
    assert names(found) == ["bias_step", "rate_ramp"]


def test_slow_noise_beside_a_walk_of_the_start_model_is_found():
    conditions = Conditions(np.arange(20000) * 0.04, 0.04, axis="gyro_x")
    effects = (WhiteNoise(2e-4), RandomWalk(6e-6), GaussMarkov(5e-4, 7.0))
    values = sum(effect.sample(conditions, stream(2, "beside", effect.name)) for effect in effects)
    log = AxisSequence(values, conditions)
    before = fit(log, Description.known(*effects[:2]))
    after = Search(before.description, KINDS, LOG_ALPHA).explore(before)
    assert [effect.name for effect in after.description.noise.effects[2:]] == ["gauss_markov"]


class _Tempted(Search):
    """Search with one proposal, which is worth more than others, and of a gain given by the sequence."""

    gain = 0.0

    def trials(self, before, bar, whole=None, worth=-np.inf):
        yield Trial(RandomWalk(1e-5), before, self.gain, 1, 1.0)


class _TemptedByUncertain(_Tempted):
    gain = 7.5


class _TemptedByCertain(_Tempted):
    gain = 12.0


@pytest.mark.parametrize(("kind", "exchanged"), [(_TemptedByUncertain, False), (_TemptedByCertain, True)])
def test_an_effect_is_exchanged_only_for_one_that_is_certain(kind, exchanged):
    """An uncertain one is removed next, and the first one added again, without an end."""
    known, chirp = Description.known(WHITE), Chirp(1.2, 1e-3, 6.85e-4)
    found = fit(sequence(chirp, count=6000), known.adding(chirp))
    search = kind(known, (*KINDS, Chirp), LOG_ALPHA)
    (own,) = search.added(found)
    (other,) = search.trials(own.without, 0.0)
    assert own.significant
    assert other.worth > own.trial.worth
    assert (search.refined(found) is not found) == exchanged

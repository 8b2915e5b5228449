"""Misfits of named effects, by goodness of fit and against unnamed alternatives."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from scipy.ndimage import uniform_filter1d
from scipy.special import ndtr
from scipy.stats import binom
from tests.chance import as_often_as
from tests.discovery import simulated
from tests.discovery.simulated import (
    COUNT,
    INTERVAL,
    KNOWN,
    LOG_ALPHA,
    added_to,
    explored,
    fitted,
    names,
    result_of,
    searched,
)

from imugap.discovery.axis import conclude, power_law_finding, without_unnamed
from imugap.discovery.checks import MAX_LOG_P, MIN_SHARE, misfits
from imugap.discovery.checks import gaussianity as samples
from imugap.discovery.checks.all_checks import ambiguous_variance, steps_as_jump_process, terms_as_power_law
from imugap.discovery.checks.gaussianity import BURSTS, sample_misfits
from imugap.discovery.checks.hysteresis import CURVE
from imugap.discovery.checks.mean import shape_log_p
from imugap.discovery.checks.misfit import Misfit
from imugap.discovery.checks.outliers import outliers_misfit
from imugap.discovery.checks.spectrum import POWER_LAW, band_log_p, power_share, substitution_log_p
from imugap.discovery.checks.transient import DURATION, transient_misfits
from imugap.discovery.checks.transition import transition_misfits
from imugap.discovery.fit.description import Entry
from imugap.discovery.search.search import Search, without
from imugap.discovery.unnamed.chirps import find_chirps
from imugap.effects import (
    BiasInstability,
    BiasStep,
    GaussMarkov,
    Outliers,
    OutputFilter,
    PowerLaw,
    RandomTelegraph,
    RandomWalk,
    RateRamp,
    Sinusoid,
    VarianceChange,
    WarmUp,
)
from imugap.effects.power_law import STEEPEST
from imugap.numerics.samples.contaminated_normal import tails
from imugap.stream import stream

sequence = partial(simulated.sequence, label="doubts")


def reasons(data, *kinds):
    return {misfit.reason for misfit in misfits(*explored(data, *kinds)).values()}


@pytest.mark.slow
@pytest.mark.parametrize("effect", [GaussMarkov(5e-3, 8.0), BiasInstability(2e-3), RandomWalk(1e-3)])
def test_the_stationarity_p_value_of_stationary_noise_is_uniform(effect, monkeypatch):
    """Without the tolerated divergence."""
    monkeypatch.setattr(samples, "TOLERATED_DIVERGENCE", 0.0)
    log_ps = []
    for label in range(60):
        found = fitted(sequence(effect, count=8000, label=label), effect)
        _, fading = sample_misfits(found, power_share(found, found.description.noise.effects[1]))
        log_ps.append(np.exp(fading.log_p))
    for level in (0.05, 0.2):
        assert as_often_as(np.array(log_ps) < level, level, 2e-3)


def test_the_band_p_value_of_few_coefficients_is_uniform():
    """Bands use only the effective number of parameters; other bins determine the white noise."""
    log_ps = []
    for label in range(200):
        effect = RandomWalk(2e-4)
        found = fitted(sequence(effect, label=label), effect)
        mine = np.flatnonzero(power_share(found, found.description.noise.effects[1]) > MIN_SHARE)
        assert 60 < len(mine) < 130
        log_ps.append(band_log_p(found, mine))
    for level in (0.01, 0.05, 0.2):
        assert as_often_as(np.exp(log_ps) < level, level, 2e-3)


def rising(time, rng):
    """Return a line whose frequency grows fifty times."""
    growth = np.log(50) / time[-1]
    return 8e-3 * np.sin(2 * np.pi * 0.01 * np.expm1(growth * time) / growth)


@pytest.mark.slow
def test_an_exponential_chirp_is_not_named_noise():
    data = sequence(added=rising, count=12_000)
    _, found = explored(data, GaussMarkov)
    _, fading = sample_misfits(found, power_share(found, found.description.noise.effects[1]))
    assert fading.log_p < MAX_LOG_P
    assert names(result_of(data)) == []


def chamber(time):
    """Return the temperature of cycles between two plateaus, which come slowly to rest."""
    return 20 + 25 * np.tanh(3 * np.sin(2 * np.pi * time / 320)) + 5 * np.sin(2 * np.pi * time / 777)


@pytest.mark.slow
def test_a_curve_over_the_temperature_is_not_named_noise():
    """With a bend at a level, as at the freezing point of water."""
    warm = chamber(INTERVAL * np.arange(COUNT))
    data = sequence(added=lambda time, rng: 2e-4 * np.maximum(warm - 5, 0) - 4e-6 * warm**2, temperature=warm)
    assert CURVE in reasons(data, BiasInstability, GaussMarkov, RandomWalk)


@pytest.mark.slow
def test_steps_with_the_sign_of_the_temperature_rate_are_not_named_noise():
    wanders = uniform_filter1d(stream(2, "warm").standard_normal(COUNT), 300)
    warm = 20 + 2 * uniform_filter1d(np.cumsum(wanders), 300)
    data = sequence(added=lambda time, rng: 5e-3 * np.sign(np.gradient(warm, INTERVAL)), temperature=warm)
    assert reasons(data, GaussMarkov) == {CURVE}


@pytest.mark.slow
@pytest.mark.parametrize("course", [chamber, lambda time: 20 + 10 * np.exp(-time / 300), lambda time: 20 + time / 100])
@pytest.mark.parametrize(
    "effect", [BiasInstability(2e-3), RandomWalk(1e-4), RandomWalk(1e-3), RandomTelegraph(4e-3, 0.02)]
)
def test_noise_keeps_its_name_under_any_temperature_profile(effect, course):
    warm = course(INTERVAL * np.arange(COUNT))
    for label in range(5):
        data = sequence(effect, label=label, temperature=warm)
        found = reasons(data, BiasInstability, GaussMarkov, RandomTelegraph, RandomWalk)
        assert not any("temperature" in reason for reason in found)


def steep(time, rng):
    """Return noise of a spectrum of slope -2.7."""
    frequency = np.fft.rfftfreq(8 * len(time), INTERVAL)[1:]
    real, imaginary = rng.standard_normal((2, len(frequency) + 1))
    values = np.fft.irfft(np.r_[0.0, frequency**-1.35] * (real + 1j * imaginary))[: len(time)]
    return 2e-3 * (values - values.mean()) / values.std()


@pytest.mark.slow
def test_means_fitted_to_steep_noise_are_withheld():
    kinds, more = (BiasStep, RateRamp, WarmUp), 0
    for label in range(6):
        search, found = explored(sequence(added=steep, count=6000, label=f"steep {label}"), *kinds)
        added = search.added(found)
        more += len(added) > 1 and terms_as_power_law(added).keys() == set(added)
    assert more > 1


def test_true_means_are_likelier_than_a_power_law():
    data = sequence(BiasStep(400.0, -1e-3), RateRamp(2e-6), WarmUp(3e-3, 60.0))
    search, found = explored(data, BiasStep, RateRamp, WarmUp)
    assert len(search.added(found)) > 1
    assert terms_as_power_law(search.added(found)) == {}


def relaxations(time, rng):
    """Return jumps at random times, of random size, each of which dies away."""
    since = time - rng.uniform(0, time[-1], (15, 1))
    heights = 2e-2 * rng.standard_exponential((15, 1))
    return np.sum(heights * np.where(since >= 0, np.exp(-np.maximum(since, 0) / 20), 0), axis=0)


@pytest.mark.slow
@pytest.mark.parametrize("exponent", [0.6, 1.5])
def test_noise_of_an_unnamed_slope_enters_the_model_as_a_power_law(exponent):
    found = result_of(sequence(PowerLaw(4e-3, exponent), label=exponent))
    assert found.withheld
    assert not found.findings
    ends = found.power_law.parameters["exponent"]
    assert ends.low < exponent < ends.high
    for one in (found.training_fit, found.whole_fit):
        assert [effect.name for effect in one.description.effects()] == ["white_noise", "power_law"]
    assert found.same_names


def carried_on(found, reason=POWER_LAW):
    """Return a fit without what it has beside white noise, all of which has a misfit."""
    misfitting = dict.fromkeys(added_to(found), Misfit(reason, -20.0))
    return without_unnamed(Search(KNOWN, (), LOG_ALPHA), found, misfitting)


@pytest.mark.slow
@pytest.mark.parametrize("reason", [POWER_LAW, BURSTS])
def test_only_noise_of_another_slope_is_replaced_by_a_power_law(reason):
    carried = carried_on(fitted(sequence(PowerLaw(4e-3, 1.5)), RandomWalk(1e-3)), reason)
    assert carried.has(PowerLaw) == (reason == POWER_LAW)
    assert not carried.has(RandomWalk)


def test_a_trend_is_not_replaced_by_a_power_law():
    """Steep noise is, although its interval of the slope reaches that of a trend."""
    trend = sequence(added=lambda time, rng: 2e-2 * np.sin(2 * np.pi * (time / time[-1]) ** 2))
    for data, noise in ((trend, False), (sequence(PowerLaw(1e-4, 2.6), label="s1"), True)):
        carried = carried_on(fitted(data, RandomWalk(1e-4)))
        assert carried.has(PowerLaw) == noise
    ends = power_law_finding(Search(KNOWN, (), LOG_ALPHA), carried).parameters["exponent"]
    assert ends.low < 2.6 < STEEPEST < ends.high


@pytest.mark.slow
def test_misfitting_slow_noise_is_not_detected_as_a_chirp(monkeypatch):
    data = sequence(RandomWalk(3e-5), count=300_000, label="w0")
    search = searched(data, RandomWalk)
    walk = search.whole_search.added(search.whole_fit)
    assert find_chirps(without(search.whole_fit, walk), LOG_ALPHA) != ()
    withheld = dict.fromkeys(walk, Misfit(POWER_LAW, -20.0))
    monkeypatch.setattr("imugap.discovery.axis.misfits", lambda search, found: withheld)
    result = conclude(search)
    assert [one.name for one in result.withheld] == ["random_walk"]
    assert result.bands == ()


def test_a_misfitting_step_with_slow_noise_is_not_replaced_by_a_power_law():
    step = BiasStep(400.0, 0.1)
    found = fitted(sequence(PowerLaw(4e-3, 1.5), step), Entry(step, ("step",)), RandomWalk(1e-3))
    assert [one.name for one in carried_on(found).description.effects()] == ["white_noise"]


@pytest.mark.slow
def test_relaxations_after_steps_are_not_named_telegraph_noise():
    data = sequence(added=relaxations, count=12_000, label="a")
    assert names(result_of(data, BiasStep, RandomTelegraph, RandomWalk)) == []


@pytest.mark.parametrize(("noise", "most"), [(GaussMarkov(2e-3, 5.0), 2), (RandomTelegraph(4e-3, 0.1), 1)])
def test_many_steps_with_slow_noise_are_a_jump_process(noise, most):
    for count in (most, most + 1):
        steps = tuple(Entry(BiasStep(200.0 * (k + 1), 0.05), ("step",)) for k in range(count))
        effects = (noise, *(step.effect for step in steps))
        added = added_to(fitted(sequence(*effects), *steps, noise))
        assert set(steps_as_jump_process(added)) == (set(added) if count > most else set())


@pytest.mark.parametrize(("second", "misfitting"), [(0.5, True), (2.0, False)])
def test_several_steps_within_a_warm_up_reject_its_shape(second, misfitting):
    """Within two time constants; a single step, or steps after the warm-up, keep their names."""
    over = DURATION * 40.0
    terms = (
        Entry(WarmUp(0.05, 40.0), ("amplitude", "time_constant")),
        *(Entry(BiasStep(time, 0.02), ("step",)) for time in (0.25 * over, second * over)),
    )
    added = added_to(fitted(sequence(*(term.effect for term in terms)), *terms))
    assert len(added) == 3
    assert set(transient_misfits(added)) == (set(added) if misfitting else set())


def passing(time, rng):
    """Return a passage to another level, which takes a minute or so."""
    return 4e-3 * ndtr((time - 480) / 20)


@pytest.mark.slow
@pytest.mark.parametrize(("kinds", "most"), [((BiasStep,), 4), ((RandomWalk, GaussMarkov), 2)])
def test_a_gradual_transition_is_named_neither_steps_nor_noise(kinds, most):
    search, found = explored(sequence(added=passing), *kinds)
    added = search.added(found)
    assert 0 < len(added) <= most
    assert set(transition_misfits(added)) == set(added)


@pytest.mark.slow
@pytest.mark.parametrize(
    "effects", [(BiasStep(460.0, 1e-3), BiasStep(500.0, 1e-3)), (RandomWalk(1e-4),), (RandomTelegraph(2e-3, 0.02),)]
)
def test_steps_of_one_sign_and_slow_noise_keep_their_names(effects):
    for label in range(10):
        search, found = explored(sequence(*effects, label=label), BiasStep, RandomWalk, RandomTelegraph)
        assert search.added(found)
        assert transition_misfits(search.added(found)) == {}


@pytest.mark.parametrize("later", [True, False])
def test_a_step_with_exponential_onset_or_settling_has_a_misfit(later):
    """With a time constant of a hundredth of the log, before or after it."""

    def crept(time, rng):
        late = np.maximum(time - 480 if later else 480 - time, 0.0)
        return 4e-3 * np.where(late > 0, np.exp(-late / 9.6), 0.0) * (-1 if later else 1) + 4e-3 * (time >= 480)

    found = fitted(sequence(added=crept), Entry(BiasStep(480.0, 4e-3), ("step",)))
    assert shape_log_p(found, 0) < MAX_LOG_P - 10


@pytest.mark.parametrize(("factor", "odd"), [(1.0, False), (4.0, True)])
def test_samples_and_spectrum_agree_where_a_random_walk_replaces_telegraph_noise(factor, odd):
    true = RandomTelegraph(4e-3, 0.05)
    found = fitted(sequence(true), RandomWalk(4e-4))
    hidden = replace(true, step=1e-9)
    *_, candidate = added_to(replace(found, description=found.description.adding(hidden)))
    log_p = substitution_log_p(candidate, replace(true, step=factor * true.step))
    assert (log_p < MAX_LOG_P) == odd


RELAXING = {
    "logarithm": lambda time, rng: 3e-3 * np.log1p(time / 5),
    "power": lambda time, rng: 1e-3 * time**0.4,
    "stretched": lambda time, rng: 1.5e-2 * np.exp(-np.sqrt(time / 50)),
    "warm-up and ramp": lambda time, rng: 3e-3 * np.exp(-time / 60) + 2e-6 * time,
}
"""Relaxations by their kind, and a warm-up with a ramp."""


@pytest.mark.slow
@pytest.mark.parametrize("kind", RELAXING)
def test_a_transient_of_another_shape_is_not_named_warm_up_and_ramp(kind):
    search, found = explored(sequence(added=RELAXING[kind], label=kind), WarmUp, RateRamp, BiasStep)
    added = search.added(found)
    assert len(added) >= 2
    misfitting = misfits(search, found)
    assert set(misfitting) == (set() if kind == "warm-up and ramp" else set(added))


def test_bursts_make_a_change_of_variance_ambiguous():
    change = VarianceChange(200.0, 300.0, 4.0)
    noise = GaussMarkov(2e-3, 5.0)
    slow, changes = added_to(fitted(sequence(noise, change), noise, change))
    bursts, slope = Misfit(BURSTS, -20.0), Misfit("its spectrum has another slope", -20.0)
    assert ambiguous_variance([slow, changes], {slow: bursts}) == {changes: bursts}
    assert ambiguous_variance([slow, changes], {slow: slope}) == {}


@pytest.mark.slow
def test_two_sidebands_without_a_carrier_are_withheld():
    def beating(time, rng):
        return 8e-4 * np.cos(2 * np.pi * 0.05 * time / 2) * np.cos(2 * np.pi * 9 * time)

    data = sequence(added=beating)
    assert reasons(data, Sinusoid) == {"lines beside it make it one that swells or drifts"}
    apart = sequence(Sinusoid(9.0, 4e-4), Sinusoid(9.2, 4e-4))
    assert reasons(apart, Sinusoid) == set()


@pytest.mark.slow
def test_a_filter_is_more_significant_than_the_remaining_deviation():
    """A bump of the spectrum below Nyquist is followed by a fall, which alone would be a filter."""

    def bump(time, rng):
        frequency = np.fft.rfftfreq(len(time), INTERVAL)
        gain = 1.2 * np.exp(-0.5 * (np.log(np.maximum(frequency, 1e-9) / 5) / 0.2) ** 2)
        return np.fft.irfft(np.fft.rfft(rng.standard_normal(len(time)) * 1e-3 / np.sqrt(INTERVAL)) * gain, len(time))

    assert reasons(sequence(added=bump), OutputFilter) == {"the spectrum around it is farther off"}
    assert reasons(sequence(OutputFilter(5.0, 1)), OutputFilter) == set()


@pytest.mark.slow
def test_p_values_of_uniform_and_irregular_outliers_are_conservative():
    rng, found = stream(5, "even"), []
    for _ in range(200):
        hit = rng.random(10_000) < 10 ** rng.uniform(-2.5, -1.5)
        found.append(tails(rng.standard_normal(10_000) * np.where(hit, 12.0, 1.0)))
    for level in (0.01, 0.1):
        for log_ps in ([one.uneven for one in found], [one.beating for one in found]):
            assert np.sum(np.exp(log_ps) < level) <= binom.isf(1e-3, len(found), level)
    assert np.sum(np.exp([one.uneven for one in found]) < 0.5) >= binom.isf(1 - 1e-3, len(found), 0.4)


def spikes(time, rng):
    return 0.05 * (np.arange(len(time)) % 131 == 7)


def fewer_and_fewer(time, rng):
    hit = rng.random(len(time)) < 0.02 * np.exp(-4 * time / time[-1])
    return np.where(hit, 0.05 * rng.standard_normal(len(time)), 0.0)


def skewed(time, rng):
    return 0.01 * (rng.standard_exponential(len(time)) - 1)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("added", "reason"),
    [
        (spikes, "they come at a beat"),
        (fewer_and_fewer, "they come at some times more often than at others"),
        (skewed, "all samples are of another distribution"),
    ],
)
def test_periodic_decaying_or_skewed_samples_are_not_named_outliers(added, reason):
    search, found = explored(sequence(added=added), Outliers)
    assert found.has(Outliers)
    (outliers,) = search.added(found)
    assert outliers_misfit(outliers).reason == reason
    assert {misfit.reason for misfit in misfits(search, found).values()} == {reason}


def test_outliers_on_one_side_are_the_tail_of_another_law():
    def tail(time, rng):
        return np.where(rng.random(len(time)) < 0.03, 0.02 * rng.standard_exponential(len(time)), 0.0)

    assert reasons(sequence(added=tail), Outliers) == {"most of them go to one side"}
    assert reasons(sequence(Outliers(0.03, 0.02)), Outliers) == set()


@pytest.mark.slow
@pytest.mark.parametrize("law", ["standard_normal", "laplace", "uniform"])
def test_outliers_of_any_distribution_keep_their_name(law):
    def far(time, rng):
        size = 0.04 * (rng.uniform(-2, 2, len(time)) if law == "uniform" else getattr(rng, law)(size=len(time)))
        return np.where(rng.random(len(time)) < 0.005, size, 0.0)

    for label in range(5):
        search, found = explored(sequence(added=far, label=label), Outliers)
        assert found.has(Outliers)
        assert misfits(search, found) == {}


@pytest.mark.slow
def test_heavy_tails_of_all_samples_are_not_named_outliers():
    data = sequence(added=lambda time, rng: 5e-3 * rng.laplace(size=len(time)))
    assert reasons(data, Outliers) == {"they are not rare"}


@pytest.mark.slow
def test_volatile_noise_is_named_neither_outliers_nor_changes_of_variance():
    def volatile(time, rng):
        level = np.convolve(rng.standard_normal(len(time)), np.ones(200) / np.sqrt(200), "same")
        return 5e-3 * np.exp(0.8 * level) * rng.standard_normal(len(time))

    search, found = explored(sequence(added=volatile), Outliers, VarianceChange)
    added = search.added(found)
    assert {type(one.effect) for one in added} == {Outliers, VarianceChange}
    assert set(misfits(search, found)) == set(added)
    assert ambiguous_variance(added, {}) == {}

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.fft import dct
from scipy.signal import butter, lfilter
from scipy.stats import binom, chi2

from imugap.benchmark.sealing.noise import fractional
from imugap.discovery.axis import concluded, told
from imugap.discovery.between_runs import turn_on
from imugap.discovery.checks import Doubt, doubts
from imugap.discovery.checks.all_checks import _of_the_spectrum, _parts_of_it
from imugap.discovery.checks.hysteresis import MEMORY, in_place_of_means
from imugap.discovery.checks.misfit import LEVEL
from imugap.discovery.common_noise import _errors, shared
from imugap.discovery.device import _nameless
from imugap.discovery.finding import Gap
from imugap.discovery.fit import matched_filters as scans
from imugap.discovery.fit.axis_fit import Description, Term, cosines, fit, jacobian
from imugap.discovery.fit.contaminated_normal import tails
from imugap.discovery.fit.telegraph_likelihood import compare
from imugap.discovery.fit.whittle import Noise, _Spectra, limits
from imugap.discovery.preparation.cosine_bins import usable
from imugap.discovery.preparation.sequence import Sequence
from imugap.discovery.search.intervals import _near
from imugap.discovery.search.search import MANY, RESHAPED, Key, Search, _behind, _hopeful, at
from imugap.discovery.unnamed import periodic as waves
from imugap.discovery.unnamed.hysteresis import Hysteresis
from imugap.discovery.views.gaps import gaps
from imugap.effects import (
    CATALOGUE,
    BiasInstability,
    BiasStep,
    CommonMode,
    GaussMarkov,
    Outliers,
    OutputFilter,
    Quantization,
    RandomTelegraph,
    RandomWalk,
    RateRamp,
    Sinusoid,
    Temperature,
    TurnOnBias,
    VarianceChange,
    WarmUp,
    WhiteNoise,
)
from imugap.effects.conditions import Conditions
from imugap.effects.effect import AxisModel
from imugap.stream import stream

COUNT, INTERVAL = 24_000, 0.04
WHITE = WhiteNoise(1e-3)
LOG_ALPHA = np.log(0.01 / 6 / 28)


def sequence(*effects, count=COUNT, axis="gyro_x", label="search"):
    conditions = Conditions(INTERVAL * np.arange(count), INTERVAL, axis=axis)
    values = AxisModel((WHITE, *effects)).simulate(np.zeros(count), conditions, 1, label)
    return Sequence(values, conditions, np.zeros(count, bool))


def plain(data):
    return fit(data, Description((), Noise((WHITE,))))


def told_of(*effects, **kwargs):
    data = sequence(*effects, **kwargs)
    return concluded(told(data, (), tuple(CATALOGUE.values()), LOG_ALPHA, int(0.8 * len(data.values))))


def names(story):
    return sorted(finding.name for finding in story.findings)


def test_gain_of_every_step_is_that_of_its_column():
    found = fit(sequence(BiasInstability(3e-4), count=4000), Description((), Noise((WHITE, BiasInstability(3e-4)))))
    gains = found.steps.gains
    for place in (80, 777, 2000, 3500):
        column = (np.arange(4000) >= place).astype(float)
        assert gains[place] == pytest.approx(found.gains(found.whiten(column[:, None]))[0], rel=1e-6)


@pytest.mark.parametrize("output_filter", [None, OutputFilter(2.0, 2)])
def test_gain_of_every_step_is_that_beside_terms_which_move(output_filter):
    """Behind a filter what leaks over the ends of the log is left out of it."""
    terms = Term(RateRamp(0.0), ("slope",)), Term(Sinusoid(0.013, 1e-4, 0.4), ("frequency", "amplitude", "phase"))
    effects = () if output_filter is None else (output_filter,)
    found = fit(sequence(*effects, count=4000), Description(terms, Noise((WHITE,), output_filter)))
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


@pytest.mark.parametrize(
    "noise",
    [
        Noise((WHITE, BiasInstability(2e-4), RandomWalk(1e-5))),
        Noise((WHITE, GaussMarkov(3e-4, 8.0), Quantization(1e-5)), OutputFilter(6.0, 2)),
        Noise((WHITE, RandomTelegraph(1e-3, 0.1))),
    ],
)
def test_gradient_of_the_spectral_likelihood(noise):
    data = sequence(GaussMarkov(3e-4, 5.0), count=5000)
    power = data.bins.sums(cosines(data.values) ** 2)
    spectra, theta = _Spectra(noise, data.bins), noise.theta()
    _, gradient, information = spectra.expand(theta, power)
    for step in 1e-5 * np.eye(len(theta)):
        above, below = spectra.expand(theta + step, power)[0], spectra.expand(theta - step, power)[0]
        assert (above - below) / 2e-5 == pytest.approx(gradient @ step / 1e-5, rel=1e-4, abs=1e-3)
    assert np.all(np.linalg.eigvalsh(information) > 0)


def test_ramp_in_white_noise_is_that_of_least_squares():
    data = sequence(RateRamp(1e-6))
    found = fit(data, Description((Term(RateRamp(0.0), ("slope",)),), Noise((WHITE,))))
    slope = np.polynomial.polynomial.polyfit(data.conditions.time, data.values, 1)[1]
    assert found.description.terms[0].effect.slope == pytest.approx(slope, rel=1e-6)
    error = np.sqrt(12 * found.variance[0] / COUNT) / (COUNT * INTERVAL)
    assert np.sqrt(found.covariance[0, 0]) == pytest.approx(error, rel=1e-3)


@pytest.mark.parametrize(
    "effect",
    [Sinusoid(1.3, 2e-3, 0.4), WarmUp(2e-3, 90.0), BiasStep(300.0, 1e-3), RateRamp(1e-6)],
    ids=lambda e: e.name,
)
def test_slopes_are_difference_quotients(effect):
    data = sequence(count=2000)
    free = tuple(effect.slopes(data.conditions))
    columns = jacobian((Term(effect, free),), data)
    for name, column in zip(free, columns.T, strict=True):
        step = 1e-6 * max(abs(getattr(effect, name)), 1e-3)
        above, below = (
            type(effect)(**(effect.parameters() | {name: getattr(effect, name) + side})).sample(data.conditions, None)
            for side in (step, -step)
        )
        np.testing.assert_allclose((above - below) / (2 * step), column, rtol=1e-4, atol=1e-6 * np.abs(column).max())


def test_tails_of_a_mixture():
    rng = stream(5, "tails")
    hit = rng.random(50_000) < 0.004
    found = tails(rng.standard_normal(50_000) * np.where(hit, np.sqrt(1 + 6.0**2), 1.0))
    (low, high), (least, most) = found.intervals
    assert low < 0.004 < high
    assert least < 6.0 < most
    assert found.gain > 50


def test_tails_of_samples_that_others_tell_count_for_nothing():
    values = stream(5, "tails").standard_t(5, 4000)
    once, held = tails(values), tails(np.repeat(values, 8), 1 / 8)
    assert held.gain == pytest.approx(once.gain, rel=0.01)
    assert held.intervals[0] == pytest.approx(once.intervals[0], rel=0.05)


@pytest.mark.parametrize("walk", [0.0, 1.0, 1e4])
def test_the_highest_step_comes_by_chance_as_often_as_its_places_say(walk):
    """From white noise to a walk, of which each increment is a step of its own."""
    noise = Noise((WHITE, RandomWalk(walk * 1e-3)) if walk else (WHITE,))
    data = sequence(count=4000)
    variance = data.bins.spread(noise.variance(data.bins))
    chances = []
    for run in range(400):
        found = scans.steps(stream(run, "places").standard_normal(3999), variance, np.empty((3999, 0)))
        gain = found.gains.max()
        chances.append(found.places(gain) * chi2.sf(2 * gain, 1))
    for level in (0.02, 0.1):
        assert binom.ppf(1e-4, 400, 0.5 * level) <= np.sum(np.array(chances) < level) <= binom.isf(1e-4, 400, level)


def filtered(order, cutoff, added=0.0, before=0.0):
    """A log behind a filter that has still to let go of what was before."""
    data, smooth = sequence(), OutputFilter(cutoff, order)
    output = smooth.passed(data.values + added, INTERVAL) + before * smooth.decay(COUNT, INTERVAL)
    moved = replace(data, values=output, share=usable(output))
    return concluded(told(moved, (), tuple(CATALOGUE.values()), LOG_ALPHA, int(0.8 * COUNT)))


@pytest.mark.parametrize(("order", "cutoff"), [(1, 0.5), (2, 0.5), (4, 1.5)])
def test_a_step_behind_a_filter_is_one_and_has_its_time_and_size(order, cutoff):
    story = filtered(order, cutoff, np.where(INTERVAL * np.arange(COUNT) >= 431.2, 0.02, 0.0))
    assert names(story) == ["bias_step", "output_filter"]
    step, smooth = sorted(story.findings, key=lambda finding: finding.name)
    assert step.parameters["time"].low <= 431.2 <= step.parameters["time"].high
    assert step.parameters["time"].high - step.parameters["time"].low < 2.0
    assert step.parameters["step"].value == pytest.approx(0.02, rel=0.02)
    assert smooth.parameters["cutoff"].value == pytest.approx(cutoff, rel=0.05)


@pytest.mark.parametrize(("order", "cutoff"), [(1, 2.0), (2, 0.5), (3, 5.0)])
@pytest.mark.parametrize("before", [0.05, 1.0])
def test_a_filter_that_settles_is_a_filter_and_no_more(order, cutoff, before):
    story = filtered(order, cutoff, before=before)
    assert names(story) == ["output_filter"]
    assert not story.withheld
    assert story.findings[0].parameters["cutoff"].value == pytest.approx(cutoff, rel=0.05)


def test_the_place_of_a_change_is_known_as_far_as_the_likelihood_says():
    gain = np.array([0.0, 6.0, 5.0, 0.0, 9.0, 10.0, 5.0, 7.0, 2.0])
    time = np.arange(9.0)
    assert _near(gain, time, 5.0) == (3.0, 7.0)
    assert _near(gain + np.eye(9)[1], time, 5.0) == (0.0, 7.0)


@pytest.mark.parametrize("since", [0.1, 0.5, 0.9])
def test_a_large_step_came_between_the_samples_that_it_parts(since):
    """The first sample that shows it does not tell how long before it the step came."""
    time = INTERVAL * np.arange(COUNT)
    came = time[1000] - since * INTERVAL
    values = np.where(time >= came, 30.0, 0.0) + stream(5, "parts").standard_normal(COUNT)
    steps = scans.steps(dct(values, norm="ortho")[1:], np.ones(COUNT - 1), np.empty((COUNT - 1, 0)))
    low, high = _near(steps.gains, time, time[np.argmax(steps.gains)])
    assert low < came < high <= low + 1.5 * INTERVAL


LOUDER = VarianceChange(1000.0, 1200.0, 2.4)


@pytest.mark.parametrize(
    ("change", "label"),
    [
        *((LOUDER, f"louder {run}") for run in range(3)),
        *(
            (replace(LOUDER, stop=stop, ratio=ratio), f"louder {ratio}")
            for stop, ratio in ((1100.0, 4.5), (2000.0, 10.0))
        ),
    ],
)
def test_outliers_beside_a_louder_stretch_have_their_share_and_size_and_it_its_ratio(change, label):
    """Its noise is not taken for small outliers, nor they for noise."""
    outliers = Outliers(5e-4, 0.1)
    story = told_of(outliers, change, count=100_000, label=label)
    assert names(story) == ["outliers", "variance_change"]
    found = {name: interval for finding in story.findings for name, interval in finding.parameters.items()}
    for name, truth in {**outliers.parameters(), "ratio": change.ratio}.items():
        error = (found[name].high - found[name].low) / 3.92
        assert abs(found[name].value - truth) < 3 * error < truth


def test_two_values_are_told_from_a_continuum():
    for effect, sign in ((RandomTelegraph(2e-3, 0.05), 1), (GaussMarkov(1e-3, 10.0), -1)):
        found = fit(sequence(effect), Description((), Noise((WHITE, GaussMarkov(1e-3, 10.0)))))
        assert sign * compare(found, found.description.noise.effects[1:]).gain > 6


@pytest.mark.parametrize(("cutoff", "order"), [(1.2, 3), (2.0, 4), (6.0, 4), (3.0, 1)])
@pytest.mark.parametrize("count", [6000, 24_000])
def test_what_a_steep_filter_leaves_is_not_taken_for_noise(cutoff, order, count):
    """Towards half the rate the cosine transform shows what leaks from the ends of the log, and nothing else."""
    data, smooth = sequence(count=count), OutputFilter(cutoff, order)
    output = smooth.apply(data.values, data.conditions, stream(1))
    moved = replace(data, values=output, share=usable(output))
    plainly = fit(moved, Description((), Noise((WHITE,), smooth)))
    grainy = fit(moved, Description((), Noise((WHITE, Quantization(1e-7)), smooth)))
    assert grainy.log_likelihood - plainly.log_likelihood < 3
    assert plainly.description.noise.output_filter.cutoff == pytest.approx(cutoff, rel=0.03)


def correlated(run, colour, size, own=()):
    """Fits of two axes with noise of their own and in common, this filtered by the coefficients ``colour``."""
    fits, common = {}, lfilter([1.0], colour, stream(run, "common").standard_normal(COUNT))
    for axis in ("gyro_x", "gyro_y"):
        data = sequence(*own, axis=axis, label=f"own {run}")
        values = data.values + size * WHITE.density / np.sqrt(INTERVAL) * common / common.std()
        fits[axis] = fit(replace(data, values=values), Description((), Noise((WHITE, *own))))
    return fits


@pytest.mark.parametrize(("size", "own"), [(0.2, ()), (0.5, (GaussMarkov(2e-3, 2.0),)), (2.0, ())])
def test_white_noise_in_common_has_its_name(size, own):
    for run in range(5):
        (found,) = shared(correlated(run, [1.0], size, own), LOG_ALPHA)
        assert found.axes == ("gyro_x", "gyro_y")


@pytest.mark.parametrize("colour", [[1.0, -0.5], [1.0, -0.99], [1.0, 0.5]])
def test_noise_in_common_that_is_not_white_has_no_name(colour):
    for run in range(5):
        assert shared(correlated(run, colour, 0.5), LOG_ALPHA) == ()


def test_noise_in_common_for_a_moment_has_no_name():
    """For a hundredth of the log, as long as a shock."""
    shock = 3 * WHITE.density / np.sqrt(INTERVAL) * stream(1, "shock").standard_normal(COUNT)
    shock[np.abs(np.arange(COUNT) - 0.6 * COUNT) > COUNT / 200] = 0.0
    data = {axis: sequence(axis=axis) for axis in ("gyro_x", "gyro_y")}
    shaken = {axis: plain(replace(one, values=one.values + shock)) for axis, one in data.items()}
    assert shared(shaken, LOG_ALPHA) == ()


@pytest.mark.parametrize("loading", [0.6, 3.0])
@pytest.mark.parametrize("count", [2, 3])
def test_errors_of_shared_noise_are_those_of_many_logs(loading, count):
    axes, whole, errors = ("gyro_x", "gyro_y", "gyro_z")[:count], [], []
    for number in range(100):
        own = CommonMode(1e-3, loading)
        data = {axis: sequence(own, count=2000, axis=axis, label=f"shared {number}") for axis in axes}
        (found,) = shared({axis: plain(one) for axis, one in data.items()}, LOG_ALPHA)
        whole.append(found.densities[0])
        errors.append(found.errors[0])
    assert np.mean(whole) == pytest.approx(1e-3 * loading, abs=4 * np.std(whole) / 10)
    assert np.std(whole, ddof=1) == pytest.approx(np.mean(errors), rel=4 / np.sqrt(200))


def test_what_an_axis_of_no_loading_leaves_open_has_a_wide_interval():
    sure, open_ended = (_errors(np.array([0.5, 0.5, last]), 1000) for last in (0.5, 0.0))
    assert np.all(sure < 0.1)
    assert np.all(np.isfinite(open_ended))
    assert np.all(open_ended[:2] > 10)


def test_shared_noise_has_its_sign_and_size_also_where_one_axis_is_filtered():
    common, smooth = CommonMode(1e-3, 1.0), OutputFilter(3.0, 2)
    data = {axis: sequence(common, axis=axis) for axis in ("gyro_x", "gyro_y")}
    output = smooth.apply(data["gyro_x"].values, data["gyro_x"].conditions, stream(1))
    filtered = fit(replace(data["gyro_x"], values=output), Description((), Noise((WHITE,), smooth)))
    (found,) = shared({"gyro_x": filtered, "gyro_y": plain(data["gyro_y"])}, LOG_ALPHA)
    np.testing.assert_array_less(np.abs(found.densities - 1e-3), 4 * found.errors)


def test_noise_that_axes_share():
    sharing = ("gyro_x", "gyro_y", "accel_z")
    effects = {axis: [CommonMode(5e-4, loading)] for axis, loading in zip(sharing, (1.0, -0.8, 0.6), strict=True)}
    fits = {
        axis: plain(sequence(*effects.get(axis, []), axis=axis)) for axis in ("gyro_x", "gyro_y", "gyro_z", "accel_z")
    }
    (found,) = shared(fits, LOG_ALPHA)
    assert found.axes == sharing
    np.testing.assert_array_less(np.abs(found.densities - [5e-4, -4e-4, 3e-4]), 4 * found.errors)
    assert shared({axis: plain(sequence(axis=axis, label="alone")) for axis in sharing}, LOG_ALPHA) == ()


def test_turn_on_bias_of_several_runs():
    fits = [{"gyro_x": plain(sequence(TurnOnBias(1e-3), count=4000, label=f"run{run}"))} for run in range(8)]
    (finding,) = turn_on(fits, LOG_ALPHA)
    assert finding.parameters["std"].low < 1e-3 < finding.parameters["std"].high
    same = [{"gyro_x": plain(sequence(count=4000, label=f"run{run}"))} for run in range(8)]
    assert turn_on(same, LOG_ALPHA) == ()


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
    story = told_of(effect)
    assert names(story) == [effect.name]
    for name, interval in story.findings[0].parameters.items():
        if name in ("phase", "time", "start", "stop") or interval.low == interval.high:
            continue
        wide = 2.0 * (interval.high - interval.low)
        assert interval.low - wide < getattr(effect, name) < interval.high + wide


@pytest.mark.slow
def test_a_pair_that_masquerades_as_one():
    assert names(told_of(BiasInstability(5e-4), RateRamp(4e-6))) == ["bias_instability", "rate_ramp"]


@pytest.mark.slow
def test_nothing_hidden_is_called_nothing():
    stories = [told_of(count=6000, label=f"nothing{run}") for run in range(12)]
    assert sum(bool(story.findings) for story in stories) == 0


def test_a_line_that_drifts_is_a_place_without_a_name():
    data = sequence(count=12_000)
    time = data.conditions.time
    chirp = 2.5e-3 * np.cos(2 * np.pi * (0.5 * time + 2.0 * time**2 / (2 * time[-1])))
    moving = Sequence(data.values + chirp, data.conditions, data.flawed)
    story = concluded(told(moving, (), tuple(CATALOGUE.values()), LOG_ALPHA, 9600))
    assert names(story) == []
    places = [gap for gap in gaps({"gyro_x": story.whole}, 0.01, 0, 39) if gap.view == "spectrum"]
    assert any(gap.low < 2.5 and gap.high > 0.5 for gap in places)


def test_bursts_are_no_noise_though_their_spectrum_is():
    """What dies away has the spectrum of a Gauss-Markov process, but what drives it is skewed and peaked."""
    data, rng = sequence(count=12_000), stream(3, "bursts")
    since = data.conditions.time - rng.uniform(0, data.conditions.time[-1], (20, 1))
    heights = 4e-3 * rng.standard_exponential((20, 1))
    bursts = np.sum(heights * np.where(since >= 0, np.exp(-np.maximum(since, 0) / 6), 0), axis=0)
    process = GaussMarkov(float(bursts.std()), 6.0).sample(data.conditions, rng)
    reasons = []
    for added in (bursts, process):
        moved = Sequence(data.values + added, data.conditions, data.flawed)
        search = Search(plain(moved).description, (GaussMarkov,), LOG_ALPHA)
        found = search.explore(plain(moved))
        assert found.has(GaussMarkov)
        reasons.append([doubt.reason for doubt in doubts(search, found).values()])
    assert reasons == [["it is stronger at some times than at others"], []]


@pytest.mark.parametrize(
    ("doubtful", "reason", "warm", "withheld"),
    [
        ("noise", "bursts", 2e-2, [BiasStep]),
        ("noise", "bursts", 2e-3, [BiasStep, WarmUp]),
        ("noise", MEMORY, 2e-2, [BiasStep, WarmUp]),
        ("line", "drifts", 2e-3, []),
    ],
)
def test_what_slow_noise_without_a_name_may_have_made_has_none_either(doubtful, reason, warm, withheld):
    terms = [
        Term(BiasStep(200.0, 2e-2), ("step",)),
        Term(Sinusoid(0.8, 5e-4, 0.3), ("amplitude",)),
        Term(WarmUp(warm, 20.0), ("amplitude",)),
    ]
    described = Description(tuple(terms), Noise((WHITE, GaussMarkov(1e-3, 6.0))))
    data = sequence(BiasStep(200.0, 2e-2), WarmUp(warm, 20.0), GaussMarkov(1e-3, 6.0), count=12_000)
    search = Search(Description((), Noise((WHITE,))), tuple(CATALOGUE.values()), LOG_ALPHA)
    keys = [*(Key("term", index) for index in range(3)), Key("noise", 1)]
    doubt = {keys[3 if doubtful == "noise" else 1]: Doubt(reason, -20.0)}
    found = fit(data, described)
    of_it = _parts_of_it(search, found, keys, doubt)
    assert [type(at(found.description, key)) for key in of_it] == withheld
    assert all(one.reason == reason for one in of_it.values())


def test_a_line_or_filter_where_noise_without_a_name_is_the_power_has_none_either():
    """A peak of a spectrum that is not known is not known to be a line."""
    lines = tuple(Term(Sinusoid(f, 5e-4, 0.3), ("amplitude",)) for f in (0.1, 9.0))
    keys, doubt = [Key("term", 0), Key("term", 1), Key("noise", 1), Key("filter", 0)], Doubt("bursts", -20.0)
    for cutoff, nameless in ((0.1, [Key("term", 0), Key("filter", 0)]), (9.0, [Key("term", 0)])):
        noise = Noise((WHITE, GaussMarkov(1e-2, 1.0)), OutputFilter(cutoff, 1))
        found = fit(sequence(GaussMarkov(1e-2, 1.0), count=12_000), Description(lines, noise))
        described = replace(found, description=Description(lines, noise))
        assert list(_of_the_spectrum(described, keys, {Key("noise", 1): doubt})) == nameless


@pytest.mark.parametrize(
    ("hidden", "known"),
    [(GaussMarkov(4.4e-3, 18.0), RandomWalk(1.6e-5)), (BiasInstability(2e-3), RandomWalk(1e-5))],
)
def test_slow_noise_of_the_start_model_does_not_stand_for_what_is_missing(hidden, known):
    """It is free, and takes the place of what is hidden; beside it there is no room for the right name."""
    data = sequence(hidden, known)
    story = concluded(told(data, (WHITE, known), (GaussMarkov, BiasInstability), LOG_ALPHA, 19_200))
    assert names(story) == [hidden.name]


@pytest.mark.parametrize("known", [RandomWalk(3e-5), BiasInstability(1e-4), GaussMarkov(3e-4, 20.0)])
@pytest.mark.parametrize("cutoff", [0.6, 3.2])
def test_a_filter_is_found_behind_noise_that_went_far_to_look_like_it(known, cutoff):
    """Without the filter the slow noise of the start model is the whole spectrum, and white noise is none of it."""
    data, hidden = sequence(known), OutputFilter(cutoff, 2)
    output = hidden.apply(data.values, data.conditions, stream(1))
    filtered = replace(data, values=output, share=usable(output))
    story = concluded(told(filtered, (WHITE, known), tuple(CATALOGUE.values()), LOG_ALPHA, 19_200))
    assert names(story) == ["output_filter"]
    (found,) = story.findings
    assert found.parameters["cutoff"].low < cutoff < found.parameters["cutoff"].high


@pytest.mark.parametrize("slow", [(), (RandomWalk(3e-5),)])
@pytest.mark.parametrize("cutoff", [0.5, 3.0, 12.0, None])
def test_what_a_filter_gains_is_known_before_it_is_fitted(cutoff, slow):
    data = sequence(*slow, count=6000)
    if cutoff is not None:
        output = OutputFilter(cutoff, 2).apply(data.values, data.conditions, stream(1))
        data = replace(data, values=output, share=usable(output))
    description = Description((), Noise((WHITE, *slow)))
    before = fit(data, description)
    search = Search(description, tuple(CATALOGUE.values()), LOG_ALPHA)
    for start in OutputFilter.starts(before):
        expected, beside = _behind(start, before)
        found = search.judged(expected, before, beside)
        assert found.gain == pytest.approx(expected.gain - RESHAPED, abs=RESHAPED / 3)
        assert _hopeful(expected, LOG_ALPHA) or found.log_p > LOG_ALPHA


@pytest.mark.parametrize("base", [RandomWalk(1.5e-4), BiasInstability(4e-4), GaussMarkov(1e-3, 20.0)])
def test_in_the_place_of_slow_noise_that_is_right_other_is_no_surer_than_chance_makes_it(base):
    surest = []
    for number in range(60):
        data = sequence(base, count=4000, label=f"instead {number}")
        before = fit(data, Description((), Noise((WHITE, base))))
        search = Search(before.description, (BiasInstability, GaussMarkov, RandomWalk), LOG_ALPHA)
        surest.append(min((trial.log_p for trial in search.trials(before, 0.0)), default=0.0))
    assert np.mean(np.array(surest) < np.log(0.03)) <= 0.03 + 3 * np.sqrt(0.03 / 60)


def test_the_power_of_a_line_that_sweeps_is_no_noise():
    data = sequence()
    time = data.conditions.time
    turns = 0.5 * time + 0.5 * (2.1 - 0.5) * time**2 / time[-1]
    moved = replace(data, values=data.values + 1.0e-3 * np.sin(2 * np.pi * turns))
    story = concluded(told(moved, (), (GaussMarkov, Sinusoid), LOG_ALPHA, 19_200))
    assert names(story) == []
    assert [one.reason for one in story.withheld] == ["a line that sweeps or wanders explains it"]
    (band,) = story.bands
    assert (band.low, band.high) == pytest.approx((0.5, 2.1), rel=0.05)


def test_beside_a_line_that_sweeps_noise_of_other_frequencies_keeps_its_name():
    data = sequence(GaussMarkov(2e-3, 10.0))
    time = data.conditions.time
    turns = 2.0 * time + 0.5 * (4.0 - 2.0) * time**2 / time[-1]
    moved = replace(data, values=data.values + 1.0e-3 * np.sin(2 * np.pi * turns))
    story = concluded(told(moved, (), (GaussMarkov, Sinusoid), LOG_ALPHA, 19_200))
    assert names(story) == ["gauss_markov"]
    assert len(story.bands) == 1


def test_flicker_keeps_its_name_in_either_form_that_samples_of_it_may_have():
    """Fractionally differenced noise lies above 1/f towards half the rate; its slope is that of flicker."""
    data, rng = sequence(count=120_000), stream(1, "fractional")
    moved = replace(data, values=data.values + 6e-3 * fractional(120_000, 1.0, rng))
    search = Search(plain(moved).description, (BiasInstability,), LOG_ALPHA)
    found = search.explore(plain(moved))
    assert found.has(BiasInstability)
    assert doubts(search, found) == {}


def test_a_loop_over_the_temperature_is_no_walk():
    """The bias goes by the way that the temperature came, with play; the walk of the same size keeps its name."""
    time = np.arange(16_000) * 0.04
    warming = 25 + 4 * np.sin(2 * np.pi * time / 260) + 1.5 * np.sin(2 * np.pi * time / 97 + 1)
    conditions = Conditions(time, 0.04, warming, "gyro_x")
    dragged = [warming[0]]
    for value in warming[1:]:
        dragged.append(min(max(dragged[-1], value - 0.8), value + 0.8))
    white = WHITE.sample(conditions, stream(4, "white"))
    walk = RandomWalk(1e-4).sample(conditions, stream(4, "walk"))
    found = []
    for added in (2e-3 * (warming - np.array(dragged)), walk):
        data = Sequence(white + added, conditions, np.zeros(len(time), bool))
        found.append(concluded(told(data, (), tuple(CATALOGUE.values()), LOG_ALPHA, 12_800)))
    loop, wandering = found
    assert names(loop) == []
    assert loop.seen
    assert names(wandering) == ["random_walk"]


@pytest.mark.slow
@pytest.mark.parametrize(("constant", "period", "size"), [(200, 700, 9e-3), (100, 500, 6e-3), (120, 900, 9e-3)])
def test_a_loop_over_a_temperature_that_warms_up_is_neither_temperature_nor_warm_up(constant, period, size):
    """Both together, by coefficients and a time constant of their own, keep their names."""
    time = np.arange(24_000) * 0.04
    warming = 25 + 5.5 * (1 - np.exp(-time / constant)) + np.sin(2 * np.pi * time / period)
    conditions = Conditions(time, 0.04, warming, "gyro_x")
    loop = Hysteresis(size, -size, 0.1).sample(conditions, None)
    both = Temperature(1e-3, 25.0).sample(conditions, None) + WarmUp(5e-3, 60.0).sample(conditions, None)
    white, found = WHITE.sample(conditions, stream(4, "white2")), []
    for added in (loop, both):
        data = Sequence(white + added, conditions, np.zeros(len(time), bool))
        found.append(concluded(told(data, (), tuple(CATALOGUE.values()), LOG_ALPHA, 19_200)))
    assert names(found[0]) == []
    assert found[0].seen
    assert names(found[1]) == ["temperature", "warm_up"]


@pytest.mark.slow
def test_noise_between_flicker_and_walk_is_seldom_a_markov_process():
    """A process of the same number of parameters has to be likelier than a power law to have its name."""
    white, named = sequence(count=60_000), []
    for run in range(16):
        values = white.values + 1.2e-4 * fractional(60_000, 1.5, stream(run, "gml", "f"))
        moved = replace(white, values=values)
        search = Search(plain(moved).description, (GaussMarkov,), LOG_ALPHA)
        found = search.explore(plain(moved))
        assert found.has(GaussMarkov)
        named.append(not doubts(search, found))
    assert sum(named) <= 4


@pytest.mark.parametrize("run", range(3))
def test_a_markov_process_is_no_power_law(run):
    data = sequence(GaussMarkov(1e-3, 5.0), count=60_000, label=f"markov {run}")
    search = Search(plain(data).description, (GaussMarkov,), LOG_ALPHA)
    found = search.explore(plain(data))
    assert found.has(GaussMarkov)
    assert doubts(search, found) == {}


@pytest.mark.parametrize(
    "change", [VarianceChange(200.0, 290.0, 1.3), VarianceChange(0.0, 960.0, depth=0.15, frequency=0.01, phase=1.0)]
)
def test_a_change_of_variance_is_weighed_again_as_it_was_taken(change):
    search = Search(Description((), Noise((WHITE,))), (VarianceChange,), LOG_ALPHA)
    before = search.fitted(sequence(change), search.start)
    taken = min(search.trials(before, LOG_ALPHA), key=lambda trial: trial.log_p)
    again, _ = search.weighed(taken.fit, Key("change", 0))
    assert (again.parameters, again.trials) == (taken.parameters, taken.trials)
    assert again.log_p == pytest.approx(taken.log_p)
    assert search.settled(taken.fit).description.changes


@pytest.mark.parametrize("apart", [2, 5, 30])
def test_one_outlier_far_beyond_the_others_is_no_change_of_the_variance(apart):
    data, rng = sequence(BiasInstability(3e-4)), stream(apart, "outliers")
    places, white = rng.choice(COUNT, 20, replace=False), WHITE.density / np.sqrt(INTERVAL)
    data.values[places] += np.r_[40.0, np.full(19, 10.0)] * white * rng.choice([-1.0, 1.0], 20)
    story = concluded(told(data, (), tuple(CATALOGUE.values()), LOG_ALPHA, int(0.8 * COUNT)))
    assert names(story) == ["bias_instability", "outliers"]


@pytest.mark.parametrize("change", [VarianceChange(360.0, 372.0, 4.0), VarianceChange(200.0, 290.0, 1.5)])
def test_a_change_of_variance_keeps_its_name_beside_outliers(change):
    """Outliers take it from no draw of the noise that shows it without them."""
    outliers = Outliers(1e-3, 0.1)
    assert names(told_of(outliers, change, label="beside")) == ["outliers", "variance_change"]
    assert names(told_of(outliers, change)) == ["outliers", *names(told_of(change))]


def switching(high, low, label):
    """Return samples with two values, and the mean times that they last [s]."""
    rng, place, up = stream(1, label), 0.0, False
    path = np.zeros(COUNT)
    while place < COUNT:
        end = place + rng.exponential(high if up else low) / INTERVAL
        path[int(place) : int(end)] = 4e-3 * up
        place, up = end, not up
    data = sequence()
    return data.changed(data.values + path)


@pytest.mark.parametrize(
    ("high", "low", "expected"),
    [(6.0, 6.0, ["random_telegraph"]), (4.0, 9.0, ["random_telegraph"]), (0.5, 20.0, [])],
)
def test_two_values_are_one_telegraph_noise_if_they_are_about_as_frequent(high, low, expected):
    data = switching(high, low, "switching")
    story = concluded(told(data, (), tuple(CATALOGUE.values()), LOG_ALPHA, int(0.8 * COUNT)))
    assert [finding.name for finding in story.findings if finding.name == "random_telegraph"] == expected


@pytest.mark.parametrize("unit", [1e-4, 1e4])
def test_nothing_depends_on_the_unit(unit):
    data = sequence(GaussMarkov(3e-3, 5.0), RandomWalk(1e-4))
    here, there = (
        concluded(told(one, (), tuple(CATALOGUE.values()), LOG_ALPHA, int(0.8 * COUNT)))
        for one in (data, data.changed(unit * data.values))
    )
    assert names(here) == names(there)
    for one, other in zip(here.findings, there.findings, strict=True):
        assert one.log_p == pytest.approx(other.log_p, rel=1e-3)
        sizes = [1.0 if name == "correlation_time" else unit for name in one.parameters]
        for size, a, b in zip(sizes, one.parameters.values(), other.parameters.values(), strict=True):
            assert [size * end for end in (a.value, a.low, a.high)] == pytest.approx([b.value, b.low, b.high], rel=2e-2)


def test_the_limits_of_a_correlation_time_are_those_of_the_log():
    data = sequence(RandomWalk(1e-6))
    noise = Noise((WhiteNoise(1e-8), GaussMarkov(1e-8, 100.0)))
    low, high = limits(noise, data.bins, data.bins.sums(cosines(1e-5 * data.values) ** 2))
    assert np.exp([low[-1], high[-1]]) == pytest.approx([INTERVAL / 3, 30 * COUNT * INTERVAL])


@pytest.mark.parametrize("growth", [-4.0, 0.0, 4.0])
def test_a_variance_that_grows_is_no_swing_without_bounds(growth):
    """Less than half a cycle of a swing of any depth is what a trend of the variance looks like."""
    time = np.arange(COUNT) * INTERVAL
    whitened = np.exp(growth * time / time[-1] / 2) * stream(6, "grows").standard_normal(COUNT)
    frequency, depth, phase, gain = scans.swing(whitened, time)
    assert frequency >= 0.999 * scans.SLOWEST / time[-1]
    assert 0 <= depth <= np.sqrt(2) * scans.DEEPEST
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


def beside_white(added, count=20_000, interval=0.05, label="beside"):
    """White noise and what ``added`` makes of the times [s] and a random generator."""
    conditions = Conditions(np.arange(count) * interval, interval, axis="gyro_x")
    rng = stream(5, label)
    values = WHITE.sample(conditions, rng) + added(conditions.time, rng)
    return Sequence(values, conditions, np.zeros(count, bool))


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
def test_what_is_nearly_an_effect_has_a_place_and_no_name(added, view, low, high):
    story = concluded(told(beside_white(added), (), tuple(CATALOGUE.values()), LOG_ALPHA, 16_000))
    assert names(story) == []
    places = [one.place for one in story.withheld if one.place.view == view]
    assert all(place.axis == "gyro_x" and place.p_value < 0.01 for place in places)
    assert any(place.low <= low and high <= place.high for place in places)


@pytest.mark.parametrize("count", [19_997, 20_011])
@pytest.mark.parametrize("periods", [5.3, 41.7, 93.1])
def test_a_wave_gains_what_it_does_at_its_own_frequency(count, periods):
    """Also where no fast transform has the length of the log, or a multiple of it."""
    frequency = periods / (0.05 * count)
    data = beside_white(lambda time, rng: 2e-3 * (time * frequency % 1), count)
    found = fit(data, Description((), Noise((WHITE,))))
    own = waves._gain_at(frequency, found)
    assert own > 50
    assert 0.95 * own < waves.gain(found) < 1.02 * own + 5


def test_what_has_no_name_is_told_on_axes_on_which_no_view_shows_it():
    gap = Gap("spectrum", "gyro_x", 1.0, 2.0, "Hz", 1e-9)
    places = {axis: replace(gap, axis=axis) for axis in ("gyro_x", "gyro_y", "accel_x")}
    weak = replace(gap, axis="accel_y", p_value=0.2)
    stories = {
        axis: SimpleNamespace(withheld=[SimpleNamespace(place=place)])
        for axis, place in (places | {"accel_y": weak}).items()
    }
    shown = [replace(gap, view="coherence", axis="gyro_x,gyro_z")]
    assert _nameless(stories, shown, 0.01) == (places["gyro_y"], places["accel_x"])


def test_beside_a_wave_of_another_shape_a_step_keeps_its_name():
    wave = Sinusoid(0.4, 2e-3, 0.3), Sinusoid(0.8, 1e-3, 1.0)
    assert names(told_of(*wave, BiasStep(250.0, 1e-3), count=12_000)) == ["bias_step"]


@pytest.mark.parametrize(("shape", "reasons"), [("teeth", ["a wave of one period explains it better"]), ("step", [])])
def test_a_jump_of_a_wave_is_no_step(shape, reasons):
    """The walk of the start model hides the wave but for a jump of it; a step alone keeps its name."""
    known = RandomWalk(5e-5)
    data = sequence(known, label="jump")
    time = data.conditions.time
    added = {"teeth": 2e-3 * (time / 96.3 % 1), "step": -2e-3 * (time > 4 * 96.3)}[shape]
    moved = replace(data, values=data.values + added)
    before = fit(moved, Description((), Noise((WHITE, known))))
    step = Term(BiasStep(4 * 96.3, -2e-3), ("step",))
    found = fit(moved, replace(before.description, terms=(step,)))
    doubtful = doubts(Search(before.description, (BiasStep,), LOG_ALPHA), found)
    assert [doubt.reason for doubt in doubtful.values()] == reasons


def test_a_steady_line_is_not_in_doubt():
    data = sequence(Sinusoid(0.8, 5e-4, 0.3), count=12_000)
    search = Search(plain(data).description, tuple(CATALOGUE.values()), LOG_ALPHA)
    found = search.explore(plain(data))
    assert [effect.name for effect in found.description.effects()] == ["sinusoid", "white_noise"]
    assert doubts(search, found) == {}


def two_means(slope, coefficient, label):
    """Search a log with a ramp and a temperature effect that nearly cancel."""
    time = np.arange(12000) * 0.05
    warming = 20 + 8 * (1 - np.exp(-time / 200)) + np.sin(2 * np.pi * time / 450)
    conditions = Conditions(time, 0.05, warming, "gyro_x")
    values = RateRamp(slope).sample(conditions, None) + Temperature(coefficient).sample(conditions, None)
    values += WhiteNoise(1e-4).sample(conditions, stream(1, label))
    log = Sequence(values, conditions, np.zeros(len(time), bool))
    before = fit(log, Description((), Noise((WhiteNoise(1e-4),))))
    return Search(before.description, tuple(CATALOGUE.values()), LOG_ALPHA).explore(before)


@pytest.mark.parametrize("number", [13, 63, 74])
def test_nothing_stays_that_chance_explains_beside_the_rest(number):
    """A walk that a ramp follows: with a second mean beside it the ramp looks likelier, but that mean is chance."""
    count, interval = 3000, 0.2
    time = interval * np.arange(count)
    warming = 24 + 4 * (1 - np.exp(-time / 120)) + 0.5 * np.sin(2 * np.pi * time / 200)
    conditions = Conditions(time, interval, warming, "gyro_x")
    values = AxisModel((WHITE, RandomWalk(4e-5))).simulate(np.zeros(count), conditions, number, "couple")
    data = Sequence(values, conditions, np.zeros(count, bool))
    search = Search(plain(data).description, (RateRamp, Temperature, WarmUp, BiasStep, Sinusoid), LOG_ALPHA)
    found = search.explore(plain(data))
    assert search.added(found.description)
    assert all(search.weighed(found, key)[0].log_p < LOG_ALPHA for key in search.added(found.description))


def test_two_means_that_nearly_cancel_are_found_together():
    found = two_means(-6e-7, 6e-5, "cancel").description.terms
    assert sorted(term.effect.name for term in found) == ["rate_ramp", "temperature"]


@pytest.mark.parametrize("run", range(4))
def test_a_step_and_a_ramp_that_nearly_cancel_are_found_together(run):
    """A walk gains more than either of them alone, and hides both."""
    found = told_of(BiasStep(480.0, -1.2e-3), RateRamp(1.8e-6), label=f"saw {run}")
    assert names(found) == ["bias_step", "rate_ramp"]


def test_a_temperature_beside_a_walk_is_seldom_a_memory_of_it():
    count, interval, few = 3000, 0.2, []
    time = interval * np.arange(count)
    warming = 24 + 4 * (1 - np.exp(-time / 120)) + 0.5 * np.sin(2 * np.pi * time / 200)
    conditions, straight = Conditions(time, interval, warming, "gyro_x"), Temperature(1e-3, 25.0)
    described = Description((Term(straight, ("coefficient",)),), Noise((WHITE, RandomWalk(4e-5))))
    for run in range(60):
        values = AxisModel((WHITE, RandomWalk(4e-5), straight)).simulate(np.zeros(count), conditions, run, "nested")
        found = fit(Sequence(values, conditions, np.zeros(count, bool)), described)
        few.append(in_place_of_means(Search(Description((), Noise((WHITE,))), (), LOG_ALPHA), found).log_p)
    assert np.sum(np.array(few) < LEVEL) <= 3
    assert 5 <= np.sum(np.array(few) < np.log(0.5)) <= 40


def test_slow_noise_beside_a_walk_of_the_start_model_is_found():
    conditions = Conditions(np.arange(20000) * 0.04, 0.04, axis="gyro_x")
    effects = (WhiteNoise(2e-4), RandomWalk(6e-6), GaussMarkov(5e-4, 7.0))
    values = sum(effect.sample(conditions, stream(2, "beside", effect.name)) for effect in effects)
    log = Sequence(values, conditions, np.zeros(len(values), bool))
    before = fit(log, Description((), Noise(effects[:2])))
    after = Search(before.description, tuple(CATALOGUE.values()), LOG_ALPHA).explore(before)
    assert [effect.name for effect in after.description.noise.effects[2:]] == ["gauss_markov"]


@pytest.mark.parametrize("count", [20, 24_000])
def test_noise_beneath_a_spectrum_does_not_rise_above_it(count):
    """Also where a log is too short to have a frequency below the cutoff: it touches the first that there are."""
    data = sequence(count=count)
    power = data.bins.sums(cosines(data.values) ** 2)
    noise = Noise((WHITE,), OutputFilter(0.2, 1)).beneath(data.bins, power)
    asked = slice(max(8, np.sum(data.bins.frequency < 0.2)))
    over = power[asked] / data.bins.number[asked] / noise.variance(data.bins)[asked]
    assert np.mean(over >= 1 - 1e-9) >= 0.5
    assert over.min() <= 1 + 1e-9


@pytest.mark.parametrize("number", [MANY[VarianceChange], MANY[VarianceChange] + 1])
def test_beside_more_changes_of_the_variance_than_have_a_name_nothing_else_is_looked_for(number):
    changes = tuple(VarianceChange(start, start + 50.0, 3.0) for start in 100.0 + 200.0 * np.arange(number))
    data = sequence(*changes, BiasStep(480.0, 2e-3), label="restless")
    search = Search(Description((), Noise((WHITE,))), tuple(CATALOGUE.values()), LOG_ALPHA)
    found = search.explore(fit(data, replace(search.start, changes=changes)))
    assert found.has(BiasStep) == (number == MANY[VarianceChange])


@pytest.mark.parametrize(
    ("beside", "step"),
    [
        (GaussMarkov(6e-3, 2.0), 0.0),
        (RandomTelegraph(1.2e-2, 0.3), 0.0),
        (BiasInstability(4e-3), 0.0),
        (GaussMarkov(3e-3, 2.0), 1.2e-2),
    ],
    ids=["gauss_markov", "random_telegraph", "bias_instability", "on a coarse lattice"],
)
def test_outliers_in_noise_that_is_not_white_have_their_size(beside, step):
    """In the residual made white they are one over the mean of 1/sqrt(S), not over the root of the mean of S."""
    data, rng = sequence(beside, count=100_000, label="coloured"), stream(1, "coloured")
    outliers = 0.06 * rng.standard_normal(400)
    data.values[rng.choice(100_000, 400, replace=False)] += outliers
    values = step * np.rint(data.values / step) if step else data.values
    data = Sequence(values, data.conditions, np.zeros(100_000, bool), step=step)
    before = fit(data, Description((), Noise((WHITE, beside))))
    assert (before.cells is not None) == (step > 0)
    cleaned = Search(before.description, (), LOG_ALPHA).cleaned(before)
    assert cleaned.effect.std == pytest.approx(np.sqrt(np.mean(outliers**2)), rel=0.06)

from itertools import permutations
from pathlib import Path

import allantools
import numpy as np
import pandas as pd
import pytest
from allantools.ci import edf_greenhall
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import binom
from tests.chance import as_often_as

from imugap.effects import BiasInstability, Conditions, GaussMarkov, Quantization, RandomWalk, RateRamp, WhiteNoise
from imugap.effects.effect import AxisModel
from imugap.estimation.variances import allan
from imugap.estimation.variances.allan import LAWS, curve, factors, local_slope, tangent, variance
from imugap.stream import stream

NBS14 = pd.read_csv(Path(__file__).parents[2] / "reference" / "nbs14.csv", comment="#")
NINE = np.array([892.0, 809, 823, 798, 671, 644, 883, 903, 677])
PURE = {
    "Q": Quantization(1.0),
    "N": WhiteNoise(1.0),
    "B": BiasInstability(1.0),
    "K": RandomWalk(1.0),
    "R": RateRamp(1.0),
}
SHOWN = {symbol: AxisModel((effect,)) for symbol, effect in PURE.items()} | {"R": RateRamp(1.0) + RandomWalk(1.0)}
"""Logs that show one law: a ramp needs a noise, or there is nothing to be uncertain of."""
RUNS = 400


def thousand():
    """The 1000-point test set: a linear congruential generator (NIST SP 1065, section 12)."""
    chain = [1234567890]
    for _ in range(999):
        chain.append(16807 * chain[-1] % 2147483647)
    assert chain[1] == 395529916
    return np.array(chain) / 2147483647


def sampled(count, *effects, label=0, interval=1.0):
    """One sequence of a sum of effects."""
    at = Conditions(interval * np.arange(count), interval)
    return sum(effect.sample(at, stream(41, label, effect)) for effect in effects)


def ideal_curve(sigma, tau, count=10**8):
    """A curve without noise, as one of a log of ``count`` samples would be."""
    tau = np.asarray(tau, float)
    error = np.sqrt(0.5 / (count / tau - 1))
    columns = {"deviation": sigma, "low": sigma * (1 - 2 * error), "high": sigma * (1 + 2 * error), "error": error}
    columns |= {"slope": local_slope(tau, sigma), "edf": 0.5 / error**2}
    return pd.DataFrame(columns, index=pd.Index(tau, name="tau"))


TAU = np.logspace(0, 5, 51)


@pytest.fixture(scope="module")
def curves():
    """Curves of many runs of each law."""
    return {symbol: [curve(sampled(4096, *of, label=run), 1.0) for run in range(RUNS)] for symbol, of in SHOWN.items()}


@pytest.fixture(scope="module")
def readings(curves):
    """Readings of each law on its own curves."""
    return {symbol: [tangent(asd, LAWS[symbol]) for asd in found] for symbol, found in curves.items()}


@pytest.mark.parametrize("row", list(NBS14.itertuples()), ids=lambda row: f"{row.suite}-{row.averaging}")
def test_variance_is_that_of_the_nbs14_suite(row):
    data = NINE if row.suite == 9 else thousand()
    found = np.sqrt(variance(data, np.array([row.averaging])))[0]
    assert found == pytest.approx(row.deviation, abs=row.half_digit * 1.01)


@pytest.mark.parametrize("kind", ["white", "walk", "nbs14"])
def test_variance_is_that_of_allantools(kind):
    white = stream(42, kind).standard_normal(5000)
    data = {"white": white, "walk": np.cumsum(white), "nbs14": thousand()}[kind]
    averaging = factors(len(data))
    _, deviation, _, _ = allantools.oadev(data, rate=1.0, data_type="freq", taus=averaging)
    np.testing.assert_allclose(np.sqrt(variance(data, averaging)), deviation, rtol=1e-10)


@given(st.integers(10, 300), st.floats(-1e3, 1e3), st.floats(1e-6, 1e6))
@settings(deadline=None)  # the first call compiles
def test_variance_is_blind_to_the_bias_and_quadratic_in_the_scale(count, offset, scale):
    data = stream(43, count).standard_normal(count)
    averaging = factors(count)
    changed = variance(scale * (offset + data), averaging)
    np.testing.assert_allclose(changed, scale**2 * variance(data, averaging), rtol=1e-7)


def test_variance_of_a_ramp_is_half_the_square_of_its_rise():
    averaging = np.array([1, 10, 100])
    np.testing.assert_allclose(variance(0.2 * np.arange(1000.0), averaging), (0.2 * averaging) ** 2 / 2, rtol=1e-9)


def test_variance_survives_a_bias_far_above_the_noise():
    data = stream(44).standard_normal(100_000)
    averaging = np.array([1, 100, 10_000])
    np.testing.assert_allclose(variance(1e6 + data, averaging), variance(data, averaging), rtol=1e-5)


@given(st.integers(4, 10**7))
def test_factors_run_from_one_to_a_quarter_of_the_samples(count):
    found = factors(count)
    assert found[0] == 1
    assert found[-1] == count // 4
    assert np.all(np.diff(found) > 0)
    assert len(found) <= 10 * np.log10(count) + 1


@pytest.mark.parametrize("slope", [-1.0, -0.5, 0.0, 0.5, 1.0])
def test_local_slope_of_a_power_law_is_its_exponent(slope):
    np.testing.assert_allclose(local_slope(TAU, 3e-5 * TAU**slope), slope, atol=1e-9)


def test_tau_scales_with_the_interval_and_nothing_else_does():
    data = stream(45).standard_normal(2000)
    slow, fast = curve(data, 1.0), curve(data, 0.01)
    np.testing.assert_allclose(fast.index, slow.index * 0.01, rtol=1e-14)
    np.testing.assert_allclose(fast["deviation"], slow["deviation"], rtol=0)
    np.testing.assert_allclose(fast["high"], slow["high"], rtol=1e-12)


def test_a_wider_level_contains_the_narrower_interval():
    data = stream(46).standard_normal(2000)
    wide, narrow = curve(data, 1.0, level=0.99), curve(data, 1.0, level=0.6)
    assert (wide["low"] < narrow["low"]).all()
    assert (narrow["low"] < narrow["deviation"]).all()
    assert (narrow["deviation"] < narrow["high"]).all()
    assert (narrow["high"] < wide["high"]).all()


def test_a_constant_sequence_is_refused():
    with pytest.raises(ValueError, match="expected samples that vary"):
        curve(np.ones(1000), 1.0)


@pytest.mark.slow
@pytest.mark.parametrize(("symbol", "shortest"), [("Q", 1), ("N", 1), ("B", 10), ("K", 10), ("R", 10)])
def test_intervals_cover_the_truth_as_often_as_they_say(curves, symbol, shortest):
    tau = curves[symbol][0].index.to_numpy()
    truth = np.sqrt(SHOWN[symbol].sampled_allan_variance(tau.astype(int), 1.0))
    held = np.array([(asd["low"] <= truth) & (truth <= asd["high"]) for asd in curves[symbol]])
    for column in np.flatnonzero((tau >= shortest) & (tau <= 130)):
        assert as_often_as(held[:, column], 0.95), tau[column]


@pytest.mark.slow
@pytest.mark.parametrize(
    "model",
    [
        Quantization(1.0) + WhiteNoise(0.0),
        Quantization(3.0) + WhiteNoise(1.0),
        WhiteNoise(1.0) + RateRamp(0.02),
        RandomWalk(1.0) + RateRamp(1.0),
        WhiteNoise(1.0) + RandomWalk(0.02) + RateRamp(0.02),
    ],
    ids=["Q", "Q + N", "N + R", "K + R", "N + K + R"],
)
def test_degrees_of_freedom_of_the_steep_laws_are_those_of_the_scatter(model):
    """At every averaging time, 2 sigma^4/edf is the variance of the estimate, within what 500 runs can tell of it.

    The median over the runs: where a run shows a walk that is not there, its degrees of freedom are too few.
    """
    count, runs = 8192, 500
    found = [curve(sampled(count, *model, label=run), 1.0) for run in range(runs)]
    averaging = found[0].index.to_numpy().astype(int)
    expected = model.sampled_allan_variance(averaging, 1.0)
    scatter = np.mean([(asd["deviation"] ** 2 / expected - 1) ** 2 for asd in found], axis=0)
    ratio = scatter / np.median([2 / asd["edf"] for asd in found], axis=0)
    assert np.all(np.abs(ratio[averaging <= count / 16] - 1) < 4 * np.sqrt(3 / runs))


def test_a_ramp_alone_is_known_exactly():
    asd = curve(0.3 * np.arange(5000.0), 1.0)
    assert np.all(asd["high"] / asd["low"] < 1 + 1e-4)
    assert tangent(asd, LAWS["R"]).value == pytest.approx(0.3, rel=1e-6)


@pytest.mark.slow
def test_intervals_cover_the_truth_at_the_longest_averaging_times(curves):
    tau = curves["N"][0].index.to_numpy()
    held = np.array([(asd["low"] <= tau**-0.5) & (tau**-0.5 <= asd["high"]) for asd in curves["N"]])
    for column in np.flatnonzero(tau > 400):
        assert as_often_as(held[:, column], 0.95), tau[column]


@pytest.mark.slow
@pytest.mark.parametrize("symbol", LAWS)
def test_tangent_recovers_the_coefficient_of_a_law(readings, symbol):
    """What the other laws add cannot be negative, which takes up to 0.7 of its scatter off a reading.

    Flicker and walk are point samples: above their law by 1/(2 n^2) and its like at the shortest tau of a region.
    """
    values = np.array([reading.value for reading in readings[symbol] if reading.holds])
    scatter = values.std(ddof=1)
    assert len(values) > 0.95 * RUNS
    assert scatter < 0.06
    assert abs(values.mean() - 1) < (0.7 + 4 / np.sqrt(RUNS)) * scatter


@pytest.mark.slow
@pytest.mark.parametrize("symbol", LAWS)
def test_intervals_of_tangents_cover_the_truth_at_least_as_often_as_they_say(readings, symbol):
    held = [reading.low <= 1 <= reading.high for reading in readings[symbol] if reading.holds]
    assert np.sum(held) >= binom.ppf(5e-5, len(held), 0.95)


@pytest.mark.slow
@pytest.mark.parametrize("symbol", LAWS)
def test_intervals_of_tangents_are_about_as_wide_as_the_readings_scatter(readings, symbol):
    read = [reading for reading in readings[symbol] if reading.holds]
    scatter = np.std([reading.value for reading in read])
    said = np.mean([reading.high - reading.low for reading in read]) / (2 * 1.96)
    assert 0.8 < said / scatter < 1.8


@pytest.mark.slow
@pytest.mark.parametrize(("shown", "absent"), list(permutations(LAWS, 2)))
def test_an_absent_law_is_refused(curves, shown, absent):
    refused = [not tangent(asd, LAWS[absent]).holds for asd in curves[shown]]
    assert np.mean(refused) > 0.99


@pytest.mark.slow
@pytest.mark.parametrize("time", [10.0, 50.0, 200.0])
def test_no_law_is_read_on_a_gauss_markov_process_that_the_log_sees_the_end_of(time):
    """Its flank looks like a walk, its top like flicker; beyond the top the slope falls, which it does for neither.

    At 50 s the log ends about the top: flicker is read in some runs, and in a longer log it would not be.
    """
    model = WhiteNoise(1.0) + GaussMarkov(1.0, time)
    curves = [curve(sampled(108_000, *model, label=run, interval=0.1), 0.1) for run in range(60)]
    read = {symbol: np.mean([tangent(asd, law).holds for asd in curves]) for symbol, law in LAWS.items()}
    assert read["N"] == 1
    assert read["Q"] == read["K"] == read["R"] == 0
    assert read["B"] <= (0.2 if time == 50 else 0)


def test_no_law_that_lasts_is_read_where_the_slope_falls_again():
    top = np.sqrt(GaussMarkov(1.0, 300.0).allan_variance(TAU))
    found = {symbol: tangent(ideal_curve(top, TAU), law) for symbol, law in LAWS.items()}
    assert [symbol for symbol, reading in found.items() if reading.holds] == ["N"]  # of the falling flank


@pytest.mark.slow
@pytest.mark.parametrize(
    ("symbol", "small", "large"),
    [
        ("K", RandomWalk(3e-3), WhiteNoise(1.0)),
        ("B", BiasInstability(0.1), WhiteNoise(1.0)),
        ("N", WhiteNoise(1.0), RandomWalk(1.0)),
        ("N", WhiteNoise(2.0), RandomWalk(1.0)),
    ],
)
def test_the_bound_of_a_hidden_law_lies_above_the_truth_and_not_absurdly_far(symbol, small, large):
    truth = next(iter(small.parameters().values()))
    for run in range(60):
        found = tangent(curve(sampled(16384, small, large, label=run), 1.0), LAWS[symbol])
        assert not found.holds
        assert found.low == 0
        assert truth <= found.high < 5 * truth
        assert found.value <= found.high


@pytest.mark.parametrize("exponent", np.arange(-1.0, 1.01, 0.125))
@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
def test_only_its_own_slope_is_read_from_the_lattice_of_slopes(exponent, law):
    found = tangent(ideal_curve(0.3 * TAU**exponent, TAU), law)
    assert found.holds == (exponent == law.slope)


@given(st.sampled_from(sorted(LAWS)), st.floats(1e-9, 1e3))
def test_a_pure_law_gives_its_coefficient_back(symbol, coefficient):
    found = tangent(ideal_curve(LAWS[symbol].deviation(coefficient, TAU), TAU), LAWS[symbol])
    assert found.holds
    assert found.value == pytest.approx(coefficient, rel=1e-9)
    assert found.low < coefficient < found.high
    assert (found.tau_low, found.tau_high) == (TAU[0], pytest.approx(TAU[-4]))


@given(st.floats(1e-3, 1e3), st.floats(1e-3, 1e3))
def test_two_laws_in_one_curve_are_told_apart(white, crossing):
    """N and K whose lines cross far inside of the curve."""
    tau = crossing * np.logspace(-2.5, 2.5, 51)
    walk = white * np.sqrt(3) / crossing
    sigma = np.hypot(LAWS["N"].deviation(white, tau), LAWS["K"].deviation(walk, tau))
    asd = ideal_curve(sigma, tau, count=1e9 * crossing)
    found = {symbol: tangent(asd, law) for symbol, law in LAWS.items()}
    assert found["N"].holds
    assert found["N"].value == pytest.approx(white, rel=0.02)
    assert found["K"].holds
    assert found["K"].value == pytest.approx(walk, rel=0.02)
    assert not found["B"].holds
    assert found["B"].value * LAWS["B"].gain == pytest.approx(sigma.min(), rel=0.02)


@pytest.mark.parametrize("symbol", LAWS)
def test_each_law_is_the_closed_form_of_its_effect(symbol):
    np.testing.assert_allclose(LAWS[symbol].deviation(1.0, TAU) ** 2, PURE[symbol].allan_variance(TAU), rtol=1e-14)


@pytest.mark.parametrize(("decades", "holds"), [(0.4, False), (2.0, True)])
def test_a_law_has_to_hold_over_the_shortest_range(decades, holds):
    sigma = np.clip((TAU / 100) ** -0.5, 10 ** (-decades / 2), 1)
    assert tangent(ideal_curve(sigma, TAU), LAWS["N"]).holds == holds


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
def test_the_shortest_log_gives_a_reading_or_a_bound(law):
    found = tangent(curve(stream(47).standard_normal(allan.SHORTEST), 1.0), law)
    assert 0 <= found.low <= found.value <= found.high < np.inf
    assert found.low == 0 or found.holds


def test_a_log_too_short_to_know_a_slope_is_refused():
    with pytest.raises(ValueError, match=f"expected at least {allan.SHORTEST} samples; found {allan.SHORTEST - 1}"):
        curve(stream(47).standard_normal(allan.SHORTEST - 1), 1.0)


def test_at_the_longest_averaging_times_the_law_that_was_shown_last_goes_on():
    """White noise whose last local slopes look like other laws keeps the degrees of freedom of white noise."""
    found = [curve(stream(47, run).standard_normal(4096), 1.0).iloc[-1] for run in range(20)]
    assert any(abs(last["slope"] + 0.5) > 0.25 for last in found)
    edf = edf_greenhall(alpha=0, d=2, m=1024, N=4097, overlapping=True)
    assert [last["edf"] for last in found] == pytest.approx([edf] * len(found))


def test_points_per_decade_is_what_the_slope_error_assumes():
    found = np.log10(factors(10**6))
    np.testing.assert_allclose(np.diff(found[-20:]), 1 / allan.POINTS_PER_DECADE, rtol=0.03)


def test_a_log_of_lost_samples_has_no_curve():
    """Each sample is the only one for long, so that none tells a slope."""
    lost = np.arange(1200) % 20 != 0
    with pytest.raises(ValueError, match="expected samples enough for a slope; found 95 % lost of 1200"):
        curve(stream(1, "sparse").standard_normal(1200), 1.0, lost=lost)

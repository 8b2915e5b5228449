import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import chi2

from imugap.effects import Bias, Conditions, GaussMarkov, RandomWalk, TurnOnBias, WhiteNoise
from imugap.effects.effect import AxisModel
from imugap.effects.gauss_markov import FLAT_TOP
from imugap.estimation.variances import allan
from imugap.figures.static import TITLES
from imugap.interchange.from_indices import CONTENDERS, READ, AxisIndices, bounded, fit, nbk
from imugap.numerics.samples.bias_stability import bias_stability
from imugap.stream import stream

INTERVAL, PERIOD = 0.1, 1.0
HOUR = Conditions(INTERVAL * np.arange(36_001), INTERVAL)
RUNS = 400


def curve_of(model, tau, error=1e-3):
    """The Allan curve of a model, known to a relative error."""
    return pd.DataFrame({"deviation": np.sqrt(model.allan_variance(tau)), "error": error}, index=pd.Index(tau))


def indices(**changed):
    values = {"bias": 0.4, "stability": 0.03, "repeatability": 0.2, "white": 0.05, "flicker": 0.01, "walk": 1e-3}
    curve = curve_of(WhiteNoise(0.05) + RandomWalk(1e-3), np.logspace(-1, 3, 41))
    return AxisIndices(**values | {"period": PERIOD, "curve": curve} | changed)


def errors(name, of, label, at=HOUR):
    return CONTENDERS[name](of).simulate(np.zeros(len(at)), at, 61, name, label)


def sharp_std(samples, std, alpha=1e-4):
    """Whether independent zero-mean Gaussian samples have this standard deviation (chi-square, two-sided)."""
    low, high = chi2.ppf([alpha / 2, 1 - alpha / 2], samples.size)
    return low < np.sum(samples**2) / std**2 < high


def effect(model, kind):
    (only,) = (item for item in model if isinstance(item, kind))
    return only


@pytest.mark.parametrize(("name", "per_hour"), [("method_a", 60 * 0.03), ("method_b", 60 * 0.01)])
def test_slow_drift_after_an_hour_is_sixty_times_its_index(name, per_hour):
    """methods.md section 1: after 1 h, A's slow drift has a standard deviation of 60 Bs; B's with Bi in its place."""
    drift = effect(CONTENDERS[name](indices()), RandomWalk)
    last = np.array([drift.sample(HOUR, stream(62, name, run))[-1] for run in range(RUNS)])
    assert sharp_std(last, per_hour)


@pytest.mark.parametrize("period", [0.5, 1.0, 4.0])
def test_slow_drift_of_method_a_gains_the_stability_each_period(period):
    drift = effect(CONTENDERS["method_a"](indices(period=period)), RandomWalk)
    sequence = drift.sample(HOUR, stream(63, period))
    assert sharp_std(np.diff(sequence[:: round(period / INTERVAL)]), 0.03)


def test_rate_random_walk_grows_by_k_each_second():
    model = CONTENDERS["rate_random_walk"](indices())
    sequence = effect(model, RandomWalk).sample(HOUR, stream(64))
    assert sharp_std(np.diff(sequence), 1e-3 * np.sqrt(INTERVAL))
    assert effect(model, Bias).value == 0.4


@pytest.mark.parametrize("name", ["white", "white_turn_on", "rate_random_walk", "method_a", "method_b"])
def test_fast_noise_has_the_white_density(name):
    sequence = errors(name, indices(walk=1e-6, stability=1e-6, flicker=1e-6), "white")
    assert sharp_std(np.diff(sequence)[::2], 0.05 * np.sqrt(2 / INTERVAL))


@pytest.mark.parametrize("name", ["bias_only", "white", "rate_random_walk"])
def test_contenders_without_a_turn_on_bias_start_from_the_mean_bias(name):
    starts = [errors(name, indices(white=1e-9, walk=1e-9), run, Conditions(HOUR.time[:2], INTERVAL)) for run in (1, 2)]
    np.testing.assert_allclose(starts, 0.4, atol=1e-6)


@pytest.mark.parametrize("name", ["white_turn_on", "restoration", "nbk"])
def test_contenders_with_a_turn_on_bias_spread_by_the_repeatability(name):
    offset = np.array(
        [effect(CONTENDERS[name](indices()), TurnOnBias).sample(HOUR, stream(65, name, run))[0] for run in range(RUNS)]
    )
    assert sharp_std(offset, 0.2)


@given(st.floats(1e-6, 10), st.sampled_from([0.5, 1.0, 2.0, 10.0]))
@settings(max_examples=25)
def test_restored_sequence_has_exactly_the_prescribed_stability(stability, period):
    at = Conditions(HOUR.time[:2003], INTERVAL)
    sequence = errors("restoration", indices(stability=stability, period=period), "exact", at)
    assert bias_stability(sequence, INTERVAL, period) == pytest.approx(stability, rel=1e-9)


def test_white_with_turn_on_is_the_restoration_without_its_scaling():
    unscaled = CONTENDERS["restoration"](indices()).effects[:-1]
    assert unscaled == (WhiteNoise(0.05), Bias(0.4), TurnOnBias(0.2))
    assert set(CONTENDERS["white_turn_on"](indices())) == set(unscaled)


def test_restoration_shifts_the_allan_curve_in_parallel_and_makes_no_slow_drift():
    of, averaging = indices(), allan.factors(len(HOUR))
    model = CONTENDERS["restoration"](of)
    plain = AxisModel(model.effects[:-1]).simulate(np.zeros(len(HOUR)), HOUR, 61, "parallel")
    restored = model.simulate(np.zeros(len(HOUR)), HOUR, 61, "parallel")
    ratio = np.sqrt(allan.variance(restored, averaging) / allan.variance(plain, averaging))
    np.testing.assert_allclose(ratio, ratio[0], rtol=1e-7)
    assert ratio[0] == pytest.approx(of.stability / bias_stability(plain, INTERVAL, PERIOD), rel=1e-7)
    assert restored.mean() == pytest.approx(plain.mean(), abs=1e-9)


@given(st.floats(1e-6, 1.0), st.floats(-1.5, 1.5), st.floats(0.2, 0.9))
@settings(max_examples=40)
def test_nbk_gives_back_what_its_own_family_made(density, log_time, share):
    """A Gauss-Markov process whose top stands at the floor of N and K: the floor of the sum is where the fit looks."""
    floor = 10.0**log_time
    tau = floor * np.logspace(-2, 2, 81)
    level = density * np.sqrt(2 / floor)
    unit = GaussMarkov(1.0, floor / FLAT_TOP)
    std = share * level / np.sqrt(unit.allan_variance(floor))
    truth = WhiteNoise(density) + GaussMarkov(std, unit.correlation_time) + RandomWalk(np.sqrt(3) * density / floor)
    curve = curve_of(truth, tau)
    near = abs(np.log10(curve["deviation"].idxmin() / floor)) < 0.06
    found = nbk(indices(curve=curve))
    assert near
    assert effect(found, WhiteNoise).density == pytest.approx(density, rel=0.03)
    assert effect(found, RandomWalk).density_k == pytest.approx(np.sqrt(3) * density / floor, rel=0.03)
    assert effect(found, GaussMarkov).std == pytest.approx(std, rel=0.15)
    np.testing.assert_allclose(found.allan_variance(tau), truth.allan_variance(tau), rtol=0.02)


def test_nbk_finds_no_process_that_is_not_there():
    tau = np.logspace(-1, 3, 41)
    found = nbk(indices(curve=curve_of(WhiteNoise(0.05) + RandomWalk(1e-3), tau)))
    np.testing.assert_allclose(found.psd(1 / tau), (WhiteNoise(0.05) + RandomWalk(1e-3)).psd(1 / tau), rtol=0.01)
    assert effect(found, WhiteNoise).density == pytest.approx(0.05, rel=1e-6)
    assert effect(found, RandomWalk).density_k == pytest.approx(1e-3, rel=1e-6)
    assert effect(found, GaussMarkov).std < 1e-6


def test_nbk_leaves_out_what_the_curve_does_not_know():
    known = curve_of(WhiteNoise(0.05) + RandomWalk(1e-3), np.logspace(-1, 2.5, 41))
    wild = pd.DataFrame({"deviation": [1e-9, 5.0], "error": [0.3, 0.9]}, index=[1e4, 1e5])
    assert nbk(indices(curve=pd.concat([known, wild]))) == nbk(indices(curve=known))


VALUES = pd.Series({"bias": 1.0, "stability": 0.1, "repeatability": 0.3, "N": 0.2, "B": 0.05, "K": 0.01})


def restored(period, **values):
    """Fit the restoration to the indices of axes, each a series by symbol."""
    tables = [of.rename_axis("symbol").reset_index(name="value").assign(axis=axis) for axis, of in values.items()]
    curves = pd.DataFrame({"axis": list(values), "tau": 1.0, "deviation": 1.0, "error": 0.1})
    return fit("restoration", pd.concat(tables), curves, period)


def test_fit_builds_each_axis_from_its_own_indices():
    model = restored(4.0, gyro_x=VALUES, accel_z=2 * VALUES)
    parameters = {name: [item.parameters() for item in model[name]] for name in ("gyro_x", "accel_z")}
    assert parameters["gyro_x"] == [{"density": 0.2}, {"value": 1.0}, {"std": 0.3}, {"stability": 0.1, "period": 4.0}]
    assert parameters["accel_z"] == [{"density": 0.4}, {"value": 2.0}, {"std": 0.6}, {"stability": 0.2, "period": 4.0}]


def test_fit_of_a_single_run_has_no_turn_on_bias():
    assert effect(restored(1.0, gyro_x=VALUES.drop("repeatability"))["gyro_x"], TurnOnBias).std == 0


def test_every_contender_has_a_title():
    assert list(TITLES) == list(CONTENDERS)


@pytest.mark.parametrize(("symbol", "name"), [("N", "white"), ("B", "flicker"), ("K", "walk")])
def test_the_coefficients_that_a_contender_takes_from_the_curve_are_those_that_change_it(symbol, name):
    usual = indices()
    other = indices(**{name: 3 * getattr(usual, name)})
    changed = {contender for contender, build in CONTENDERS.items() if build(usual) != build(other)}
    assert changed == {contender for contender, of in READ.items() if symbol in of}


def test_bounds_that_stand_for_values_are_counted_by_contender():
    rows = [(axis, symbol, axis != "x" or symbol == "N") for axis in ("x", "y") for symbol in ("N", "B", "K")]
    rows = pd.DataFrame(rows, columns=["axis", "symbol", "holds"])
    assert bounded(rows) == {"rate_random_walk": 1, "method_b": 1}
    assert bounded(rows.assign(holds=True)) == {}
    assert bounded(rows.assign(holds=rows["symbol"] != "N"))["restoration"] == 2

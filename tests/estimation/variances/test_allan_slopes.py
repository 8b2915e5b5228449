from math import isinf, isnan
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from imugap.effects import (
    BiasInstability,
    Conditions,
    GaussMarkov,
    Quantization,
    RandomWalk,
    RateRamp,
    TurnOnBias,
    WhiteNoise,
)
from imugap.effects.effect import AxisModel
from imugap.estimation.result import Identifiability
from imugap.estimation.variances import allan
from imugap.estimation.variances.allan_slopes import PEAK_RATIO, SYMBOLS, fit

PEERS = pd.read_csv(Path(__file__).parents[2] / "reference" / "montecarlo_allan.csv", comment="#")
ALL = (*SYMBOLS, GaussMarkov)
INTERVAL, COUNT = 0.1, 108_000
"""The setting of the peers' values: 3 h at 10 Hz."""


def simulate(model, count, *labels, interval=INTERVAL):
    return model.simulate(np.zeros(count), Conditions(np.arange(count) * interval, interval), 71, *labels)


def by_parameter(found):
    return {estimate.parameter: estimate for estimate in found.estimates}


@pytest.mark.parametrize("kind", SYMBOLS)
def test_a_power_law_is_read_as_its_tangent(kind):
    sequence = simulate(kind(1.0) + WhiteNoise(0.1), 8192, kind.name, interval=1.0)
    reading = allan.tangent(allan.curve(sequence, 1.0), allan.LAWS[SYMBOLS[kind]])
    (estimate,) = fit(sequence, 1.0, (kind,)).estimates
    assert reading.holds
    assert (estimate.value, estimate.low, estimate.high) == (reading.value, reading.low, reading.high)
    assert estimate.verdict == Identifiability.IDENTIFIED
    assert estimate.low < 1 < estimate.high


def test_a_law_that_the_curve_does_not_show_is_zero_with_its_bound():
    sequence = simulate(AxisModel((WhiteNoise(1.0),)), 8192, "absent")
    reading = allan.tangent(allan.curve(sequence, INTERVAL), allan.LAWS["K"])
    found = by_parameter(fit(sequence, INTERVAL, (WhiteNoise, RandomWalk)))["density_k"]
    assert (found.value, found.low, found.high) == (0.0, 0.0, reading.high)
    assert found.verdict == Identifiability.UPPER_BOUND
    assert isinf(found.error)


def test_result_is_a_model_with_its_estimates_and_no_objective():
    model = WhiteNoise(0.005) + GaussMarkov(1 / 180, 10.0)
    found = fit(simulate(model, COUNT, "result"), INTERVAL, (WhiteNoise, RandomWalk, GaussMarkov))
    assert isnan(found.objective)
    values = by_parameter(found)
    white, walk, markov = found.model
    assert (white.density, walk.density_k, markov.std) == tuple(
        values[k].value for k in ("density", "density_k", "std")
    )
    assert markov.correlation_time == values["correlation_time"].value
    assert markov.driving_psd == pytest.approx(values["driving_psd"].value, rel=1e-12)
    assert list(found.table().columns) == ["value", "low", "high", "error", "verdict"]


def test_top_is_that_of_eq_37():
    assert pytest.approx(0.4365 * np.sqrt(2), abs=1e-4) == PEAK_RATIO


@pytest.mark.parametrize("time", [1.0, 5.0])
def test_a_process_that_stands_out_is_found_where_it_is(time):
    """A long log of little white noise: the top is known to a few per cent."""
    model = WhiteNoise(1e-3) + GaussMarkov(0.01, time)
    found = by_parameter(fit(simulate(model, COUNT, "plain", time), INTERVAL, (WhiteNoise, GaussMarkov), level=0.999))
    assert found["std"].value == pytest.approx(0.01, rel=0.08)
    assert found["correlation_time"].value == pytest.approx(time, rel=0.3)
    for name, truth in {"std": 0.01, "correlation_time": time, "driving_psd": 2e-4 / time}.items():
        assert found[name].low < truth < found[name].high
        assert found[name].verdict == Identifiability.IDENTIFIED


@pytest.mark.slow
@pytest.mark.parametrize(("time", "walk"), [(10, 0), (10, 1), (50, 0), (50, 1), (200, 0), (200, 1)])
def test_readings_are_no_worse_than_the_peers(time, walk):
    """Relative RMSE over 100 logs, less one standard error, against every peer method (one standard error of its own).

    Intervals hold the truth of T nearly always, of N and std in most runs: a chosen maximum is not a point chosen
    beforehand.
    """
    model = WhiteNoise(5e-3) + GaussMarkov(1 / 180, float(time))
    model = model + RandomWalk(1 / 21600) if walk else model
    kinds = tuple(map(type, model))
    fits = [by_parameter(fit(simulate(model, COUNT, "peers", time, run), INTERVAL, kinds)) for run in range(100)]
    truths = {"density": 5e-3, "std": 1 / 180, "correlation_time": float(time)}
    least = {"density": 0.85, "std": 0.8, "correlation_time": 0.9}
    for name, truth in truths.items():
        squares = np.array([one[name].value / truth - 1 for one in fits]) ** 2
        rmse = np.sqrt(squares.mean())
        error = squares.std() / np.sqrt(len(squares)) / (2 * rmse)
        peers = PEERS[(PEERS["correlation_time"] == time) & (PEERS["walk"] == walk) & (PEERS["parameter"] == name)]
        assert len(peers) > 0
        assert rmse - error < peers["rmse"].min() + error, name
        held = np.mean([one[name].low <= truth <= one[name].high for one in fits])
        assert held >= least[name], name
    if walk:
        assert np.mean([one["density_k"].low <= 1 / 21600 <= one["density_k"].high for one in fits]) > 0.9


@pytest.mark.slow
def test_white_noise_has_no_top_and_its_bounds_hold():
    faint = GaussMarkov(5e-4, 20.0)
    for run in range(30):
        plain = by_parameter(fit(simulate(AxisModel((WhiteNoise(5e-3),)), 20_000, run), INTERVAL, ALL))
        assert plain["std"].value == 0
        assert plain["std"].verdict == Identifiability.UPPER_BOUND
        assert plain["correlation_time"].verdict == Identifiability.UNDETERMINED
        hidden = by_parameter(fit(simulate(WhiteNoise(5e-3) + faint, 20_000, "faint", run), INTERVAL, ALL))
        assert hidden["std"].low <= faint.std <= hidden["std"].high
        assert hidden["driving_psd"].low <= faint.driving_psd <= hidden["driving_psd"].high


@pytest.mark.slow
def test_white_noise_read_beyond_a_top_is_freed_from_the_flank_and_only_bounded():
    """There N^2 has S_B T^2 = 2 std^2 T on it, here twenty times as much as itself."""
    markov, white = GaussMarkov(0.1, 0.1), WhiteNoise(0.01)
    flank = np.sqrt(markov.driving_psd) * markov.correlation_time
    for run in range(20):
        sequence = simulate(white + markov, 200_000, "flank", run, interval=0.01)
        alone = by_parameter(fit(sequence, 0.01, (WhiteNoise,)))["density"]
        both = by_parameter(fit(sequence, 0.01, (WhiteNoise, GaussMarkov)))
        assert alone.value == pytest.approx(np.hypot(white.density, flank), rel=0.1)
        assert both["density"].value < 0.75 * alone.value
        assert both["density"].verdict == Identifiability.UPPER_BOUND
        assert both["density"].low <= white.density <= both["density"].high
        assert both["std"].value == pytest.approx(markov.std, rel=0.12)  # N adds to the top, unseen


@pytest.mark.parametrize(
    "model",
    [
        AxisModel((WhiteNoise(1.0),)),
        AxisModel((RandomWalk(1.0),)),
        AxisModel((BiasInstability(1.0),)),
        AxisModel((Quantization(1.0),)),
        AxisModel((RateRamp(1.0),)),
        AxisModel((GaussMarkov(1.0, 1e4),)),
        AxisModel((GaussMarkov(1.0, 1e-3),)),
        RateRamp(1.0) + WhiteNoise(1.0),
        TurnOnBias(1e6) + WhiteNoise(1.0),
    ],
    ids=["white", "walk", "flicker", "rounding", "ramp", "slow", "fast", "ramp in noise", "offset"],
)
@pytest.mark.parametrize("count", [allan.SHORTEST, 5000])
def test_every_log_has_a_reading_or_a_bound_of_everything(model, count):
    for estimate in fit(simulate(model, count, "any"), INTERVAL, ALL).estimates:
        assert 0 <= estimate.low <= estimate.value <= estimate.high
        assert not isnan(estimate.error)


def test_every_odd_shape_has_a_reading_or_a_bound_of_everything():
    time = np.arange(4000) * INTERVAL
    shapes = [np.sin(time), np.sign(np.sin(time / 7)), time**2, np.exp(-time / 40), (time > 200) * 1.0, time % 1]
    for shape in shapes:
        for estimate in fit(shape, INTERVAL, ALL).estimates:
            assert 0 <= estimate.low <= estimate.value <= estimate.high


@given(st.floats(1e-6, 1e6), st.floats(1e-3, 1e2), st.integers(0, 5))
@settings(max_examples=15)
def test_readings_scale_with_the_unit_and_with_the_clock(scale, interval, run):
    sequence = simulate(WhiteNoise(0.5) + GaussMarkov(1.0, 20.0), 5000, "scale", run, interval=1.0)
    unit, other = by_parameter(fit(sequence, 1.0, ALL)), by_parameter(fit(scale * sequence, interval, ALL))
    powers = {"q": 1, "density": 0.5, "density_b": 0, "density_k": -0.5, "slope": -1, "std": 0}
    for name, power in powers.items():
        assert other[name].value == pytest.approx(scale * interval**power * unit[name].value, rel=1e-6)
        assert other[name].high == pytest.approx(scale * interval**power * unit[name].high, rel=1e-6)
    assert other["correlation_time"].value == pytest.approx(interval * unit["correlation_time"].value, rel=1e-6)


@pytest.mark.parametrize("kinds", [(), (WhiteNoise, WhiteNoise), (GaussMarkov, GaussMarkov), (TurnOnBias,)])
def test_processes_that_cannot_be_read_are_refused(kinds):
    with pytest.raises(ValueError, match="Allan slopes: expected"):
        fit(np.zeros(1000), 1.0, kinds)

import numpy as np
import pandas as pd
import pytest
from tests.chance import as_often_as

from imugap import log
from imugap.effects import BiasInstability, Conditions, RandomWalk, WhiteNoise
from imugap.estimation.indices import (
    BATCHES,
    INDICES,
    IndexSamples,
    of_run,
    of_samples,
    over_runs,
    repeatability,
    shortest,
)
from imugap.estimation.variances import allan
from imugap.stream import stream
from imugap.units import factor


def table(sequence, interval=0.01, axis="gyro_x"):
    return log.from_samples({axis: np.asarray(sequence, float)}, interval)


def ideal(value=0.0, axis="gyro_x"):
    return pd.Series({axis: value})


def simulated(count, *effects, label=0, interval=0.01):
    at = Conditions(interval * np.arange(count), interval)
    return sum(effect.sample(at, stream(51, label, effect)) for effect in effects)


def found(sequence, *symbols, period=1.0, interval=0.01, true=0.0):
    return of_run(table(sequence, interval), ideal(true), period, symbols).set_index("symbol")


def runs(values, symbol="bias", holds=True):
    """A table of runs with one value each."""
    rows = [
        {"run": k, "axis": "gyro_x", "symbol": symbol, "value": v, "low": v - 1, "high": v + 1, "holds": h}
        for k, (v, h) in enumerate(zip(values, np.broadcast_to(holds, len(values)), strict=True))
    ]
    return pd.DataFrame(rows).assign(tau_low=np.nan, tau_high=np.nan)


def test_bias_is_the_mean_error_against_the_ideal_reading():
    sequence = 3.0 + simulated(2000, WhiteNoise(1e-3))
    bias = found(sequence, "bias", true=2.5).loc["bias"]
    assert bias["value"] == pytest.approx(sequence.mean() - 2.5, abs=1e-12)
    assert bias["low"] < bias["value"] < bias["high"]


@pytest.mark.slow
def test_interval_of_the_bias_covers_it():
    rows = [found(simulated(1000, WhiteNoise(1.0), label=run), "bias").loc["bias"] for run in range(400)]
    assert as_often_as([row["low"] <= 0 <= row["high"] for row in rows], 0.95)


def test_stability_of_a_square_wave_over_whole_periods_is_its_amplitude_with_one_degree_less():
    wave = np.tile(np.repeat([1.0, -1.0], 100), 20)
    assert found(wave, "stability").loc["stability", "value"] == pytest.approx(np.sqrt(40 / 39), rel=1e-12)


@pytest.mark.slow
def test_interval_of_the_stability_covers_it_for_white_noise():
    rows = [
        found(simulated(20_000, WhiteNoise(1.0), label=run), "stability").loc["stability"] for run in range(400)
    ]  # 20 periods in each of 10 batches
    inside = [row["low"] <= 1.0 <= row["high"] for row in rows]
    assert 0.90 < np.mean(inside) < 0.98


def test_indices_of_the_allan_curve_are_read_or_bounded():
    sequence = simulated(100_000, WhiteNoise(0.3))
    rows = found(sequence, "N", "B", "K")
    assert rows["holds"].to_dict() == {"N": True, "B": False, "K": False}
    assert rows.loc["N", "low"] < 0.3 < rows.loc["N", "high"]
    assert rows.loc["N", "value"] == pytest.approx(0.3, rel=0.02)
    assert (rows.loc[["B", "K"], "low"] == 0).all()


def test_random_walk_index_of_a_random_walk():
    rows = found(simulated(100_000, RandomWalk(0.3)), "N", "B", "K")
    assert rows["holds"].to_dict() == {"N": False, "B": False, "K": True}
    assert rows.loc["K", "value"] == pytest.approx(0.3, rel=0.06)


def test_flicker_index_of_flicker():
    rows = found(simulated(100_000, BiasInstability(0.3)), "N", "B", "K")
    assert rows["holds"].to_dict() == {"N": False, "B": True, "K": False}
    assert rows.loc["B", "value"] == pytest.approx(0.3, rel=0.06)


def test_only_what_is_asked_for_is_given_axis_by_axis():
    both = log.from_samples({axis: simulated(3000, WhiteNoise(1.0), label=axis) for axis in log.GYRO[:2]}, 0.01)
    rows = of_run(both, pd.Series({"gyro_x": 0.0, "gyro_y": 0.0}), 1.0, ("N", "bias"))
    assert list(zip(rows["axis"], rows["symbol"], strict=True)) == [
        ("gyro_x", "bias"),
        ("gyro_x", "N"),
        ("gyro_y", "bias"),
        ("gyro_y", "N"),
    ]


@pytest.mark.parametrize("symbol", INDICES)
def test_a_log_too_short_for_an_index_says_how_long_it_has_to_be(symbol):
    count = int(INDICES[symbol].minimum_s / 0.01) - 1
    title = INDICES[symbol].title.replace("(", r"\(").replace(")", r"\)")
    with pytest.raises(log.LogError, match=f"expected at least {INDICES[symbol].minimum_s:g} s for the {title}"):
        of_run(table(simulated(count, WhiteNoise(1.0))), ideal(), 1.0, (symbol,))


@pytest.mark.parametrize("symbol", INDICES)
def test_a_log_just_long_enough_for_an_index_passes(symbol):
    count = int(INDICES[symbol].minimum_s / 0.01)
    of_run(table(simulated(count, WhiteNoise(1.0))), ideal(), 1.0, (symbol,))


def test_fewer_periods_than_batches_are_refused():
    with pytest.raises(log.LogError, match="stability"):
        found(simulated(3000, WhiteNoise(1.0)), "stability", period=5.0)


@pytest.mark.parametrize("period", [0.1, 1.0, 5.0, 60.0])
def test_the_shortest_log_for_the_stability_has_two_periods_in_every_batch(period):
    needed = shortest("stability", period, 0.1)
    assert needed == max(INDICES["stability"].minimum_s, 2 * BATCHES * period)
    count = round(needed / 0.1)
    row = found(simulated(count, WhiteNoise(1.0), interval=0.1), "stability", period=period, interval=0.1).iloc[0]
    assert 0 <= row["low"] < row["value"] < row["high"]
    with pytest.raises(log.LogError, match=f"expected at least {needed:g} s for the bias stab"):
        found(simulated(count - 1, WhiteNoise(1.0), interval=0.1), "stability", period=period, interval=0.1)


@pytest.mark.parametrize("symbol", [symbol for symbol in INDICES if symbol != "stability"])
def test_the_period_of_the_stability_lengthens_no_other_index(symbol):
    assert shortest(symbol, 1e4, 0.01) == INDICES[symbol].minimum_s


@pytest.mark.parametrize("symbol", ["N", "B", "K"])
def test_a_slow_log_has_to_have_enough_samples_for_a_curve(symbol):
    assert shortest(symbol, 1.0, 100.0) == 100.0 * allan.SHORTEST


def test_repeatability_is_the_deviation_over_runs():
    value, low, high = repeatability(np.array([1.0, 2.0, 3.0]))
    assert value == pytest.approx(1.0, rel=1e-15)
    assert low < value < high


@pytest.mark.parametrize("count", [2, 6])
def test_interval_of_the_repeatability_covers_it(count):
    drawn = stream(52, count).normal(5.0, 0.7, (4000, count))
    intervals = np.array([repeatability(biases)[1:] for biases in drawn])
    assert as_often_as((intervals[:, 0] <= 0.7) & (intervals[:, 1] >= 0.7), 0.95)


def test_over_runs_is_the_mean_with_a_student_interval():
    rows = over_runs(runs([1.0, 2.0, 3.0])).set_index("symbol")
    assert rows.loc["bias", "value"] == pytest.approx(2.0)
    assert rows.loc["bias", "high"] - 2.0 == pytest.approx(4.303 / np.sqrt(3), rel=1e-3)  # t(0.975, 2 df), tabulated
    assert rows.loc["repeatability", "value"] == pytest.approx(1.0)
    assert (rows["runs"] == 3).all()


@pytest.mark.slow
@pytest.mark.parametrize("count", [2, 5])
def test_interval_over_runs_covers_the_mean(count):
    drawn = stream(53, count).normal(5.0, 0.7, (1000, count))
    rows = [over_runs(runs(values)).iloc[0] for values in drawn]
    assert as_often_as([row["low"] <= 5.0 <= row["high"] for row in rows], 0.95)


def test_a_single_run_keeps_its_own_intervals_and_has_no_repeatability():
    single = runs([2.0])
    rows = over_runs(single)
    assert list(rows["symbol"]) == ["bias"]
    assert rows.loc[0, ["value", "low", "high"]].tolist() == [2.0, 1.0, 3.0]
    assert rows.loc[0, "runs"] == 1
    assert set(rows.columns) == set(over_runs(runs([1.0, 2.0])).columns)


@pytest.mark.parametrize(
    ("holds", "reading"), [((True, True, False), True), ((True, False, False), False), ((True, False), False)]
)
def test_a_value_is_a_reading_only_if_most_runs_read_it(holds, reading):
    row = over_runs(runs(np.arange(len(holds)) + 1.0, "K", holds)).iloc[0]
    assert row["holds"] == reading
    assert (row["low"] == 0) == (not reading)


def test_bounds_do_not_enter_the_mean_of_readings():
    row = over_runs(runs([1.0, 1.0, 10.0], "K", (True, True, False))).iloc[0]
    assert row["value"] == pytest.approx(1.0)
    assert row["runs"] == 2


def test_all_runs_bound_what_most_do_not_read():
    row = over_runs(runs([1.0, 4.0, 10.0], "K", (True, False, False))).iloc[0]
    assert row[["value", "low", "high", "runs"]].tolist() == [5.0, 0.0, 6.0, 3]


@pytest.mark.filterwarnings("ignore:Degrees of freedom", "ignore:invalid value")
def test_a_reading_of_a_single_run_among_several_keeps_its_own_interval():
    rows = over_runs(pd.concat([runs([1.0, 2.0]), runs([5.0], "K")])).set_index("symbol")
    assert rows.loc["K", ["value", "low", "high"]].tolist() == [5.0, 4.0, 6.0]


def test_units_of_the_indices_are_convertible():
    for index in INDICES.values():
        assert factor(index.unit("gyro_x")) > 0
        assert factor(index.unit("accel_x")) > 0
        assert index.unit("gyro_z") == index.gyro_unit
        assert index.unit("accel_z") == index.accel_unit


def test_a_bias_needs_measured_samples():
    samples = IndexSamples("gyro_x", np.arange(100.0), np.arange(100) >= BATCHES - 1, 1.0)
    with pytest.raises(log.LogError, match="gyro_x: expected at least 10 measured samples; found 9"):
        of_samples(samples, 0.0, 1.0, ("bias",))

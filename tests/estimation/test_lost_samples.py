"""Lost samples are gaps: estimates stay unbiased and intervals hold, for any share of lost samples and over a pause."""

import numpy as np
import pandas as pd
import pytest

from imugap.effects import RandomWalk, WhiteNoise
from imugap.estimation.gap_draws import draw_gaps
from imugap.estimation.indices import IndexSamples, of_samples
from imugap.estimation.report import EstimatorSettings, estimate_axis
from imugap.estimation.screening import information
from imugap.estimation.variances import allan
from imugap.stream import stream

DENSITY, DENSITY_K, RATE = 2e-4, 1e-5, 20.0
LOGS = 12
LOSSES = [0.2, 0.6, 0.8, "pause"]


def with_gaps(loss, seed, count):
    rng = stream(seed, "lost samples", str(loss))
    walk = np.cumsum(DENSITY_K / np.sqrt(RATE) * rng.standard_normal(count))
    lost = rng.random(count) < loss if loss != "pause" else np.zeros(count, bool)
    if loss == "pause":
        lost[count // 4 : 3 * count // 4] = True
    return np.where(lost, np.nan, walk + DENSITY * np.sqrt(RATE) * rng.standard_normal(count))


@pytest.mark.slow
@pytest.mark.parametrize("loss", LOSSES)
def test_estimates_lie_within_their_intervals(loss):
    settings = EstimatorSettings((WhiteNoise, RandomWalk))
    found = [
        estimate_axis("gyro_x", with_gaps(loss, seed, 12000), 1 / RATE, settings).fit.estimates for seed in range(LOGS)
    ]
    white, walk = zip(*found, strict=True)
    assert sum(one.low <= DENSITY <= one.high for one in white) >= LOGS - 3
    assert sum(one.low <= DENSITY_K <= one.high for one in walk) >= LOGS - 3
    deviations = np.array([(one.value / DENSITY - 1) / one.error for one in white])
    assert abs(deviations.mean()) < 4 / np.sqrt(LOGS)
    assert 0.4 < np.sqrt(np.mean(deviations**2)) < 1.7


@pytest.mark.slow
@pytest.mark.parametrize("loss", LOSSES)
def test_indices_lie_within_their_intervals(loss):
    rows = []
    for seed in range(LOGS):
        values = with_gaps(loss, seed, 12000)
        lost = np.isnan(values)
        drawn = draw_gaps(values, lost, 1 / RATE, stream(seed, "draws"))
        found = of_samples(IndexSamples("gyro_x", drawn, lost, 1 / RATE), 0.0, 1.0, ("N", "K"))
        rows.append(found.set_index("symbol"))
    for symbol, truth in (("N", DENSITY), ("K", DENSITY_K)):
        inside = [row.loc[symbol, "low"] <= truth <= row.loc[symbol, "high"] for row in rows]
        assert sum(inside) >= LOGS - 3
    assert np.mean([row.loc["N", "value"] for row in rows]) == pytest.approx(DENSITY, rel=0.02)


def test_a_whole_log_keeps_its_numbers_to_the_last_digit():
    whole = with_gaps(0.0, 1, 4000)
    pd.testing.assert_frame_equal(
        allan.curve(whole, 1 / RATE), allan.curve(whole, 1 / RATE, lost=np.zeros(4000, bool)), check_exact=True
    )
    assert information(1.0) == 1.0


def test_a_gap_costs_no_information_at_averaging_times_beyond_it():
    whole, lost = with_gaps(0.0, 2, 4000), np.zeros(4000, bool)
    lost[np.arange(4000) % 20 < 10] = True
    ratio = allan.curve(whole, 1 / RATE, lost=lost)["edf"] / allan.curve(whole, 1 / RATE)["edf"]
    assert ratio.iloc[0] == pytest.approx(information(0.5))
    assert ratio.iloc[-1] == 1.0

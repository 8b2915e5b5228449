"""The products of the workflow, where they have been made: they have to make physical sense."""

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

ROOT = Path(__file__).parents[1]
TABLES = ROOT / "paper" / "tables"

pytestmark = pytest.mark.skipif(not (ROOT / "paper/paper.pdf").exists(), reason="the workflow has not been run here")


def devices():
    study = ROOT / "paper/numbers/study.json"
    return json.loads(study.read_text())["devices"] if study.exists() else []


def read(name):
    return pd.read_csv(TABLES / f"{name}.csv")


def test_every_table_has_its_three_forms_and_rows():
    for path in TABLES.glob("*.csv"):
        page = json.loads(path.with_suffix(".json").read_text())
        assert path.with_suffix(".tex").read_text().startswith(r"\begin{tabular}")
        assert page["rows"]
        assert all(len(row) == len(page["columns"]) for row in page["rows"])


@pytest.mark.parametrize("device", devices())
def test_white_noise_model_spreads_as_integrated_white_noise(device):
    """The calibrated heading of the white-noise model: random walk plus the error of the calibration's mean."""
    drift = np.load(ROOT / f"results/{device}/drift/white.npz")
    density = read(f"indices_{device}").set_index(["axis", "symbol"]).loc[("gyro_z", "N"), "value"]
    config = json.loads((ROOT / "paper/numbers/study.json").read_text())["config"]["navigation"]
    calibration, time = config["calibration_s"], drift["time"][-1]
    seen = drift["drift"][1, :, drift["time"] == 10, 2].std(ddof=1)
    predicted = density * np.sqrt(10 + 10**2 / calibration)
    trials = drift["drift"].shape[1]
    assert time >= 10
    assert abs(np.log(seen / predicted)) < 4 / np.sqrt(2 * trials)


@pytest.mark.parametrize("device", devices())
def test_error_grows_with_the_length(device):
    scores = pd.read_csv(ROOT / f"results/{device}/drift_scores.csv")
    for _, group in scores.groupby(["start", "contender", "quantity"]):
        assert group.sort_values("horizon")["median_e_abs"].is_monotonic_increasing


def test_bench_indices_cover_the_truth_as_often_as_they_say():
    if "bench" not in devices():
        pytest.skip("no bench in this study")
    score = read("bench_score")
    assert score["inside"].mean() > 0.8


@pytest.mark.parametrize(("run", "low", "high"), [(3, 0.94, 0.975), (4, 0.94, 0.97), (5, 0.82, 0.86)])
def test_measured_clocks_of_the_real_device(run, low, high):
    if "adis16405" not in devices():
        pytest.skip("the files of adis16405 are not here")
    clock = read("clock_adis16405").set_index("run")
    if run not in clock.index:
        pytest.skip("the run is not part of this study")
    assert low < clock.loc[run, "combined"] < high
    assert clock.loc[run, "verdict"] == "different clock"


def test_restoration_never_wins_by_its_slow_drift():
    """Its Allan curve is a white one: above the white model's by one factor at every averaging time."""
    for device in devices():
        white, restored = (
            pd.read_csv(ROOT / f"results/{device}/model_allan/{name}.csv") for name in ("white", "restoration")
        )
        for axis, group in restored.groupby("axis"):
            ratio = (group["median"].to_numpy() / white.loc[white["axis"] == axis, "median"].to_numpy())[:20]
            assert ratio.std() / ratio.mean() < 0.02

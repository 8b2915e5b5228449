"""The products of the workflow, where they have been made: they have to make physical sense."""

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import typst
import yaml

from imugap.interchange.devices import catalogue as device_models
from imugap.study import statements, verdicts
from imugap.units import to_si

ROOT = Path(__file__).parents[1]
TABLES = ROOT / "paper" / "tables"

pytestmark = pytest.mark.skipif(not (ROOT / "paper/paper.pdf").exists(), reason="the workflow has not been run here")


def devices(key="devices"):
    """The devices of the study, or those whose missing effects it tells (``missing_of``)."""
    study = ROOT / "paper/numbers/study.json"
    return json.loads(study.read_text())[key] if study.exists() else []


def read(name):
    return pd.read_csv(TABLES / f"{name}.csv")


def read_of_walks(name):
    """Read a table that is not there without the walking sets."""
    if not (TABLES / f"{name}.csv").exists():
        pytest.skip("the walking sets are not here")
    return read(name)


@pytest.mark.parametrize(("text", "source"), [("paper", "main"), ("summary", "summary")])
def test_statements_rest_on_the_tables(text, source):
    found, faults = statements.collect(ROOT / "paper" / f"{source}.typ")
    listed = pd.read_csv(TABLES / "statements.csv", dtype=str, keep_default_na=False)
    assert not faults
    assert found.astype(str).equals(listed.loc[listed["text"] == text, list(found)].reset_index(drop=True))


def test_the_summary_has_two_pages():
    pages = typst.compile(str(ROOT / "paper" / "summary.typ"), root=str(ROOT / "paper"), format="png", ppi=20.0)
    assert len(pages) == 2


def test_verdicts_follow_the_intervals_of_their_tables():
    number = {path.stem: json.loads(path.read_text()) for path in (ROOT / "paper/numbers").glob("*.json")}
    if "compensation" in number:
        ends = read("compensation").set_index("contender")
        for quantity, gaps in number["compensation"]["gap"].items():
            for name, gap in gaps.items():
                interval = tuple(ends.loc[name, [f"{quantity}_excess_low", f"{quantity}_excess_high"]])
                assert gap["verdict"] == verdicts.difference(interval)
    for device in devices("unseen_of"):
        for one in read(f"unseen_{device}").dropna(subset="verdict").itertuples():
            assert one.verdict == verdicts.difference((one.low, one.high), "level")
    for device in devices("missing_of"):
        ends = ("value", "low", "high")
        for one in read(f"missing_distances_{device}").to_dict("records"):
            found = verdicts.distance(
                *({end: one[f"{of}_{end}"] for end in ends} for of in ("before", "after", "floor"))
            )
            key = "navigation" if one["distance"] == "navigation drift" else one["distance"]
            assert number[f"missing_{device}"]["starts"][one["start"]][key]["verdict"] == found["verdict"]


def test_every_table_has_its_three_forms_and_rows():
    for path in TABLES.glob("*.csv"):
        page = json.loads(path.with_suffix(".json").read_text())
        assert path.with_suffix(".tex").read_text().startswith(r"\begin{tabular}")
        assert page["rows"] or path.stem == "blind_misses"
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


def test_computed_covariance_says_one_for_the_right_filter_and_more_for_the_others():
    ends = read("planar").dropna(subset="computed_ratio").set_index("filter")
    assert ends.loc["N + B + K", "computed_ratio"].to_numpy() == pytest.approx(1.0, rel=1e-6)
    assert ends.drop(index="N + B + K")["computed_ratio"].min() > 1


def test_conversions_of_one_device_agree_with_one_another():
    """A density is one number in every unit, and what a tool takes per sample is it times a root of the rate."""
    table = read("conversion").set_index(["tool", "device", "parameter"]).sort_index()
    for device in devices():
        of = {tool: table.loc[(tool, device)]["value"] for tool in table.index.get_level_values("tool").unique()}
        rate = table.xs(device, level="device")["rate_hz"].iloc[0]
        white = of["Kalibr, OpenVINS"]["gyroscope_noise_density"]
        assert to_si(of["KF-GINS"]["arw"], "deg/sqrt(h)") == pytest.approx(white)
        assert of["VINS-Mono, VINS-Fusion"]["gyr_n"] == pytest.approx(np.sqrt(2 * rate) * white)
        assert of["ROS sensor_msgs/Imu"]["angular_velocity_covariance"] == pytest.approx(rate * white**2)


@pytest.mark.parametrize("method", ["indirect_full", "likelihood"])
def test_efficient_methods_come_near_the_bound_with_honest_intervals(method):
    found = read("monte_carlo")
    known = found[(found["method"] == method) & (found["bound"] < 0.2)]
    assert len(known) > 6
    spread = 3.5 / np.sqrt(2 * known["runs"])  # of a root mean square of normal errors, at the worst of a dozen
    assert (known["efficiency"] < 1.1 * (1 + spread)).all()
    assert (known["efficiency"] > 0.9 * (1 - spread)).all()
    assert (known["coverage_high"] > 0.92).all()
    assert (known["coverage_low"] < 0.98).all()


def test_a_random_walk_that_cannot_be_known_is_not_given_as_certain():
    found = read("monte_carlo")
    hidden = found[(found["parameter"] == "density_k") & (found["bound"] > 0.8)]
    assert (hidden["identified"] < 0.8).all()


def test_every_fit_of_the_peer_is_reached():
    if "adis16405" not in devices():
        pytest.skip("the files of adis16405 are not here")
    fits = read("peers")
    assert (fits["here"] <= fits["minimum"] * (1 + 1e-6)).all()


@pytest.mark.parametrize("device", devices())
def test_samples_of_the_continuous_models_have_the_allan_deviation_of_their_spectra(device):
    curves = pd.read_csv(ROOT / f"results/{device}/tutorial/allan.csv").dropna()
    short = curves[curves["tau"] < curves["tau"].max() / 250]
    apart = np.log(short["mean"] / short["deviation"]).abs()
    assert apart.median() < 0.01
    assert apart.max() < 0.1


def test_laws_that_are_there_are_read_more_often_than_those_that_are_not():
    rates = read("false_readings").groupby("there")["rate"].mean()
    assert rates[False] < 0.02
    assert rates[True] > 0.5


@pytest.mark.parametrize("device", devices("missing_of"))
def test_what_is_missing_lies_in_its_intervals_and_simulations_are_one_scatter_apart(device):
    effects = read(f"missing_effects_{device}").dropna(subset=["low", "high"])
    assert ((effects["low"] <= effects["value"]) & (effects["value"] <= effects["high"])).all()
    apart = read(f"missing_distances_{device}").set_index("distance")
    assert apart.loc["distribution", "floor_value"].between(0.8, 1.2).all()
    assert apart["floor_value"].between(0.5, 1.5).all()


def drives():
    return read("drive_schemes").groupby(["case", "scheme"])


def test_the_plain_filter_of_the_simulated_drives_knows_itself():
    """NIS over its degrees of freedom: each drive has thousands; NEES: some ten independent pieces of a drive."""
    clean = drives().get_group(("clean", "none"))
    runs = clean["run"].nunique()
    assert abs(clean["nis"].mean() - 1) < 4 * np.sqrt(2 / (5000 * runs))
    assert abs(clean["nees"].mean() - 1) < 4 * np.sqrt(2 / (9 * 10 * runs))


def test_control_is_worth_more_than_none_and_less_than_an_oracle():
    middle = drives()["horizontal_95"].mean()["contaminated"]
    for scheme in ("remove", "robust", "gated", "reset"):
        assert middle["oracle"] < middle[scheme] < middle["none"]
    assert 0.7 * middle["oracle"] < middle["separation"] < 1.3 * middle["oracle"]
    assert middle["separation"] < 0.6 * middle["reset"]


def test_wheels_help_most_where_fixes_are_lacking():
    middle = drives()["horizontal_95"].mean()
    gains = {
        case: middle[case, "separation, wheels"] / middle[case, "separation"] for case in ("clean", "outage alone")
    }
    assert gains["outage alone"] < gains["clean"] < 1.0


def test_separation_doubts_where_there_is_cause_and_nowhere_else():
    doubts, resets = (drives()[name].mean() for name in ("doubts", "resets"))
    assert doubts["clean", "separation"] < 0.5 < doubts["contaminated", "separation"]
    assert resets["lost", "separation"] > 0.5 > resets["lost", "gated"]


def test_control_costs_little_where_nothing_is_wrong():
    middle = drives()["horizontal_95"].mean()["clean"].drop(["smoothed", "smoothed, wheels"])
    rolling = middle.index.str.endswith(", wheels")
    for of, none in ((middle[~rolling], "none"), (middle[rolling], "none, wheels")):
        assert (of / of[none]).between(0.97, 1.1).all()
    false = drives()["false"].mean()["clean"]
    assert false[["remove", "robust"]].between(0.0020, 0.0034).all()


def test_a_hidden_effect_is_named_and_where_there_is_none_it_is_not():
    found = read("drive_hidden")
    nothing = found["hidden"] == "nothing"
    assert (found["named"] == found["hidden"])[~nothing].mean() > 0.8
    assert (found["named"] != "nothing")[nothing].mean() < 0.2


def test_the_drift_of_the_tuned_model_on_the_recorded_drive_is_of_the_predicted_size():
    path = ROOT / "paper/numbers/drive_car.json"
    if not path.exists():
        pytest.skip("the files of rtklibexplorer_drive are not here")
    drift = json.loads(path.read_text())["drift"]
    assert 0.33 < float(drift["tuned"]["ratio"]) < 3
    assert float(drift["tuned"]["rms_m"]) < float(drift["rest"]["rms_m"])


def test_restoration_compensates_a_walk_by_no_more_than_its_bias():
    """A drawn turn-on bias adds to that of the device: over devices it is no better than the bias alone."""
    found = read("compensation").set_index("contender")
    for quantity in ("position", "heading"):
        assert found.loc["restoration", f"{quantity}_excess_high"] > 0
        assert found.loc["none", f"{quantity}_mean"] > 5 * found.loc["bias_only", f"{quantity}_mean"]
        assert found.loc["stand", f"{quantity}_mean"] < found.loc["bias_only", f"{quantity}_mean"]


def test_a_filter_that_knows_of_turn_on_biases_ends_near_and_believes_itself():
    found = read("compensation_inside").set_index("contender")
    for name in ("white_turn_on", "restoration", "nbk", "fitted", "truth"):
        assert found.loc[name, "position"] < 0.5 * found.loc["white", "position"]
        assert 0.1 < found.loc[name, "heading_nees"] < 3
    assert found.loc["white", "heading_nees"] > 10


def test_every_real_walk_ends_within_a_hundredth_of_its_distance():
    """The bars of the study: half a per cent in the median, one per cent on each."""
    walks = read_of_walks("walks")
    assert walks["share"].median() < 0.5
    assert walks["share"].max() < 1.0
    strides = walks[walks["dataset"] == "gaitmap_2x20m"]
    assert (strides[["stride_rmse", "stride_rmse_plain"]] < 0.049).all().all()


def test_each_error_of_a_device_has_a_place_in_the_budget_of_every_walk():
    budget = read("walk_budget")
    none = budget[budget["triad"] == "none"].set_index("set")
    for name, one in budget.groupby("set"):
        single = one[~one["triad"].isin(["all", "none"])]
        assert len(single) == 13
        assert none.loc[name, "horizontal"] < single["horizontal"].max()


def test_a_filter_whose_assumptions_hold_has_ellipses_that_hold_the_end():
    found = read("walk_consistency").set_index("foot")
    for level in (0.9, 0.99):
        assert found.loc["as assumed", f"low_{level:g}"] <= level <= found.loc["as assumed", f"high_{level:g}"]
        assert found.loc["slipping", f"high_{level:g}"] >= level


def test_what_real_walks_name_is_significant_and_the_rest_is_not():
    found = read_of_walks("walk_missing")
    alpha = found.loc[found["named"], "p_value"].max()
    assert (found.loc[~found["named"], "p_value"] > alpha).all()
    named = found[found["named"]]
    assert ((named["low"] < named["value"]) & (named["value"] < named["high"])).all()
    assert (found["by"] == "named").sum() >= found["dataset"].nunique()


def test_ends_are_foretold_by_every_twin_alike():
    scores = read_of_walks("walk_foretold").set_index("by")
    assert scores["walks"].nunique() == 1
    assert set(scores.index) == {"at rest", "data sheet", "named", "other sets"}
    for quantity in ("horizontal", "height", "space"):
        assert scores.loc["at rest", f"{quantity}_gap"] == 0
        assert np.allclose(scores[quantity] - scores.loc["at rest", quantity], scores[f"{quantity}_gap"])
        assert (scores[f"{quantity}_0.5"] <= scores[f"{quantity}_0.9"]).all()
        assert scores[quantity].between(0, 0.5).all()


def test_settings_chosen_on_other_sets_do_about_as_well():
    found = read("walk_settings")
    if found.empty:
        pytest.skip("fewer than two walking sets are here")
    assert (found["with_best"] <= found[["with_chosen", "with_usual"]].min(axis=1)).all()
    assert (found["with_chosen"] / found["with_usual"]).median() < 1.1


def test_hidden_effects_are_named_with_the_exact_reference_and_nothing_is_not():
    found = read("walk_hidden").set_index("case")
    assert found.loc["nothing", "exact_right"]
    assert found.loc[found["there"], "exact_right"].mean() > 0.7


@pytest.mark.parametrize("name", device_models.names())
def test_a_device_model_that_is_shipped_is_what_the_workflow_makes(name):
    made = ROOT / f"results/devices/{name}/card.yaml"
    if not made.exists():
        pytest.skip("the rule device_models has not been run here")
    fresh, kept = yaml.safe_load(made.read_text()), dict(device_models.read(name).content)
    if fresh["made_by"] != kept["made_by"]:
        pytest.skip("made with other settings, such as those of a quick pass")
    assert numbers_of(fresh) == pytest.approx(numbers_of(kept), rel=1e-4)
    assert texts_of(fresh) == texts_of(kept)


def numbers_of(value):
    """Return all numbers of plain data, in order."""
    if isinstance(value, dict | list):
        return [number for one in (value.values() if isinstance(value, dict) else value) for number in numbers_of(one)]
    return [value] if isinstance(value, int | float) else []


def texts_of(value):
    """Return plain data with every number as none."""
    if isinstance(value, dict):
        return {key: texts_of(one) for key, one in value.items()}
    if isinstance(value, list):
        return [texts_of(one) for one in value]
    return None if isinstance(value, int | float) else value

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from imugap.kinematics import strapdown
from imugap.study.static import he2023
from imugap.units import STANDARD_GRAVITY, from_si, to_si

PUBLISHED = Path(__file__).parents[3] / "data" / "published"
NAMES = ("table1_performance_indices", "table2_static_navigation", "table3_pedestrian_compensation")
RATES = {"method_a": 1.0, "method_b": 0.8, "restoration": 0.2}


@pytest.fixture(scope="module")
def printed():
    return tuple(pd.read_csv(PUBLISHED / f"he2023_{name}.csv") for name in NAMES)


@pytest.fixture(scope="module")
def findings(printed):
    return he2023.findings(*printed).set_index("check")


@pytest.fixture(scope="module")
def sound():
    """Tables of a device whose printed numbers all follow from one another."""
    seconds, rate = 60.0, 100.0
    bias = np.array([*to_si(np.array([199.08, 414.0, 1032.12]), "deg/h"), *to_si(np.array([4.4, 1.4, 3.5]), "mg")])
    units = ["deg/h"] * 3 + ["g"] * 3
    walk_units = ["deg/sqrt(h)"] * 3 + ["m/s/sqrt(h)"] * 3
    table1 = pd.DataFrame({"sensor": ["gyro"] * 3 + ["accel"] * 3, "axis": list("xyz") * 2, "bias_unit": units})
    table1["bias"] = [from_si(value, unit) for value, unit in zip(bias, units, strict=True)]
    table1["random_walk"], table1["random_walk_unit"] = 0.01, walk_units
    floor = [to_si(0.01, unit) for unit in walk_units]
    table1["bias_stability_1s"] = [1.2 * from_si(v, unit) for v, unit in zip(floor, units, strict=True)]
    table1["bias_stability_unit"], table1["repeatability"] = units, 1.0
    samples = np.tile(bias - [0, 0, 0, 0, 0, STANDARD_GRAVITY], (int(seconds * rate) + 1, 1))
    local = strapdown.Local(STANDARD_GRAVITY)
    end = strapdown.navigate(samples[:, :3], samples[:, 3:], 1 / rate, strapdown.NavigationState(), local)[-1]
    final = {"east_position": abs(end[1]), "north_position": abs(end[0]), "heading": np.rad2deg(abs(end[8]))}
    rows = []
    for k, (name, drift) in enumerate(final.items()):
        share = {method: 0.03 * (k + 1) * value for method, value in RATES.items()}
        rows.append({"quantity": f"max_abs_{name}_error"} | {m: s * drift for m, s in share.items()})
        rows.append({"quantity": f"max_rel_{name}_error"} | {m: 100 * s for m, s in share.items()})
    turned = float(np.rad2deg(bias[2] * 189.0))
    walk = {"uncompensated": turned, "method_a": turned / 2, "method_b": turned / 4, "restoration": 0.005}
    reduced = {key: 100 * (1 - value / turned) for key, value in walk.items() if key != "uncompensated"}
    table3 = pd.DataFrame(
        [{"quantity": f"end_{what}_error"} | walk for what in ("position", "heading")]
        + [{"quantity": f"end_{what}_error_reduction"} | reduced for what in ("position", "heading")]
    )
    return table1, pd.DataFrame(rows), table3


def only(findings, *words):
    """The one finding whose check has all the words."""
    hits = findings[[all(word in check for word in words) for check in findings.index]]
    assert len(hits) == 1, list(hits.index)
    return hits.iloc[0]


@pytest.mark.parametrize(("axis", "stability", "floor"), [("y", "24.26", "32.80"), ("z", "28.07", "38.58")])
def test_accelerometers_y_and_z_are_printed_below_their_floor(findings, axis, stability, floor):
    """methods.md section 1: 24.26 ug and 28.07 ug below the floors 32.80 ug and 38.58 ug."""
    row = only(findings, f"accel {axis}")
    assert not row["consistent"]
    assert (row["printed"], row["implied"]) == (f"{stability} µg", f"≥ {floor} µg")


@pytest.mark.parametrize("axis", ["gyro x", "gyro y", "gyro z", "accel x"])
def test_the_other_axes_are_printed_above_their_floor(findings, axis):
    assert only(findings, axis)["consistent"]


def test_repeatability_is_missing(findings):
    assert not only(findings, "repeatability")["consistent"]


def test_north_of_the_restoration_is_divided_by_the_east_drift(findings):
    row = only(findings, "north", "restoration", "divisor")
    assert not row["consistent"]
    assert (row["printed"], row["implied"]) == ("765.41 m", "east: 765.45 m")
    assert not only(findings, "north", "restoration", "against that of the other")["consistent"]


def test_no_other_divisor_is_wrong(findings):
    drifts = findings[["final drift e_abs/e_rel" in check for check in findings.index]]
    assert len(drifts) == 9
    assert (~drifts["consistent"]).sum() == 1


def test_north_of_the_restoration_would_be_1_59_percent(printed):
    """methods.md section 1: 4.2549 m of the implied 267.6 m is 1.590 %."""
    north = he2023.final_drifts(printed[1]).loc["north"]
    assert north["method_a"] == pytest.approx(267.6, abs=0.05)
    assert 100 * 4.2549 / north["method_a"] == pytest.approx(1.590, abs=5e-4)


def test_position_and_heading_imply_lengths_that_differ_sevenfold(printed, findings):
    length = he2023.lengths(*printed[:2])
    assert length["horizontal"] == pytest.approx(62.2, abs=0.3)
    assert length["heading"] == pytest.approx(8.8, abs=0.1)
    row = only(findings, "length of the static navigation")
    assert not row["consistent"]
    assert (row["printed"], row["implied"]) == ("62 s", "8.8 s")


def test_restoration_leaves_a_heading_error_that_its_own_mean_would_remove(findings, printed):
    """The printed 54.20 deg at the printed bias of 1032.12 deg/h take 189 s; 3 ARW sqrt(189 s) is all that is left."""
    row = only(findings, "walk: heading error after restoration")
    assert not row["consistent"]
    gyro = printed[0].query("sensor == 'gyro' and axis == 'z'").iloc[0]
    assert (gyro["bias_unit"], gyro["random_walk_unit"]) == ("deg/h", "deg/sqrt(h)")
    hours = 54.20 / gyro["bias"]
    assert f"54.20° (in {3600 * hours:.0f} s)" in row.name
    assert 3600 * hours == pytest.approx(189, abs=0.5)
    assert (row["printed"], row["implied"]) == ("37.29°", f"≤ {3 * gyro['random_walk'] * np.sqrt(hours):.2f}°")


def test_printed_reductions_follow_from_the_printed_errors(findings):
    rows = findings[["reduction" in check for check in findings.index]]
    assert len(rows) == 6
    assert rows["consistent"].all()


def test_consistent_tables_give_no_inconsistency(sound):
    found = he2023.findings(*sound)
    assert list(found.loc[~found["consistent"], "check"]) == []
    assert len(found) == 25


def test_lengths_are_those_after_which_consistent_tables_were_computed(sound):
    assert he2023.lengths(*sound[:2]).to_list() == pytest.approx([60.0, 60.0], abs=0.11)


@pytest.mark.parametrize(
    ("table", "row", "column", "factor", "check"),
    [
        (0, 1, "bias_stability_1s", 0.8, "gyro y"),
        (0, 2, "bias", 1.5, "length of the static navigation"),
        (0, 2, "bias", 0.5, "length of the static navigation"),
        (1, 3, "method_b", 1.01, "north, method b"),
        (1, 5, "restoration", 0.99, "heading, restoration"),
        (2, 2, "method_a", 1.01, "position error: reduction by method a"),
        (2, 1, "restoration", 30.0, "walk: heading error after restoration"),
        (0, 2, "random_walk", 0.1, "walk: heading error after restoration"),
    ],
)
def test_one_wrong_number_is_found(sound, table, row, column, factor, check):
    tables = [each.copy() for each in sound]
    tables[table][column] = tables[table][column].astype(float)
    tables[table].loc[row, column] *= factor
    found = he2023.findings(*tables)
    assert any(check in text for text in found.loc[~found["consistent"], "check"])


def test_a_heading_that_drifts_so_far_leaves_no_walk_to_end_so_near(findings, printed):
    """Three metres in three minutes; and a path that is walked with that drift ends as far off as the formula says."""
    row = only(findings, "walk: way out and back")
    assert not row["consistent"]
    length, heading = float(row["implied"].removesuffix(" m")), np.deg2rad(54.203)
    time = np.linspace(0, 1, 20_001)
    steps = length * np.where(time < 0.5, 1, -1) * np.exp(1j * heading * time)
    assert abs(np.trapezoid(steps, time)) == pytest.approx(0.709, rel=0.02)

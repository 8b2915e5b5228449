"""Audit of the tables of He et al. (2023): consistency with one another and with physics.

Inputs are the printed tables as data frames (``data/published``); outputs are checks, each computed from them.
"""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from imugap.kinematics import strapdown
from imugap.units import STANDARD_GRAVITY, to_si

PERIOD_S = 1.0
"""Averaging period of the printed bias stability."""
ROUNDING = 2e-3
"""Relative difference within the printed digits, three in the shortest number."""
SLOWEST_M_PER_S = 0.3
"""Slowest walking speed."""
METHODS = ("method_a", "method_b", "restoration")


@dataclass(frozen=True)
class PrintedCheck:
    """One check: compared quantity, printed and implied value as text, and whether they are consistent."""

    check: str
    printed: str
    implied: str
    consistent: bool


def stability_against_floor(table1: pd.DataFrame) -> list[PrintedCheck]:
    """Compare the printed bias stability with the floor N/sqrt(P) that the printed white noise implies."""
    findings = []
    for row in table1.itertuples():
        stability = to_si(row.bias_stability_1s, row.bias_stability_unit)
        floor = to_si(row.random_walk, row.random_walk_unit) / np.sqrt(PERIOD_S)
        unit, shown = ("deg/h", "°/h") if row.sensor == "gyro" else ("ug", "µg")
        printed, implied = stability / to_si(1, unit), floor / to_si(1, unit)
        findings.append(
            PrintedCheck(
                f"{row.sensor} {row.axis}: bias stability at 1 s, at least the white-noise floor",
                f"{printed:.2f} {shown}",
                f"≥ {implied:.2f} {shown}",
                bool(stability >= floor),
            )
        )
    return findings


def final_drifts(table2: pd.DataFrame) -> pd.DataFrame:
    """Return the final measured drift that each printed pair of e_abs and e_rel implies, quantity by method."""
    values = table2.set_index("quantity")[list(METHODS)]
    absolute, relative = values.filter(like="_abs_", axis=0), values.filter(like="_rel_", axis=0)
    return pd.DataFrame(
        absolute.to_numpy() / relative.to_numpy() * 100, index=["east", "north", "heading"], columns=list(METHODS)
    )


def agreement_of_final_drifts(table2: pd.DataFrame) -> list[PrintedCheck]:
    """Check that all methods imply the same final drift, since the measured log is the same (within the rounding).

    Where one does not, say whether it is the final drift of another quantity, i.e. a wrong divisor.
    """
    drifts = final_drifts(table2)
    usual = drifts.median(axis=1)
    units = {"east": "m", "north": "m", "heading": "°"}
    results = []
    for (quantity, method), drift in drifts.stack().items():
        name, unit = method.replace("_", " "), units[quantity]
        check = f"{quantity}, {name}: final drift e_abs/e_rel, against that of the other methods"
        agrees = bool(abs(drift / usual[quantity] - 1) < ROUNDING)
        results.append(PrintedCheck(check, f"{drift:.2f} {unit}", f"{usual[quantity]:.2f} {unit}", agrees))
        twins = [other for other in usual.index if not agrees and abs(drift / usual[other] - 1) < ROUNDING]
        for twin in twins:
            check = f"{quantity}, {name}: the divisor of e_rel is the final drift of the quantity itself, not {twin}"
            results.append(
                PrintedCheck(check, f"{drift:.2f} {unit}", f"{twin}: {usual[twin]:.2f} {units[twin]}", False)
            )
    return results


def lengths(table1: pd.DataFrame, table2: pd.DataFrame) -> pd.Series:
    """Return the navigation lengths [s] after which the printed biases alone drift as far as table 2 implies.

    Horizontal distance and heading are taken, which the unknown initial heading does not change. NaN where the drift is
    not reached within an hour.
    """
    bias = [to_si(row.bias, row.bias_unit) for row in table1.itertuples()]
    rate, seconds = 100.0, 3600.0
    samples = np.tile(bias, (int(rate * seconds), 1)) - [0, 0, 0, 0, 0, STANDARD_GRAVITY]
    mechanisation = strapdown.Local(STANDARD_GRAVITY)
    path = strapdown.navigate(samples[:, :3], samples[:, 3:], 1 / rate, strapdown.NavigationState(), mechanisation, 10)
    final = final_drifts(table2).median(axis=1)
    reached = {
        "horizontal": np.hypot(path[:, 0], path[:, 1]) >= np.hypot(final["east"], final["north"]),
        "heading": np.abs(np.unwrap(path[:, 8])) >= np.deg2rad(final["heading"]),
    }
    return pd.Series({name: np.argmax(hit) * 10 / rate if hit.any() else np.nan for name, hit in reached.items()})


def agreement_of_lengths(table1: pd.DataFrame, table2: pd.DataFrame) -> PrintedCheck:
    """Check that position and heading imply the same length of the static navigation."""
    length = lengths(table1, table2)
    return PrintedCheck(
        "length of the static navigation that the printed biases imply, from position and from heading",
        f"{length['horizontal']:.0f} s",
        f"{length['heading']:.1f} s",
        bool(0.8 < length["heading"] / length["horizontal"] < 1.25),
    )


def heading_of_walk(table1: pd.DataFrame, table3: pd.DataFrame) -> PrintedCheck:
    """Compare the heading error after restoration with what can be left once the printed z-gyro bias is taken off.

    The length of the walk is not printed; it is taken as the time in which that bias alone makes the uncompensated
    error. What is left without the bias is then the angle random walk, of which three standard deviations are allowed.
    """
    gyro_z = table1[(table1["sensor"] == "gyro") & (table1["axis"] == "z")].iloc[0]
    heading = table3.set_index("quantity").loc["end_heading_error"]
    length = np.deg2rad(heading["uncompensated"]) / to_si(gyro_z["bias"], gyro_z["bias_unit"])
    left = 3 * np.rad2deg(to_si(gyro_z["random_walk"], gyro_z["random_walk_unit"]) * np.sqrt(length))
    return PrintedCheck(
        "walk: heading error after restoration, whose mean term takes the z-gyro bias off, if this bias made the "
        f"uncompensated {heading['uncompensated']:.2f}° (in {length:.0f} s)",
        f"{heading['restoration']:.2f}°",
        f"≤ {left:.2f}°",
        bool(heading["restoration"] <= left),
    )


def position_of_walk(table1: pd.DataFrame, table3: pd.DataFrame) -> PrintedCheck:
    """Compare the uncompensated position error with that which the uncompensated heading error makes of a walk.

    On a walk out and back of length s, at an even pace, with a heading that drifts evenly to psi, the end is off by
    ``4 s sin^2(psi/4)/psi``: the integral of ``exp(i psi t)`` over the way out less that over the way back. The time is
    that in which the printed z-gyro bias makes the heading error.
    """
    gyro_z = table1[(table1["sensor"] == "gyro") & (table1["axis"] == "z")].iloc[0]
    walk = table3.set_index("quantity")["uncompensated"]
    heading = np.deg2rad(walk["end_heading_error"])
    seconds = heading / to_si(gyro_z["bias"], gyro_z["bias_unit"])
    length = walk["end_position_error"] * heading / (4 * np.sin(heading / 4) ** 2)
    return PrintedCheck(
        f"walk: way out and back in {seconds:.0f} s that ends so far off if the heading drifts evenly to "
        f"{walk['end_heading_error']:.2f}°",
        f"{walk['end_position_error']:.3f} m off",
        f"{length:.1f} m",
        bool(length / seconds > SLOWEST_M_PER_S),
    )


def reductions(table3: pd.DataFrame) -> list[PrintedCheck]:
    """Recompute the printed reductions of table 3."""
    rows = table3.set_index("quantity")
    findings = []
    for quantity in ("end_position_error", "end_heading_error"):
        value, printed = rows.loc[quantity], rows.loc[f"{quantity}_reduction"]
        for method in METHODS:
            implied = 100 * (1 - value[method] / value["uncompensated"])
            findings.append(
                PrintedCheck(
                    f"table 3, {quantity.replace('_', ' ')}: reduction by {method.replace('_', ' ')}",
                    f"{printed[method]:.3f} %",
                    f"{implied:.3f} %",
                    bool(abs(printed[method] - implied) < 0.1),
                )
            )
    return findings


def findings(table1: pd.DataFrame, table2: pd.DataFrame, table3: pd.DataFrame) -> pd.DataFrame:
    """Return every finding as a table, columns ``check``, ``printed``, ``implied``, ``consistent``."""
    repeatability = "repeatability" in " ".join(table1.columns)
    everything = [
        *stability_against_floor(table1),
        PrintedCheck("bias repeatability, which eq. 14 draws from", "not printed", "needed", repeatability),
        *agreement_of_final_drifts(table2),
        agreement_of_lengths(table1, table2),
        heading_of_walk(table1, table3),
        position_of_walk(table1, table3),
        *reductions(table3),
    ]
    return pd.DataFrame([vars(finding) for finding in everything])

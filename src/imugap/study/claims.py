"""Published claims of He et al. (2023) against the results of the study, each with the rule of its verdict."""

from collections.abc import Mapping, Sequence

import pandas as pd

from imugap.interchange.from_indices import SOURCE
from imugap.kinematics.free_inertial import QUANTITIES
from imugap.study import verdicts
from imugap.study.static.rankings import share_interval
from imugap.workflow import tables

RELIABLE, LIKELY = 0.9, 0.5
"""Share of five-trial tables above which a result is called reliable, or likely."""
ORDER_OF_MAGNITUDE = 10.0
CLEARLY_SMALLER = 0.95
"""Ratio of two median errors below which the first is called smaller."""


def reliability(intervals: Sequence[verdicts.Interval]) -> str:
    """Judge the shares of five-trial tables that show a result by their 95 % intervals, one for each quantity."""
    if all(verdicts.side(one, RELIABLE) > 0 for one in intervals):
        return "reliable"
    if all(verdicts.side(one, LIKELY) > 0 for one in intervals):
        return "likely, not shown to be reliable"
    if all(verdicts.side(one, LIKELY) < 0 for one in intervals):
        return "unlikely"
    return "not decided"


RELIABILITY = (
    f"by the 95 % intervals of all three: reliable above {100 * RELIABLE:.0f} %, likely above {100 * LIKELY:.0f} %, "
    f"unlikely below {100 * LIKELY:.0f} %; else not decided"
)


def smallest(five: pd.DataFrame) -> int:
    """Count the quantities, absolute and relative, in which restoration has the smallest error of the three."""
    means = five[five["runs"] == "1"].pivot(index="contender", columns="quantity", values=["e_abs", "e_rel"])
    return int((means.loc[list(SOURCE)].idxmin() == "restoration").sum())


def gain(five: pd.DataFrame) -> pd.Series:
    """Return the smaller error of methods A and B over that of restoration, per quantity."""
    means = five[five["runs"] == "1"].pivot(index="contender", columns="quantity", values="e_abs")
    return means.loc[["method_a", "method_b"]].min() / means.loc["restoration"]


def best(scores: pd.DataFrame, column: str) -> pd.Series:
    """Name the contender with the smallest score per quantity."""
    return scores.loc[scores.groupby("quantity", sort=False)[column].idxmin()].set_index("quantity")["contender"]


def printed_gain(static: pd.DataFrame) -> pd.Series:
    """Return the ratio of :func:`gain` from the printed table 2."""
    rows = static[static["quantity"].str.contains("_abs_")]
    return rows[["method_a", "method_b"]].min(axis=1) / rows["restoration"]


def of_device(
    device: str,
    five: pd.DataFrame,
    ranking: pd.DataFrame,
    scores: pd.DataFrame,
    static: pd.DataFrame,
    horizon: float,
    titles: Mapping[str, str],
) -> list[dict[str, str]]:
    """Judge the claims that the static comparison of one device can judge, at one navigation length, raw start.

    ``titles`` names the models for the reader.
    """
    at = ranking[(ranking["start"] == "raw") & (ranking["horizon"] == horizon)].set_index("quantity")
    shares = {name: at.loc[name, "restoration"] for name in QUANTITIES}
    intervals = {name: share_interval(share, int(at.loc[name, "tables"])) for name, share in shares.items()}
    raw = scores[(scores["start"] == "raw") & (scores["horizon"] == horizon)]
    gains, wins = gain(five), smallest(five)
    leaders, proper = best(raw, "median_e_abs"), best(raw, "crps")
    relative = raw.pivot(index="contender", columns="quantity", values="median_e_abs")
    ratio = (relative.loc["restoration"] / relative.loc["bias_only"])[list(QUANTITIES)]
    return [
        {
            "claim": "restoration has the smallest error of the three methods, in all six columns",
            "published": "6 of 6",
            "device": device,
            "here": f"{wins} of 6",
            "rule": "seen: 6 of 6 in the five-trial table of the first run",
            "verdict": "seen in this draw" if wins == 6 else "not seen in this draw",
        },
        {
            "claim": "a five-trial table shows it (share of tables with restoration first [%])",
            "published": "—",
            "device": device,
            "here": " / ".join(tables.share(shares[name], intervals[name]) for name in QUANTITIES),
            "rule": RELIABILITY,
            "verdict": reliability(list(intervals.values())),
        },
        {
            "claim": "its error is an order of magnitude smaller (best of the others over restoration)",
            "published": " / ".join(f"{value:.1f}" for value in printed_gain(static)),
            "device": device,
            "here": " / ".join(f"{gains[quantity]:.2f}" for quantity in QUANTITIES),
            "rule": f"holds: ≥ {ORDER_OF_MAGNITUDE:g} in all three, five trials of the first run",
            "verdict": "holds" if gains.min() >= ORDER_OF_MAGNITUDE else "does not hold",
        },
        {
            "claim": "it does so by its noise model (its median error over that of a bare constant bias)",
            "published": "—",
            "device": device,
            "here": " / ".join(f"{ratio[quantity]:.2f}" for quantity in QUANTITIES),
            "rule": f"holds: < {CLEARLY_SMALLER:g} in all three, all trials and runs",
            "verdict": "holds" if ratio.max() < CLEARLY_SMALLER else "does not hold",
        },
        {
            "claim": "the smallest error marks the model closest to the device (best by e_abs; best by CRPS)",
            "published": "—",
            "device": device,
            "here": "; ".join(
                " / ".join(titles[name] for name in found[list(QUANTITIES)]) for found in (leaders, proper)
            ),
            "rule": "holds: both scores have the same best model in all three",
            "verdict": "holds" if (leaders == proper).all() else "does not hold",
        },
    ]


def of_walk(ends: pd.DataFrame, printed: pd.DataFrame) -> dict[str, str]:
    """Judge the claim that restoration improves a walk, against the bias that is in it."""
    one = ends.set_index("contender").loc["restoration"]
    units = {"position": "m", "heading": "°"}
    sides = [verdicts.side((one[f"{quantity}_excess_low"], one[f"{quantity}_excess_high"])) for quantity in units]
    differences = [
        tables.interval(*(one[f"{quantity}_excess{end}"] for end in ("", "_low", "_high"))) + f" {unit}"
        for quantity, unit in units.items()
    ]
    gains = (printed.loc[f"end_{quantity}_error_reduction", "restoration"] for quantity in units)
    verdict = "does harm" if max(sides) > 0 else "holds" if max(sides) < 0 else "not decided"
    return {
        "claim": "subtracted from the log of a walk it reduces the end error (excess over that of its bias alone)",
        "published": " / ".join(f"{gain:.1f} % less" for gain in gains),
        "device": "simulated walk",
        "here": " / ".join(differences),
        "rule": "holds: both 95 % intervals below 0; does harm: one of them above 0; else not decided",
        "verdict": verdict,
    }

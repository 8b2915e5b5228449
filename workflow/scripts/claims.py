"""Confront the published claims with the results here."""

import pandas as pd

from imugap.interchange.from_indices import SOURCE
from imugap.kinematics.free_inertial import QUANTITIES
from imugap.workflow import tables
from imugap.workflow.job_log import journal


def smallest(five):
    """Count the quantities, absolute and relative, in which restoration has the smallest error of the three."""
    means = five[five["runs"] == "1"].pivot(index="contender", columns="quantity", values=["e_abs", "e_rel"])
    return int((means.loc[list(SOURCE)].idxmin() == "restoration").sum())


def gain(five):
    """Return by how much restoration's error is below the smaller of A's and B's, per quantity."""
    means = five[five["runs"] == "1"].pivot(index="contender", columns="quantity", values="e_abs")
    return means.loc[["method_a", "method_b"]].min() / means.loc["restoration"]


def best(scores, column, horizon):
    """Name the contender with the smallest score per quantity, for the raw start."""
    one = scores[(scores["start"] == "raw") & (scores["horizon"] == horizon)]
    return one.loc[one.groupby("quantity", sort=False)[column].idxmin()].set_index("quantity")["contender"]


def printed_gain(static):
    """Return the same gain from the printed table 2."""
    rows = static[static["quantity"].str.contains("_abs_")]
    return rows[["method_a", "method_b"]].min(axis=1) / rows["restoration"]


def of_device(device, five, ranking, scores, static, horizon):
    """Judge the claims that the static comparison of one device can judge."""
    gains, printed = gain(five), printed_gain(static)
    at = ranking[(ranking["start"] == "raw") & (ranking["horizon"] == horizon)].set_index("quantity")["restoration"]
    wins = smallest(five)
    chances = " / ".join(f"{100 * at[quantity]:.0f} %" for quantity in QUANTITIES)
    leaders = best(scores, "median_e_abs", horizon)
    proper = best(scores, "crps", horizon)
    raw = scores[(scores["start"] == "raw") & (scores["horizon"] == horizon)]
    relative = raw.pivot(index="contender", columns="quantity", values="median_e_abs")
    ratio = (relative.loc["restoration"] / relative.loc["bias_only"])[list(QUANTITIES)]
    return [
        {
            "claim": "restoration has the smallest error of the three methods, in all six columns",
            "published": "6 of 6",
            "device": device,
            "here": f"{wins} of 6",
            "verdict": "seen in this draw" if wins == 6 else "not seen in this draw",
        },
        {
            "claim": "a five-trial table shows it (chance that it ranks restoration first: east / north / heading)",
            "published": "—",
            "device": device,
            "here": chances,
            "verdict": "reliable" if at.min() > 0.95 else "depends on the draw",
        },
        {
            "claim": "its error is an order of magnitude smaller (best of the others over restoration)",
            "published": " / ".join(f"{value:.1f}" for value in printed),
            "device": device,
            "here": " / ".join(f"{gains[quantity]:.2f}" for quantity in QUANTITIES),
            "verdict": "holds" if gains.min() >= 10 else "does not hold",
        },
        {
            "claim": "it does so by its noise model (its median error over that of a bare constant bias)",
            "published": "—",
            "device": device,
            "here": " / ".join(f"{ratio[quantity]:.2f}" for quantity in QUANTITIES),
            "verdict": "holds" if ratio.max() < 0.95 else "does not hold",
        },
        {
            "claim": "the smallest error marks the model closest to the device (best by e_abs; best by proper score)",
            "published": "—",
            "device": device,
            "here": "; ".join(
                ", ".join(dict.fromkeys(found[list(QUANTITIES)])).replace("_", " ") for found in (leaders, proper)
            ),
            "verdict": "holds" if (leaders == proper).all() else "does not hold",
        },
    ]


def of_walk(ends, printed):
    """Judge the claim that restoration compensates a walk, against the bias that is in it."""
    one = ends.set_index("contender").loc["restoration"]
    units = {"position": "m", "heading": "°"}
    gaps = [
        tables.interval(*(one[f"{quantity}_excess{end}"] for end in ("", "_low", "_high"))) + f" {unit}"
        for quantity, unit in units.items()
    ]
    better = all(one[f"{quantity}_excess_high"] < 0 for quantity in units)
    gains = (printed.loc[f"end_{quantity}_error_reduction", "restoration"] for quantity in units)
    return {
        "claim": "subtracted from the log of a walk it mends the end (error at the end over that of its bias alone)",
        "published": " / ".join(f"{gain:.1f} % less" for gain in gains),
        "device": "simulated walk",
        "here": " / ".join(gaps),
        "verdict": "holds" if better else "does not hold",
    }


if __name__ == "__main__":
    with journal(snakemake.log[0]):
        source, params = snakemake.input, snakemake.params
        static = pd.read_csv(source.static)
        results = ([pd.read_csv(path) for path in paths] for paths in (source.five, source.ranking, source.scores))
        frames = zip(params.devices, *results, strict=True)
        rows = [row for frame in frames for row in of_device(*frame, static, params.table_horizon_s)]
        published = pd.read_csv(source.walk).set_index("quantity")
        rows += [of_walk(pd.read_csv(path), published) for path in source.compensation]
        data = pd.DataFrame(rows)
        tables.write(snakemake.output[0].removesuffix(".csv"), data, data)

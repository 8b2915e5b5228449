"""Draw and tabulate the scores of the blind benchmark, and write what the text says of them."""

import json
from pathlib import Path

import pandas as pd

from imugap import figures, tables
from imugap.blind import STOCHASTIC
from imugap.figures import AXIS_TITLES
from imugap.figures import blind as drawn
from imugap.journal import journal

ALARMS = {"name": "nothing hidden: a name", "place": "nothing hidden: a place only", "any": "nothing hidden: any alarm"}
NAMINGS = {
    ("static", "top1"): "one effect, at rest: its name",
    ("static", "top3"): "one effect, at rest: its name among three",
    ("static", "axes"): "one effect, at rest: its name and axes",
    ("motion", "top1"): "one effect, in motion: its name",
    ("motion", "top3"): "one effect, in motion: its name among three",
    ("motion", "axes"): "one effect, in motion: its name and axes",
    ("pair", "both"): "two effects: both names",
    ("unknown", "abstained"): "effect without a name: a place, no name",
    ("unknown", "no_name"): "effect without a name: no name",
}
WHOLES = {"all that it has": "all that gmwm has a term for", "all that it has not": "all that it has none for"}
CLOSED = {
    "distance": "one effect: distribution reaches the floor",
    "navigation_distance": "one effect: drift reaches it",
}


def rates(scores):
    """Return all rates in one table: false alarms, names, truth in its interval, distance at the floor."""
    naming = [NAMINGS[one.group, one.score] for one in scores["naming"].itertuples(index=False)]
    parts = [
        scores["false_alarms"].assign(title=scores["false_alarms"]["alarm"].map(ALARMS)),
        scores["naming"].assign(title=naming),
        scores["coverage"].head(1).assign(title="named effects: truth in the interval of a parameter"),
        scores["closed"].assign(title=scores["closed"]["distance"].map(CLOSED)),
    ]
    return pd.concat(parts, ignore_index=True)[["title", "count", "rate", "low", "high"]]


def rate(one):
    """Show a rate with its interval in per cent."""
    return f"{100 * one.rate:.0f} % [{100 * one.low:.0f}, {100 * one.high:.0f}]" if one.count else "—"


def detection_page(detection):
    """Lay out how many were named and found of how many, a row per name and a column per size."""
    hits = detection.assign(hits=(detection["rate"] * detection["count"]).round().astype(int))
    wide = hits.pivot(index=["name", "size"], columns="score")
    cells = (
        wide["hits"]["named"].astype(str) + " | " + wide["hits"]["detected"].astype(str)
        + " | " + wide["count"]["named"].astype(str)
    )  # fmt: skip
    page = cells.unstack("size", fill_value="")
    page.columns = [f"{size:g}" for size in page.columns]
    return page.rename_axis("hidden").rename(lambda name: name.replace("_", " ")).reset_index()


def coverage_page(coverage):
    """Lay out median error and share of intervals that hold the truth, a row per parameter."""
    return pd.DataFrame({
        "effect": coverage["name"].str.replace("_", " "),
        "parameter": coverage["parameter"].str.replace("_", " "),
        "intervals": coverage["count"],
        "median error [half widths]": coverage["error"].map(tables.number),
        "hold the truth": [rate(one) for one in coverage.itertuples(index=False)],
    })  # fmt: skip


def calibration_page(calibration):
    """Lay out the share of p-values up to each level, a row per view."""
    shown = calibration.assign(shown=[rate(one) for one in calibration.itertuples(index=False)])
    page = shown.pivot(index=["view", "count"], columns="level", values="shown")
    page.columns = [f"p ≤ {level:g}" for level in page.columns]
    return page.rename(lambda view: drawn.TITLES.get(view, view), level="view").reset_index()


def beside_page(beside):
    """Lay out how often each name is given rightly, and what gmwm calls it."""
    return pd.DataFrame({
        "hidden": beside["name"].replace(WHOLES).str.replace("_", " "),
        "gmwm's term": beside["term"].fillna("—"),
        "clear cases": beside["count"],
        "rightly named by discovery": [rate(one) for one in beside.itertuples(index=False)],
    })  # fmt: skip


def peer_page(peer):
    """Lay out what gmwm chose for the axes on which it was run."""
    return pd.DataFrame({
        "axis": peer["axis"].map(AXIS_TITLES),
        "compositions tried": peer["candidates"],
        "chosen": peer["chosen"],
        "p of its test of fit": peer["gof_p"].map(tables.number),
        "best p of all tried": peer["best_gof_p"].map(tables.number),
        "time [s]": peer["seconds"].map(tables.number) + " (" + peer["clock"] + ")",
    })  # fmt: skip


def numbers(scores, seconds, clear_size):
    """Return what the text says."""
    cases = scores["cases"]
    alarm = scores["false_alarms"].set_index("alarm").loc["name"]
    reached = scores["closed"].set_index("distance").loc["distance"]
    return {
        "cases": len(cases),
        "kinds": cases["kind"].value_counts().reindex(["single", "pair", "nothing", "unknown"], fill_value=0).to_dict(),
        "motion": int(cases["motion"].sum()),
        "clear": f"{clear_size:g}",
        "false_names": f"{100 * alarm['rate']:.1f}",
        "false_names_high": f"{100 * alarm['high']:.1f}",
        "quiet": int(alarm["count"]),
        "shrunk": tables.number(reached["before"] / reached["after"], 2),
        "median_seconds": f"{seconds.median():.0f}",
        "longest_seconds": f"{seconds.max():.0f}",
        "stochastic": len(STOCHASTIC),
        "terms": int(scores["beside"]["term"].notna().sum()),
    }


if __name__ == "__main__":
    with journal(snakemake.log[0]):
        source, output, clear = snakemake.input, snakemake.output, snakemake.params.clear_size
        scores = {name: pd.read_csv(path) for name, path in source.items() if name != "code"}
        summary, confusion = rates(scores), scores["confusion"].set_index("hidden")
        clearly = scores["effects"].query("kind == 'single' and size >= @clear")["case"]
        cases = scores["cases"][scores["cases"]["case"].isin(clearly)]
        drawings = {
            "detection": drawn.detection(scores["detection"], clear),
            "confusion": drawn.confusion(confusion),
            "rates": drawn.rates(summary),
            "coverage": drawn.coverage(scores["parameters"], scores["coverage"]),
            "distances": drawn.distances(cases),
            "calibration": drawn.calibration(scores["p_values"]),
        }
        for name, figure in drawings.items():
            figures.save(figure, output[f"{name}_figure"])
        shown = pd.DataFrame({
            "score": summary["title"],
            "cases": summary["count"],
            "rate": [rate(one) for one in summary.itertuples(index=False)],
        })  # fmt: skip
        pages = {
            "rates": (summary, shown),
            "detection": (scores["detection"], detection_page(scores["detection"])),
            "coverage": (scores["coverage"], coverage_page(scores["coverage"])),
            "calibration": (scores["calibration"], calibration_page(scores["calibration"])),
            "beside": (scores["beside"], beside_page(scores["beside"])),
            "peer": (scores["peer"], peer_page(scores["peer"])),
        }
        for name, (data, page) in pages.items():
            tables.write(output[name].removesuffix(".csv"), data, page)
        said = numbers(scores, scores["run_time"]["seconds"], clear)
        Path(output.numbers).write_text(json.dumps(said, indent=1) + "\n")

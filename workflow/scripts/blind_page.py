"""Draw and tabulate the scores of the blind benchmark, and write what the text says of them."""

import pandas as pd

from imu_benchmark import scores as blind
from imugap.effects import title_of
from imugap.figures import blind as drawn
from imugap.figures.style import AXIS_TITLES
from imugap.figures.views import title
from imugap.workflow import tables
from imugap.workflow.job_log import job
from imugap.workflow.products import record_of, save

TERMS = {"white_noise": "WN", "quantization": "QN", "random_walk": "RW", "gauss_markov": "AR1", "rate_ramp": "DR"}
"""What the R package gmwm calls the names that its choice of a model can give."""
ALARMS = {"name": "nothing hidden: a name", "place": "nothing hidden: a place only", "any": "nothing hidden: any alarm"}
NAMINGS = {
    ("static", "top1"): "one effect, at rest: its name",
    ("static", "top3"): "one effect, at rest: its name among three",
    ("static", "axes"): "one effect, at rest: its name and axes",
    ("motion", "top1"): "one effect, in motion: its name",
    ("motion", "top3"): "one effect, in motion: its name among three",
    ("motion", "axes"): "one effect, in motion: its name and axes",
    ("pair", "both"): "two effects: both names and axes",
    ("unknown", "abstained"): "effect without a name: a place, no name",
    ("unknown", "no_name"): "effect without a name: no name",
}
WHOLES = {"all that it has": "all that gmwm has a term for", "all that it has not": "all that it has none for"}
BESIDE = {
    "single": "one effect, named: another name beside it",
    "pair": "two effects, named: another name beside them",
    "every": "any case of any size: a name that is not hidden",
}
CLOSED = {
    ("distance", blind.ALL): "one effect: distribution in the floor after the search ({} before)",
    ("distance", blind.BEYOND): "those beyond it before: distribution in the floor after",
    ("navigation_distance", blind.ALL): "one effect, at rest: drift in the floor after the search ({} before)",
    ("navigation_distance", blind.BEYOND): "those beyond it before: drift in the floor after",
}


def rates(scores, clear_size):
    """Return all rates in one table: false alarms, names, truth in its interval, distance at the floor."""
    alarms, named = blind.false_alarms(scores.cases), blind.naming(scores.effects, clear_size)
    covered, closed = blind.coverage(scores.parameters), blind.floor_reached(scores, clear_size)
    beside = blind.superfluous_names(scores, clear_size)
    counts = closed.set_index(["distance", "scope"])["count"].unstack()
    before = {name: f"{row[blind.ALL] - row[blind.BEYOND]} of {row[blind.ALL]}" for name, row in counts.iterrows()}
    parts = [
        alarms.assign(title=alarms["alarm"].map(ALARMS)),
        named.assign(title=[NAMINGS[one.group, one.score] for one in named.itertuples(index=False)]),
        beside.assign(title=beside["group"].map(BESIDE)),
        covered.head(1).assign(title="named effects: truth in the interval of a parameter"),
        closed.assign(
            title=[
                CLOSED[one.distance, one.scope].format(before[one.distance]) for one in closed.itertuples(index=False)
            ]
        ),
    ]
    return pd.concat(parts, ignore_index=True)[["title", "count", "rate", "low", "high"]]


def rates_page(table):
    """Lay out the rates, a row each."""
    return pd.DataFrame({
        "score": table["title"],
        "cases": table["count"],
        "rate": [rate(one) for one in table.itertuples(index=False)],
    })  # fmt: skip


def rate(one):
    """Show a rate with its interval in per cent."""
    return f"{100 * one.rate:.0f} % [{100 * one.low:.0f}, {100 * one.high:.0f}]" if one.count else "—"


def words(names):
    """Show names of the vocabulary."""
    return names.map(title_of)


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
    return page.rename_axis("hidden").rename(title_of).reset_index()


def coverage_page(coverage):
    """Lay out median error and share of intervals that hold the truth, a row per parameter."""
    return pd.DataFrame({
        "effect": words(coverage["name"]),
        "parameter": words(coverage["parameter"]),
        "intervals": coverage["count"],
        "median error [half widths]": coverage["error"].map(tables.number),
        "hold the truth": [rate(one) for one in coverage.itertuples(index=False)],
    })  # fmt: skip


def calibration_page(calibration):
    """Lay out the share of p-values up to each level, a row per view."""
    shown = calibration.assign(shown=[rate(one) for one in calibration.itertuples(index=False)])
    page = shown.pivot(index=["view", "count"], columns="level", values="shown")
    page.columns = [f"p ≤ {level:g}" for level in page.columns]
    return page.rename(title, level="view").reset_index()


def beside_page(beside):
    """Lay out how often each name is given rightly, and what gmwm calls it."""
    return pd.DataFrame({
        "hidden": words(beside["name"].replace(WHOLES)),
        "gmwm's term": beside["term"].replace("", "—"),
        "clear cases": beside["count"],
        "rightly named by discovery": [rate(one) for one in beside.itertuples(index=False)],
    })  # fmt: skip


def misses_page(misses):
    """Lay out the wrong answers, a row each."""
    return pd.DataFrame({
        "case": misses["case"],
        "hides": misses["kind"],
        "in motion": misses["motion"].map({True: "yes", False: "no"}),
        "effect": words(misses["name"]),
        "size": [f"{size:g}" if size else "—" for size in misses["size"]],
        "answer": words(misses["answer"]),
    })  # fmt: skip


def confusion_page(counts):
    """Lay out the answers to each hidden name."""
    return counts.assign(hidden=words(counts["hidden"])).set_axis(words(counts.columns), axis="columns")


def peer_page(peer):
    """Lay out what gmwm chose for the axes on which it was run."""
    return pd.DataFrame({
        "axis": peer["axis"].map(AXIS_TITLES),
        "compositions tried": peer["candidates"],
        "chosen": peer["chosen"],
        "p of its test of fit": peer["gof_p"].map(tables.number),
        "best p of all tried": peer["best_gof_p"].map(tables.number),
        "time on another machine [s]": peer["seconds"].map(tables.number) + " (" + peer["clock"] + ")",
    })  # fmt: skip


def by_kind(cases):
    """Count cases by what they hide."""
    return cases["kind"].value_counts().reindex(["single", "pair", "nothing", "unknown"], fill_value=0).to_dict()


def named_shares(effects, smallest):
    """Return the shares of the names that are right, of effects from the size ``smallest`` upward."""
    naming = blind.naming(effects, smallest).set_index(["group", "score"])
    return {
        f"{group}_{score}": {"count": int(one["count"]), "right": round(one["count"] * one["rate"])}
        | {end: f"{100 * one[end]:.0f}" for end in ("rate", "low", "high")}
        for (group, score), one in naming[naming["count"] > 0].iterrows()
    }


def numbers(scores, table, beside, misses, seconds, clear_size):
    """Return what the text says."""
    cases = scores.cases
    alarm = blind.false_alarms(cases).set_index("alarm").loc["name"]
    closed = blind.floor_reached(scores, clear_size).fillna({"rate": 0.0}).set_index(["distance", "scope"])
    far, drift = closed.loc[("distance", blind.BEYOND)], closed.loc["navigation_distance"].T
    every = table[table["title"] == BESIDE["every"]]
    of_one = blind.single_cases(scores, clear_size)
    beyond = of_one[of_one["distance_before"] > of_one["distance_floor_high"]]
    factors = beyond["distance_before"] / beyond["distance_after"]
    return {
        "cases": len(cases),
        "kinds": by_kind(cases),
        "wrong": by_kind(misses.drop_duplicates("case")),
        "not_hidden": round((every["count"] * every["rate"]).item()),
        "motion": int(cases["motion"].sum()),
        "clear": f"{clear_size:g}",
        "false_names": f"{100 * alarm['rate']:.1f}",
        "false_names_high": f"{100 * alarm['high']:.1f}",
        "quiet": int(alarm["count"]),
        "named": named_shares(scores.effects, clear_size),
        "named_of_all": named_shares(scores.effects, 0.0),
        "alone": len(of_one),
        "beyond": int(far["count"]),
        "came": round(far["count"] * far["rate"]) if far["count"] else 0,
        "drift": {
            "cases": int(drift[blind.ALL]["count"]),
            "before": int(drift[blind.ALL]["count"] - drift[blind.BEYOND]["count"]),
            "after": round(drift[blind.ALL]["count"] * drift[blind.ALL]["rate"]),
        },
        "shrunk": [tables.number(one, 2) for one in factors.quantile([0.5, 0.25, 0.75])],
        "median_seconds": f"{seconds.median():.0f}",
        "longest_seconds": f"{seconds.max():.0f}",
        "stochastic": len(blind.STOCHASTIC),
        "terms": int((beside["term"] != "").sum()),
    }


with job(snakemake) as (source, params, output):
    clear, source = params.clear_size, dict(source.items())
    scores = blind.Scores(*(pd.read_csv(source[name]) for name in ("cases", "effects", "parameters")))
    p_values, seconds = pd.read_csv(source["p_values"]), pd.read_csv(source["run_time"])["seconds"]
    table, coverage = rates(scores, clear), blind.coverage(scores.parameters)
    detection, confusion = blind.detection(scores.effects), blind.confusion(scores.effects, clear)
    misses, calibration = blind.wrong_answers(scores, clear), blind.calibration(p_values)
    beside, peer = blind.stochastic_names(scores.effects, TERMS, clear), pd.read_csv(source["peer"])
    save(
        output,
        detection_figure=drawn.detection(detection, clear),
        confusion_figure=drawn.confusion(confusion),
        rates_figure=drawn.rates(table),
        coverage_figure=drawn.coverage(scores.parameters, coverage),
        distances_figure=drawn.distances(blind.single_cases(scores, clear)),
        calibration_figure=drawn.calibration(p_values),
        rates=(table, rates_page(table)),
        detection=(detection, detection_page(detection)),
        confusion=(confusion.reset_index(), confusion_page(confusion.reset_index())),
        misses=(misses, misses_page(misses)),
        coverage=(coverage, coverage_page(coverage)),
        calibration=(calibration, calibration_page(calibration)),
        beside=(beside, beside_page(beside)),
        peer=(peer, peer_page(peer)),
        numbers=numbers(scores, table, beside, misses, seconds, clear) | record_of(source),
    )

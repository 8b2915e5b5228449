"""Summarise the scores of several entries in one table."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import pandas as pd

from imu_benchmark import forecasts as probabilities
from imu_benchmark.answers import Entry
from imu_benchmark.scores import ALL, Scores, coverage, detection, false_alarms, naming, rate, score, whole

SHARE, VALUE = "share", "value"
TITLES = {
    "false_name": "nothing hidden: a name",
    "false_alarm": "nothing hidden: a name or a place",
    "single_top1": "one effect: its name",
    "single_top3": "one effect: its name among three",
    "single_axes": "one effect: its name and axes",
    "motion_axes": "one effect, in motion: its name and axes",
    "pair": "two effects: both names and axes",
    "triple": "three effects: all names and axes",
    "unknown": "effect without a name: a place, no name",
    "coverage": "named effects: truth in the interval of a parameter",
    "brier": "Brier score",
    "log_score": "log score",
    "calibration_error": "expected calibration error",
    "set_holds": "ambiguity sets that hold the truth",
    "set_size": "mean size of an ambiguity set",
    "seconds": "median run time of a case [s]",
}
"""Scores in words; beside them ``found_SIZE``, one effect of this size: found, by a name or a place."""


@dataclass(frozen=True, eq=False)
class Scored:
    """An entry with its scores case by case, its distributions and its summary."""

    name: str
    scores: Scores
    forecasts: pd.DataFrame
    summary: pd.DataFrame


def scored(entry: Entry, keys: Sequence[Mapping], clear: float) -> Scored:
    """Score an entry; effects from the size ``clear`` upward count as clear."""
    reports = [entry.reports[key["case"]] for key in keys]
    scores = score(keys, reports, [entry.seconds[key["case"]] for key in keys])
    table = probabilities.forecasts(keys, reports)
    return Scored(entry.name, scores, table, summary(scores, table, probabilities.stated(reports), clear))


def summary(scores: Scores, forecasts: pd.DataFrame, stated: bool, clear: float) -> pd.DataFrame:
    """Return the scores of an entry.

    Columns ``score``, ``kind`` (:data:`SHARE` or :data:`VALUE`), ``count``, ``rate`` (the share or the value), ``low``
    and ``high`` (95 % interval of a share). Scores of probabilities where they are ``stated``.
    """
    effects = scores.effects
    alarms = false_alarms(scores.cases).set_index("alarm")
    single = effects[(effects["kind"] == "single") & (effects["size"] >= clear)]
    top1 = single["top1"].astype(bool)
    axes = top1 & single["axes"].eq(True)
    unknown = naming(effects, clear).set_index(["group", "score"]).loc[("unknown", "abstained")]
    shares = {
        "false_name": alarms.loc["name"],
        "false_alarm": alarms.loc["any"],
        **{f"found_{one.size:g}": one._asdict() for one in _found(effects)},
        "single_top1": rate(top1),
        "single_top3": rate(single["top3"].astype(bool)),
        "single_axes": rate(axes),
        "motion_axes": rate(axes[single["motion"].astype(bool)]),
        "pair": rate(whole(effects, "pair", 2, clear)),
        "triple": rate(whole(effects, "triple", 3, clear)),
        "unknown": unknown,
        "coverage": coverage(scores.parameters).iloc[0],
    }
    seconds = scores.cases["seconds"].dropna()
    values = {"seconds": (len(seconds), seconds.median())} if len(seconds) else {}
    if stated:
        sets = probabilities.ambiguity_sets(forecasts)
        shares["set_holds"] = rate(sets["holds"])
        values |= {
            "brier": (len(sets), probabilities.brier_score(forecasts)),
            "log_score": (len(sets), probabilities.log_score(forecasts)),
            "calibration_error": (len(sets), probabilities.calibration_error(forecasts)),
            "set_size": (len(sets), sets["size"].mean()),
        }
    rows = [
        {"score": name, "kind": SHARE} | {part: one[part] for part in ("count", "rate", "low", "high")}
        for name, one in shares.items()
    ]
    rows += [{"score": name, "kind": VALUE, "count": count, "rate": value} for name, (count, value) in values.items()]
    return pd.DataFrame(rows)


def together(entries: Sequence[Scored]) -> pd.DataFrame:
    """Return the summaries of several entries one below the other, with the column ``entry``."""
    return pd.concat([one.summary.assign(entry=one.name) for one in entries], ignore_index=True)


def table(summaries: pd.DataFrame) -> pd.DataFrame:
    """Lay the summaries out, a row for each score and a column for each entry, as text."""
    cells = summaries.assign(shown=[_shown(one) for one in summaries.itertuples(index=False)])
    wide = cells.pivot(index="score", columns="entry", values="shown").fillna("—")
    known = [*TITLES]
    known[2:2] = sorted({name for name in wide.index if name not in TITLES}, key=lambda name: float(name[6:]))
    rows = [name for name in known if name in wide.index]
    page = wide.loc[rows, list(dict.fromkeys(summaries["entry"]))].reset_index()
    titles = [TITLES.get(name) or f"one effect of size {name[6:]}: found" for name in page["score"]]
    return page.assign(score=titles).rename_axis(columns=None)


def _found(effects: pd.DataFrame):
    rates = detection(effects)
    return rates[(rates["name"] == ALL) & (rates["score"] == "detected")].itertuples(index=False)


def _shown(one) -> str:
    """Show a share as a count, with its interval in per cent, and a value as it is."""
    if one.kind == VALUE:
        return f"{one.rate:.3g}"
    if not one.count:
        return "—"
    return f"{one.rate * one.count:.0f} of {one.count:.0f} [{100 * one.low:.0f}, {100 * one.high:.0f}] %"

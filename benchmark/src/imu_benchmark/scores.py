"""Score the blind benchmark: compare the report of each case with its key.

A key (:mod:`imu_benchmark.sealing`) holds ``case``, ``kind``, ``motion``, ``base``, ``rate_hz``, ``duration_s`` and
``effects`` (``name``, ``axes``, ``parameters``, ``size``); reports are those of :mod:`imu_benchmark.answers`. Answers
are names of the vocabulary, :data:`NONE` where nothing was found, and :data:`UNKNOWN` for a place without a name.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import pandas as pd
from scipy.stats import binomtest

from imu_benchmark.schema import check, load, read_json

NONE = "none"
UNKNOWN = "unknown"
ALL = "all"
"""Name of all effects together."""
BEYOND = "beyond"
"""Name of the cases whose start model lies beyond the floor."""
MORE = "right, and another name"
"""Answer where the hidden names are found and another name is given as well."""
LEVEL = 0.95
LEVELS = (0.01, 0.05, 0.5)
"""Levels up to which p-values are counted."""
STOCHASTIC = (
    "white_noise", "quantization", "random_walk", "gauss_markov", "rate_ramp", "bias_instability", "random_telegraph",
    "sinusoid", "outliers", "variance_change", "output_filter", "common_mode",
)  # fmt: skip
"""Names of the random effects of a device at rest, and of those that a random process may replace."""
DISTANCES = ("distance", "navigation_distance")
STATES = ("before", "after", "floor")
CASE = ("case", "kind", "motion", "base", "rate_hz", "duration_s")
CASE_COLUMNS = (*CASE, "named", "superfluous", "unexplained", "seconds")
EFFECT_COLUMNS = ("case", "kind", "motion", "base", "name", "size", "answer", "top1", "top3", "axes")
PARAMETER_COLUMNS = ("case", "motion", "name", "size", "parameter", "truth", "value", "low", "high", "error", "inside")


@dataclass(frozen=True, eq=False)
class Scores:
    """Scores of each case.

    Attributes
    ----------
    cases
        A row for each case: :data:`CASE_COLUMNS`, with the numbers of effects named and of those not hidden, whether a
        place is unexplained, and the run time [s]; then ``distance_before``, ``_low``,
        ``_high`` and so on for every distance and state.
    effects
        A row for each hidden effect, and one for each case without a hidden name: ``answer``, whether the name is
        right (``top1``), whether it or one of its first two alternatives is (``top3``), and whether the axes are.
    parameters
        A row for each parameter of a rightly named effect: truth, value, interval, error in half widths of the
        interval, whether the truth lies inside.
    """

    cases: pd.DataFrame
    effects: pd.DataFrame
    parameters: pd.DataFrame


def read_key(path: str | Path) -> dict:
    """Read the key of a case."""
    key = read_json(path)
    check(key, load("key"), path)
    return key


def score(keys: Sequence[Mapping], reports: Sequence[Mapping], seconds: Sequence[float]) -> Scores:
    """Return the scores of cases from their keys, reports and run times [s], given in the same order."""
    cases, effects, parameters = [], [], []
    for key, report, time in zip(keys, reports, seconds, strict=True):
        matches = match(key["effects"], report["effects"])
        cases.append(_case(key, report, time, matches))
        effects += _effects(key, report, matches)
        parameters += _parameters(key, matches)
    return Scores(
        pd.DataFrame(cases),
        pd.DataFrame(effects, columns=list(EFFECT_COLUMNS)),
        pd.DataFrame(parameters, columns=list(PARAMETER_COLUMNS)),
    )


def match(hidden: Sequence[Mapping], found: Sequence[Mapping]) -> list[Mapping | None]:
    """Match each hidden effect with at most one reported effect, or None.

    Effects match by name and axes, else by name, else by a common axis.
    """
    answers: list[Mapping | None] = [None] * len(hidden)
    free = list(found)
    rules = (
        lambda one, other: one["name"] == other["name"] and set(one["axes"]) & set(other["axes"]),
        lambda one, other: one["name"] == other["name"],
        lambda one, other: set(one["axes"]) & set(other["axes"]),
    )
    for agrees in rules:
        for number, effect in enumerate(hidden):
            fitting = [report for report in free if answers[number] is None and agrees(effect, report)]
            if fitting:
                answers[number] = fitting[0]
                free = [report for report in free if report is not fitting[0]]
    return answers


def _case(key: Mapping, report: Mapping, seconds: float, matches: Sequence[Mapping | None]) -> dict:
    right = sum(
        answer is not None and answer["name"] == effect["name"]
        for effect, answer in zip(key["effects"], matches, strict=True)
    )
    row = {name: key[name] for name in CASE} | {
        "named": len(report["effects"]),
        "superfluous": len(report["effects"]) - right,
        "unexplained": unexplained(report),
        "seconds": seconds,
    }
    for distance in DISTANCES:
        for state in STATES:
            found = (report.get(distance) or {}).get(state) or {}
            row |= {
                f"{distance}_{state}": found.get("value"),
                f"{distance}_{state}_low": found.get("low"),
                f"{distance}_{state}_high": found.get("high"),
            }
    return row


def unexplained(report: Mapping) -> bool:
    """Return whether the report has a place that no name explains."""
    return bool(report["unexplained"]) or (bool(report["gaps"]) and not report["effects"])


def _effects(key: Mapping, report: Mapping, matches: Sequence[Mapping | None]) -> list[dict]:
    """Return a row for each hidden effect of the vocabulary, or one for the case if there is none."""
    same = {name: key[name] for name in ("case", "kind", "motion", "base")}
    silent = UNKNOWN if unexplained(report) else NONE
    if key["kind"] in ("nothing", "unknown"):
        right = NONE if key["kind"] == "nothing" else UNKNOWN
        size = key["effects"][0]["size"] if key["effects"] else 0.0
        names = [effect["name"] for effect in report["effects"]] or [silent]
        return [
            same
            | {"name": right, "size": size, "answer": names[0], "top1": names[0] == right, "top3": None, "axes": None}
        ]
    rows = []
    for effect, answer in zip(key["effects"], matches, strict=True):
        row = same | {"name": effect["name"], "size": effect["size"]}
        if answer is None:
            rows.append(row | {"answer": silent, "top1": False, "top3": False, "axes": False})
            continue
        first = [
            answer["name"],
            *(one["name"] for one in answer.get("alternatives", []) if one["name"] != answer["name"]),
        ]
        right = answer["name"] == effect["name"]
        axes = set(answer["axes"]) == set(effect["axes"])
        rows.append(row | {"answer": answer["name"], "top1": right, "top3": effect["name"] in first[:3], "axes": axes})
    return rows


def _parameters(key: Mapping, matches: Sequence[Mapping | None]) -> list[dict]:
    """Return a row for each hidden parameter reported under the right name."""
    rows = []
    for effect, answer in zip(key["effects"], matches, strict=True):
        if answer is None or answer["name"] != effect["name"]:
            continue
        for name, truth in effect["parameters"].items():
            found = answer["parameters"].get(name)
            if found is None:
                continue
            value, low, high = (found.get(part) for part in ("value", "low", "high"))
            width = None if None in (value, low, high) or high <= low else (high - low) / 2
            rows.append({
                "case": key["case"], "motion": key["motion"], "name": effect["name"], "size": effect["size"],
                "parameter": name, "truth": truth, "value": value, "low": low, "high": high,
                "error": None if width is None else (value - truth) / width,
                "inside": width is not None and low <= truth <= high,
            })  # fmt: skip
    return rows


def rate(hits: pd.Series) -> dict[str, float]:
    """Return the share of true values with its exact binomial interval (Clopper and Pearson 1934)."""
    count, good = len(hits), int(hits.sum())
    if count == 0:
        return {"count": 0, "rate": float("nan"), "low": 0.0, "high": 1.0}
    span = binomtest(good, count).proportion_ci(LEVEL, "exact")
    return {"count": count, "rate": good / count, "low": float(span.low), "high": float(span.high)}


def detection(effects: pd.DataFrame) -> pd.DataFrame:
    """Return the rates at which single effects are found, and named, by ``name`` (and :data:`ALL`) and ``size``.

    Columns ``name``, ``size``, ``score`` (``detected``: any answer but none; ``named``: the right one), ``count``,
    ``rate``, ``low``, ``high``.
    """
    rows = []
    single = effects[effects["kind"] == "single"]
    groups = (group for some in (single.assign(name=ALL), single) for group in some.groupby(["name", "size"]))
    for (name, size), group in groups:
        hits = {"detected": group["answer"] != NONE, "named": group["top1"].astype(bool)}
        rows += [{"name": name, "size": size, "score": score} | rate(hit) for score, hit in hits.items()]
    return pd.DataFrame(rows, columns=["name", "size", "score", "count", "rate", "low", "high"])


def false_alarms(cases: pd.DataFrame) -> pd.DataFrame:
    """Return the rates of names, of places without a name, and of either, in cases without hidden effects."""
    quiet = cases[cases["kind"] == "nothing"]
    named, placed = quiet["named"] > 0, quiet["unexplained"].astype(bool)
    alarms = {"name": named, "place": placed & ~named, "any": named | placed}
    return pd.DataFrame([{"alarm": alarm} | rate(hit) for alarm, hit in alarms.items()])


def confusion(effects: pd.DataFrame, smallest: float = 0.0) -> pd.DataFrame:
    """Return how often each hidden name (rows) gets each answer (columns), from the size ``smallest`` upward.

    Both end with ``none`` and ``unknown``; pairs and triples are excluded, since their answers may be exchanged.
    """
    alone = effects[~effects["kind"].isin(["pair", "triple"])]
    chosen = alone[(alone["size"] >= smallest) | (alone["name"] == NONE)]
    names = [*sorted((set(chosen["name"]) | set(chosen["answer"])) - {NONE, UNKNOWN}), NONE, UNKNOWN]
    counts = pd.crosstab(chosen["name"], chosen["answer"])
    return counts.reindex(index=names, columns=names, fill_value=0).rename_axis(index="hidden", columns="answer")


def naming(effects: pd.DataFrame, smallest: float) -> pd.DataFrame:
    """Return naming rates from the size ``smallest`` upward, by kind of case.

    Scores: ``top1``, ``top3``, ``axes`` (right name and right axes) for singles at rest and in motion; ``both`` (all
    names and axes of a case right) for pairs; ``abstained`` (a place and no name) for effects of no vocabulary, and
    ``no_name``.
    """
    clear = effects[effects["size"] >= smallest]
    rows = []
    for group, moving in (("static", False), ("motion", True)):
        of = clear[(clear["kind"] == "single") & (clear["motion"] == moving)]
        top1 = of["top1"].astype(bool)
        hits = {"top1": top1, "top3": of["top3"].astype(bool), "axes": top1 & of["axes"].astype(bool)}
        rows += [{"group": group, "score": name} | rate(hit) for name, hit in hits.items()]
    rows.append({"group": "pair", "score": "both"} | rate(whole(effects, "pair", 2, smallest)))
    answers = clear.loc[clear["kind"] == "unknown", "answer"]
    rows.append({"group": "unknown", "score": "abstained"} | rate(answers == UNKNOWN))
    rows.append({"group": "unknown", "score": "no_name"} | rate(answers.isin([UNKNOWN, NONE])))
    return pd.DataFrame(rows)


def whole(effects: pd.DataFrame, kind: str, count: int, smallest: float) -> pd.Series:
    """Return by case whether all names and axes are right, of the cases of a kind with ``count`` clear effects."""
    of = effects[(effects["kind"] == kind) & (effects["size"] >= smallest)]
    right = (of["top1"].astype(bool) & of["axes"].astype(bool)).groupby(of["case"])
    return right.all()[right.size() == count]


def stochastic_names(effects: pd.DataFrame, terms: Mapping[str, str], smallest: float) -> pd.DataFrame:
    """Return how often effects of the :data:`STOCHASTIC` subset are rightly named, and whether another program can.

    Hidden singly in a device at rest, from the size ``smallest`` upward.

    Parameters
    ----------
    terms
        What the other program calls the names that it has; the others it cannot give.

    Returns
    -------
    By ``name``, then over those that the other program has and over those that it has not: ``term``, ``count``,
    ``rate``, ``low``, ``high``.
    """
    clear = effects[(effects["kind"] == "single") & ~effects["motion"].astype(bool) & (effects["size"] >= smallest)]
    of = clear[clear["name"].isin(STOCHASTIC)].assign(term=lambda table: table["name"].map(terms).fillna(""))
    groups = [(name, terms.get(name, ""), of[of["name"] == name]) for name in STOCHASTIC]
    groups += [("all that it has", "", of[of["term"] != ""]), ("all that it has not", "", of[of["term"] == ""])]
    rows = [{"name": name, "term": term} | rate(group["top1"].astype(bool)) for name, term, group in groups]
    return pd.DataFrame(rows)


def coverage(parameters: pd.DataFrame) -> pd.DataFrame:
    """Return how often the truth lies inside its interval, by name and parameter and over all (:data:`ALL`).

    ``error`` is the median absolute error in half widths of the interval.
    """
    bounded = parameters.dropna(subset=["error"])
    groups = [((ALL, ALL), bounded), *bounded.groupby(["name", "parameter"], sort=True)]
    rows = [
        {"name": name, "parameter": parameter, "error": group["error"].astype(float).abs().median()}
        | rate(group["inside"].astype(bool))
        for (name, parameter), group in groups
    ]
    return pd.DataFrame(rows, columns=["name", "parameter", "error", "count", "rate", "low", "high"])


def single_cases(scores: Scores, smallest: float) -> pd.DataFrame:
    """Return the cases with one hidden effect, of the size ``smallest`` or more."""
    effects = scores.effects
    clear = effects.loc[(effects["kind"] == "single") & (effects["size"] >= smallest), "case"]
    return scores.cases[scores.cases["case"].isin(clear)]


def superfluous_names(scores: Scores, smallest: float) -> pd.DataFrame:
    """Return the rates at which a name is given that is not hidden, by ``group``.

    Groups: ``single`` and ``pair``, the cases from the size ``smallest`` upward with every hidden name found;
    ``every``, all cases of any size.
    """
    more = (scores.cases.set_index("case")["superfluous"] > 0).rename("hit")
    hidden = scores.effects[scores.effects["size"] >= smallest].groupby("case")["top1"].agg(["all", "size"])
    kinds = scores.cases.set_index("case")["kind"]
    found = {
        kind: hidden.index[hidden["all"].astype(bool) & (hidden["size"] == count) & (kinds[hidden.index] == kind)]
        for kind, count in (("single", 1), ("pair", 2))
    }
    groups = {kind: more[cases] for kind, cases in found.items()} | {"every": more}
    return pd.DataFrame([{"group": group} | rate(hits) for group, hits in groups.items()])


def wrong_answers(scores: Scores, smallest: float) -> pd.DataFrame:
    """Return the rows of wrong answers, to effects from the size ``smallest`` upward and to cases without effects.

    Wrong are a wrong name, wrong axes, and an additional name (the answer is then :data:`MORE`).
    """
    effects, more = scores.effects, scores.cases.loc[scores.cases["superfluous"] > 0, "case"]
    asked = effects[(effects["size"] >= smallest) | (effects["name"] == NONE)]
    wrong = ~asked["top1"].astype(bool) | asked["axes"].eq(False)
    right = asked[asked["case"].isin(more) & ~asked["case"].isin(asked.loc[wrong, "case"])]
    more = right.drop_duplicates("case").assign(answer=MORE)
    return pd.concat([asked[wrong], more]).sort_values("case", kind="stable")


def floor_reached(scores: Scores, smallest: float) -> pd.DataFrame:
    """Return how often the distance after the last addition lies within the floor's interval or below it.

    By distance, over the :func:`single_cases`, with the median distances; ``scope`` is all of them (:data:`ALL`) or
    those beyond the floor before (:data:`BEYOND`).
    """
    cases = single_cases(scores, smallest)
    rows = []
    for distance in DISTANCES:
        known = cases.dropna(subset=[f"{distance}_after", f"{distance}_floor_high"])
        far = known[known[f"{distance}_before"] > known[f"{distance}_floor_high"]]
        for scope, some in ((ALL, known), (BEYOND, far)):
            medians = {state: some[f"{distance}_{state}"].astype(float).median() for state in STATES}
            reached = some[f"{distance}_after"] <= some[f"{distance}_floor_high"]
            rows.append({"distance": distance, "scope": scope} | medians | rate(reached))
    return pd.DataFrame(rows)


def calibration(p_values: pd.DataFrame) -> pd.DataFrame:
    """Return how often views of logs without hidden effects have a p-value up to the :data:`LEVELS`.

    By ``view`` and over all (:data:`ALL`); the intervals assume that views of different axes are independent.
    """
    groups = [(ALL, p_values), *p_values.groupby("view", sort=False)]
    rows = [
        {"view": view, "level": level} | rate(group["p_value"] <= level) for view, group in groups for level in LEVELS
    ]
    return pd.DataFrame(rows)

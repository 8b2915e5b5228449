"""Score the probabilities of answers: how sure a name is, against how often it is right.

A hidden effect, a log without any, and an effect of no vocabulary are one question each, whose answer is a distribution
over names, ``none`` and ``unknown``: the ``probabilities`` of the effect that answers it, where there is none those of
a place without a name, one on an axis of the effect before others, and then those of the report. An answer without
probabilities is certain of what it says.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence, Set

import numpy as np
import pandas as pd

from imu_benchmark.scores import NONE, UNKNOWN, match, rate, unexplained

OTHER = "other"
"""Any name of the vocabulary that an answer does not list."""
COLUMNS = ("case", "question", "truth", "name", "probability")
BINS = 10
"""Bins of the confidence in the calibration error."""
LEVEL = 0.95
"""Probability of an ambiguity set: the likeliest names that have it together."""
LEAST = 1e-4
"""Least probability of the log score, which a certainty that is wrong gets."""


def forecasts(keys: Sequence[Mapping], reports: Sequence[Mapping]) -> pd.DataFrame:
    """Return the distributions of all answers: a row for each name of each ``question`` of each case."""
    rows = [
        (key["case"], number, truth, name, weight / sum(weights.values()))
        for key, report in zip(keys, reports, strict=True)
        for number, (hidden, weights) in enumerate(_questions(key, report))
        for truth in [_among(hidden, weights)]
        for name, weight in weights.items()
    ]
    return pd.DataFrame(rows, columns=list(COLUMNS))


def stated(reports: Iterable[Mapping]) -> bool:
    """Return whether any report has probabilities."""
    parts = (item for report in reports for item in (report, *report["effects"], *_places(report)))
    return any("probabilities" in item for item in parts)


def brier_score(table: pd.DataFrame) -> float:
    """Return the mean over questions of sum (p - y)^2 over names, from 0 to 2 (Brier 1950)."""
    hit = table["name"] == table["truth"]
    squares = ((table["probability"] - hit) ** 2).groupby([table["case"], table["question"]]).sum()
    absent = ~hit.groupby([table["case"], table["question"]]).any()
    return float((squares + absent).mean())


def log_score(table: pd.DataFrame) -> float:
    """Return the mean over questions of -log p of the truth, p at least :data:`LEAST`."""
    truth = table["probability"].where(table["name"] == table["truth"], 0.0)
    given = truth.groupby([table["case"], table["question"]]).sum()
    return float(-np.log(np.maximum(given, LEAST)).mean())


def reliability(table: pd.DataFrame) -> pd.DataFrame:
    """Return, by bin of the probability of the likeliest name, its mean and how often that name is right."""
    rows = [
        {"bin": number, "confidence": group["probability"].mean()} | rate(group["right"])
        for number, group in _likeliest(table).groupby("bin")
    ]
    return pd.DataFrame(rows, columns=["bin", "confidence", "count", "rate", "low", "high"])


def calibration_error(table: pd.DataFrame) -> float:
    """Return the expected calibration error: the mean distance of confidence and rate over the questions, by bin."""
    excess, questions = _excess(table)
    return float(np.abs(excess.sum(axis=0)).sum() / questions.sum())


def calibration_errors(table: pd.DataFrame, resamples: int, rng: np.random.Generator) -> np.ndarray:
    """Return the calibration error of bootstrap resamples of the cases, shape (resamples,)."""
    excess, questions = _excess(table)
    counts = rng.multinomial(len(excess), np.full(len(excess), 1 / len(excess)), size=resamples)
    return np.abs(counts @ excess).sum(axis=1) / (counts @ questions)


def _excess(table: pd.DataFrame) -> tuple[np.ndarray, np.ndarray]:
    """Return the sums of confidence less right by case and bin, shape (cases, bins), and the questions of each case."""
    top = _likeliest(table)
    excess = (top["probability"] - top["right"]).groupby([top["case"], top["bin"]]).sum().unstack(fill_value=0.0)
    return excess.to_numpy(), top.groupby("case").size().to_numpy()


def _likeliest(table: pd.DataFrame) -> pd.DataFrame:
    """Return the likeliest name of each question, the ``bin`` of its probability, and whether it is right."""
    top = table.loc[table.groupby(["case", "question"])["probability"].idxmax()]
    bins = np.minimum((top["probability"] * BINS).astype(int), BINS - 1)
    return top.assign(bin=bins, right=top["name"] == top["truth"])


def ambiguity_sets(table: pd.DataFrame) -> pd.DataFrame:
    """Return of each question the size of its ambiguity set and whether it holds the truth (``holds``)."""
    ordered = table.sort_values("probability", ascending=False, kind="stable")
    groups = ordered.groupby(["case", "question"], sort=False)["probability"]
    within = ordered[groups.cumsum() - ordered["probability"] < LEVEL - 1e-9]
    return (
        within.assign(holds=within["name"] == within["truth"])
        .groupby(["case", "question"])
        .agg(size=("name", "size"), holds=("holds", "any"))
    )


def _questions(key: Mapping, report: Mapping) -> Iterator[tuple[str, Mapping[str, float]]]:
    """Yield truth and distribution of every question of a case."""
    if key["kind"] in ("nothing", "unknown"):
        first = report["effects"][0] if report["effects"] else None
        axes = {axis for effect in key["effects"] for axis in effect["axes"]}
        yield NONE if key["kind"] == "nothing" else UNKNOWN, _distribution(first, axes, report)
        return
    for effect, answer in zip(key["effects"], match(key["effects"], report["effects"]), strict=True):
        yield effect["name"], _distribution(answer, set(effect["axes"]), report)


def _among(truth: str, weights: Mapping[str, float]) -> str:
    """Return the truth; :data:`OTHER` for a name that an answer does not list but allows for."""
    return truth if truth in weights or truth in (NONE, UNKNOWN) or OTHER not in weights else OTHER


def _distribution(answer: Mapping | None, axes: Set[str], report: Mapping) -> Mapping[str, float]:
    if answer is not None:
        return answer.get("probabilities", {answer["name"]: 1.0})
    for item in (*sorted(_places(report), key=lambda place: place.get("axis") not in axes), report):
        if "probabilities" in item:
            return item["probabilities"]
    return {UNKNOWN if unexplained(report) else NONE: 1.0}


def _places(report: Mapping) -> tuple[Mapping, ...]:
    return (*report.get("withheld", []), *report["unexplained"], *report["gaps"])

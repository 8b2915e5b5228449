"""Compare what publishers and makers state of recordings with what discovery found on them."""

from pathlib import Path

import pandas as pd

from imugap.workflow import tables
from imugap.workflow.job_log import job
from imugap.workflow.products import save

MISSED, OTHER, FOUND = "not found", "found with another value", "found"


def own(fact, parameters):
    """Return the parameter of a fact on its axes."""
    same = (parameters["effect"] == fact.effect) & (parameters["parameter"] == fact.parameter)
    return parameters[same & parameters["axis"].isin(fact.axes.split())]


def outcome(fact, parameters):
    """Judge one fact: found on every axis, with an interval that reaches the stated range; else what lacks."""
    rows = own(fact, parameters)
    if set(fact.axes.split()) - set(rows["axis"]):
        return MISSED
    inside = (rows["low"].fillna(rows["value"]) <= fact.high) & (rows["high"].fillna(rows["value"]) >= fact.low)
    return FOUND if inside.groupby(rows["axis"]).any().all() else OTHER


def seen(fact, parameters):
    """Return the values that were found, smallest to largest."""
    rows = own(fact, parameters).sort_values("value")
    if rows.empty:
        return "—"
    ends = dict.fromkeys(map(tables.number, rows["value"].iloc[[0, -1]]))
    return f"{' to '.join(ends)} {rows['unit'].iloc[0]}"


with job(snakemake) as (source, params, output):
    facts = pd.read_csv(source.facts)
    parameters = {Path(path).parent.name: pd.read_csv(path) for path in source.parameters}
    facts = facts[facts["recording"].isin(parameters)]
    rows = [(fact, parameters[fact.recording]) for fact in facts.itertuples(index=False)]
    table = facts.assign(found=[seen(*row) for row in rows], outcome=[outcome(*row) for row in rows])
    page = pd.DataFrame({
        "recording": table["recording"].map(params.titles),
        "stated": table["statement"],
        "source": table["source"],
        "in the log": table["found"].map(tables.unit),
        "outcome": table["outcome"],
    })  # fmt: skip
    counts = table["outcome"].value_counts()
    numbers = {"facts": len(table)} | {
        key: int(counts.get(name, 0)) for key, name in (("found", FOUND), ("other", OTHER), ("missed", MISSED))
    }
    save(output, table=(table, page), numbers=numbers)

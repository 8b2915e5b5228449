"""Tabulate what is found of the effects that were hidden in simulated walks."""

from pathlib import Path

import pandas as pd
import yaml

from imugap.effects import title_of
from imugap.model import ErrorModel
from imugap.study.walk.walk_naming import score, summary
from imugap.workflow import tables
from imugap.workflow.job_log import job
from imugap.workflow.products import save

SHOWN = 2
"""Places that a row of the table shows."""


def truth(cases):
    """Return the name and the axes of what each case hides."""
    rows = {}
    for case, one in cases.items():
        effects = ErrorModel.from_mapping({axis: values for axis, values in one.items() if axis != "gait"}).axes
        axes = list(effects) or list(one)
        rows[case] = next((effect.name for model in effects.values() for effect in model), case), axes
    return rows


def listed(rows):
    """Return names and axes of findings as text."""
    return "; ".join(f"{title_of(one.name)} ({said(one.axis)})" for one in rows.itertuples()) or "none"


def said(axes):
    """Return axes as text."""
    axes = axes.split()
    return ", ".join(axes) if len(axes) < 4 else f"{len(axes)} axes"


def places(rows):
    """Return the surest places as text."""
    surest = rows.sort_values("chance").head(SHOWN)
    spans = (
        f"{one.axis} {one.name}, {tables.number(one.value, 2)} to {tables.number(one.high, 2)} {tables.unit(one.unit)}"
        for one in surest.itertuples(index=False)
    )
    return "; ".join(spans) or "none"


def innovations(rows):
    """Return what zero velocity says: the surest suspect, and how many cannot be told from it."""
    if rows.empty:
        return "none"
    first = rows.iloc[0]
    others = sorted({title_of(name) for name in rows["name"]} - {title_of(first["name"])})
    also = f"; or {', '.join(others)}" if others else ""
    return f"{title_of(first['name'])} ({first['axis']}), {abs(first['deviate']):.1f} σ{also}"


def page(found, scores):
    """Lay the table out: a row per case."""
    for case in scores.itertuples():
        one = found[found["case"] == case.case]
        of = {how: one[one["how"] == how] for how in ("exact", "place", "integrity", "innovations")}
        hidden = title_of(case.hidden) + (f" ({said(case.axes)})" if case.there else "")
        row = {"hidden": hidden, "named with the exact reference": listed(of["exact"])}
        row |= {"most significant places": places(of["place"]), "named by the log alone": listed(of["integrity"])}
        row |= {"named by zero velocity": innovations(of["innovations"]), "scatter": tables.number(case.scatter, 2)}
        yield row


with job(snakemake) as (source, params, output):
    hides = truth(yaml.safe_load(Path(source.cases).read_text()))
    named = zip(params.cases, source.found, strict=True)
    found = pd.concat(pd.read_csv(path).assign(case=case) for case, path in named)
    for column in ("name", "axis", "unit", "value", "high", "chance", "deviate"):
        if column not in found:
            found[column] = None
    scores = score(found, hides)
    save(output, table=(scores, page(found, scores)), numbers=summary(scores))

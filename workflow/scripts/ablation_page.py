"""Tabulate how much of the held-out gain of a name a wrong name has."""

import pandas as pd

from imu_benchmark.scores import rate
from imugap.effects import title_of
from imugap.workflow import tables
from imugap.workflow.job_log import job
from imugap.workflow.products import record_of, save

DECIDED = 2.0
"""Gain of log-density [nat] of the name beyond which a share of it is stated."""
SEALED = "sealed"
COLUMNS = ["source", "name", "rivals", "gain", "rival_gain", "count", "rate", "low", "high"]


def summary(data):
    """Return, by source and name, median gains, and in how many logs the wrong name is behind on unseen samples."""
    rows = []
    for (source, name), group in data.groupby(["source", "name"], sort=False):
        behind = rate(group["gain"] > group["rival_gain"])
        rivals = ", ".join(group["rival"].drop_duplicates())
        medians = group[["gain", "rival_gain"]].median()
        rows.append({"source": source, "name": name, "rivals": rivals} | medians.to_dict() | behind)
    return pd.DataFrame(rows, columns=COLUMNS)


def page(found):
    """Lay the gains out, a row for each source and name."""
    return pd.DataFrame({
        "logs": found["source"].str.upper().replace(SEALED.upper(), SEALED),
        "name": found["name"].map(title_of),
        "wrong name": found["rivals"].map(lambda names: ", ".join(map(title_of, names.split(", ")))),
        "gain of the name": found["gain"].map(tables.number),
        "gain of the wrong name": found["rival_gain"].map(tables.number),
        "name ahead": [f"{round(one.rate * one.count_)} of {one.count_}" for one in
                       found.rename(columns={"count": "count_"}).itertuples()],
    })  # fmt: skip


def numbers(data):
    """Return what the text says of the sealed logs, and of each device."""
    found = {}
    for source, group in data.groupby("source", sort=False):
        ahead = rate(group["gain"] > group["rival_gain"])
        clear = group[group["gain"] > DECIDED]
        found[source] = {
            "count": ahead["count"],
            "ahead": round(ahead["count"] * ahead["rate"]),
            "low": f"{100 * ahead['low']:.0f}",
            "high": f"{100 * ahead['high']:.0f}",
            "clear": len(clear),
            "share": f"{100 * clear['share'].median():.0f}" if len(clear) else "—",
        }
    return found


with job(snakemake) as (source, _, output):
    data = pd.read_csv(source.comparisons)
    found = summary(data)
    save(output, table=(found, page(found)), numbers={"of": numbers(data)} | record_of(dict(source.items())))

"""Tabulate the baselines beside discovery, and write what the text says of them."""

import pandas as pd

from imu_benchmark import summary
from imugap.workflow.job_log import job
from imugap.workflow.products import record_of, save

KINDS = ("single", "pair", "triple", "nothing", "unknown")


def numbers(scores, answers, clear_size):
    """Return what the text says: numbers of cases, and the shares of each entry."""
    kinds = answers.drop_duplicates("case")["kind"].value_counts().reindex(KINDS, fill_value=0).to_dict()
    shares = scores[(scores["kind"] == summary.SHARE) & (scores["count"] > 0)]
    entries = {
        entry: {
            one.score: {"right": round(one.rate * one.count), "count": int(one.count)}
            for one in group.itertuples(index=False)
        }
        for entry, group in shares.groupby("entry", sort=False)
    }
    return {"cases": sum(kinds.values()), "kinds": kinds, "clear": f"{clear_size:g}", "entries": entries}


with job(snakemake) as (source, params, output):
    files = dict(source.items())
    scores, answers = pd.read_csv(files["summary"]), pd.read_csv(files["answers"])
    save(
        output,
        table=(scores, summary.table(scores).rename(columns=lambda name: name.replace("_", " "))),
        numbers=numbers(scores, answers, params.clear_size) | record_of(files),
    )

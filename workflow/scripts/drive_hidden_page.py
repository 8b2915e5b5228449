"""Tabulate the effects that the diagnosis named against the unmodelled ones."""

from pathlib import Path

import pandas as pd
import yaml

from imugap.navigation.drive.vehicle_diagnosis import CANDIDATES
from imugap.workflow import tables
from imugap.workflow.job_log import job
from imugap.workflow.products import save

NOTHING = "nothing"
TESTS = {"mean": "not zero-mean", "white": "not white", "size": "not as large"}


def page(found):
    """Lay the names out: a row per hidden effect."""
    for hidden, one in found.groupby("hidden", sort=False):
        named = one["named"].value_counts()
        row = {"hidden": hidden, "runs": len(one)}
        row |= {f"named: {name}": int(named.get(name, 0)) for name in (NOTHING, *CANDIDATES)}
        row["named: other"] = len(one) - sum(row[f"named: {name}"] for name in (NOTHING, *CANDIDATES))
        row |= {title: int((one[test] < one["alpha"]).sum()) for test, title in TESTS.items()}
        row |= {f"gain, {name}": tables.number(one[f"gain, {name}"].median(), 2) for name in CANDIDATES}
        yield row


with job(snakemake) as (source, _, output):
    found = pd.read_csv(source.names)
    nothing = found["hidden"] == NOTHING
    said = {
        "right": int((found["named"] == found["hidden"])[~nothing].sum()), "hidden": int((~nothing).sum()),
        "false": int((found["named"] != NOTHING)[nothing].sum()), "clean": int(nothing.sum()),
        "alpha": float(found["alpha"].iloc[0]),
        "recipe": yaml.safe_load(Path(source.recipe).read_text())["hidden"],
    }  # fmt: skip
    save(output, table=(found, page(found)), numbers=said)

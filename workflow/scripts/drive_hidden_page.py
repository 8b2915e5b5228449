"""Tabulate the effects that the diagnosis named against the unmodelled ones."""

import json
from pathlib import Path

import pandas as pd
import yaml

from imugap.navigation.vehicle_diagnosis import CANDIDATES
from imugap.workflow import tables
from imugap.workflow.job_log import journal

NOTHING = "nothing"
TESTS = {"mean": "not zero-mean", "white": "not white", "size": "not as large"}


def page(found):
    """Lay the names out: a row per hidden effect."""
    rows = []
    for hidden, one in found.groupby("hidden", sort=False):
        named = one["named"].value_counts()
        row = {"hidden": hidden, "runs": len(one)}
        row |= {f"named: {name}": int(named.get(name, 0)) for name in (NOTHING, *CANDIDATES)}
        row["named: other"] = len(one) - sum(row[f"named: {name}"] for name in (NOTHING, *CANDIDATES))
        row |= {title: int((one[test] < one["alpha"]).sum()) for test, title in TESTS.items()}
        row |= {f"gain, {name}": tables.number(one[f"gain, {name}"].median(), 2) for name in CANDIDATES}
        rows.append(row)
    return pd.DataFrame(rows)


if __name__ == "__main__":
    with journal(snakemake.log[0]):
        found, output = pd.read_csv(snakemake.input.names), snakemake.output
        tables.write(output.table.removesuffix(".csv"), found, page(found))
        nothing = found["hidden"] == NOTHING
        said = {
            "right": int((found["named"] == found["hidden"])[~nothing].sum()), "hidden": int((~nothing).sum()),
            "false": int((found["named"] != NOTHING)[nothing].sum()), "clean": int(nothing.sum()),
            "alpha": float(found["alpha"].iloc[0]),
            "recipe": yaml.safe_load(Path(snakemake.input.recipe).read_text())["hidden"],
        }  # fmt: skip
        Path(output.numbers).write_text(json.dumps(said, indent=1) + "\n")

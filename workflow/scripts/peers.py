"""Fit the models that gmwm was run with, by its own objective, and compare what is reached and how fast."""

import json
from pathlib import Path
from time import process_time

import pandas as pd

from imugap import log, readers, tables
from imugap.effects import GaussMarkov, Quantization, RandomWalk, WhiteNoise
from imugap.figures import AXIS_TITLES
from imugap.indirect import Weighting, fit
from imugap.journal import journal

KINDS = {"WN": (WhiteNoise,), "RW": (RandomWalk,), "QN": (Quantization,), "AR1": (GaussMarkov,)}
KINDS["2AR1"] = (GaussMarkov, GaussMarkov)


def compared(table, interval, peer):
    """Return the objective and the processor time of every fit beside the peer's."""
    rows = []
    for one in peer.itertuples():
        kinds = [kind for term in one.model.split("+") for kind in KINDS[term]]
        sequence = table[one.axis].to_numpy()
        fit(sequence, interval, kinds, weighting=Weighting.INTERVAL)
        start = process_time()
        found = fit(sequence, interval, kinds, weighting=Weighting.INTERVAL)
        spent = process_time() - start
        rows.append({"axis": one.axis, "model": one.model, "gmwm": one.objective, "minimum": one.minimum,
                     "here": found.objective, "gmwm_s": one.cpu_s, "here_s": spent})  # fmt: skip
    return pd.DataFrame(rows)


def page(data):
    """Lay the table out: a row per axis and model."""
    return pd.DataFrame(
        {
            "axis": data["axis"].map(AXIS_TITLES),
            "model": data["model"],
            "objective, gmwm": data["gmwm"].map(lambda v: tables.number(v, 5)),
            "objective, here": data["here"].map(lambda v: tables.number(v, 5)),
            "gmwm / here": (data["gmwm"] / data["here"]).map(lambda v: tables.fixed(v, 4)),
            "time, gmwm [s]": data["gmwm_s"].map(tables.number),
            "time, here [s]": data["here_s"].map(lambda v: tables.number(v, 2)),
        }
    )


if __name__ == "__main__":
    with journal(snakemake.log[0]):
        table = readers.read(snakemake.input.log)
        data = compared(table, log.interval(table), pd.read_csv(snakemake.input.peer))
        tables.write(snakemake.output[0].removesuffix(".csv"), data, page(data))
        ratio, faster = data["gmwm"] / data["here"], data["gmwm_s"] / data["here_s"]
        said = {
            "fits": len(data),
            "reached": int((data["here"] <= data["minimum"] * (1 + 1e-6)).sum()),
            "smallest": tables.fixed(ratio.min(), 4),
            "largest": tables.fixed(ratio.max(), 2),
            "slowest": f"{faster.min():.0f}",
            "median": f"{faster.median():.0f}",
        }
        Path(snakemake.output[-1]).write_text(json.dumps(said, indent=1) + "\n")

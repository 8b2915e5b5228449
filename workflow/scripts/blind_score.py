"""Score the blind benchmark."""

import json
from pathlib import Path

import pandas as pd

from imugap import blind
from imugap.journal import journal

TERMS = {"white_noise": "WN", "quantization": "QN", "random_walk": "RW", "gauss_markov": "AR1", "rate_ramp": "DR"}
"""What the R package gmwm calls the names that its choice of a model can give."""


def main(source, clear_size, output):
    """Read keys, reports and run times; write the scores case by case and what they come to."""
    keys = [blind.read_key(path) for path in source.key]
    reports = [blind.read_report(path) for path in source.reports]
    scores = blind.score(keys, reports, [json.loads(Path(path).read_text())["seconds"] for path in source.seconds])
    quiet = quiet_views(keys, source.views)
    tables = {
        # run times differ from run to run: apart from them, the tables are the same on every machine
        "cases": scores.cases.drop(columns="seconds"),
        "run_time": scores.cases[["case", "rate_hz", "duration_s", "seconds"]],
        "effects": scores.effects,
        "parameters": scores.parameters,
        "detection": blind.detection(scores.effects),
        "false_alarms": blind.false_alarms(scores.cases),
        "confusion": blind.confusion(scores.effects, clear_size).reset_index(),
        "naming": blind.naming(scores.effects, clear_size),
        "beside": blind.beside(scores.effects, TERMS, clear_size),
        "coverage": blind.coverage(scores.parameters),
        "closed": blind.closed(scores, clear_size),
        "p_values": quiet,
        "calibration": blind.calibration(quiet),
    }
    for name, table in tables.items():
        table.to_csv(output[name], index=False)


def quiet_views(keys, paths):
    """Return the p-values of the views of the cases that hide nothing, under the start model, which is right there."""
    views = [
        pd.read_csv(path).assign(case=key["case"])
        for key, path in zip(keys, paths, strict=True)
        if key["kind"] == "nothing"
    ]
    columns = {"case": "case", "view": "view", "axis": "axis", "start": "p_value"}
    table = pd.concat([pd.DataFrame(columns=list(columns), dtype=float), *views], ignore_index=True)
    return table.rename(columns=columns)[list(columns.values())].dropna(subset=["p_value"])


if __name__ == "__main__":
    with journal(snakemake.log[0]):
        main(snakemake.input, snakemake.params.clear_size, dict(snakemake.output.items()))

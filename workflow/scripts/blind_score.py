"""Score the blind benchmark."""

from pathlib import Path

import pandas as pd

from imu_benchmark import scores as blind
from imu_benchmark.answers import read_report
from imugap.workflow.job_log import job
from imugap.workflow.products import read_json, save


def quiet_views(keys, paths):
    """Return the p-values of the views of cases without hidden effects, whose start model is right."""
    views = [
        pd.read_csv(path).assign(case=key["case"])
        for key, path in zip(keys, paths, strict=True)
        if key["kind"] == "nothing"
    ]
    columns = {"case": "case", "view": "view", "axis": "axis", "start": "p_value"}
    table = pd.concat([pd.DataFrame(columns=list(columns), dtype=float), *views], ignore_index=True)
    return table.rename(columns=columns)[list(columns.values())].dropna(subset=["p_value"])


with job(snakemake) as (source, _, output):
    keys = [blind.read_key(path) for path in source.key]
    found = {case.name: case for batch in source.found for case in Path(batch).iterdir()}
    answers = [found[key["case"]] for key in keys]
    reports = [read_report(answer / "report.json") for answer in answers]
    seconds = [read_json(answer / "seconds.json")["seconds"] for answer in answers]
    scores = blind.score(keys, reports, seconds)
    # run times differ from run to run: apart from them, the tables are the same on every machine
    run_time = scores.cases[["case", "rate_hz", "duration_s", "seconds"]]
    save(output, cases=scores.cases.drop(columns="seconds"), run_time=run_time, effects=scores.effects,
         parameters=scores.parameters, p_values=quiet_views(keys, [answer / "views.csv" for answer in answers]),
    )  # fmt: skip

"""Name what is missing from the model of each of a batch of sealed cases, and note how long each took."""

import json
from pathlib import Path
from time import perf_counter

from imugap.discovery.device import Settings
from imugap.discovery.inputs import Files, discover_files
from imugap.discovery.report import view_table
from imugap.workflow.job_log import job

with job(snakemake) as (source, params, output):
    settings = Settings(**params.settings, seed=params.seed)
    for case in map(Path, source.cases):
        begin, out = perf_counter(), Path(output[0]) / case.name
        logs = tuple(sorted(path for path in case.glob("*.parquet") if path.stem != "reference"))
        given = {"reference": case / "reference.parquet", "model": case / "model.yaml"}
        files = Files(logs, **{name: path for name, path in given.items() if path.exists()})
        result = discover_files(files, settings)
        out.mkdir(parents=True)
        (out / "report.json").write_text(json.dumps(result.report(), indent=1, allow_nan=False) + "\n")
        view_table(result.found).to_csv(out / "views.csv", index=False)
        (out / "seconds.json").write_text(json.dumps({"seconds": perf_counter() - begin}) + "\n")
        print(case.name)

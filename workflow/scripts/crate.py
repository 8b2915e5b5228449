"""Describe the last run of the workflow as a Provenance Run Crate, whose folder is that of the project."""

import json
from importlib.metadata import version
from pathlib import Path

from imugap.workflow import run_records
from imugap.workflow.job_log import job
from imugap.workflow.run_crate import crate

with job(snakemake) as (source, params, output):
    software = json.loads(Path(source.software).read_text())
    records = run_records.read(".")
    made = {path: one for path, one in records.items() if path not in output and Path(path).exists()}
    found = crate(made, software, version("snakemake"))
    Path(output[0]).write_text(json.dumps(found.metadata.generate(), indent=1) + "\n")

"""Turn a raw log into a canonical one and report on its integrity."""

import json
from dataclasses import asdict
from pathlib import Path

from imugap import log
from imugap.integrity import report as integrity
from imugap.io import recording
from imugap.io.catalogue import datasets as catalogue
from imugap.io.catalogue import readers
from imugap.workflow.job_log import job


def main(raw, dataset, run, log_path, report_path):
    """Read by the catalogue where the data set is in it, else as a canonical log; write the log and its report."""
    if dataset:
        catalogue.verify(dataset.file(run), raw)
        table = readers.read_raw(raw, dataset, run)
        report = integrity.report(readers.read_raw_table(raw, dataset, run))
    else:
        found = recording.read(raw)
        report, table = integrity.report(found.table), found.log
        if log.axes(table) != log.AXES:
            raise log.LogError(raw, "columns", f"all of {', '.join(log.AXES)}", ", ".join(table.columns))
    facts = report.facts() | {"axes": [asdict(axis) for axis in report.axes]}
    Path(report_path).write_text(json.dumps(facts, indent=1) + "\n")
    log.write(table, log_path)


with job(snakemake) as (_, params, output):
    dataset = catalogue.load("data", "workflow/schemas").get(params.device)
    for run, raw, *paths in zip(params.runs, params.raw, output.logs, output.integrity, strict=True):
        main(raw, dataset, run, *paths)

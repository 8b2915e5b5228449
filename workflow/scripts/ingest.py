"""Turn a raw log into a canonical one and report on its integrity."""

import json
from dataclasses import asdict
from pathlib import Path

from imugap import log
from imugap.estimation.indices import INDICES, shortest
from imugap.integrity import report as integrity
from imugap.io import recording
from imugap.io.catalogue import datasets as catalogue
from imugap.io.catalogue import readers
from imugap.workflow.job_log import job


def require_length(table, period, raw):
    """Raise a LogError unless a log is long enough for every index."""
    length, interval = log.duration(table), log.interval(table)
    needed = max(shortest(symbol, period, interval) for symbol in INDICES)
    if length < needed:
        expected = f"at least {needed:g} s at rest, for every index of the study (imugap indices takes a shorter log)"
        raise log.LogError(raw, "duration", expected, f"{length:g} s")


def main(raw, dataset, run, period, log_path, report_path):
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
        require_length(table, period, raw)
    facts = report.facts() | {"axes": [asdict(axis) for axis in report.axes]}
    Path(report_path).write_text(json.dumps(facts, indent=1) + "\n")
    log.write(table, log_path)


with job(snakemake) as (_, params, output):
    dataset = catalogue.load("data", "workflow/schemas").get(params.device)
    for run, raw, *paths in zip(params.runs, params.raw, output.logs, output.integrity, strict=True):
        main(raw, dataset, run, params.period_s, *paths)

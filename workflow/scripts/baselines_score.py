"""Reveal the keys, score all entries, and keep the answers to each hidden effect."""

from pathlib import Path

import pandas as pd

from imu_benchmark import answers, commitments
from imu_benchmark.summary import scored, together
from imugap.workflow.job_log import job
from imugap.workflow.products import save

DISCOVERY = "discovery"
"""Name of the entry of this library."""


def discovery(batches):
    """Return the answers of all batches as one entry."""
    parts = [
        answers.read_entry(batch, [path.parent.name for path in Path(batch).glob(f"*/{answers.REPORT}")])
        for batch in batches
    ]
    reports = {case: report for part in parts for case, report in part.reports.items()}
    return answers.Entry(DISCOVERY, reports, {case: time for part in parts for case, time in part.seconds.items()})


with job(snakemake) as (source, params, output):
    cases = commitments.read_cases(source.public)
    keys = commitments.read_secret(source.secret, source.public)
    entries = [*(answers.read_entry(entry, cases) for entry in source.entries), discovery(source.discovered)]
    found = [scored(entry, keys, params.clear_size) for entry in entries]
    save(
        output,
        summary=together(found),
        answers=pd.concat([one.scores.effects.assign(entry=one.name) for one in found], ignore_index=True),
    )

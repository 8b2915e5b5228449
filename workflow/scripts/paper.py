"""Compile the paper, and list what it states, each value with the cell that it rests on."""

import typst

from imugap.study import statements
from imugap.workflow.job_log import job
from imugap.workflow.products import save

HEADS = {"section": "section", "page": "page", "value": "value in the text", "file": "file", "cell": "cell",
         "cited": "cited beside it"}  # fmt: skip

with job(snakemake) as (source, _, output):
    typst.compile(source.main, output=output[0], root="paper")
    data, faults = statements.collect(source.main)
    if faults:
        raise ValueError("\n".join(["statements of the paper:", *faults]))
    save(output, statements=(data, data[list(HEADS)].rename(columns=HEADS)))

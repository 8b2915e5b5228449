"""Compile the paper."""

import typst

from imugap.workflow.job_log import job

with job(snakemake) as (source, _, output):
    typst.compile(source.main, output=output[0], root="paper")

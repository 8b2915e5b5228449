"""Compile the paper."""

import typst

from imugap.workflow.job_log import journal

if __name__ == "__main__":
    with journal(snakemake.log[0]):
        typst.compile(snakemake.input.main, output=snakemake.output[0], root="paper")

"""Read the optical reference attitude of every trial."""

from imugap.io import datasets as catalogue
from imugap.io import readers
from imugap.workflow.job_log import journal

if __name__ == "__main__":
    with journal(snakemake.log[0]):
        broad = catalogue.load("data", "workflow/schemas")["broad"]
        for run, raw, path in zip(snakemake.params.trials, snakemake.input.raw, snakemake.output, strict=True):
            catalogue.verify(broad.file(run), raw)
            readers.read_reference(raw, broad, run).to_parquet(path)

"""Read the optical reference attitude of every trial."""

from imugap.io.catalogue import datasets as catalogue
from imugap.io.catalogue import readers
from imugap.workflow.job_log import job

with job(snakemake) as (source, params, output):
    broad = catalogue.load("data", "workflow/schemas")["broad"]
    for run, raw, path in zip(params.trials, source.raw, output, strict=True):
        catalogue.verify(broad.file(run), raw)
        readers.read_reference(raw, broad, run).to_parquet(path)

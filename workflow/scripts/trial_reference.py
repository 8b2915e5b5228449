"""Read the optical reference attitude of a trial."""

from imugap.io import datasets as catalogue
from imugap.io import readers
from imugap.workflow.job_log import journal

if __name__ == "__main__":
    with journal(snakemake.log[0]):
        broad, run = catalogue.load("data", "workflow/schemas")["broad"], int(snakemake.wildcards.run)
        catalogue.verify(broad.file(run), snakemake.input.raw)
        readers.read_reference(snakemake.input.raw, broad, run).to_parquet(snakemake.output[0])

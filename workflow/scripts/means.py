"""Cut logs short and average them over blocks."""

from imugap import log
from imugap.io import readers
from imugap.workflow.job_log import journal

if __name__ == "__main__":
    with journal(snakemake.log[0]):
        params = snakemake.params
        for source, output in zip(snakemake.input[: len(snakemake.output)], snakemake.output, strict=True):
            table = readers.read(source).loc[: params.duration_s]
            table = table if params.columns is None else table[params.columns]
            factor = max(round(1 / (log.interval(table) * params.rate_hz)), 1)
            whole = table.iloc[: len(table) // factor * factor]
            means = {name: whole[name].to_numpy().reshape(-1, factor).mean(axis=1) for name in whole}
            log.write(log.from_samples(means, factor * log.interval(table)), output)

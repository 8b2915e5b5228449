"""Estimate the error model of the flying device from the first minutes of its static log, by every scheme."""

from pathlib import Path

import pandas as pd
import yaml

from imugap import log
from imugap.study import attitude_schemes as schemes
from imugap.workflow.job_log import journal

if __name__ == "__main__":
    with journal(snakemake.log[0]):
        static = log.load(snakemake.input.log)
        rows, models = [], {}
        for minutes in snakemake.params.minutes:
            begun = static[static.index < 60 * minutes]
            fits = {scheme: schemes.fit(begun, scheme) for scheme in schemes.SCHEMES}
            rows += [schemes.table(found, minutes=minutes, scheme=scheme) for scheme, found in fits.items()]
            models[minutes] = {scheme: schemes.believed(found).to_mapping() for scheme, found in fits.items()}
        pd.concat(rows).to_csv(snakemake.output.estimates, index=False)
        Path(snakemake.output.models).write_text(yaml.safe_dump(models, sort_keys=False))

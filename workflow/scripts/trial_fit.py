"""Estimate the error model from both rests of every trial, by every scheme; the first rest makes the filter's model."""

from pathlib import Path

import pandas as pd
import yaml

from imugap import log
from imugap.io import reference
from imugap.study import attitude_schemes
from imugap.workflow.job_log import journal

if __name__ == "__main__":
    with journal(snakemake.log[0]):
        rows, models = [], {}
        trials = zip(snakemake.params.trials, snakemake.input.logs, snakemake.input.references, strict=True)
        for trial, log_path, reference_path in trials:
            table = log.load(log_path)
            first, last = reference.rests(table, pd.read_parquet(reference_path), snakemake.params.margin_s)
            for name, rest in {"first": first, "last": last}.items():
                fits = {scheme: attitude_schemes.fit(rest, scheme) for scheme in attitude_schemes.SCHEMES}
                rows += [
                    attitude_schemes.table(one, trial=trial, rest=name, scheme=scheme) for scheme, one in fits.items()
                ]
                if name == "first":
                    models[trial] = {
                        scheme: attitude_schemes.filter_model(one).to_mapping() for scheme, one in fits.items()
                    }
        pd.concat(rows).to_csv(snakemake.output.estimates, index=False)
        Path(snakemake.output.models).write_text(yaml.safe_dump(models, sort_keys=False))

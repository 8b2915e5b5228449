"""Estimate the error model from both rests of every trial, by every scheme; the first rest makes the filter's model."""

from pathlib import Path

import pandas as pd
import yaml

from imugap import log
from imugap.io.references import reference
from imugap.study.attitude import attitude_schemes
from imugap.workflow.job_log import job
from imugap.workflow.products import save

with job(snakemake) as (source, params, output):
    rows, models = [], {}
    for trial, log_path, reference_path in zip(params.trials, source.logs, source.references, strict=True):
        table = log.load(log_path)
        rests = reference.rests(table, pd.read_parquet(reference_path), params.margin_s)
        for name, rest in zip(("first", "last"), rests, strict=True):
            fits = {scheme: attitude_schemes.fit(rest, scheme) for scheme in attitude_schemes.SCHEMES}
            rows += [attitude_schemes.table(one, trial=trial, rest=name, scheme=of) for of, one in fits.items()]
            if name == "first":
                models[trial] = {of: attitude_schemes.filter_model(one).to_mapping() for of, one in fits.items()}
    save(output, estimates=pd.concat(rows))
    Path(output.models).write_text(yaml.safe_dump(models, sort_keys=False))

"""Simulate flights, and fit the error model of each device to the static log ahead of its flight, by every scheme."""

from pathlib import Path

import yaml

from imugap import log
from imugap.simulation.flight import Flight
from imugap.study.attitude import attitude_schemes
from imugap.workflow.job_log import job

with job(snakemake) as (source, params, output):
    flight = Flight.read(source.recipe)
    files = zip(params.runs, output.flights, output.estimates, output.models, strict=True)
    for run, flown, estimates, models in files:
        static = flight.static(run, 60 * max(params.minutes), params.seed)
        table, fitted = attitude_schemes.fitted(static, params.minutes)
        table.to_csv(estimates, index=False)
        Path(models).write_text(yaml.safe_dump(fitted, sort_keys=False))
        log.write(flight.fly(run, params.seed), flown)
        print(f"flight {run}")

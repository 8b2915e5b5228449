"""Write the true trajectory of the simulated flight and the true model of its device."""

from pathlib import Path

import yaml

from imugap.simulation.flight import Flight
from imugap.workflow.job_log import job

with job(snakemake) as (source, _, output):
    flight = Flight.read(source.recipe)
    flight.truth().to_parquet(output.trajectory)
    models = {0: {"truth": flight.model.to_mapping()}}
    Path(output.models).write_text(yaml.safe_dump(models, sort_keys=False))

"""Write the true trajectory of the simulated flight and the true model of its device."""

from pathlib import Path

import yaml

from imugap.simulation.flight import Flight
from imugap.workflow.job_log import journal

if __name__ == "__main__":
    with journal(snakemake.log[0]):
        flight = Flight.read(snakemake.input.recipe)
        flight.truth().to_parquet(snakemake.output.trajectory)
        models = {0: {"truth": flight.model.to_mapping()}}
        Path(snakemake.output.models).write_text(yaml.safe_dump(models, sort_keys=False))

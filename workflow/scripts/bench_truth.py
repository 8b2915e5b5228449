"""Write the truth of the virtual bench."""

import json
from pathlib import Path

from imugap.simulation.bench import Bench
from imugap.workflow.job_log import journal

if __name__ == "__main__":
    with journal(snakemake.log[0]):
        truth = Bench.read(snakemake.input.recipe).truth()
        Path(snakemake.output[0]).write_text(json.dumps(truth, indent=1) + "\n")

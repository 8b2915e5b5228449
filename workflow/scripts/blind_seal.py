"""Seal the cases of the blind benchmark."""

from pathlib import Path

import yaml

from imugap.benchmark.sealing import plan, seal, write
from imugap.io.configuration import configure
from imugap.workflow.job_log import journal


def main(recipe, params, cases, keys):
    """Plan the cases, seal each, and write its logs below ``cases`` and its key below ``keys``."""
    for case in plan(params.seed, params.cases, recipe["shares"], recipe):
        write(seal(case, recipe), cases, keys)
    print(f"{params.cases} cases")


if __name__ == "__main__":
    with journal(snakemake.log[0]):
        source, output = snakemake.input, snakemake.output
        recipe = configure(yaml.safe_load(Path(source.recipe).read_text()), source.schema)
        main(recipe, snakemake.params, Path(output.cases[0]).parent, Path(output.key[0]).parent)

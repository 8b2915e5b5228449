"""Name what is missing from the model of one sealed case, and note how long it took."""

import json
from pathlib import Path
from time import perf_counter

from imugap.discovery import discover
from imugap.journal import journal


def main(case, seed, out):
    """Discover on the logs of the folder ``case``, with its reference and its start model where it has them."""
    logs = sorted(path for path in case.glob("*.parquet") if path.stem != "reference")
    given = {"reference": case / "reference.parquet", "model": case / "model.yaml"}
    discover(logs, out=out, seed=seed, **{name: path for name, path in given.items() if path.exists()})


if __name__ == "__main__":
    with journal(snakemake.log[0]):
        begin = perf_counter()
        main(Path(snakemake.input.case), snakemake.params.seed, Path(snakemake.output.report).parent)
        seconds = perf_counter() - begin
        Path(snakemake.output.seconds).write_text(json.dumps({"seconds": seconds}) + "\n")

"""Name what is missing from the model of one sealed case, and note how long it took."""

import json
from pathlib import Path
from time import perf_counter

from imugap.discovery.device import Question
from imugap.discovery.inputs import Files, ask
from imugap.discovery.report import view_table
from imugap.workflow.job_log import journal


def main(case, question, output):
    """Discover on the logs of the folder ``case``, with its reference and its start model where it has them."""
    logs = tuple(sorted(path for path in case.glob("*.parquet") if path.stem != "reference"))
    given = {"reference": case / "reference.parquet", "model": case / "model.yaml"}
    files = Files(logs, **{name: path for name, path in given.items() if path.exists()})
    inquiry = ask(files, question)
    Path(output.report).write_text(json.dumps(inquiry.report(), indent=1, allow_nan=False) + "\n")
    view_table(inquiry.found).to_csv(output.views, index=False)


if __name__ == "__main__":
    with journal(snakemake.log[0]):
        begin = perf_counter()
        question = Question(**snakemake.params.asked, seed=snakemake.params.seed)
        main(Path(snakemake.input.case), question, snakemake.output)
        seconds = perf_counter() - begin
        Path(snakemake.output.seconds).write_text(json.dumps({"seconds": seconds}) + "\n")

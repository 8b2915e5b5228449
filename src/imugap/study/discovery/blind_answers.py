"""Answers of discovery to cases of the blind benchmark, from their logs alone."""

import json
from pathlib import Path
from time import perf_counter

from imugap.discovery.device import Settings
from imugap.discovery.inputs import Files, discover_files
from imugap.discovery.report import view_table
from imugap.log import FORMATS


def answer(case: Path, settings: Settings, out: Path) -> None:
    """Write the report of a case, its views and its run time [s] into the folder ``out``/CASE, which is made.

    ``case`` is a folder of logs, with the error-free log and the start model where there are any.
    """
    begin, folder = perf_counter(), out / case.name
    logs = sorted(path for path in case.iterdir() if path.suffix in FORMATS and path.stem != "reference")
    given = {path.stem: path for path in case.iterdir() if path.stem in ("reference", "model")}
    result = discover_files(Files(tuple(logs), **given), settings)
    folder.mkdir(parents=True)
    (folder / "report.json").write_text(json.dumps(result.report(), indent=1, allow_nan=False) + "\n")
    view_table(result.found).to_csv(folder / "views.csv", index=False)
    (folder / "seconds.json").write_text(json.dumps({"seconds": perf_counter() - begin}) + "\n")

"""Baselines: programs to compare with, one module each, whose function ``report`` answers a case.

Each uses what is common practice or a well-kept library, with the settings of its source and without any tuning to
cases. Some need the extra ``baselines`` of this package.
"""

import json
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from time import perf_counter

from imu_benchmark.answers import REPORT, SECONDS
from imu_benchmark.case import Case, read_case
from imu_benchmark.commitments import CASES, read_cases
from imu_benchmark.schema import FormatError

BASELINES = ("nothing", "allan_slopes", "noise_id", "gmwm_choice", "change_points", "classifier")


def named(name: str) -> Callable[[Case], dict]:
    """Return the function that answers a case, of the baseline ``name``."""
    return import_module(f"imu_benchmark.baselines.{name}").report


def answer_all(report: Callable[[Case], dict], public: str | Path, out: str | Path) -> None:
    """Write the report of every case of a benchmark and its run time [s] into the new folder ``out``."""
    out = Path(out)
    cases = read_cases(public)
    if out.exists():
        raise FormatError(out, "", "nothing, for it is made", "a file or a folder")
    for name in cases:
        begin = perf_counter()
        found = report(read_case(Path(public) / CASES / name))
        folder = out / name
        folder.mkdir(parents=True)
        (folder / REPORT).write_text(json.dumps(found, indent=1, allow_nan=False) + "\n")
        (folder / SECONDS).write_text(json.dumps({"seconds": perf_counter() - begin}) + "\n")

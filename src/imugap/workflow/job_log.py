"""The log file of a job: everything that it prints, warns and raises."""

import sys
import traceback
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from pathlib import Path

from imugap.workflow.restart import end_with_main


@contextmanager
def journal(path: str | Path) -> Iterator[None]:
    """Send output and warnings of the block to the file at ``path``, and an exception to the file and onwards."""
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("w", buffering=1) as file, redirect_stdout(file), redirect_stderr(file):
        try:
            yield
        except BaseException:
            traceback.print_exc(file=file)
            raise
        print("done", file=sys.stdout)


@contextmanager
def job(rule) -> Iterator[tuple]:
    """Run the block as the job of a rule (``snakemake`` of its script), with its log; give input, params, output."""
    end_with_main()
    with journal(rule.log[0]):
        yield rule.input, rule.params, rule.output

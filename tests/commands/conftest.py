"""Run commands in a working directory of their own, with links to the files of the module (fixture ``files``)."""

import re
import shlex
from pathlib import Path

import pytest
from matplotlib.figure import Figure

from imugap import cli


def names(folder):
    return {path.name for path in Path(folder).iterdir()}


@pytest.fixture
def here(tmp_path, monkeypatch, files):
    """Work in a folder with links to the files of the module."""
    monkeypatch.chdir(tmp_path)
    for path in files.iterdir():
        Path(path.name).symlink_to(path)
    return tmp_path


@pytest.fixture
def refused(here, capsys):
    """Run a command line that has to end with one message, exit code 1 and no file more than before.

    Only lines of the standard error that match ``among`` count.
    """

    def run(line, message, among=""):
        before = names(here)
        assert cli.main(shlex.split(line)) == 1
        lines = capsys.readouterr().err.replace("\r", "\n").splitlines()
        (said,) = (one for one in lines if re.match(among, one))
        assert re.match(f"imugap: .*{message}", said)
        assert names(here) - {"__pycache__"} == before

    return run


@pytest.fixture
def fill_disk(monkeypatch):
    """From its call on every figure fails halfway."""

    def fail(_, path, **_options):
        Path(path).write_text("half")
        raise OSError("disk full")

    return lambda: monkeypatch.setattr(Figure, "savefig", fail)

"""A command that is killed leaves the older output or the new one, never a mixture."""

import multiprocessing
import os
import shlex
import time
from contextlib import suppress
from importlib import import_module

import numpy as np
import pytest
from tests.hostile.harness import driven, walk

from imugap import cli, log
from imugap.effects import Bias, WhiteNoise
from imugap.model import ErrorModel
from imugap.stream import stream

LINES = {
    "estimate": "estimate {}.csv --terms white_noise --out found",
    "discover": "discover {}.csv --workers 2 --out found",
    "walk": "walk {}_walk.csv --out found",
    "drive": "drive {}_imu.csv fixes.csv --out found",
}


KILLS = [
    ("estimate", 3),
    *(
        pytest.param(*one, marks=(pytest.mark.slow, pytest.mark.each))
        for one in (("discover", 5), ("walk", 5), ("drive", 3))
    ),
    pytest.param("discover", 20, marks=pytest.mark.slow),
    pytest.param("estimate", 70, marks=pytest.mark.slow),
]
"""Commands and the number of times that each is killed: fewer, the longer the command takes."""


@pytest.fixture(scope="module")
def inputs(tmp_path_factory):
    """Two inputs of each command: ``one`` and ``two``; what the commands import is imported once for all."""
    for command in LINES:
        import_module(f"imugap.commands.{command}")
    folder = tmp_path_factory.mktemp("killed")
    model = ErrorModel({"gyro_x": WhiteNoise(1e-4) + Bias(1e-3)})
    still = log.from_samples({"gyro_x": np.zeros(1500)}, 0.04)
    record, fixes = driven()
    for seed, name in enumerate(("one", "two")):
        log.write(model.simulate(still, seed, "killed"), folder / f"{name}.csv")
        other = {"gyro_z": lambda table, seed=seed: table["gyro_z"] + 1e-4 * seed}
        log.write(walk().assign(**other), folder / f"{name}_walk.csv")
        log.write(record.assign(**other), folder / f"{name}_imu.csv")
    fixes.to_csv(folder / "fixes.csv")
    return folder


def begun(folder, line):
    """Start a command line in a process and a session of its own."""

    def run():
        os.chdir(folder)
        os.setsid()
        for descriptor in (1, 2):
            os.dup2(os.open(os.devnull, os.O_WRONLY), descriptor)
        os._exit(cli.main(shlex.split(line)))

    process = multiprocessing.get_context("fork").Process(target=run)
    process.start()
    return process


def contents(folder):
    return {path.relative_to(folder): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def wait_for_change(folder, process):
    """Return once anything in a folder has changed, or the process has ended."""

    def seen():
        return {path: path.lstat().st_mtime_ns for path in (folder, *folder.rglob("*")) if os.path.lexists(path)}

    before = seen()
    while process.is_alive():
        with suppress(FileNotFoundError):  # gone between its name and its time
            if seen() != before:
                return


def kill(process, folder, moment, rng, duration):
    """Kill a process at any time, or a little after it begins to write, or as its output changes."""
    if moment == 0:
        process.join(rng.uniform(0, 1.1) * duration)
    else:
        wait_for_change(folder if moment == 1 else folder / "found", process)
        process.join(rng.uniform(0, (0.3, 0.001)[moment - 1]))
    process.kill()
    process.join()


@pytest.mark.parametrize(("command", "kills"), KILLS)
def test_a_killed_command_leaves_the_old_or_the_new_output(inputs, tmp_path, command, kills):
    whole = {}
    for name in ("one", "two"):
        folder = tmp_path / name
        folder.mkdir()
        for path in inputs.iterdir():
            (folder / path.name).symlink_to(path)
        began = time.monotonic()
        process = begun(folder, LINES[command].format(name))
        process.join()
        assert process.exitcode == 0
        duration = time.monotonic() - began
        whole[name] = contents(folder / "found")
    assert whole["one"].keys() == whole["two"].keys()
    rng = stream(1, "killed", command)
    for number in range(kills):
        process = begun(tmp_path / "one", LINES[command].format(("two", "one")[number % 2]))
        kill(process, tmp_path / "one", number % 3, rng, duration)
        found = contents(tmp_path / "one" / "found")
        assert found in whole.values()
    process = begun(tmp_path / "one", LINES[command].format("two"))
    process.join()
    assert contents(tmp_path / "one" / "found") == whole["two"]

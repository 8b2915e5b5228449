"""Run one command line on one hostile input in this process, and say what is wrong with how it ends."""

import io
import os
import re
import shutil
import signal
import warnings
from collections.abc import Callable
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from tempfile import TemporaryFile

import numpy as np
import pandas as pd
import yaml
from scipy.spatial.transform import Rotation
from tests.hostile import mutations

from imugap import cli, log
from imugap.analysis import drive_settings
from imugap.effects import Bias, WhiteNoise
from imugap.interchange.devices import catalogue as devices
from imugap.interchange.export import Target
from imugap.io.catalogue import datasets
from imugap.kinematics.error_free import POSITION, QUATERNION, error_free_log
from imugap.model import ErrorModel
from imugap.simulation.drive import Drive
from imugap.simulation.walk import Walk, WalkCourse
from imugap.stream import stream
from imugap.units import STANDARD_GRAVITY

ROOT = Path(__file__).parents[2]
LONGEST_S = 60
FORM = re.compile(r"imugap: \S.*: .*expected .+; found .+")
"""Form of every message: place, expected, found."""
NOTE = re.compile(r"imugap: .+")
"""Form of a line that a command says besides."""
BUG = "an error of imugap itself"


class HungError(BaseException):
    """A case that takes more processor time than the limit."""


@dataclass(frozen=True)
class Case:
    """Command line, and the files that it reads."""

    command: str
    arguments: tuple[str, ...]
    contents: dict[str, bytes]


@cache
def static() -> pd.DataFrame:
    """Return a short static log of three axes."""
    model = ErrorModel({
        "gyro_x": WhiteNoise(1e-4) + Bias(1e-3), "gyro_z": WhiteNoise(1e-4) + Bias(1e-3),
        "accel_z": WhiteNoise(1e-3) + Bias(0.0),
    })  # fmt: skip
    ideal = log.from_samples({axis: np.full(400, -9.80665 * (axis == "accel_z")) for axis in model.axes}, 0.04)
    return model.simulate(ideal, 1, "hostile")


@cache
def walk() -> pd.DataFrame:
    """Return a walk of four strides."""
    recipe = replace(Walk.read(ROOT / "data" / "walk.yaml"), course=WalkCourse.out_and_back(2, stand_s=1.0))
    return recipe.record(1, 1)


@cache
def driven() -> tuple[pd.DataFrame, pd.DataFrame]:
    """Return the first part of a drive at 20 Hz, and its fixes in degrees."""
    recipe = replace(Drive.read(ROOT / "data" / "drive.yaml"), laps=1)
    fixes = recipe.fixes(1, 1).loc[:45.0]
    fixes = fixes.assign(**{name: np.degrees(fixes[name]) for name in ("latitude", "longitude")})
    record = recipe.record(1, 1)
    return record.iloc[:: max(round(0.05 / log.interval(record)), 1)].loc[:45.0], fixes


@cache
def posed() -> tuple[pd.DataFrame, pd.DataFrame]:
    """Return the poses of a body that tumbles and sways, and the log of a device on it."""
    time = 0.04 * np.arange(400)
    attitude = Rotation.from_euler(
        "ZYX", np.column_stack([0.8 * time, 0.5 * np.sin(1.3 * time), 0.4 * np.cos(0.9 * time)])
    )
    place = np.column_stack([np.sin(0.7 * time), time, np.cos(2 * time)])
    columns = dict(zip(QUATERNION, attitude.as_quat().T, strict=True)) | dict(zip(POSITION, place.T, strict=True))
    poses = pd.DataFrame(columns, index=pd.Index(time, name=log.TIME))
    return poses, error_free_log(poses, time, -STANDARD_GRAVITY)


def _csv(table: pd.DataFrame, index: bool = True) -> bytes:
    return table.to_csv(index=index).encode()


def _log(table: pd.DataFrame, rng: np.random.Generator) -> tuple[str, bytes]:
    """Return the name and the bytes of a mutated log."""
    if rng.uniform() < 0.25:
        return "log.csv", mutations.text_bytes(_csv(table), rng)
    changed = mutations.table_values(table, rng)
    if rng.uniform() < 0.25 and changed.columns.is_unique:
        return "log.parquet", mutations.parquet_bytes(changed, rng)
    return "log.csv", _csv(changed, index=False)


def _model(rng: np.random.Generator) -> dict[str, bytes]:
    return {"model.yaml": mutations.model_text(rng).encode("utf-8", errors="surrogateescape")}


def check(rng):
    """Draw a case of ``check``."""
    name, content = _log(static(), rng)
    return Case("check", (name,), {name: content})


def formats(rng):
    """Draw a case of ``check`` on arrays or a PX4 log, or of ``drive`` on fixes of a receiver, most of them refused."""
    if rng.uniform() < 0.3:
        record, fixes = driven()
        name, content = mutations.fix_file(fixes, rng)
        return Case("drive", ("log.csv", name, "--out", "out"), {"log.csv": _csv(record.iloc[:3]), name: content})
    name, content = mutations.array_file(mutations.table_values(static(), rng).select_dtypes("number"), rng)
    return Case("check", (name, *(("--topic", "0") if rng.uniform() < 0.1 else ())), {name: content})


def indices(rng):
    """Draw a case of ``indices``."""
    name, content = _log(static(), rng)
    return Case("indices", (name, "--out", "out.csv"), {name: content})


def estimate(rng):
    """Draw a case of ``estimate``, of one given effect or two in most."""
    name, content = _log(static()[["gyro_x"]], rng)
    method = str(rng.choice(["likelihood", "allan", "wavelet"]))
    terms = str(rng.choice(["white_noise", "white_noise,random_walk", "white_noise,gauss_markov"]))
    extra = ("--table", "out.csv", "--model", "out.yaml") if rng.uniform() < 0.2 else ()
    return Case("estimate", (name, "--method", method, "--terms", terms, "--out", "out.json", *extra), {name: content})


def discover(rng):
    """Draw a case of ``discover`` on one axis."""
    name, content = _log(static()[["gyro_x"]], rng)
    model = _model(rng) if rng.uniform() < 0.3 else {}
    arguments = (name, *(("--model", "model.yaml") if model else ()), "--workers", "1", "--out", "out")
    return Case("discover", arguments, {name: content} | model)


def walked(rng):
    """Draw a case of ``walk``."""
    if rng.uniform() < 0.3:
        return Case(
            "walk", ("log.csv", "--model", "model.yaml", "--out", "out"), {"log.csv": _csv(walk())} | _model(rng)
        )
    name, content = _log(walk(), rng)
    return Case("walk", (name, "--out", "out"), {name: content})


def drove(rng):
    """Draw a case of ``drive``: the log, the fixes, the configuration or the model is mutated."""
    record, fixes = driven()
    name, content, kind = "log.csv", _csv(record), rng.uniform()
    others = {"fixes.csv": _csv(fixes)}
    options: tuple[str, ...] = ()
    if kind < 0.3:
        name, content = _log(record, rng)
    elif kind < 0.6:
        fixes_name, changed = _log(fixes, rng)
        others = {fixes_name.replace("log", "fixes"): changed}
    else:
        schema = yaml.safe_load(drive_settings.SCHEMA.read_text())
        text = "model: model.yaml\n" if kind < 0.75 else mutations.configuration_text(schema, rng)
        others |= {"own.yaml": text.encode()} | _model(rng)
        options = ("--config", "own.yaml")
    fixes_file = next(one for one in others if one.startswith("fixes"))
    return Case("drive", (name, fixes_file, *options, "--out", "out"), {name: content} | others)


def simulate(rng):
    """Draw a case of ``simulate``."""
    rate = f"{10 ** rng.uniform(-7, 8):g}" if rng.uniform() < 0.2 else "25"
    duration = f"{10 ** rng.uniform(-9, 20):g}" if rng.uniform() < 0.2 else "20"
    if 1e5 < float(rate) * float(duration) < 1e16:  # sound, but not in the time of a test
        duration = "1"
    out = "out.txt" if rng.uniform() < 0.05 else str(rng.choice(["out.csv", "out.parquet"]))
    return Case("simulate", ("model.yaml", "--duration", duration, "--rate", rate, "--out", out), _model(rng))


def export(rng):
    """Draw a case of ``export`` to any target."""
    rate = f"{10 ** rng.uniform(-7, 8):g}" if rng.uniform() < 0.3 else "100"
    horizon = ("--horizon", f"{10 ** rng.uniform(-12, 12):g}") if rng.uniform() < 0.3 else ()
    target = str(rng.choice(list(Target)))
    return Case("export", ("model.yaml", "--to", target, "--rate", rate, *horizon, "--out", "out.yaml"), _model(rng))


def convert(rng):
    """Draw a case of ``convert``."""
    name, content = _log(static(), rng)
    if rng.uniform() < 0.3:
        name, content = mutations.array_file(mutations.table_values(static(), rng).select_dtypes("number"), rng)
    return Case("convert", (name, "--out", str(rng.choice(["out.parquet", "out.csv", name]))), {name: content})


def models(rng):
    """Draw a case of ``models``: a name that is none, or a file for the model of one."""
    known = devices.names()
    name = str(
        rng.choice([*known, *known, known[0].upper(), known[-1][:-1], "../x", "", "\x00", "Ω" * 300, "model.yaml"])
    )
    out = rng.choice(["", "out.yaml", "no/such/folder.yaml", "."])
    return Case("models", (name, *(("--out", str(out)) if out else ())), _model(rng))


def reference(rng):
    """Draw a case of ``reference``: the poses or the log are mutated."""
    poses, measured = posed()
    name, content = "log.csv", _csv(measured)
    others = {"poses.csv": _csv(poses)}
    if rng.uniform() < 0.5:
        name, content = _log(measured, rng)
    else:
        poses_name, changed = _log(poses, rng)
        others = {poses_name.replace("log", "poses"): changed}
    options = ("--align",) if rng.uniform() < 0.5 else ("--lag", f"{rng.normal():g}") if rng.uniform() < 0.5 else ()
    return Case("reference", (*others, "--log", name, *options, "--out", "out.csv"), {name: content} | others)


CASES: dict[str, Callable[[np.random.Generator], Case]] = {
    "check": check, "formats": formats, "indices": indices, "estimate": estimate, "discover": discover, "walk": walked,
    "drive": drove, "simulate": simulate, "export": export, "convert": convert, "models": models,
    "reference": reference,
}  # fmt: skip


@contextmanager
def limited():
    """Raise an error in the block after the longest processor time that a case may take."""

    def stop(*_):
        raise HungError

    former = signal.signal(signal.SIGPROF, stop)
    signal.setitimer(signal.ITIMER_PROF, LONGEST_S)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.signal(signal.SIGPROF, former)


@contextmanager
def heard():
    """Yield a file that gets all that this process, its libraries and its workers write to the standard error."""
    with TemporaryFile("a+", buffering=1) as file:
        kept = os.dup(2)
        os.dup2(file.fileno(), 2)
        try:
            with redirect_stderr(file):
                yield file
        finally:
            os.dup2(kept, 2)
            os.close(kept)


def faults(case: Case, folder: Path) -> list[str]:
    """Return what is wrong with how a case ends, in words; work in ``folder``, which is emptied."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()
    for name, content in case.contents.items():
        (folder / name).write_bytes(content)
    here = Path.cwd()
    os.chdir(folder)
    try:
        with heard() as err, limited(), redirect_stdout(io.StringIO()), warnings.catch_warnings():
            warnings.simplefilter("always")
            try:
                code = cli.main([case.command, *case.arguments])
            except SystemExit as end:
                code = end.code
            err.seek(0)
            text = err.read()
    except HungError:
        return [f"longer than {LONGEST_S} s"]
    except BaseException as error:
        return [f"{type(error).__name__} left main: {error}"]
    finally:
        os.chdir(here)
    return [*_of_text(code, text), *_of_files(code, case, folder)]


def _of_text(code: int, text: str) -> list[str]:
    lines = [line for line in re.split(r"[\r\n]+", text) if line.strip()]
    if code == 2:
        return [] if lines and "expected" in lines[-1] else [f"usage: {lines[-1:]}"]
    found = [f"says {line!r}" for line in lines if not NOTE.match(line) or BUG in line]
    if code == 1 and not (lines and FORM.match(lines[-1])):
        found.append(f"no place, expected and found: {lines[-1:]}")
    if code not in (0, 1):
        found.append(f"exit code {code}")
    return list(dict.fromkeys(found))


def _of_files(code: int, case: Case, folder: Path) -> list[str]:
    left = {path.name for path in folder.iterdir()} - set(case.contents)
    hidden = [f"leaves {name}" for name in left if name.startswith(".")]
    if code:
        return [f"leaves {name} though it failed" for name in left]
    changed = [name for name, content in case.contents.items() if (folder / name).read_bytes() != content]
    return (
        hidden
        + [f"changes {name}" for name in changed]
        + ([] if left or "--out" not in case.arguments else ["no output"])
    )


TABLES = {name: (ROOT / "data" / name).read_bytes() for name in ("datasets.csv", "files.csv")}


def catalogue_faults(number: int, folder: Path) -> list[str]:
    """Return what is wrong with how reading a mutated catalogue ends."""
    rng = stream(7, "catalogue", number)
    name = str(rng.choice(list(TABLES)))
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()
    for one, content in TABLES.items():
        (folder / one).write_bytes(mutations.text_bytes(content, rng) if one == name else content)
    try:
        sets = datasets.load(folder, ROOT / "workflow" / "schemas")
    except datasets.CatalogueError as error:
        return [] if re.match(r"\S.*: .*expected .+; found .+", str(error), re.DOTALL) else [f"form of {error}"]
    except Exception as error:
        return [f"{type(error).__name__}: {error}"]
    places = [file.place(folder).resolve() for one in sets.values() for file in one.files]
    return [f"escapes to {place}" for place in places if place.parents[1] != folder.resolve()]

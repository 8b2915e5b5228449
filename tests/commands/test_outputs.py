"""Outputs of all commands: files of the user are neither harmed nor left half-written, and streams work."""

import os
import shlex
import stat
import subprocess
import sys
from pathlib import Path

import pytest

from imugap import cli

MODEL = "gyro_x: [{white_noise: {density: 1e-4}}]\n"
SIMULATE = "simulate model.yaml --duration 40 --rate 25 --out"


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """A model and a log."""
    folder = tmp_path_factory.mktemp("outputs")
    (folder / "model.yaml").write_text(MODEL)
    options = shlex.split("--duration 40 --rate 25 --out")
    assert cli.main(["simulate", str(folder / "model.yaml"), *options, str(folder / "run.csv")]) == 0
    return folder


def process(line, **options):
    """Run a command line in a process of its own."""
    code = "import sys; from imugap.cli import main; sys.exit(main())"
    return subprocess.run([sys.executable, "-c", code, *shlex.split(line)], capture_output=True, text=True, **options)


REFUSED = {
    "simulate model.yaml --duration 4 --rate 25 --out model.yaml": "model.yaml: expected an output that is no input",
    "simulate model.yaml --duration 4 --rate 25 --out .": "expected a file; found a folder",
    "simulate model.yaml --duration 4 --rate 25 --out run.csv/a.csv": "expected a folder at .*run.csv; found a file",
    "indices run.csv --out ./run.csv": "run.csv: expected an output that is no input; found the input run.csv",
    "estimate run.csv --out a.json --table ./a.json": "--table: expected a file of its own; found that of --out",
    "estimate run.csv --out run.csv": "run.csv: expected an output that is no input",
    "export model.yaml --to imugap --rate 25 --out link.yaml": "link.yaml: expected an output that is no input",
    "discover run.csv --out .": "expected a folder that can be replaced as a whole; found the working folder",
    "discover run.csv --out ..": "expected a folder that can be replaced as a whole; found the working folder",
    "discover run.csv --model found/model.yaml --out found": "found: expected an output that is no input",
    "walk run.csv --out run.csv": "run.csv: expected a folder; found a file",
    "drive run.csv run.csv --out model.yaml/deep": "expected a folder at .*model.yaml; found a file",
    "estimate bag --out bag/part.db3": "part.db3: expected an output that is no input; found the input bag",
    "indices time.csv --out gyro-0.csv": "expected an output that is no input; found a file that is read with time.csv",
}


@pytest.mark.parametrize(("line", "message"), REFUSED.items(), ids=REFUSED)
def test_an_output_that_would_harm_is_refused_before_the_work(here, refused, line, message):
    Path("link.yaml").symlink_to("model.yaml")
    Path("found").mkdir()
    Path("found/model.yaml").write_text(MODEL)
    Path("bag").mkdir()
    Path("bag/part.db3").touch()
    Path("time.csv").write_text("time (sec)\n0\n")
    Path("gyro-0.csv").write_text("gyro_x (deg/s)\n0\n")
    before = {path: path.read_bytes() for path in here.rglob("*") if path.is_file()}
    refused(line, message, among="imugap:")
    assert {path: path.read_bytes() for path in here.rglob("*") if path.is_file()} == before


@pytest.mark.parametrize(
    "name", ["br{run}.csv", "with blank.csv", "it's.csv", '"quoted".csv', "ünïcödé Ω.csv", "-.csv"]
)
def test_any_name_is_a_name(here, capsys, name):
    Path("deep").mkdir()
    assert cli.main([*SIMULATE.split(), f"./deep/../{name}"]) == 0
    assert Path(name).is_file()
    assert cli.main(["indices", f"./deep/../{name}", f"--out={name}.csv"]) == 0
    assert Path(f"{name}.csv").is_file()
    assert name in {path.name for path in here.iterdir()}


def test_a_name_that_is_no_text_is_shown_escaped(here):
    name = os.fsdecode(b"run\xff.csv")
    assert cli.main([*SIMULATE.split(), name]) == 0
    found = process(f"check {name}")
    assert (found.returncode, found.stderr) == (0, "")
    assert "run\\udcff.csv" in found.stdout


def test_the_standard_output_is_a_file_to_write_to(here):
    assert cli.main([*SIMULATE.split(), "run2.csv"]) == 0
    found = process(f"{SIMULATE} /dev/stdout")
    assert (found.returncode, found.stderr, found.stdout) == (0, "", Path("run2.csv").read_text())
    with Path("redirected").open("w") as file:
        code = "import sys; from imugap.cli import main; print('first'); sys.exit(main())"
        subprocess.run([sys.executable, "-c", code, *SIMULATE.split(), "/dev/stdout"], stdout=file, check=True)
    assert Path("redirected").read_text() == "first\n" + Path("run2.csv").read_text()


def test_nothing_is_written_to_the_null_device(here):
    assert cli.main([*SIMULATE.split(), "/dev/null"]) == 0
    assert stat.S_ISCHR(Path("/dev/null").stat().st_mode)


def test_a_reader_that_leaves_early_is_no_error(here):
    line = f"{SIMULATE} /dev/stdout"
    code = "import sys; from imugap.cli import main; sys.exit(main())"
    command = f"{shlex.quote(sys.executable)} -c {shlex.quote(code)} {line} | head -1"
    found = subprocess.run(command, shell=True, capture_output=True, text=True)
    assert (found.stdout, found.stderr) == ("time,gyro_x\n", "")


def test_a_full_disk_is_one_message_and_leaves_nothing(here):
    found = process(f"{SIMULATE} out.csv", preexec_fn=lambda: limit("RLIMIT_FSIZE", 1000))
    assert found.returncode == 1
    assert found.stderr == "imugap: out.csv: expected a file or folder that can be used; found 'File too large'\n"
    assert not Path("out.csv").exists()
    assert not list(here.glob(".*"))


def limit(name, value):
    import resource
    import signal

    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(getattr(resource, name), (value, value))


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everywhere")
def test_a_file_or_folder_that_is_read_only_is_refused(here, refused):
    Path("only.csv").write_text("old")
    Path("only.csv").chmod(0o444)
    Path("closed").mkdir(mode=0o555)
    refused(f"{SIMULATE} only.csv", "only.csv: --out: expected one that can be written; found one that is read-only")
    refused(f"{SIMULATE} closed/a.csv", "closed/a.csv: --out: expected a folder that can be written")
    assert Path("only.csv").read_text() == "old"

"""A disk that is full or read-only: one message, and the older output is as it was."""

import shutil
import subprocess
from hashlib import sha256
from pathlib import Path

import numpy as np
import pytest

from imugap import cli, log
from imugap.io.catalogue.datasets import FetchError, RawFile, fetch

MODEL = "gyro_x: [{white_noise: {density: 1e-4}}, {bias: {value: 1.0e-3}}]\n"
LINES = {
    "simulate": "simulate model.yaml --duration 4000 --rate 1 --out small/out.csv",
    "simulate parquet": "simulate model.yaml --duration 4000 --rate 1 --out small/out.parquet",
    "convert": "convert log.csv --out small/out.parquet",
    "export": "export model.yaml --to cpp --rate 50 --out small/out.hpp",
    "effects": "effects gauss_markov --out small/out.svg",
    "estimate": "estimate log.csv --terms white_noise --out small/found",
    "several": "estimate log.csv --terms white_noise --model small/out.yaml --figure small/out.svg",
}


@pytest.fixture
def small(tmp_path, monkeypatch):
    """A file system of seven pages, of which older outputs take six."""
    monkeypatch.chdir(tmp_path)
    Path("model.yaml").write_text(MODEL)
    noise = np.random.default_rng(1).normal(1e-3, 1e-3, 4000)
    log.write(log.from_samples({"gyro_x": noise}, 0.02), "log.csv")
    folder = Path("small")
    folder.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", "size=28k", "tmpfs", str(folder)]
    made = subprocess.run(mount, capture_output=True, text=True) if shutil.which("mount") else None
    if made is None or made.returncode:
        pytest.skip(f"no file system can be mounted here: {made.stderr.strip() if made else 'no mount'}")
    try:
        for name in ("csv", "parquet", "hpp", "svg", "yaml"):
            (folder / f"out.{name}").write_text("old")
        (folder / "found").mkdir()
        (folder / "found" / "report.html").write_text("old")
        yield folder
    finally:
        subprocess.run(["umount", "--lazy", str(tmp_path / folder)], check=True)


def contents(folder):
    return {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@pytest.mark.parametrize("line", LINES.values(), ids=LINES)
def test_a_full_disk_is_one_message_and_the_older_output_stays(small, capsys, line):
    before = contents(small)
    assert cli.main(line.split()) == 1
    said = [one for one in capsys.readouterr().err.splitlines() if "expected" in one]
    assert len(said) == 1
    assert said[0].startswith("imugap: small/")
    assert "found 'No space left on device'" in said[0] or "for which there is room; found" in said[0]
    assert contents(small) == before


@pytest.mark.parametrize("line", LINES.values(), ids=LINES)
def test_a_read_only_disk_is_refused_before_the_work(small, capsys, line):
    subprocess.run(["mount", "-o", "remount,ro", str(small)], check=True)
    before = contents(small)
    assert cli.main(line.split()) == 1
    assert "expected one that can be written; found" in capsys.readouterr().err.replace("a folder that", "one that")
    assert contents(small) == before


def test_a_file_of_the_catalogue_that_does_not_fit_leaves_nothing(small):
    content = bytes(100_000)
    mirrored = Path("mirror") / "set" / "file.bin"
    mirrored.parent.mkdir(parents=True)
    mirrored.write_bytes(content)
    address = "https://localhost/file.bin"
    file = RawFile("set", "file.bin", (1,), len(content), sha256(content).hexdigest(), address)
    before = contents(small)
    with pytest.raises(FetchError, match=r"file.bin: .*No space left on device.*To place it by hand"):
        fetch(file, small, "mirror")
    assert contents(small) == before

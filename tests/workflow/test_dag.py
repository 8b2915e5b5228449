import json
import os
import re
import shutil
import subprocess
import sys
import time
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from imugap import log
from imugap.commands.discover import FILES
from imugap.effects import Bias, Sinusoid, WhiteNoise
from imugap.effects.effect import AxisModel
from imugap.io import recording
from imugap.model import ErrorModel
from imugap.stream import stream

ROOT = Path(__file__).parents[2]
QUICK = "workflow/config/quick.yaml"

BLIND = "blind={cases: 4, cases_per_job: 2}"

pytestmark = pytest.mark.slow


def snakemake(*arguments, folder=ROOT):
    environment = {key: value for key, value in os.environ.items() if key != "IMUGAP_MIRROR"}
    command = [sys.executable, "-m", "snakemake", *arguments]
    return subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True)


def test_lint_finds_nothing_but_the_missing_conda_directive():
    found = snakemake("--lint")
    titles = re.findall(r"^\s*\* (.*?):?$", found.stdout + found.stderr, re.MULTILINE)
    assert set(titles) == {"Specify a conda environment or container for each rule."}


def test_every_rule_has_a_docstring_and_a_log():
    for path in (ROOT / "workflow/rules").glob("*.smk"):
        for rule in re.split(r"^ *rule\b", path.read_text(), flags=re.MULTILINE)[1:]:
            name = rule.split(":")[0]
            assert re.match(r'[\w ]*:\n +"""[A-Z]', rule), name
            assert re.search(r"^ +log:\n", rule, re.MULTILINE), name


def test_misspelt_key_names_the_nearest():
    found = snakemake("--dry-run", "--config", "sead=1")
    assert found.returncode != 0
    assert "did you mean seed?" in found.stdout + found.stderr


def test_missing_mirror_leaves_the_real_device_out():
    found = snakemake("--dry-run", "--config", "mirror=no/such/folder", "devices={bench: [1, 2], adis16405: []}")
    assert found.returncode == 0
    assert "results/bench/1/log.parquet" in found.stdout
    assert "adis16405/1" not in found.stdout


def jobs(*arguments):
    """The rules that would run for a paper of these chapters."""
    found = snakemake("--dry-run", "--forceall", "--configfile", QUICK, "--config", *arguments)
    assert found.returncode == 0, found.stderr
    return set(re.findall(r"^(?:local)?rule (\w+):", found.stdout, re.MULTILINE))


def test_chapters_can_be_left_out_of_the_paper():
    static, drive, everything = jobs("chapters=[]"), jobs("chapters=[drive]"), jobs("seed=1")
    assert {"indices_bench", "fit_models", "drift_scores", "claims", "paper", "notebook"} < static < drive < everything
    assert {name.split("_")[0] for name in drive - static} == {"drive"}
    assert not static & {
        "monte_carlo",
        "walk_budget",
        "dossier",
        "flight_runs",
        "planar_runs",
        "tutorial_allan",
        "speed",
    }


def test_a_chapter_that_is_none_is_refused():
    found = snakemake("--dry-run", "--config", "chapters=[drives]")
    assert found.returncode != 0
    assert "drives" in found.stdout + found.stderr


def test_absent_raw_files_are_named_with_address_checksum_and_place(tmp_path):
    folder = sources(tmp_path / "project")
    found = snakemake("fetch", "--cores", "1", "--config", "mirror=no/such/folder", folder=folder)
    text = (folder / "logs/fetch.log").read_text()
    if found.returncode == 0:
        pytest.skip("the network gave the files")
    assert "1eb09074beabd7cfc15b402cb8043b5302f6e4edfd9e4ebfbf8117436f8b9fa9" in text
    assert "https://" in text
    assert "data/raw/adis16405/adis_16405_imu1.rda" in text
    assert not list((folder / "data" / "raw").rglob("*.rda"))


def test_own_logs_become_a_device():
    found = snakemake("--dry-run", "--config", "own_logs=[README.md,LICENSE]", "devices={bench: [], adis16405: []}")
    assert "results/own/2/log.parquet" in found.stdout
    assert "results/bench" not in found.stdout.replace("results/bench/truth", "")


def test_a_table_length_that_is_no_navigation_length_is_refused():
    found = snakemake("--dry-run", "--config", "navigation={horizons_s: [10, 60], table_horizon_s: 30}")
    assert found.returncode != 0
    assert "navigation.table_horizon_s: expected one of horizons_s" in found.stdout + found.stderr


@pytest.fixture
def two_runs(tmp_path):
    """Two runs of a device of two gyroscopes, one with a line."""
    model = ErrorModel({
        "gyro_x": AxisModel((WhiteNoise(1e-4), Bias(1e-3))),
        "gyro_y": AxisModel((WhiteNoise(1e-4), Bias(1e-3), Sinusoid(7.3, 6e-4))),
    })  # fmt: skip
    still = log.from_samples(dict.fromkeys(model.axes, np.zeros(3000)), 0.02)
    for run in (1, 2):
        log.write(model.simulate(still, run, "workflow"), tmp_path / f"line{run}.csv")
    return tmp_path


def sources(folder):
    """Lay out a folder with the sources of the project and none of its products."""
    for name in ("data", "paper"):
        (folder / name).mkdir(parents=True)
    own = [path for path in (ROOT / "data").iterdir() if path.name != "raw"]
    for path in (*own, *(ROOT / name for name in ("Snakefile", "workflow", "src", "benchmark", "notebooks"))):
        (folder / path.relative_to(ROOT)).symlink_to(path)
    return folder


@pytest.fixture
def copied(tmp_path):
    """A folder with the sources of the project and none of its products."""
    return sources(tmp_path / "project")


def test_a_log_of_ones_own_gets_its_folder_of_what_is_missing(two_runs, copied):
    options = ("--config", f"log={two_runs / 'line1.csv'}", f"test={two_runs / 'line2.csv'}")
    found = snakemake("discover", "--cores", "2", *options, folder=copied)
    assert found.returncode == 0, found.stderr
    folder = copied / "results/discover/line1"
    assert {path.name for path in folder.iterdir()} == set(FILES)
    report = json.loads((folder / "report.json").read_text())
    assert [(one["name"], one["axes"]) for one in report["effects"]] == [("sinusoid", ["gyro_y"])]
    assert [one["path"] for one in report["test"]] == [str(two_runs / "line2.csv")]
    text = (copied / "logs/dossier/discover/line1.log").read_text()
    assert "search" in text
    assert "gyro_y: sinusoid" in text
    again = snakemake("discover", "--cores", "2", *options, folder=copied)
    assert "Nothing to be done" in again.stdout + again.stderr


HARD = ["br{run}.csv", 'blank \'s "Ω" #1.csv', "[1, 2]: {device}.csv"]
"""Names of files that snakemake, YAML or a shell may take for something else."""


def test_a_log_of_ones_own_has_any_name(two_runs, copied):
    for name in HARD:
        (two_runs / name).write_bytes((two_runs / "line1.csv").read_bytes())
        found = snakemake("discover", "--dry-run", "--config", f"log={json.dumps([f'../{name}'])}", folder=copied)
        assert found.returncode == 0, found.stderr
        assert re.search(r"input: results/discover/[\w.-]+/report.md\n", found.stdout), name


def test_runs_of_ones_own_have_any_name_and_a_change_of_one_reruns_what_reads_it(copied, tmp_path):
    model = ErrorModel(dict.fromkeys(log.AXES, AxisModel((WhiteNoise(1e-4),))))
    still = log.from_samples(dict.fromkeys(log.AXES, np.zeros(6100)), 0.1)
    for run, name in enumerate(HARD):
        log.write(model.simulate(still, run, "workflow"), tmp_path / name)
    paths = [f"../{name}" for name in HARD]
    options = ("--cores", "1", "--config", f"own_logs={json.dumps(paths)}", "devices={bench: [], adis16405: []}")
    found = snakemake("ingest_own", *options, folder=copied)
    assert found.returncode == 0, found.stderr
    for run, name in enumerate(HARD, 1):
        read = log.load(copied / f"results/own/{run}/log.parquet")
        pd.testing.assert_frame_equal(read, recording.read(tmp_path / name).log)
    os.utime(tmp_path / HARD[0])
    found = snakemake("ingest_own", "--dry-run", *options, folder=copied)
    assert "rule ingest_own:" in found.stdout


def test_a_run_of_ones_own_that_is_too_short_is_told_by_its_name(copied, tmp_path):
    model = ErrorModel(dict.fromkeys(log.AXES, AxisModel((WhiteNoise(1e-4),))))
    still = log.from_samples(dict.fromkeys(log.AXES, np.zeros(4500)), 0.1)
    log.write(model.simulate(still, 1, "workflow"), tmp_path / "short.csv")
    options = ("--config", f"own_logs=[{tmp_path / 'short.csv'}]", "devices={bench: [], adis16405: []}")
    found = snakemake("ingest_own", "--cores", "1", *options, folder=copied)
    assert found.returncode != 0
    said = (copied / "logs/ingest/own.log").read_text()
    assert re.search(r"short\.csv: duration: expected at least 600 s at rest.*; found 450 s", said)


@pytest.mark.parametrize("kills", [2, 20])
def test_a_killed_run_is_taken_up_by_the_same_command_with_the_same_bytes(tmp_path, kills):
    """The main process is killed alone, as by a lack of memory: its jobs end by themselves."""
    model = ErrorModel(dict.fromkeys(log.AXES, AxisModel((WhiteNoise(1e-4), Bias(1e-3)))))
    still = log.from_samples(dict.fromkeys(log.AXES, np.zeros(40_000)), 0.02)
    paths = [str(tmp_path / f"run{run}.csv") for run in (1, 2)]
    for run, path in enumerate(paths):
        log.write(model.simulate(still, run, "workflow"), path)
    config = [f"own_logs={json.dumps(paths)}", "devices={bench: [], adis16405: []}", "chapters=[]"]
    table = "paper/tables/indices_own.csv"
    command = (table, "--cores", "2", "--configfile", QUICK, "--config", *config)
    whole, killed = sources(tmp_path / "whole"), sources(tmp_path / "killed")
    for folder in (whole, killed):
        (folder / "profiles").symlink_to(ROOT / "profiles")
    began = time.monotonic()
    assert snakemake(*command, folder=whole).returncode == 0
    longest, rng = time.monotonic() - began, stream(1, "kills")
    for _ in range(kills):
        options = {"cwd": killed, "stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        with subprocess.Popen([sys.executable, "-m", "snakemake", *command], **options) as run:
            time.sleep(rng.uniform(0.2, 1.0) * longest)
            run.kill()
    found = snakemake(*command, folder=killed)
    assert found.returncode == 0, found.stdout + found.stderr
    assert products(killed) == products(whole)


def products(folder):
    """Bytes of all results and tables of a project."""
    paths = [*folder.glob("results/**/*"), *folder.glob("paper/tables/*")]
    return {path.relative_to(folder): path.read_bytes() for path in paths if path.is_file()}


def test_a_log_that_cannot_be_read_is_told_in_the_log_of_the_job(copied, tmp_path):
    (tmp_path / "bad.csv").write_text("time,giro_x\n0.0,0.1\n0.1,0.1\n")
    found = snakemake("discover", "--cores", "1", "--config", f"log={tmp_path / 'bad.csv'}", folder=copied)
    assert found.returncode != 0
    assert "did you mean gyro_x" in (copied / "logs/dossier/discover/bad.log").read_text()
    assert not (copied / "results/discover/bad").exists()


@pytest.mark.each
@pytest.mark.parametrize(
    ("options", "message"),
    [
        ([], "log: expected --config log=PATH; found none"),
        (["log=no/such.csv"], "log: expected a file; found none at no/such.csv"),
        (["log=README.md", "model=no/such.yaml"], "model: expected a file; found none at no/such.yaml"),
        (["log=README.md", "test=[LICENSE,no/such.csv]"], "test: expected a file; found none at no/such.csv"),
        (["reference=README.md"], "log: expected the log that reference belongs to; found none"),
        (["own_logs=[no{1}.csv]"], "own_logs: expected a file; found none at [no{1}.csv] (in a list, put a name with"),
        (["log=README.md", "mirror=a/{b}"], "mirror: expected a folder without braces in its name; found a/{b}"),
        (["log=README.md", "discovery={alpha: 2}"], "discovery.alpha: expected a number < 1; found 2"),
    ],
)
def test_a_missing_file_is_told_by_its_option(options, message):
    found = snakemake("discover", "--dry-run", *(["--config", *options] if options else []))
    assert found.returncode != 0
    assert message in found.stdout + found.stderr


def blind_project(folder):
    """Lay out the project with a blind benchmark of short logs."""
    sources(folder)
    (folder / "benchmark").unlink()
    shutil.copytree(ROOT / "benchmark/src", folder / "benchmark/src")
    path = folder / "benchmark/src/imu_benchmark/recipe.toml"
    shorter = re.sub(r"(duration_s) = .*", r"\1 = [60, 90]", path.read_text())
    path.write_text(re.sub(r"rates_hz = .*", "rates_hz = [25]", shorter))
    return folder


def blind_tables(folder):
    """Read the bytes of all tables of the blind benchmark but the run times."""
    paths = [*folder.glob("results/blind/*.csv"), *folder.glob("paper/tables/blind_*")]
    return {path.relative_to(folder): path.read_bytes() for path in paths if path.name != "run_time.csv"}


@pytest.fixture(scope="module")
def benchmark(tmp_path_factory):
    """The project after a blind benchmark of four cases on this machine."""
    folder = blind_project(tmp_path_factory.mktemp("blind") / "here")
    found = snakemake("blind", "--cores", "2", "--config", BLIND, folder=folder)
    assert found.returncode == 0, found.stderr
    return folder


def test_the_blind_benchmark_seals_discovers_scores_and_shows(benchmark):
    cases = pd.read_csv(benchmark / "results/blind/cases.csv")
    assert cases["case"].tolist() == ["c0001", "c0002", "c0003", "c0004"]
    assert len(list(benchmark.glob("paper/figures/blind_*.svg"))) == 6
    assert json.loads((benchmark / "paper/numbers/blind.json").read_text())["cases"] == 4
    for log_file in benchmark.glob("logs/blind_*/*.log"):
        assert log_file.read_text().endswith("done\n")


def test_baselines_and_discovery_answer_the_same_cases_in_one_table(copied):
    pytest.importorskip("ruptures")
    pytest.importorskip("allantools")
    small = "baselines={cases: 2, cases_per_job: 1, entries: [nothing, allan_slopes, noise_id, change_points]}"
    found = snakemake("baselines", "--cores", "2", "--configfile", QUICK, "--config", small, folder=copied)
    assert found.returncode == 0, found.stderr
    scores = pd.read_csv(copied / "results/baselines/summary.csv")
    entries = ["nothing", "allan_slopes", "noise_id", "change_points", "discovery"]
    assert list(dict.fromkeys(scores["entry"])) == entries
    assert json.loads((copied / "paper/numbers/baselines.json").read_text())["cases"] == 2
    assert len(json.loads((copied / "paper/tables/baselines.json").read_text())) > 0


@pytest.fixture
def cluster(tmp_path):
    """A SLURM cluster of two nodes on this machine."""
    missing = [name for name in ("slurmctld", "slurmd", "sbatch", "munged") if shutil.which(name) is None]
    if missing:
        pytest.skip(f"SLURM is not installed here: no {', '.join(missing)}")
    if find_spec("snakemake_executor_plugin_slurm") is None:
        pytest.skip("snakemake-executor-plugin-slurm is not installed here")
    if os.geteuid() != 0:
        pytest.skip("only root can start a SLURM cluster")
    script = str(ROOT / "tests/slurm/cluster")
    if subprocess.run([script, "taken"]).returncode == 0:
        pytest.skip("this machine is part of a SLURM cluster")
    try:
        subprocess.run([script, "start", str(tmp_path / "slurm")], check=True)
        yield
    finally:
        subprocess.run([script, "stop"], check=True)


def test_the_blind_benchmark_on_a_slurm_cluster_has_the_same_tables(benchmark, cluster, tmp_path):
    folder = blind_project(tmp_path / "there")
    options = ["--workflow-profile", "workflow/profiles/slurm"]
    options += ["--slurm-status-command", "squeue", "--slurm-no-account"]
    options += ["--slurm-init-seconds-before-status-checks", "5", "--seconds-between-status-checks", "2"]
    found = snakemake("blind", "--config", BLIND, *options, folder=folder)
    text = found.stdout + found.stderr
    assert found.returncode == 0, text
    submitted = re.findall(r"submitted with SLURM jobid \d+ \(log: .*/slurm_logs/(\w+)/", text)
    assert sorted(submitted) == ["rule_blind_discover"] * 2 + ["rule_blind_seal"]
    assert blind_tables(folder) == blind_tables(benchmark)

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
QUICK = "workflow/config/quick.yaml"

pytestmark = pytest.mark.slow


def snakemake(*arguments, folder=ROOT):
    environment = {key: value for key, value in os.environ.items() if key != "IMUGAP_MIRROR"}
    command = [sys.executable, "-m", "snakemake", *arguments]
    return subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, timeout=300)


def test_lint_finds_nothing_but_the_missing_conda_directive():
    found = snakemake("--lint")
    titles = re.findall(r"^\s*\* (.*?):?$", found.stdout + found.stderr, re.MULTILINE)
    assert set(titles) == {"Specify a conda environment or container for each rule."}


def test_every_rule_has_a_docstring_a_log_and_all_but_the_fetch_a_benchmark():
    for path in (ROOT / "workflow/rules").glob("*.smk"):
        for rule in re.split(r"^rule ", path.read_text(), flags=re.MULTILINE)[1:]:
            name = rule.split(":")[0]
            assert re.match(r'\w+:\n    """[A-Z]', rule), name
            assert "    log:\n" in rule, name
            assert "    benchmark:\n" in rule or name == "fetch"


def test_misspelt_key_names_the_nearest():
    found = snakemake("--dry-run", "--config", "sead=1")
    assert found.returncode != 0
    assert "did you mean 'seed'?" in found.stdout + found.stderr


def test_missing_mirror_leaves_the_real_device_out():
    found = snakemake("--dry-run", "--config", "mirror=no/such/folder", "devices={bench: [1, 2], adis16405: []}")
    assert found.returncode == 0
    assert "results/bench/1/log.parquet" in found.stdout
    assert "adis16405/1" not in found.stdout


def test_absent_raw_files_are_named_with_address_checksum_and_place(tmp_path):
    for name in ("Snakefile", "workflow", "data", "src", "paper", "notebooks"):
        (tmp_path / name).symlink_to(ROOT / name)
    (tmp_path / "data").unlink()
    (tmp_path / "data").mkdir()
    for source in (ROOT / "data").iterdir():
        if source.name != "raw":
            (tmp_path / "data" / source.name).symlink_to(source)
    found = snakemake("fetch", "--cores", "1", "--config", "mirror=no/such/folder", folder=tmp_path)
    text = (tmp_path / "logs/fetch.log").read_text()
    if found.returncode == 0:
        pytest.skip("the network gave the files")
    assert "1eb09074beabd7cfc15b402cb8043b5302f6e4edfd9e4ebfbf8117436f8b9fa9" in text
    assert "https://" in text
    assert "data/raw/adis16405/adis_16405_imu1.rda" in text
    assert not list((tmp_path / "data" / "raw").rglob("*.rda"))


def test_own_logs_become_a_device():
    found = snakemake("--dry-run", "--config", "own_logs=[README.md,LICENSE]", "devices={bench: [], adis16405: []}")
    assert "results/own/2/log.parquet" in found.stdout
    assert "results/bench" not in found.stdout.replace("results/bench/truth", "")


def test_a_table_length_that_is_no_navigation_length_is_refused():
    found = snakemake("--dry-run", "--config", "navigation={horizons_s: [10, 60], table_horizon_s: 30}")
    assert found.returncode != 0
    assert "navigation.table_horizon_s: expected one of horizons_s" in found.stdout + found.stderr

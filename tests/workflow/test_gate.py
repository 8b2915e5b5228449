"""The workflow file of the forge runs the gate, and nothing that is not pinned; the audit needs no network."""

import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).parents[2]


def test_the_forge_runs_the_gate_with_pinned_actions_and_no_secret():
    for path in (ROOT / ".github" / "workflows").glob("*.yml"):
        text = path.read_text()
        found = yaml.safe_load(text)
        steps = [step for job in found["jobs"].values() for step in job["steps"]]
        assert [step["run"] for step in steps if "run" in step] == [".ci/run"]
        assert all(re.fullmatch(r"[\w/-]+@[0-9a-f]{40}", step["uses"]) for step in steps if "uses" in step)
        assert found["permissions"] == {"contents": "read"}
        assert "secrets." not in text


def test_without_a_network_the_audit_is_skipped_with_a_sentence():
    assert ".ci/audit\n" in (ROOT / ".ci" / "run").read_text()
    if shutil.which("bash") is None:
        pytest.skip("no bash")
    nowhere = dict.fromkeys(("https_proxy", "HTTPS_PROXY"), "http://127.0.0.1:9")
    found = subprocess.run([ROOT / ".ci" / "audit"], env=os.environ | nowhere, capture_output=True, text=True)
    assert (found.returncode, found.stderr) == (0, "")
    assert found.stdout == "audit of the pinned packages skipped: pypi.org cannot be reached\n"

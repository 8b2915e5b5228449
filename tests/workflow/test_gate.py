"""The workflow file of the forge runs the gate, and nothing that is not pinned."""

import re
from pathlib import Path

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

"""What the catalogue of Snakemake workflows asks of a repository with standardised usage."""

from pathlib import Path

import yaml

ROOT = Path(__file__).parents[2]


def test_the_layout_is_that_of_standardised_usage():
    readme = (ROOT / "README.md").read_text().lower()
    assert "snakemake" in readme
    assert "workflow" in readme
    assert "rule all:" in (ROOT / "workflow/Snakefile").read_text()
    assert (ROOT / "Snakefile").read_text().startswith('include: "workflow/Snakefile"\n')
    assert "workflow/config/study.yaml" in (ROOT / "config/README.md").read_text()
    usage = yaml.safe_load((ROOT / ".snakemake-workflow-catalog.yml").read_text())["usage"]
    assert usage.keys() == {"mandatory-flags", "software-stack-deployment"}
    assert usage["mandatory-flags"].keys() == {"desc", "flags"}
    assert usage["software-stack-deployment"].keys() == {"conda", "apptainer", "apptainer+conda", "report"}

"""Citation, metadata, changelog and package name the same version, authors and licence."""

import json
import tomllib
from pathlib import Path

import pytest
import yaml

import imugap

ROOT = Path(__file__).parents[1]
REQUIRED = {"authors", "cff-version", "message", "title"}
"""Keys that the schema of the Citation File Format 1.2.0 requires."""
OF_REFERENCE = {"authors", "title", "type"}
"""Keys that it requires of a reference."""
CITATION = yaml.load((ROOT / "CITATION.cff").read_text(), yaml.BaseLoader)
CODEMETA = json.loads((ROOT / "codemeta.json").read_text())
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
AUTHORS = [one["name"] for one in PROJECT["authors"]]


@pytest.mark.parametrize("name", ["CITATION.cff", "codemeta.json", "package", "changelog"])
def test_the_version_is_that_of_the_project(name):
    headings = [line.split()[1] for line in (ROOT / "CHANGELOG.md").read_text().splitlines() if line.startswith("## ")]
    found = {
        "CITATION.cff": {CITATION["version"], CITATION["preferred-citation"]["version"]},
        "codemeta.json": {CODEMETA["version"]},
        "package": {imugap.__version__},
        "changelog": {next(one.rstrip(".") for one in headings if one != "Unreleased")},
    }
    assert found[name] == {PROJECT["version"]}


def test_the_citation_has_what_its_schema_requires():
    assert CITATION.keys() >= REQUIRED
    assert CITATION["cff-version"] == "1.2.0"
    assert CITATION["type"] == "software"
    assert CITATION["preferred-citation"].keys() >= OF_REFERENCE


def test_authors_licence_and_words_are_those_of_the_project():
    assert [one["name"] for one in CITATION["authors"]] == AUTHORS
    assert [one["name"] for one in CITATION["preferred-citation"]["authors"]] == AUTHORS
    assert [one["name"] for one in CODEMETA["author"]] == AUTHORS
    assert CITATION["license"] == PROJECT["license"]
    assert CODEMETA["license"] == f"https://spdx.org/licenses/{PROJECT['license']}"
    assert CODEMETA["description"] == PROJECT["description"]
    assert CODEMETA["keywords"] == PROJECT["keywords"]
    assert CODEMETA["dateModified"] == CITATION["date-released"]
    assert CODEMETA["programmingLanguage"]["version"] == PROJECT["requires-python"]

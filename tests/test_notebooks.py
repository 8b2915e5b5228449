"""Notebooks carry the outputs of a fresh execution, explain each of them, and need package and recipes alone."""

from itertools import pairwise
from pathlib import Path

import nbformat
import pytest

ROOT = Path(__file__).parents[1]
FOLDER = ROOT / "notebooks"
NAMES = ("static", "estimation", "discovery", "walk", "drive")
LARGEST = 300_000
"""Largest size of a notebook [byte]."""
EXPLAINED = "What to see"


def read(name):
    return nbformat.read(FOLDER / f"{name}.ipynb", as_version=4)


def outputs(cell):
    return cell.outputs if cell.cell_type == "code" else []


def shown(notebook):
    """Return the texts of the outputs of each cell, and the kinds of those that are no text."""
    return [
        [
            one.get("text") or (one.data["text/plain"], sorted(one.data))
            for one in outputs(cell)
            if one.get("name") != "stderr"
        ]
        for cell in notebook.cells
    ]


def test_these_are_all_notebooks_and_the_site_lists_them():
    assert {path.stem for path in FOLDER.glob("*.ipynb")} == set(NAMES)
    lines = (ROOT / "docs/notebooks.md").read_text().splitlines()
    assert [line for line in lines if line.startswith("notebooks/")] == [f"notebooks/{name}" for name in NAMES]


@pytest.mark.parametrize("name", NAMES)
def test_a_notebook_carries_its_outputs_and_is_small(name):
    some = [one for cell in read(name).cells for one in outputs(cell)]
    assert not any(one.output_type == "error" or one.get("name") == "stderr" for one in some)
    assert any("image/png" in one.get("data", {}) for one in some)
    assert (FOLDER / f"{name}.ipynb").stat().st_size < LARGEST


@pytest.mark.parametrize("name", NAMES)
def test_outputs_are_explained(name):
    cells = read(name).cells
    last = [(cell, after) for cell, after in pairwise(cells) if outputs(cell) and after.cell_type == "markdown"]
    assert last
    assert all(EXPLAINED in after.source for _, after in last)
    assert not outputs(cells[-1])


@pytest.mark.parametrize("name", NAMES)
def test_a_notebook_reads_recipes_alone_and_shows_success_and_failure(name):
    cells = read(name).cells
    code = "\n".join(cell.source for cell in cells if cell.cell_type == "code")
    assert not any(place in code for place in ("results/", "paper/", "snakemake"))
    assert "| word | meaning |" in cells[0].source
    titles = [line for cell in cells if cell.cell_type == "markdown" for line in cell.source.splitlines()]
    assert sum(line.startswith("## ") for line in titles) >= 3


@pytest.mark.parametrize("name", NAMES)
def test_the_execution_by_the_workflow_has_the_same_outputs(name):
    made = ROOT / f"results/notebooks/{name}.ipynb"
    if not made.exists():
        pytest.skip("the workflow has not been run here")
    assert shown(nbformat.read(made, as_version=4)) == shown(read(name))


@pytest.mark.long
@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_a_fresh_execution_has_the_same_outputs(name):
    client = pytest.importorskip("nbclient")
    fresh = read(name)
    client.NotebookClient(
        fresh, timeout=900, startup_timeout=600, coalesce_streams=True, resources={"metadata": {"path": FOLDER}}
    ).execute()
    assert shown(fresh) == shown(read(name))

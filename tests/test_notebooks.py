"""Notebooks carry the outputs of a fresh execution where the package suffices; the others say what they need."""

from pathlib import Path

import nbformat
import pytest

ROOT = Path(__file__).parents[1]
ALONE = ("discovery",)
"""Notebooks that need no results of the study."""
OTHERS = sorted(path.stem for path in (ROOT / "notebooks").glob("*.ipynb") if path.stem not in ALONE)


def read(name):
    return nbformat.read(ROOT / f"notebooks/{name}.ipynb", as_version=4)


def shown(notebook):
    """Return the texts of the outputs of each cell, and the kinds of those that are no text."""
    cells = [cell for cell in notebook.cells if cell.cell_type == "code"]
    return [
        [
            one.get("text") or (one.data["text/plain"], sorted(one.data))
            for one in cell.outputs
            if one.get("name") != "stderr"
        ]
        for cell in cells
    ]


@pytest.mark.parametrize("name", ALONE)
def test_a_notebook_carries_its_outputs_and_is_small(name):
    notebook = read(name)
    outputs = [one for cell in notebook.cells if cell.cell_type == "code" for one in cell.outputs]
    assert outputs
    assert not any(one.output_type == "error" or one.get("name") == "stderr" for one in outputs)
    assert any("image/png" in one.get("data", {}) for one in outputs)
    assert (ROOT / f"notebooks/{name}.ipynb").stat().st_size < 300_000


@pytest.mark.parametrize("name", ALONE)
def test_the_execution_by_the_workflow_has_the_same_outputs(name):
    made = ROOT / f"results/notebooks/{name}.ipynb"
    if not made.exists():
        pytest.skip("the workflow has not been run here")
    assert shown(nbformat.read(made, as_version=4)) == shown(read(name))


@pytest.mark.long
@pytest.mark.slow
@pytest.mark.parametrize("name", ALONE)
def test_a_fresh_execution_has_the_same_outputs(name, tmp_path):
    client = pytest.importorskip("nbclient")
    fresh = read(name)
    client.NotebookClient(fresh, timeout=900, startup_timeout=600, resources={"metadata": {"path": tmp_path}}).execute()
    assert shown(fresh) == shown(read(name))


@pytest.mark.parametrize("name", OTHERS)
def test_a_notebook_that_reads_results_says_how_to_get_them(name):
    code = next(cell.source for cell in read(name).cells if cell.cell_type == "code")
    assert "run snakemake --cores all first" in code

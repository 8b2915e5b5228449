"""Execute a notebook in its folder, as Jupyter does, and keep it with its outputs, and as HTML."""

from pathlib import Path

import nbformat
from nbclient import NotebookClient
from nbconvert import HTMLExporter

from imugap.workflow.job_log import job

with job(snakemake) as (source, _, output):
    notebook = nbformat.read(source.notebook, as_version=4)
    folder = Path(source.notebook).parent
    NotebookClient(
        notebook, startup_timeout=600, coalesce_streams=True, resources={"metadata": {"path": folder}}
    ).execute()
    page, _ = HTMLExporter().from_notebook_node(notebook)
    nbformat.write(notebook, output[0])
    Path(output.page).write_text(page)

"""Execute a notebook at the top of the project and keep it as HTML."""

from pathlib import Path

import nbformat
from nbclient import NotebookClient
from nbconvert import HTMLExporter

from imugap.workflow.job_log import journal

if __name__ == "__main__":
    with journal(snakemake.log[0]):
        notebook = nbformat.read(snakemake.input.notebook, as_version=4)
        NotebookClient(notebook, startup_timeout=600, resources={"metadata": {"path": "."}}).execute()
        page, _ = HTMLExporter().from_notebook_node(notebook)
        Path(snakemake.output[0]).write_text(page)

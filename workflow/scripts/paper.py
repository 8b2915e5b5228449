"""Compile the paper, also as a web page, and its summary, and list what they state, each value with its cell."""

from pathlib import Path
from shutil import copy

import pandas as pd
import typst

from imugap.site import paper
from imugap.study import statements
from imugap.workflow.job_log import job
from imugap.workflow.products import save

HEADS = {"text": "text", "section": "section", "page": "page", "value": "value in the text", "file": "file",
         "cell": "cell", "cited": "cited beside it"}  # fmt: skip


def write_page(exported, pdf, folder):
    """Write the folder of the web page: page, figures, and the PDF beside them."""
    text, pictures = paper.web_page(exported)
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "index.html").write_text(text)
    for name, content in pictures.items():
        (folder / name).write_bytes(content)
    copy(pdf, folder / paper.PDF)


def write_pdf(source, product):
    """Write a PDF with tags; without them where the compiler fails over the place of a float (its issue 8487)."""
    try:
        typst.compile(source, output=product, root="paper")
    except typst.TypstError as error:
        if "internal error" not in str(error):
            raise
        print(f"{product}: without tags for screen readers: {error}")
        typst.compile(source, output=product, root="paper", pdf_tags=False)


with job(snakemake) as (source, _, output):
    texts = {"paper": (source.main, output.pdf), "summary": (source.summary, output.summary)}
    for path, product in texts.values():
        write_pdf(path, product)
    write_page(typst.compile(source.main, root="paper", format="html").decode(), output.pdf, Path(output.page))
    found = {name: statements.collect(path) for name, (path, _) in texts.items()}
    faults = [f"{name}: {fault}" for name, (_, some) in found.items() for fault in some]
    if faults:
        raise ValueError("\n".join(["statements:", *faults]))
    data = pd.concat([table.assign(text=name) for name, (table, _) in found.items()])
    save(output, statements=(data, data[list(HEADS)].rename(columns=HEADS)))

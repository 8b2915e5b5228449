"""Compile the paper and its summary, and list what they state, each value with the cell that it rests on."""

import pandas as pd
import typst

from imugap.study import statements
from imugap.workflow.job_log import job
from imugap.workflow.products import save

HEADS = {"text": "text", "section": "section", "page": "page", "value": "value in the text", "file": "file",
         "cell": "cell", "cited": "cited beside it"}  # fmt: skip


with job(snakemake) as (source, _, output):
    texts = {"paper": (source.main, output[0]), "summary": (source.summary, output.summary)}
    for path, product in texts.values():
        typst.compile(path, output=product, root="paper")
    found = {name: statements.collect(path) for name, (path, _) in texts.items()}
    faults = [f"{name}: {fault}" for name, (_, some) in found.items() for fault in some]
    if faults:
        raise ValueError("\n".join(["statements:", *faults]))
    data = pd.concat([table.assign(text=name) for name, (table, _) in found.items()])
    save(output, statements=(data, data[list(HEADS)].rename(columns=HEADS)))

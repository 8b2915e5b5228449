"""Confront the published claims with the results here."""

import pandas as pd

from imugap.figures.static import TITLES
from imugap.study import claims
from imugap.workflow.job_log import job
from imugap.workflow.products import save

with job(snakemake) as (source, params, output):
    static = pd.read_csv(source.static)
    results = ([pd.read_csv(path) for path in paths] for paths in (source.five, source.ranking, source.scores))
    frames = zip(params.devices, *results, strict=True)
    rows = [row for frame in frames for row in claims.of_device(*frame, static, params.table_horizon_s, TITLES)]
    published = pd.read_csv(source.walk).set_index("quantity")
    rows += [claims.of_walk(pd.read_csv(path), published) for path in source.compensation]
    data = pd.DataFrame(rows)
    save(output, table=(data, data))

"""Build the continuous models of a device."""

from dataclasses import asdict

import pandas as pd

from imugap.model import ErrorModel
from imugap.study.static.farrell2022 import MODELS, Readings
from imugap.workflow.job_log import job
from imugap.workflow.products import save

with job(snakemake) as (source, params, output):
    curves = pd.read_csv(source.allan)
    readings = {axis: Readings.of(one.set_index("tau")) for axis, one in curves.groupby("axis", sort=False)}
    rows = [{"axis": axis, **asdict(of), "left": of.left} for axis, of in readings.items()]
    save(output, readings=pd.DataFrame(rows))
    for name, path in zip(params.models, output.models, strict=True):
        ErrorModel({axis: MODELS[name](of) for axis, of in readings.items()}).write(path)

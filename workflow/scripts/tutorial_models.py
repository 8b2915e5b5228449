"""Build the continuous models of a device."""

from dataclasses import asdict

import pandas as pd

from imugap.model import ErrorModel
from imugap.study.farrell2022 import MODELS, Readings
from imugap.workflow.job_log import journal

if __name__ == "__main__":
    with journal(snakemake.log[0]):
        curves = pd.read_csv(snakemake.input.allan)
        readings = {axis: Readings.of(one.set_index("tau")) for axis, one in curves.groupby("axis", sort=False)}
        rows = [{"axis": axis, **asdict(of), "left": of.left} for axis, of in readings.items()]
        pd.DataFrame(rows).to_csv(snakemake.output.readings, index=False)
        for name, path in zip(snakemake.params.models, snakemake.output.models, strict=True):
            ErrorModel({axis: MODELS[name](of) for axis, of in readings.items()}).write(path)

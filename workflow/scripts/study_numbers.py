"""Write what the text says of the study itself."""

import platform
from importlib.metadata import version

import pandas as pd

from imugap.effects import CATALOGUE, title_of
from imugap.estimation.variances import allan
from imugap.figures.static import TITLES
from imugap.interchange.from_indices import CONTENDERS
from imugap.io.catalogue import datasets as catalogue
from imugap.workflow.job_log import job
from imugap.workflow.products import save

PACKAGES = ("imugap", "numpy", "scipy", "pandas", "numba", "matplotlib", "allantools", "snakemake")


def omission(dataset):
    """Tell of a data set that is left out what a reader needs to get it."""
    return {"name": dataset.name, "title": dataset.title, "source": dataset.source, "files": len(dataset.files)}


with job(snakemake) as (_, params, output):
    sets = catalogue.load("data", "workflow/schemas")
    study = {
        "devices": list(params.runs),
        "runs": {device: len(runs) for device, runs in params.runs.items()},
        "missing_of": params.missing_of,
        "unseen_of": params.unseen_of,
        "sighted": params.sighted,
        "recordings": params.recordings,
        "power_cycles": len(params.power_cycles),
        "walks": params.walks,
        "protocol": params.protocol,
        "omitted": [omission(sets[name]) for name in params.omitted],
        "catalogue": [title_of(name) for name in CATALOGUE],
        "contenders": [TITLES[name] for name in CONTENDERS],
        "config": params.config,
        "reading": {"tolerance": allan.SLOPE_TOLERANCE, "decades": allan.REGION_DECADES},
        "versions": {name: version(name) for name in PACKAGES} | {"Python": platform.python_version()},
    }
    data = pd.DataFrame([vars(one) | {"files": len(one.files), "runs": len(one.runs)} for one in sets.values()])
    heads = {"name": "name", "title": "title", "rate_hz": "rate [Hz]", "runs": "runs", "gyro_unit": "gyro",
             "accel_unit": "accel", "frame": "frame", "licence": "licence"}  # fmt: skip
    shown = data[list(heads)].assign(rate_hz=data["rate_hz"].map("{:.6g}".format)).rename(columns=heads).fillna("—")
    shown["here"] = ["left out" if name in params.omitted else "yes" for name in shown["name"]]
    save(output, numbers=study, table=(data, shown))

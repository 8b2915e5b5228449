"""Write the model of a device with its card, of what discovery found on its log."""

from pathlib import Path

import pandas as pd
import yaml

from imugap import __version__
from imugap.io.catalogue import datasets as catalogue
from imugap.study.discovery.device_cards import DeviceFound
from imugap.workflow.job_log import job
from imugap.workflow.products import read_json

with job(snakemake) as (source, params, output):
    dataset = catalogue.load("data", "workflow/schemas")[params.dataset]
    found = DeviceFound(
        params.title, tuple(params.remarks), dataset, tuple(params.runs), params.in_motion, read_json(source.report),
        pd.read_csv(source.parameters), {"version": __version__, **params.settings},
    )  # fmt: skip
    text = yaml.safe_dump(found.card(), sort_keys=False, default_flow_style=None, width=120, allow_unicode=True)
    Path(output.model).write_text(text)

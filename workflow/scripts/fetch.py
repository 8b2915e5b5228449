"""Fetch every file of the catalogue; report all that cannot be had before failing."""

import sys

from imugap.io.catalogue.datasets import FetchError, fetch, load
from imugap.workflow.job_log import job

with job(snakemake) as (_, params, _):
    faults = []
    for file in (file for dataset in load("data", "workflow/schemas").values() for file in dataset.files):
        try:
            print(fetch(file, params.folder, params.mirror))
        except FetchError as error:
            faults.append(str(error))
    if faults:
        raise FetchError("\n\n".join(faults))
sys.stdout.write("every file of the catalogue is in data/raw\n")

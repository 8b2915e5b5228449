"""Fetch every file of the catalogue; report all that cannot be had before failing."""

import sys

from imugap.io.datasets import FetchError, fetch, load
from imugap.workflow.job_log import journal


def main(folder, mirror):
    """Fetch into ``folder``; raise one error that lists every file that is missing."""
    faults = []
    for dataset in load("data", "workflow/schemas").values():
        for file in dataset.files:
            try:
                print(fetch(file, folder, mirror))
            except FetchError as error:
                faults.append(str(error))
    if faults:
        raise FetchError("\n\n".join(faults))


if __name__ == "__main__":
    with journal(snakemake.log[0]):
        main(snakemake.params.folder, snakemake.params.mirror)
    sys.stdout.write("every file of the catalogue is in data/raw\n")

"""Add known effects to the real logs of devices, alone and together, and discover on each."""

import pandas as pd

from imugap import log
from imugap.discovery.device import Settings
from imugap.discovery.steps import each_in_processes
from imugap.log import AXES
from imugap.study.discovery.injection import KINDS, inject, untouched
from imugap.workflow.job_log import job
from imugap.workflow.products import save


def trials(device, run, axis, path, sizes, together, settings):
    """Return the rows of all trials on one axis of a run: each kind alone at each size, and several at the largest."""
    base = untouched(run, axis, log.load(path), settings)
    alone = [([kind], size) for kind in KINDS for size in sizes]
    several = [(tuple(KINDS)[:number], max(sizes)) for number in together]
    return [
        {"device": device} | row
        for kinds, size in (*alone, *several)
        for row in inject(base, kinds, size, settings).rows()
    ]


# started processes import this module again
if __name__ == "__main__":
    with job(snakemake) as (source, params, output):
        settings = Settings(**params.settings, seed=params.seed)
        # one axis of each run, every axis in turn
        tasks = [
            (device, run, AXES[number % len(AXES)], path, params.sizes, params.together, settings)
            for number, ((device, run), path) in enumerate(zip(params.runs, source.logs, strict=True))
        ]
        with each_in_processes(snakemake.threads) as each:
            rows = [row for some in each(trials, *zip(*tasks, strict=True)) for row in some]
        save(output, trials=pd.DataFrame(rows))

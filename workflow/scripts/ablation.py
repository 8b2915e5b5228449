"""Compare the held-out gain of names with that of wrong names: on sealed cases, and on further runs of devices."""

import pandas as pd

from imu_benchmark.recipe import read
from imu_benchmark.sealing import plan, seal
from imugap import log
from imugap.discovery.device import Settings, name_missing
from imugap.discovery.preparation.prepare import prepare
from imugap.study.discovery.ablation import on_another_run, within_log
from imugap.study.discovery.sealed_trials import search
from imugap.workflow.job_log import job
from imugap.workflow.products import save

SHARES = {"single": 1.0}
COLUMNS = ["source", "right", "axis", "name", "rival", "gain", "rival_gain", "share"]


def sealed(recipe, cases, seed, settings):
    """Yield the comparisons on sealed cases of one clear effect in a device at rest."""
    for case in plan(seed, cases, recipe | {"shares": SHARES}):
        if case.motion == "rest":
            closed = seal(case, recipe)
            hidden = {effect["name"] for effect in closed.key["effects"]}
            for one in within_log(search(closed, settings)):
                yield {"source": "sealed", "right": one.name in hidden} | one.row()


def real(device, paths, settings):
    """Yield the comparisons on the further runs of a device, of what was found on its first run."""
    first, *others = map(log.load, paths)
    found = name_missing([first], settings)
    for other in others:
        for one in on_another_run(found, prepare(other, seed=settings.seed).sequences):
            yield {"source": device, "right": None} | one.row()


with job(snakemake) as (source, params, output):
    settings = Settings(**params.settings, seed=params.seed)
    recipe = read(source.recipe) | params.ranges
    rows = list(sealed(recipe, params.cases, params.cases_seed, settings))
    for device in params.devices:
        rows += real(device, [path for path in source.logs if f"/{device}/" in path], settings)
    save(output, comparisons=pd.DataFrame(rows, columns=COLUMNS))

"""Discover on a batch of sealed cases: what the answers hold probable, and whether single effects are found."""

import pandas as pd

from imu_benchmark.forecasts import forecasts
from imu_benchmark.recipe import read
from imu_benchmark.sealing import plan
from imugap.discovery.device import Settings
from imugap.study.discovery.sealed_trials import answer
from imugap.workflow.job_log import job
from imugap.workflow.products import save


def cases(trial, recipe):
    """Return all cases of a trial: drawn from the recipe, or each of one effect, every name at every size in turn."""
    drawn = recipe | {key: trial[key] for key in ("sizes", "shares") if key in trial}
    return plan(trial["seed"], trial["cases"], drawn)


with job(snakemake) as (source, params, output):
    recipe = read(source.recipe) | params.ranges
    first = int(snakemake.wildcards.batch)
    settings = Settings(**params.settings, seed=params.seed)
    chosen = cases(params.trial, recipe)[first : first + params.cases]
    answers = [answer(case, recipe, settings) for case in chosen]
    singles = [
        {"case": one.key["case"], "name": effect["name"], "size": effect["size"], "seen": one.seen, "right": one.right}
        for one in answers if len(one.key["effects"]) == 1 for effect in one.key["effects"]
    ]  # fmt: skip
    save(
        output,
        forecasts=forecasts([one.key for one in answers], [one.report for one in answers]),
        curves=pd.DataFrame(singles, columns=["case", "name", "size", "seen", "right"]),
    )

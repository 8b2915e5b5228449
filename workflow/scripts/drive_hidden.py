"""Diagnose simulated drives with one unmodelled effect each by the innovations of the filter."""

from itertools import product

import pandas as pd

from imugap.navigation.drive.vehicle_diagnosis import CANDIDATES, diagnose, solve, whiteness
from imugap.study.drive.fault_ablation import Ablation, hide_effect
from imugap.workflow.job_log import job
from imugap.workflow.products import save

NOTHING = "nothing"

with job(snakemake) as (source, params, output):
    study, rows = Ablation.read(source.recipe), []
    for what, run in product((None, *CANDIDATES), range(1, params.runs + 1)):
        case = hide_effect(study, source.recipe, what, run, params.seed)
        names, told = diagnose(case, params.alpha)
        tests = whiteness(solve(case).record)
        of = told[told["round"] == 1].set_index("candidate")["gain"]
        gains = {f"gain, {candidate}": of[candidate] for candidate in CANDIDATES}
        said = told[told["named"]]["estimates"]
        rows.append({"hidden": what or NOTHING, "run": run, "named": " + ".join(names) or NOTHING,
                     "estimates": "; ".join(said)} | tests | gains)  # fmt: skip
    save(output, names=pd.DataFrame(rows).assign(alpha=params.alpha))

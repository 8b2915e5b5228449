"""Diagnose simulated drives with one unmodelled effect each by the innovations of the filter."""

import pandas as pd

from imugap.navigation.vehicle_diagnosis import CANDIDATES, diagnose, solve, whiteness
from imugap.study.fault_ablation import Ablation, hide_effect
from imugap.workflow.job_log import journal

NOTHING = "nothing"

if __name__ == "__main__":
    with journal(snakemake.log[0]):
        params, recipe = snakemake.params, snakemake.input.recipe
        study, rows = Ablation.read(recipe), []
        for what in (None, *CANDIDATES):
            for run in range(1, params.runs + 1):
                case = hide_effect(study, recipe, what, run, params.seed)
                names, told = diagnose(case, params.alpha)
                tests = whiteness(solve(case).record)
                of = told[told["round"] == 1].set_index("candidate")["gain"]
                gains = {f"gain, {candidate}": of[candidate] for candidate in CANDIDATES}
                said = told[told["named"]]["estimates"]
                rows.append({"hidden": what or NOTHING, "run": run, "named": " + ".join(names) or NOTHING,
                             "estimates": "; ".join(said)} | tests | gains)  # fmt: skip
        pd.DataFrame(rows).assign(alpha=params.alpha).to_csv(snakemake.output.names, index=False)

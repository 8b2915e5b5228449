"""Fit banks of Gauss-Markov states to flicker noise."""

import numpy as np
import pandas as pd

from imugap.effects import BiasInstability
from imugap.figures import farrell2022
from imugap.interchange import flicker_bank
from imugap.workflow.job_log import job
from imugap.workflow.products import save

DECADES = (1, 2, 3, 4, 5)
DRAWN = 3
"""Decades of the range whose banks are drawn."""
GOALS = (0.1, 0.05, 0.01)


def ratio(decades, states):
    """Return the Allan deviation of a bank over that of flicker, half a decade beyond its range on both sides."""
    tau = np.geomspace(10**-0.5, 10 ** (decades + 0.5), 201)
    bank = flicker_bank.bank(1.0, 1.0, 10.0**decades, states)
    return pd.Series(np.sqrt(bank.allan_variance(tau) / BiasInstability(1.0).allan_variance(tau)), index=tau)


def page(data):
    """Lay the table out: a row per range, a column per number of states."""
    shown = data.assign(error=[f"{100 * error:.2g} %" for error in data["error"]])
    shown = shown.pivot(index="decades", columns="states", values="error").fillna("")
    shown.columns = [f"{states} state" + "s" * (states > 1) for states in shown.columns]
    return shown.rename_axis("decades of τ").reset_index()


def numbers(data):
    """Collect what the text quotes: the error of one state, and the states that a goal needs."""
    error = data.set_index(["decades", "states"])["error"]
    needed = {f"{100 * goal:.0f}": {int(d): int(one.loc[one["error"] < goal, "states"].min()) for d, one in
                                    data.groupby("decades")} for goal in GOALS}  # fmt: skip
    per_decade = [error.loc[(decades, decades)] for decades in DECADES[1:]]
    return {
        "one_state_percent": {decades: f"{100 * error.loc[(decades, 1)]:.0f}" for decades in DECADES},
        "per_decade_percent": [f"{100 * min(per_decade):.1f}", f"{100 * max(per_decade):.1f}"],
        "states_needed": needed,
    }


with job(snakemake) as (_, _, output):
    rows = [
        {"decades": decades, "states": states,
         "error": flicker_bank.error(flicker_bank.bank(1.0, 1.0, 10.0**decades, states), 1.0, 1.0, 10.0**decades)}
        for decades in DECADES for states in range(1, decades + 4)
    ]  # fmt: skip
    data = pd.DataFrame(rows)
    ratios = {states: ratio(DRAWN, states) for states in range(1, DRAWN + 2)}
    save(output, figure=farrell2022.bank(ratios, data), table=(data, page(data)), numbers=numbers(data))

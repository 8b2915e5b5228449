"""Draw the Allan deviation of every contender against the device, and tabulate where they part."""

import numpy as np
import pandas as pd

from imugap.figures import static, style
from imugap.figures.static import TITLES, titled
from imugap.interchange.from_indices import bounded
from imugap.workflow import tables
from imugap.workflow.job_log import job
from imugap.workflow.products import save


def agreement(device, simulated):
    """Compare the first run's interval with the band of each contender at every tau the two share.

    ``verdict`` is 0 where they overlap, +1 where the device lies above the model, -1 where it lies below.
    """
    first = device[device["run"] == device["run"].min()]
    both = simulated.merge(first, on=["axis", "tau"], suffixes=("_model", "_device"))
    above = (both["low_device"] > both["high_model"]).astype(int)
    below = (both["high_device"] < both["low_model"]).astype(int)
    return both.assign(verdict=above - below)[["contender", "axis", "tau", "low_device", "high_device",
                                               "low_model", "high_model", "verdict"]]  # fmt: skip


def reproduced(group):
    """Show the longest range of tau without a disagreement."""
    tau, fits = group["tau"].to_numpy(), (group["verdict"] == 0).to_numpy()
    edges = np.flatnonzero(np.diff(np.r_[False, fits, False])).reshape(-1, 2)
    if not len(edges):
        return "nowhere"
    start, stop = max(edges, key=lambda edge: np.log(tau[edge[1] - 1] / tau[edge[0]]))
    return f"{tables.number(tau[start], 2)}–{tables.number(tau[stop - 1], 2)} s"


def page(data, bounds):
    """Lay the table out: a row per contender, a column per axis."""
    cells = data.groupby(["contender", "axis"], sort=False)[["tau", "verdict"]].apply(reproduced).unstack("axis")
    cells = cells.loc[list(dict.fromkeys(data["contender"])), list(dict.fromkeys(data["axis"]))]
    cells.columns = [style.AXIS_TITLES[axis] for axis in cells.columns]
    return cells.rename(index=titled(bounds)).rename_axis("model").reset_index()


def numbers(data):
    """Collect what the text quotes: the share of averaging times and axes that each contender reproduces."""
    share = data.assign(fits=data["verdict"] == 0).groupby("contender", sort=False)["fits"].mean().sort_values()
    percent = {name: f"{100 * value:.0f}" for name, value in share.items()}
    return {"share_percent": percent, "best": TITLES[share.index[-1]], "second": TITLES[share.index[-2]],
            "best_percent": percent[share.index[-1]], "second_percent": percent[share.index[-2]]}  # fmt: skip


with job(snakemake) as (source, _, output):
    device = pd.read_csv(source.device)
    simulated = pd.concat([pd.read_csv(path) for path in source.models])
    data, bounds = agreement(device, simulated), bounded(pd.read_csv(source.indices))
    table = data, page(data, bounds)
    save(output, figure=static.models(device, simulated), table=table, numbers=numbers(data) | {"bounded": bounds})

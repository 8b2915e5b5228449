"""Draw the continuous models of a device against it, and tabulate where and by how much they depart."""

import numpy as np
import pandas as pd

from imugap.figures import farrell2022, style
from imugap.study.static.farrell2022 import COMPOSED, KNOWN, TITLES
from imugap.workflow import tables
from imugap.workflow.job_log import job
from imugap.workflow.products import save


def departures(device, models):
    """Compare the deviation of each model with the device's interval, where the device is known.

    ``verdict`` is 0 where the model lies within the interval, +1 where it lies above, -1 where it lies below.
    """
    both = models.merge(device[device["error"] < KNOWN], on=["axis", "tau"], suffixes=("", "_device"))
    above, below = both["deviation"] > both["high_device"], both["deviation"] < both["low_device"]
    ratio = both["deviation"] / both["deviation_device"]
    columns = ["model", "axis", "tau", "deviation", "deviation_device", "low_device", "high_device"]
    return both[columns].assign(verdict=above.astype(int) - below, ratio=ratio)


def cell(group):
    """Show the longest range within the interval, and the largest departure with its averaging time."""
    tau, fits, ratio = group["tau"].to_numpy(), (group["verdict"] == 0).to_numpy(), group["ratio"].to_numpy()
    if not ratio.any():
        return "not read"
    edges = np.flatnonzero(np.diff(np.r_[False, fits, False])).reshape(-1, 2)
    start, stop = max(edges, key=lambda edge: np.log(tau[edge[1] - 1] / tau[edge[0]]), default=(0, 0))
    ends = dict.fromkeys(tables.number(end, 2) for end in tau[[start, stop - 1]])
    within = f"{'–'.join(ends)} s" if stop else "nowhere"
    if fits.all():
        return within
    worst = np.argmax(np.where(fits, 0, np.abs(np.log(ratio))))
    return f"{within}; ×{tables.number(ratio[worst], 2)} at {tables.number(tau[worst], 2)} s"


def page(data):
    """Lay the table out: a row per model, a column per axis."""
    cells = data.groupby(["model", "axis"], sort=False)[["tau", "verdict", "ratio"]].apply(cell).unstack("axis")
    cells = cells.loc[list(TITLES), list(dict.fromkeys(data["axis"]))]
    cells.columns = [style.AXIS_TITLES[axis] for axis in cells.columns]
    return cells.rename(index=TITLES).rename_axis("model").reset_index()


def numbers(data, models, readings, device):
    """Collect what the text quotes: shares of points within the interval, the double count, samples against eq. 16."""
    share = 100 * data.assign(fits=data["verdict"] == 0).groupby("model", sort=False)["fits"].mean()
    longest = device.groupby("axis")["tau"].max().min()
    sampled = models[models["model"].isin(COMPOSED) & (models["tau"] < longest / 100)]
    apart = np.abs(sampled["mean"] / sampled["deviation"] - 1)
    floors = data.merge(readings[["axis", "place"]], left_on=["axis", "tau"], right_on=["axis", "place"])
    ratios = floors[floors["model"] == "nbk"]["ratio"]
    left = 100 * readings["left"] / readings["floor"]
    return {
        "share_percent": {name: f"{value:.0f}" for name, value in share.items()},
        "best": TITLES[share.idxmax()],
        "walks": int((readings["walk"] > 0).sum()),
        "as_read_at_floor": [f"{ratios.min():.2f}", f"{ratios.max():.2f}"],
        "left_percent": [f"{left.min():.0f}", f"{left.max():.0f}"],
        "samples_percent": f"{100 * apart.quantile(0.95):.1f}",
    }


with job(snakemake) as (source, _, output):
    device, readings, models = (pd.read_csv(source[name]) for name in ("device", "readings", "models"))
    data = departures(device, models)
    save(output, figure=farrell2022.models(device, models), table=(data, page(data)),
         numbers=numbers(data, models, readings, device))  # fmt: skip

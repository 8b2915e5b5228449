"""Tabulate and draw the scores of all contenders on runs that none has seen, paired with the discovered model."""

import numpy as np
import pandas as pd
from scipy.stats import ttest_1samp

from imugap.figures.unseen_runs import TITLES, unseen_runs
from imugap.log import ACCEL, GYRO
from imugap.study import verdicts
from imugap.workflow import tables
from imugap.workflow.job_log import job
from imugap.workflow.products import save

REFERENCE = "discovered_white"
"""Contender with which the others are compared, run by run."""
PER = 1000
"""Samples for which differences of the log score are shown."""
CLAIMED, RIVALS = "restoration", ("white", "method_a", "method_b", "nbk")
"""Model that the published trials put first, and the others that are built from indices."""
SENSORS = {"gyroscopes": GYRO, "accelerometers": ACCEL}


def paired(values, comparisons=1):
    """Return mean and Student interval of differences, shape (runs,); 95 % for all ``comparisons`` together."""
    low, high = ttest_1samp(values, 0.0).confidence_interval(1 - 0.05 / comparisons)
    return float(values.mean()), float(low), float(high)


def drift_scores(data):
    """Return the name of the drift score, and its logarithm for each contender, over the runs."""
    name = next(name for name in data["quantity"].unique() if name.startswith("drift_"))
    wide = data[data["quantity"] == name].pivot_table(index="run", columns="contender", values="value", sort=False)
    return name.removeprefix("drift_").replace("_", " "), np.log(wide)


def losses(data):
    """Yield the loss of each contender over the discovered model, in each score."""
    wide = data.pivot_table(index=["run", "quantity", "axis"], columns="contender", values="value", sort=False)
    by_axis = wide.xs("log_score", level="quantity")
    scores = {
        f"log score, {sensor}": -PER * by_axis.loc[(slice(None), list(axes)), :].groupby("run").mean()
        for sensor, axes in SENSORS.items()
    }
    horizon, drift = drift_scores(data)
    scores[f"log drift score, {horizon}"] = drift
    for score, one in scores.items():
        for contender in one:
            if contender != REFERENCE:
                value, low, high = paired((one[contender] - one[REFERENCE]).to_numpy())
                yield {
                    "contender": contender, "score": score, "loss": value, "low": low, "high": high,
                    "verdict": verdicts.difference((low, high), "level"),
                }  # fmt: skip


def trials(data):
    """Return the drift score of the model that trials put first over that of each rival, and the verdict."""
    horizon, drift = drift_scores(data)
    rows = []
    for rival in RIVALS:
        value, low, high = paired((drift[CLAIMED] - drift[rival]).to_numpy(), len(RIVALS))
        ratio, *ends = (tables.number(float(np.exp(one))) for one in (value, low, high))
        said = verdicts.difference((low, high), "level")
        rows.append({"rival": TITLES[rival], "ratio": ratio, "low": ends[0], "high": ends[1], "verdict": said})
    return {"horizon": horizon, "comparisons": len(RIVALS), "rows": rows}


def bands(data):
    """Return distance, upper end of its floor and width of the band of each contender, root mean squares over runs."""
    of_run = data[data["quantity"].isin(["distance", "floor", "width"])]
    squares = of_run.assign(value=of_run["value"] ** 2).groupby(["contender", "quantity"], sort=False)["value"].mean()
    return np.sqrt(squares).unstack("quantity")


def page(found, band):
    """Lay the table out, a row for each contender."""
    rows = []
    for contender, title in TITLES.items():
        own = found[found["contender"] == contender]
        cells = {
            one.score: f"{tables.interval(one.loss, one.low, one.high)}, {one.verdict}"
            for one in own.itertuples(index=False)
        }
        ends = {name: tables.number(band.loc[contender, name]) for name in ("distance", "floor", "width")}
        rows.append({"model": title} | {score: cells.get(score, "—") for score in found["score"].unique()} | ends)
    return pd.DataFrame(rows).rename(columns={"floor": "floor to", "width": "width of the band"})


def numbers(found, band, runs):
    """Return what the text says."""
    counts = {
        score: {said: [TITLES[name] for name in part.loc[part["verdict"] == said, "contender"]]
                for said in ("worse", "level", "better")}
        for score, part in found.groupby("score", sort=False)
    }  # fmt: skip
    within = band["distance"] <= band["floor"]
    titles = {said: [TITLES[name] for name in band.index[mask]] for said, mask in (("in", within), ("out", ~within))}
    others = len(found["contender"].unique())
    summary = [
        {"score": score, "said": ", ".join(f"{len(names)} {said}" for said, names in of.items())}
        for score, of in counts.items()
    ]
    return {"runs": runs, "others": others, "verdicts": counts, "summary": summary, "floor": titles}


with job(snakemake) as (source, _, output):
    data = pd.read_csv(source.scores, keep_default_na=False)
    found, band = pd.DataFrame(losses(data)), bands(data)
    save(
        output,
        table=(found.merge(band.reset_index(), on="contender"), page(found, band)),
        figure=unseen_runs(found, band),
        numbers=numbers(found, band, int(data["run"].nunique())) | {"trials": trials(data)},
    )

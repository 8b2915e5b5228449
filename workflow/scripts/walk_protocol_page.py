"""Tabulate the trials of PyShoe by the published protocol, beside the published figures."""

import pandas as pd

from imugap.numerics.fitting import block_bootstrap as bootstrap
from imugap.stream import stream
from imugap.study import verdicts
from imugap.study.walk import walk_protocol
from imugap.study.walk.walk_protocol import FIGURES
from imugap.workflow import tables
from imugap.workflow.job_log import job
from imugap.workflow.products import save

HEADS = {"mean": "mean [m]", "median": "median [m]", "p95": "95th percentile [m]", "cvar90": "CVaR90 [m]"}
HERE = {
    ("smoother", "error"): "here, smoother",
    ("filter", "error"): "here, filter",
    ("smoother", "distance"): "here, smoother: distance, RMS",
    ("filter", "distance"): "here, filter: distance, RMS",
}
"""What is tabulated: by the ARMSE of the publisher, and by the root mean square distance."""


def held_out(scores):
    """Return the rows of each trial with the setting chosen on the other fold, filter and smoother apart."""
    named = scores.assign(setting=scores["varied"] + " " + scores["factor"].map("{:g}".format))
    return pd.concat([walk_protocol.held_out(one) for _, one in named.groupby("how", sort=False)])


def figures(kept, seed):
    """Yield the figures of each row of the table, with their intervals [m]."""
    for how, quantity in HERE:
        errors = kept.loc[kept["how"] == how, quantity].to_numpy()
        for name, (value, low, high) in walk_protocol.summary(errors, stream(seed, "walk protocol", how)).items():
            yield {"how": how, "quantity": quantity, "figure": name, "value": value, "low": low, "high": high}


def page(found, published):
    """Lay the table out: a row for each navigator."""
    of = published.set_index(["navigator", "figure"])["value_m"]
    for name in published["navigator"].unique():
        values = {head: tables.fixed(of[name, key], 3) if (name, key) in of else "—" for key, head in HEADS.items()}
        yield {"navigator": name} | values
    own = found.set_index(["how", "quantity", "figure"])
    for (how, quantity), name in HERE.items():
        rows = {head: own.loc[(how, quantity, key)] for key, head in HEADS.items()}
        yield {"navigator": name} | {
            head: tables.interval(*one[["value", "low", "high"]]) for head, one in rows.items()
        }


def numbers(scores, kept, found, published, seed):
    """Collect what the text quotes."""
    best = published.groupby("figure")["value_m"].min()
    by = {how: one.set_index("figure") for how, one in found[found["quantity"] == "error"].groupby("how")}
    own, filtered = by["smoother"], by["filter"].loc["mean"]
    squares = scores.dropna(subset=["nees"])
    chosen = kept.groupby("how", sort=False)["setting"].unique()

    def mean(values, name):
        one = bootstrap.mean(values.to_numpy(), stream(seed, "walk protocol", name), block=1)
        return {
            "value": tables.interval(one.value, one.low, one.high),
            "verdict": verdicts.consistency((one.low, one.high)),
        }

    return {
        "trials": int(kept["trial"].nunique()),
        "moving": int((~squares["still"].astype(bool)).sum()),
        "own_m": {name: tables.fixed(own.loc[name, "value"], 3) for name in FIGURES},
        "intervals_m": {name: tables.interval(*own.loc[name, ["value", "low", "high"]]) for name in FIGURES},
        "filter_mean_m": tables.interval(*filtered[["value", "low", "high"]]),
        "published_m": {name: tables.fixed(best[name], 3) for name in FIGURES},
        "below": [name for name in FIGURES if own.loc[name, "high"] < best[name]],
        "chosen": {how: [one.replace("usual 1", "usual") for one in names] for how, names in chosen.items()},
        "nees": mean(squares["nees"] / 2, "horizontal"),
        "vertical_nees": mean(squares["vertical_nees"], "vertical"),
    }


with job(snakemake) as (source, params, output):
    scores, published = pd.read_csv(source.scores), pd.read_csv(source.published)
    kept = held_out(scores)
    found = pd.DataFrame(figures(kept, params.seed))
    save(output, table=(found, page(found, published)), numbers=numbers(scores, kept, found, published, params.seed))

"""Tabulate the drift comparison: five trials as published, distributions, ranking over the navigation length."""

import numpy as np
import pandas as pd

from imugap.figures import static
from imugap.figures.static import TITLES, titled
from imugap.interchange.from_indices import SOURCE, bounded
from imugap.kinematics.free_inertial import QUANTITIES
from imugap.stream import stream
from imugap.study.static.rankings import first_places, interval, share_interval
from imugap.workflow import tables
from imugap.workflow.job_log import job
from imugap.workflow.products import save

SPREADLESS = ("bias_only", "white")
"""Models that do not vary from run to run."""
DRAWS = 2000
UNITS = {"east": ("m", 1.0), "north": ("m", 1.0), "heading": ("°", 180 / np.pi)}


def five_trials(errors, count):
    """Return mean e_abs and e_rel over the first ``count`` trials, for every run (by its place) and over all runs."""
    few = errors[(errors["start"] == "raw") & (errors["trial"] < count)]
    parts = {str(run + 1): part for run, part in few.groupby("run")} | {"all": few}
    means = [part.groupby(["contender", "quantity"], sort=False)[["e_abs", "e_rel"]].mean() for part in parts.values()]
    return pd.concat(means, keys=parts, names=["runs"]).reset_index()


def printed(table_2):
    """Return the printed table 2 in the columns of :func:`five_trials`, SI."""
    values = table_2.set_index("quantity")[list(SOURCE)]
    absolute, relative = values.filter(like="_abs_", axis=0), values.filter(like="_rel_", axis=0)
    scale = np.array([1 / UNITS[quantity][1] for quantity in QUANTITIES])[:, None]
    index = pd.MultiIndex.from_product([["He et al."], QUANTITIES, SOURCE], names=["runs", "quantity", "contender"])
    columns = {"e_abs": (absolute * scale).to_numpy().ravel(), "e_rel": relative.to_numpy().ravel() / 100}
    return pd.DataFrame(columns, index=index).reset_index()


def five_trials_page(data, titles):
    """Lay out as the published table 2: a row per model, absolute and relative error per quantity; runs 1 and all."""
    data = data[data["runs"].isin(["1", "all", "He et al."])]
    for (runs, contender), group in data.groupby(["runs", "contender"], sort=False):
        row = {"runs": runs, "model": (TITLES if runs == "He et al." else titles)[contender]}
        for one in group.itertuples():
            unit, scale = UNITS[one.quantity]
            row[f"{one.quantity} [{unit}]"] = tables.number(one.e_abs * scale)
            row[f"{one.quantity} [%]"] = tables.number(one.e_rel * 100)
        yield row


def distribution_page(scores, titles):
    """Lay out median and 90 % range of e_abs, the proper score, and the share of runs inside the 90 % band."""
    ordered = scores.sort_values("start", ascending=False, kind="stable")
    for (start, contender), group in ordered.groupby(["start", "contender"], sort=False):
        row = {"start": start, "model": titles[contender]}
        for one in group.itertuples():
            unit, scale = UNITS[one.quantity]
            values = (tables.number(v * scale) for v in (one.median_e_abs, one.e_abs_5, one.e_abs_95))
            row[f"e_abs {one.quantity} [{unit}]"] = "{} [{}, {}]".format(*values)
        for one in group.itertuples():
            unit, scale = UNITS[one.quantity]
            crps, error = tables.number(one.crps * scale), tables.number(one.crps_error * scale, 2)
            row[f"CRPS {one.quantity} [{unit}]"] = f"{crps} ± {error}"
        row["inside 90 %"] = f"{100 * group['inside_90'].mean():.0f} %"
        yield row


def probability_of_first(errors, count, seed):
    """Yield how often a table of ``count`` trials on the first run ranks each of the published methods first.

    ``tables`` is how many such tables the trials make without sharing one.
    """
    first = errors[(errors["run"] == 0) & errors["contender"].isin(SOURCE)]
    for (start, horizon, quantity), group in first.groupby(["start", "horizon", "quantity"], sort=False):
        rng = stream(seed, "five-trial tables", start, horizon, quantity)
        values = np.array([group.loc[group["contender"] == name, "e_abs"] for name in SOURCE])
        picked = rng.integers(values.shape[1], size=(len(SOURCE), DRAWS, count))
        means = np.array([value[pick].mean(axis=1) for value, pick in zip(values, picked, strict=True)])
        share = np.bincount(means.argmin(axis=0), minlength=len(SOURCE)) / DRAWS
        shares = dict(zip(SOURCE, share, strict=True))
        yield {"start": start, "horizon": horizon, "quantity": quantity, **shares, "tables": values.shape[1] // count}


def ranking_page(scores, probabilities, titles):
    """Lay out the best model by each score, and the probability that a five-trial table puts restoration first."""
    for (start, horizon), group in scores.groupby(["start", "horizon"], sort=False):
        row = {"start": start, "length [s]": f"{horizon:g}"}
        for quantity in QUANTITIES:
            one = group[group["quantity"] == quantity].set_index("contender")
            row[f"e_abs {quantity}"] = titles[one["median_e_abs"].idxmin()]
            row[f"CRPS {quantity}"] = titles[one["crps"].idxmin()]
        probability = probabilities[
            (probabilities["start"] == start) & (probabilities["horizon"] == horizon)
        ].set_index("quantity")
        shares = [f"{100 * probability.loc[quantity, 'restoration']:.0f}" for quantity in QUANTITIES]
        row["restoration first [%]"] = " / ".join(shares)
        yield row


def listed(firsts, score, titles):
    """Show how often each model is first by a score, with the interval over the runs, per start, most often first."""
    said = {}
    for start, of_start in firsts[firsts["score"] == score].groupby("start", sort=False):
        counts = {name: interval(of) for name, of in of_start.groupby("contender", sort=False)}
        order = sorted((name for name in counts if counts[name][0]), key=lambda name: -counts[name][0])
        said[start] = ", ".join("{} {} [{}, {}]".format(titles[name], *counts[name]) for name in order)
    return said


def spreadless(firsts):
    """Return for each score how often a model that never varies from run to run is first, with its interval."""
    some = firsts[firsts["contender"].isin(SPREADLESS)]
    return {score: "{} [{}, {}]".format(*interval(of)) for score, of in some.groupby("score", sort=False)}


def crps_ratio(scores, of, over):
    """Show median and extremes over lengths and quantities of the CRPS of one model over another's, per start."""
    table = scores.pivot(index=["start", "horizon", "quantity"], columns="contender", values="crps")
    grouped = (table[of] / table[over]).groupby("start", sort=False)
    return {start: "{:.2f} ({:.2f} to {:.2f})".format(*ratio.quantile([0.5, 0, 1])) for start, ratio in grouped}


def numbers(scores, at_table, probabilities, firsts, titles, params):
    """Collect what the text of the paper quotes."""
    inside = at_table.groupby(["start", "contender"], sort=False)["inside_90"].mean()
    cases = scores["horizon"].nunique() * scores["quantity"].nunique()
    at = probabilities[(probabilities["start"] == "raw") & (probabilities["horizon"] == params.table_horizon_s)]
    return {
        "table_horizon_s": params.table_horizon_s,
        "trials": params.published_trials,
        "restoration_first_percent": {
            row.quantity: tables.share(row.restoration, share_interval(row.restoration, row.tables))
            for row in at.itertuples()
        },
        "restoration_first_range_percent": {
            start: [f"{100 * end:.0f}" for end in (share.min(), share.max())]
            for start, share in probabilities.groupby("start", sort=False)["restoration"]
        },
        "cases": cases,
        "places": cases * scores["start"].nunique(),
        "spreadless": spreadless(firsts),
        "restoration_over_turn_on": crps_ratio(scores, "restoration", "white_turn_on"),
        "nbk_over_restoration": crps_ratio(scores, "nbk", "restoration"),
        "first_by_e_abs": listed(firsts, "e_abs", titles),
        "first_by_crps": listed(firsts, "crps", titles),
        "inside_percent": {
            start: {name: f"{100 * inside[start, name]:.0f}" for name in TITLES} for start in scores["start"].unique()
        },
    }


with job(snakemake) as (source, params, output):
    errors, proper = pd.read_parquet(source.errors), pd.read_parquet(source.proper)
    scores, indices, table_2 = (pd.read_csv(path) for path in (source.scores, source.indices, source.static))
    bounds = bounded(indices)
    titles = titled(bounds)
    at_table = scores[scores["horizon"] == params.table_horizon_s]
    five = five_trials(errors[errors["horizon"] == params.table_horizon_s], params.published_trials)
    five = pd.concat([five, printed(table_2)])
    probabilities = pd.DataFrame(probability_of_first(errors, params.published_trials, params.seed))
    firsts = first_places(errors, proper, stream(params.seed, "first places"))
    found = numbers(scores, at_table, probabilities, firsts, titles, params)
    save(
        output,
        five=(five, five_trials_page(five, titles)),
        distribution=(at_table, distribution_page(at_table, titles)),
        ranking=(probabilities, ranking_page(scores, probabilities, titles)),
        figure=static.ranking(scores, "median_e_abs", "median e_abs"),
        crps=static.ranking(scores, "crps", "CRPS"),
        numbers=found | {"bounded": bounds, "runs": int(proper["run"].nunique())},
    )

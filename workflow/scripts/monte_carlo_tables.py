"""Tabulate five runs as the source does, and beside them what many runs say of every method."""

import numpy as np
import pandas as pd

from imugap.estimation.cramer_rao import bound
from imugap.estimation.methods import METHODS
from imugap.figures import estimation
from imugap.study.static.experiment import Experiment
from imugap.study.static.monte_carlo import summary, worse_than
from imugap.workflow import tables
from imugap.workflow.job_log import job
from imugap.workflow.products import save

TIME = ("gauss_markov", 1, "correlation_time")


def five_page(data):
    """Lay the runs out as the source does: a row per run and method, values over the truth less one in percent."""
    shown = data[data["parameter"] != "driving_psd"]
    heads = [estimation.SYMBOLS[row.effect, row.parameter] + " [%]" for row in shown.itertuples()]
    cells = [tables.number(100 * error, 2) for error in shown["error"]]
    wide = shown.assign(head=heads, cell=cells).pivot_table(
        index=["run", "method"], columns="head", values="cell", aggfunc="first", sort=False
    )
    wide = wide.reset_index()
    return wide.assign(run=wide["run"] + 1, method=wide["method"].map(estimation.TITLES))


def summary_page(data):
    """Lay the summary out: a row per correlation time, parameter and method."""
    for row in data[data["parameter"] != "driving_psd"].itertuples():
        yield {
            "T [s]": row.time,
            "parameter": estimation.SYMBOLS[row.effect, row.parameter],
            "method": estimation.TITLES[row.method],
            "bias [%]": f"{tables.number(100 * row.bias, 2)} ± {tables.number(100 * row.bias_error, 1)}",
            "RMSE [%]": tables.number(100 * row.rmse, 2),
            "bound [%]": tables.number(100 * row.bound, 2),
            "RMSE / bound": tables.interval(row.efficiency, row.efficiency_low, row.efficiency_high),
            "coverage [%]": tables.interval(*(100 * c for c in (row.coverage, row.coverage_low, row.coverage_high))),
            "identified [%]": f"{100 * row.identified:.0f}",
            "failed": row.failed,
        }


def numbers(estimates, truth, published, printed):
    """Judge the printed errors of the correlation time against the distribution of one run's error."""
    row = published.set_index("quantity").loc["relative_error_of_correlation_time"]
    claims = {name: float(row[name]) for name in ("allan", "indirect")}
    found = {"allan_printed": f"{claims['allan']:.2f}", "indirect_printed": f"{claims['indirect']:.3f}", "times": []}
    for time, true in truth.items():
        at = estimates[(estimates["time"] == time) & (estimates["parameter"] == TIME[2])]
        error = (at.assign(error=100 * (at["value"] / true - 1).abs())).pivot(
            index="run", columns="method", values="error"
        )
        pair = error[["allan", "indirect_full"]].replace(np.inf, np.nan)
        found["times"].append(
            {
                "time": time,
                "runs": len(error),
                "allan_median": tables.number(pair["allan"].median(), 2),
                "indirect_median": tables.number(pair["indirect_full"].median(), 2),
                "likelihood_median": tables.number(error["likelihood"].median(), 2),
                "allan_within": f"{100 * (pair['allan'] <= claims['allan']).mean():.0f}",
                "indirect_within": f"{100 * (pair['indirect_full'] <= claims['indirect']).mean():.0f}",
                "indirect_wins": f"{100 * (pair['indirect_full'] < pair['allan'].fillna(np.inf)).mean():.0f}",
                "five_wins": f"{100 * _majority(pair, printed):.0f}",
            }
        )
    return found


def worse_page(found):
    """Yield each parameter and correlation time at which methods are worse than the likelihood, with these methods."""
    for effect, parameter, time, methods in worse_than(found[found["parameter"] != "driving_psd"], "likelihood"):
        *others, last = (f"“{estimation.TITLES[name]}”" for name in methods)
        names = f"{', '.join(others)} and {last}" if others else last
        yield {"parameter": estimation.SYMBOLS[effect, parameter], "time": time, "methods": names}


def _majority(pair, printed):
    """Return how often the mean error of a block of ``printed`` runs is smaller by indirect inference."""
    block = np.arange(len(pair)) // printed
    means = pair.groupby(block).mean()
    return (means["indirect_full"] < means["allan"]).mean()


with job(snakemake) as (source, params, output):
    experiments = {time: Experiment.read(source.recipe).at(time) for time in params.times}
    truths = {time: experiment.truth() for time, experiment in experiments.items()}
    limits = {time: bound(one.model, one.interval, one.count) for time, one in experiments.items()}
    estimates = pd.concat(pd.read_parquet(path) for path in source.estimates)
    middle = params.times[len(params.times) // 2]
    five = estimates[(estimates["time"] == middle) & (estimates["run"] < params.printed)]
    true = [truths[middle][row.effect, row.ordinal, row.parameter] for row in five.itertuples()]
    five = five.assign(truth=true, error=five["value"] / true - 1)
    estimates = estimates[estimates["method"].isin(METHODS)]  # those that all runs were estimated by
    found = pd.concat(
        [
            summary(estimates[estimates["time"] == time], truths[time], limits[time], params.seed).assign(time=time)
            for time in params.times
        ],
        ignore_index=True,
    )
    times = {time: one[TIME] for time, one in truths.items()}
    said = numbers(estimates, times, pd.read_csv(source.published), params.printed)
    figure = estimation.distributions(estimates, truths, limits)
    one = experiments[middle]
    walks = estimates[(estimates["effect"] == "random_walk") & (estimates["method"] == "allan")]
    said |= {"worse": list(worse_page(found)), "walks": len(walks), "walks_read": int((walks["value"] > 0).sum())}
    said |= {"middle": middle, "duration_h": f"{one.interval * one.count / 3600:g}"}
    save(output, five=(five, five_page(five)), summary=(found, summary_page(found)), figure=figure, numbers=said)

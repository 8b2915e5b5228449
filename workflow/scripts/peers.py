"""Fit the models that gmwm was run with, by its own objective, and compare what is reached and how fast."""

from time import process_time

import pandas as pd

from imugap import log
from imugap.effects import GaussMarkov, Quantization, RandomWalk, WhiteNoise
from imugap.estimation.gmwm.estimator import GmwmOptions, Weighting, fit, point_estimate
from imugap.figures.style import AXIS_TITLES
from imugap.workflow import tables
from imugap.workflow.job_log import job
from imugap.workflow.products import save

KINDS = {"WN": (WhiteNoise,), "RW": (RandomWalk,), "QN": (Quantization,), "AR1": (GaussMarkov,)}
KINDS["2AR1"] = (GaussMarkov, GaussMarkov)


def timed(call, *arguments, **named):
    """Return what ``call`` returns and its processor time [s], after a call that compiles."""
    call(*arguments, **named)
    start = process_time()
    return call(*arguments, **named), process_time() - start


def compared(table, interval, peer):
    """Yield the objective and the processor time of every fit beside the peer's."""
    for one in peer.itertuples():
        kinds = [kind for term in one.model.split("+") for kind in KINDS[term]]
        arguments = table[one.axis].to_numpy(), interval, kinds
        (_, objective), point_s = timed(point_estimate, *arguments, GmwmOptions(weighting=Weighting.INTERVAL))
        _, fit_s = timed(fit, *arguments, GmwmOptions(weighting=Weighting.INTERVAL))
        yield {"axis": one.axis, "model": one.model, "gmwm": one.objective, "minimum": one.minimum,
                     "here": objective, "gmwm_s": one.cpu_s, "here_s": point_s, "intervals_s": fit_s}  # fmt: skip


def page(data):
    """Lay the table out: a row per axis and model."""
    return pd.DataFrame(
        {
            "axis": data["axis"].map(AXIS_TITLES),
            "model": data["model"],
            "objective, gmwm": data["gmwm"].map(lambda v: tables.number(v, 5)),
            "objective, here": data["here"].map(lambda v: tables.number(v, 5)),
            "gmwm / here": (data["gmwm"] / data["here"]).map(lambda v: tables.fixed(v, 4)),
            "time, gmwm [s]": data["gmwm_s"].map(tables.number),
            "time, here [s]": data["here_s"].map(lambda v: tables.number(v, 2)),
            "with intervals [s]": data["intervals_s"].map(lambda v: tables.number(v, 2)),
        }
    )


with job(snakemake) as (source, _, output):
    table = log.load(source.log)
    data = pd.DataFrame(compared(table, log.interval(table), pd.read_csv(source.peer)))
    ratio, faster = data["gmwm"] / data["here"], data["gmwm_s"] / data["here_s"]
    whole = data["gmwm_s"] / data["intervals_s"]
    said = {
        "fits": len(data),
        "reached": int((data["here"] <= data["minimum"] * (1 + 1e-6)).sum()),
        "smallest": tables.fixed(ratio.min(), 4),
        "largest": tables.fixed(ratio.max(), 2),
        "slowest": f"{faster.min():.0f}",
        "median": f"{faster.median():.0f}",
        "slowest_whole": f"{whole.min():.0f}",
        "median_whole": f"{whole.median():.0f}",
    }
    save(output, table=(data, page(data)), numbers=said)

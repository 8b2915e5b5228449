"""Count how often each law is read on simulated logs."""

import numpy as np
import pandas as pd
from scipy.stats import beta

from imugap.effects import BiasInstability, Conditions, GaussMarkov, Quantization, RandomWalk, RateRamp, WhiteNoise
from imugap.effects.effect import AxisModel
from imugap.estimation.variances import allan
from imugap.workflow.job_log import job
from imugap.workflow.products import save

WHITE = WhiteNoise(1.0)
LOGS = {
    "white": (AxisModel((WHITE,)), "N"),
    "white + rounding": (WHITE + Quantization(1.7), "NQ"),
    "white + flicker": (WHITE + BiasInstability(1.0), "NB"),
    "flicker": (AxisModel((BiasInstability(1.0),)), "B"),
    "white + walk": (WHITE + RandomWalk(0.2), "NK"),
    "white + ramp": (WHITE + RateRamp(0.05), "NR"),
    "white + Gauss-Markov, 10 s": (WHITE + GaussMarkov(1.0, 10.0), "N"),
    "white + Gauss-Markov, 50 s": (WHITE + GaussMarkov(1.0, 50.0), "N"),
    "white + Gauss-Markov, 200 s": (WHITE + GaussMarkov(1.0, 200.0), "N"),
}
"""Processes at 1/s, and the laws that are there."""


def counted(name, model, laws, at, params):
    """Return, for each law, how many of the logs it is read on, with a 95 % interval of the rate."""
    curves = [
        allan.curve(model.simulate(np.zeros(len(at)), at, params.seed, "false_readings", name, log), at.interval)
        for log in range(params.logs)
    ]
    rows = []
    for symbol, law in allan.LAWS.items():
        read = sum(allan.tangent(asd, law).holds for asd in curves)
        others = params.logs - read
        low, high = beta.ppf([0.025, 0.975], [read or 1e-9, read + 1], [others + 1, others or 1e-9])
        rows.append({"log": name, "law": symbol, "there": symbol in laws, "logs": params.logs, "read": read,
                     "rate": read / params.logs, "low": low, "high": high})  # fmt: skip
    return rows


def page(data):
    """Lay the table out: a row per kind of log, a column per law; an asterisk where the law is there."""
    cells = [f"{100 * row.rate:.0f} %" + " *" * row.there for row in data.itertuples()]
    shown = data.assign(cell=cells).pivot(index="log", columns="law", values="cell")
    return shown.loc[list(LOGS), list(allan.LAWS)].rename_axis("simulated log").reset_index()


def numbers(data):
    """Collect what the text quotes: the largest rate of a law that is not there, and the rate of all such readings."""
    absent = data[~data["there"]]
    worst = absent.loc[absent["rate"].idxmax()]
    return {"percent": f"{100 * absent['rate'].mean():.1f}", "worst_percent": f"{100 * worst['rate']:.0f}",
            "worst_low": f"{100 * worst['low']:.0f}", "worst_high": f"{100 * worst['high']:.0f}",
            "law": worst["law"], "log": worst["log"]}  # fmt: skip


with job(snakemake) as (_, params, output):
    at = Conditions(np.arange(round(params.duration_s * params.rate_hz)) / params.rate_hz, 1 / params.rate_hz)
    data = pd.DataFrame([row for name, of in LOGS.items() for row in counted(name, *of, at, params)])
    save(output, table=(data, page(data)), numbers=numbers(data))

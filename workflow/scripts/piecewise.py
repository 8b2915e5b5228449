"""Score the classical reading of white noise and a Gauss-Markov process."""

import numpy as np
import pandas as pd

from imugap.effects import Conditions, GaussMarkov, WhiteNoise
from imugap.effects.gauss_markov import FLAT_TOP
from imugap.estimation.cramer_rao import bound
from imugap.estimation.result import Identifiability
from imugap.estimation.variances import allan
from imugap.estimation.variances.allan_slopes import PEAK_RATIO, fit
from imugap.workflow import tables
from imugap.workflow.job_log import job
from imugap.workflow.products import save

TIMES = (10.0, 50.0, 200.0)
WHITE, STD = 0.005, 1 / 180
"""The setting of Liu, Ren, Li 2016, deg/s."""
SYMBOLS = {"density": "N", "std": "std", "correlation_time": "T", "driving_psd": "S_B"}


def plain_top(asd):
    """Return T and std of the highest point of the curve beyond its valley, as it stands: the tutorial's reading."""
    beyond = asd["deviation"].loc[asd["deviation"][: asd["deviation"].size // 2].idxmin() :]
    return {"correlation_time": beyond.idxmax() / FLAT_TOP, "std": beyond.max() / PEAK_RATIO}


def score(time, at, params):
    """Return bias, RMSE, Cramer-Rao bound, coverage and share of identified readings of every parameter."""
    model = WhiteNoise(WHITE) + GaussMarkov(STD, time)
    truth = {"density": WHITE, "std": STD, "correlation_time": time, "driving_psd": 2 * STD**2 / time}
    limit = bound(model, at.interval, len(at)).droplevel(["effect", "ordinal"])
    logs = [model.simulate(np.zeros(len(at)), at, params.seed, "piecewise", time, log) for log in range(params.logs)]
    fits = [fit(one, at.interval, (WhiteNoise, GaussMarkov)) for one in logs]
    plain = pd.DataFrame([plain_top(allan.curve(one, at.interval)) for one in logs])
    table = pd.concat([one.table().droplevel(["effect", "ordinal"]) for one in fits], keys=range(params.logs))
    rows = []
    for name, true in truth.items():
        one = table.xs(name, level=1)
        error, read = one["value"] / true - 1, (one["value"] > 0).to_numpy()
        rows.append({
            "time": time, "parameter": name, "logs": params.logs, "bias": error[read].mean(),
            "rmse": np.sqrt(np.mean(error[read] ** 2)), "bound": limit[name],
            "plain_rmse": np.sqrt(np.mean((plain[name] / true - 1) ** 2)) if name in plain else np.nan,
            "coverage": ((one["low"] <= true) & (true <= one["high"])).mean(),
            "identified": (one["verdict"] == Identifiability.IDENTIFIED).mean(),
        })  # fmt: skip
    return rows


def page(data):
    """Lay the table out: a row per correlation time and parameter, per cent."""
    shown = {"T": [f"{time:.0f} s" for time in data["time"]], "parameter": data["parameter"].map(SYMBOLS)}
    heads = {"bias": "bias", "rmse": "RMSE", "plain_rmse": "RMSE, plain curve", "bound": "Cramér-Rao",
             "coverage": "interval holds", "identified": "identified"}  # fmt: skip
    percent = {
        head: [f"{tables.number(100 * v, 2)} %" if np.isfinite(v) else "" for v in data[key]]
        for key, head in heads.items()
    }
    return pd.DataFrame(shown | percent)


with job(snakemake) as (_, params, output):
    at = Conditions(np.arange(round(params.duration_s * params.rate_hz)) / params.rate_hz, 1 / params.rate_hz)
    data = pd.DataFrame([row for time in TIMES for row in score(time, at, params)])
    times = data[data["parameter"] == "correlation_time"]
    quoted = {"white": f"{WHITE:g}", "std": f"{STD:.4f}", "times": [f"{time:.0f}" for time in TIMES]}
    for name in ("rmse", "plain_rmse"):
        loss = times[name] / times["bound"]
        quoted[name] = [f"{loss.min():.1f}", f"{loss.max():.1f}"]
    coverage = 100 * data.loc[data["parameter"] == "std", "coverage"]
    quoted["std_coverage_percent"] = [f"{share:.0f}" for share in coverage]
    save(output, table=(data, page(data)), numbers=quoted)

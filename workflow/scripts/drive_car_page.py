"""Lay out the recorded drive: track and outages as figures, a table of the schemes, numbers of the text."""

import numpy as np
import pandas as pd

from imugap.figures import fault_ablation, recorded_drive
from imugap.filters.consistency import nees_band
from imugap.filters.innovation_gate import SCHEMES
from imugap.study.drive.fault_ablation import SMOOTHED, WHEELS, WHOLE
from imugap.study.drive.recorded_drive import TUNED, WHEELS_STD
from imugap.units import from_si
from imugap.workflow import tables
from imugap.workflow.job_log import job
from imugap.workflow.products import save

TAIL = 5.0
"""Error with bad fixes over that with good ones, above which a draw is counted."""
SHOWN = (*SCHEMES, SMOOTHED, WHEELS[WHOLE], WHEELS[SMOOTHED])


def page(scores):
    """Lay the schemes out: medians over the draws."""
    for name in SHOWN:
        one = scores[scores["scheme"] == name].median(numeric_only=True)
        yield {
            "scheme": fault_ablation.TITLES[name],
            "clean, 95 % [m]": tables.number(one["clean"]),
            "contaminated, 95 % [m]": tables.number(one["contaminated"]),
            "gyro bias moves by [°/h]": tables.number(from_si(one["gyro"], "deg/h")),
            "accel bias moves by [mg]": tables.number(from_si(one["accel"], "mg")),
            "NIS, clean": tables.number(one["nis"]),
        }  # fmt: skip


def drift(outages):
    """Return per model what the drift at the end of the outages is, against what is predicted.

    Draws share the device and count once: their NEES are averaged within each outage.
    """
    last = outages.loc[outages.groupby(["model", "draw", "begin"])["since"].idxmax()]
    found = {}
    for model, one in last.groupby("model"):
        nees = one.groupby("begin")["nees"].mean()
        low, high = nees_band(2, len(nees))
        found[model] = {
            "outages": len(nees),
            "median_m": tables.number(one["horizontal"].median(), 2),
            "rms_m": tables.number(np.sqrt((one["horizontal"] ** 2).mean()), 2),
            "predicted_m": tables.number(np.sqrt((one["predicted"] ** 2).mean()), 2),
            "ratio": tables.number(np.sqrt((one["horizontal"] ** 2).mean() / (one["predicted"] ** 2).mean()), 2),
            "nees": tables.number(nees.mean(), 2), "low": tables.number(low, 2), "high": tables.number(high, 2),
            "consistent": bool(low < nees.mean() < high), "careful": bool(nees.mean() <= low),
        }  # fmt: skip
    return found


def numbers(outages, scores, tuning):
    """Collect what the text quotes."""
    moved = scores.pivot(index="draw", columns="scheme", values="gyro")
    middle = scores.groupby("scheme").median(numeric_only=True)
    return {
        "drift": drift(outages),
        "wheels_std_m_per_s": f"{WHEELS_STD:g}",
        "length_s": f"{outages['since'].max():.0f}",
        "factors": {name: tables.number(tuning.iloc[-1][name], 2) for name in TUNED},
        "doubts": int(scores[scores["scheme"] == "separation"]["doubts"].sum()),
        "draws": int(scores["draw"].nunique()),
        "ratio": {
            name: tables.number(middle.loc[name, "contaminated"] / middle.loc[name, "clean"]) for name in SHOWN
        },
        "steadier": {"alone": int((moved["gate"] < moved["none"]).sum()),
                     "beside": int((moved["gated"] < moved["robust"]).sum())},
        "tail": {"factor": f"{TAIL:g}"} | {
            kind: int((scores["contaminated"] > TAIL * scores["clean"])[scores["scheme"] == name].sum())
            for kind, name in (("separation", WHOLE), ("wheels", WHEELS[WHOLE]))
        },
    }  # fmt: skip


with job(snakemake) as (source, _, output):
    outages, errors = pd.read_parquet(source.outages), pd.read_parquet(source.errors)
    scores, tuning = pd.read_csv(source.schemes), pd.read_csv(source.tuning)
    save(output, outages=recorded_drive.outages(outages), track=recorded_drive.track(errors))
    save(output, table=(scores, page(scores)), numbers=numbers(outages, scores, tuning))

"""Lay out the simulated drives: figures, tables, numbers of the text."""

from pathlib import Path

import numpy as np
import pandas as pd
import yaml
from scipy.stats import binomtest

from imugap.figures import fault_ablation
from imugap.filters.innovation_gate import SCHEMES
from imugap.numerics.fitting import block_bootstrap as bootstrap
from imugap.simulation.gnss_faults import OUTAGE, OUTLIER, RAMP, STRETCH
from imugap.stream import stream
from imugap.study import verdicts
from imugap.study.drive.fault_ablation import (
    ALONE,
    CLEAN,
    CONTAMINATED,
    LOST,
    ORACLE,
    PARTS,
    PLAIN,
    SMOOTHED,
    WHEELS,
    WHOLE,
    Ablation,
)
from imugap.units import from_si
from imugap.workflow import tables
from imugap.workflow.job_log import job
from imugap.workflow.products import save

COLUMNS = {
    "horizontal_95": ("position, 95 % [m]", "m"),
    "vertical": ("height [m]", "m"),
    "velocity": ("velocity [m/s]", "m/s"),
    "tilt": ("tilt [°]", "deg"),
    "heading": ("heading [°]", "deg"),
    "gyro_bad": ("gyro bias [°/h]", "deg/h"),
    "accel_bad": ("accel bias [mg]", "mg"),
}
KINDS = {CLEAN: "no gross error in the run", "none": "between events", OUTLIER: "outlier", STRETCH: "stretch",
         RAMP: "ramp", OUTAGE: "outage"}  # fmt: skip
BLIND = (*SCHEMES, SMOOTHED, ORACLE)
ALL = (*BLIND, *(WHEELS[name] for name in (WHOLE, SMOOTHED, ORACLE)))
OF = {ORACLE: PLAIN, WHEELS[ORACLE]: WHEELS[PLAIN]}
"""Whose clean run stands beside a scheme that has none."""
GAINS = {WHOLE: CONTAMINATED, SMOOTHED: CONTAMINATED, ORACLE: CONTAMINATED, PLAIN: CLEAN}
"""Schemes that run with wheels too, and the case in which they are compared."""
DRAWN = ("none", ORACLE, "robust", "separation", WHEELS[WHOLE])
"""Schemes whose errors are drawn over time."""
BAR, SHARE = 1.3, 0.95
"""What the contaminated run may be over the clean one; seeds in which the gate has to help."""


def schemes_page(scores, recovery):
    """Lay the schemes out: medians over the runs, a row per case and scheme."""
    middle = scores.groupby(["case", "scheme"], sort=False).median(numeric_only=True)
    means = scores.groupby(["case", "scheme"], sort=False).mean(numeric_only=True)
    rows = []
    for (case, scheme), one in middle.loc[[CLEAN, CONTAMINATED]].iterrows():
        if scheme == WHEELS[PLAIN]:
            continue
        row = {"fixes": case, "scheme": fault_ablation.TITLES[scheme]}
        for name, (head, unit) in COLUMNS.items():
            row[head] = tables.number(from_si(one[name], unit))
        rates = means.loc[(case, scheme)]
        row["false [%]"], row["missed [%]"] = (tables.number(100 * rates[name], 2) for name in ("false", "missed"))
        if scheme in (ORACLE, SMOOTHED, WHEELS[ORACLE], WHEELS[SMOOTHED]):
            row["false [%]"] = row["missed [%]"] = "—"
        known = recovery[(recovery["case"] == CONTAMINATED) & (recovery["scheme"] == scheme)]["recovery"]
        row["recovery, 90 % [s]"] = f"{known.quantile(0.9):.0f}" if case == CONTAMINATED else "—"
        row["NIS"], row["NEES"] = (tables.number(one[name], 3) for name in ("nis", "nees"))
        row["NEES, sensors"] = tables.number(one["nees_sensors"], 3)
        if scheme in (SMOOTHED, WHEELS[SMOOTHED]):
            row |= dict.fromkeys(("NIS", "NEES", "NEES, sensors"), "—")  # covariances at the fixes are the filter's
        rows.append(row)
    return pd.DataFrame(rows)


def kinds_page(kinds):
    """Lay the kinds of gross errors out: 95th percentile of the horizontal error, a row per scheme."""
    table = kinds.pivot(index="scheme", columns="event", values="horizontal").loc[list(ALL), list(KINDS)]
    shown = table.map(tables.number).rename(columns=KINDS)
    shown.insert(0, "scheme", [fault_ablation.TITLES[name] for name in table.index])
    return shown


def ratio(scores, scheme, seed, score="horizontal_95", case=CONTAMINATED, over=None):
    """Return the 95th percentile over that of the clean case: ratio of the means over the runs, with its interval.

    The clean case is that of the scheme itself, or of the scheme ``over``.
    """
    usual = (scores["case"] == CLEAN) & (scores["scheme"] == (over or OF.get(scheme, scheme)))
    spoilt = (scores["case"] == case) & (scores["scheme"] == scheme)
    of = scores[usual | spoilt].pivot(index="run", columns="case", values=score).dropna()
    middle = of[case].mean() / of[CLEAN].mean()
    rng = stream(seed, "drive ratio", scheme)
    drawn_runs = of.to_numpy()[rng.integers(0, len(of), (bootstrap.RESAMPLES, len(of)))]
    both = drawn_runs.mean(axis=1)
    which = list(of.columns)
    low, high = np.quantile(both[:, which.index(case)] / both[:, which.index(CLEAN)], [0.025, 0.975])
    held = int((of[case] <= BAR * of[CLEAN]).sum())
    return {"ratio": tables.number(middle), "low": tables.number(low), "high": tables.number(high),
            "runs_within": held, "verdict": verdicts.aim((low, high), BAR)}  # fmt: skip


def lost(scores, recovery):
    """Return of the drives that begin in a stretch how many had a soft reset, and when they were right again."""
    of = scores[scores["case"] == LOST].groupby("scheme")["resets"]
    found = {}
    for scheme in (*PARTS[LOST], WHEELS[WHOLE]):
        time = recovery[(recovery["case"] == LOST) & (recovery["scheme"] == scheme)]["recovery"]
        found[scheme] = {
            "resets": int(of.sum()[scheme]), "drives": int((of.get_group(scheme) > 0).sum()),
            "right": int(np.isfinite(time).sum()), "median_s": f"{time.median():.0f}", "last_s": f"{time.max():.0f}",
        }  # fmt: skip
    return found


def gain(scores, scheme, case):
    """Return the 95th percentile with wheels over that without, ratio of the means over the runs."""
    mean = scores[scores["case"] == case].groupby("scheme")["horizontal_95"].mean()
    return tables.number(mean[WHEELS[scheme]] / mean[scheme], 2)


def claim(scores, better, worse, name):
    """Return in how many runs the error of the bias estimates in bad stretches is smaller, and by what factor."""
    of = scores[scores["case"] == CONTAMINATED].pivot(index="run", columns="scheme", values=f"{name}_bad")
    found = binomtest(int((of[better] < of[worse]).sum()), len(of))
    interval = found.proportion_ci(0.95)
    factor = (of[better] / of[worse]).quantile([0.05, 0.5, 0.95])
    return {
        "runs": found.k, "percent": f"{100 * found.statistic:.0f}",
        "interval_percent": [f"{100 * end:.0f}" for end in (interval.low, interval.high)],
        "factor": tables.number(factor[0.5], 3), "factor_range": [tables.number(factor[q]) for q in (0.05, 0.95)],
        "verdict": verdicts.gate((interval.low, interval.high), SHARE),
    }  # fmt: skip


def numbers(scores, recovery, recipe, seed, runs):
    """Collect what the text quotes."""
    clean = scores[scores["case"] == CLEAN].groupby("scheme")
    shown = {"none": "nothing", "robust": "weighed"}
    pairs = {"alone": ("gate", "none"), "beside": ("gated", "robust"), "against_nothing": ("gated", "none")}
    return {
        "runs": runs,
        "parted": int(scores[scores["case"] == LOST]["run"].nunique()),
        "recipe": recipe,
        "bar": BAR,
        "share_percent": f"{100 * SHARE:.0f}",
        "ratios": {scheme: ratio(scores, scheme, seed) for scheme in ALL},
        "aided": {scheme: ratio(scores, scheme, seed, "aided_95") for scheme in ALL},
        "alone": {
            kind: {scheme: ratio(scores, scheme, seed, case=case) for scheme in (*PARTS[case], WHEELS[WHOLE])}
            for kind, case in ALONE.items()
        },
        "over_plain": {
            scheme: ratio(scores, scheme, seed, over=PLAIN) for scheme in (WHEELS[WHOLE], SMOOTHED, WHEELS[SMOOTHED])
        },
        "gains": {scheme: gain(scores, scheme, case) for scheme, case in GAINS.items()},
        "wheels": WHEELS,
        "lost": lost(scores, recovery),
        "false_percent": {
            case: {scheme: tables.number(100 * of.mean()[scheme], 2) for scheme in SCHEMES}
            for case, of in ((case, one.groupby("scheme")["false"]) for case, one in scores.groupby("case"))
            if case in (CLEAN, CONTAMINATED)
        },
        "clean_95_m": {name: tables.number(clean["horizontal_95"].median()[scheme]) for scheme, name in shown.items()},
        "claims": {
            key: {name: claim(scores, *pair, name) for name in ("gyro", "accel")} for key, pair in pairs.items()
        },
        "nees": {name: tables.number(clean["nees"].mean()[name]) for name in (PLAIN, WHEELS[PLAIN])},
        "nees_bad": {
            name: tables.number(scores[(scores["case"] == CONTAMINATED) & (scores["scheme"] == name)]["nees"].mean())
            for name in (PLAIN, "reset", WHOLE)
        },
        "reset_s": f"{SCHEMES['reset'].reset_s:g}",
        "limit_m": tables.number(recovery["limit"].iloc[0]),
        "separation_s": f"{SCHEMES['separation'].separation_s:g}",
        "doubts": {
            case: tables.number(one["doubts"].mean(), 2)
            for case, one in scores[scores["scheme"] == "separation"].groupby("case")
        },
        "resets": {
            scheme: {case: int(one["resets"].sum()) for case, one in scores[scores["scheme"] == scheme].groupby("case")}
            for scheme in ("reset", "separation")
        },
    }


with job(snakemake) as (source, params, output):
    scores, kinds, recovery = (pd.read_csv(source[name]) for name in ("scores", "kinds", "recovery"))
    study = Ablation.read(source.recipe)
    shown = {name: run for _, name, run in study.runs(params.shown, params.seed, cases=(CONTAMINATED,))}
    tracks = {name: study.errors(shown[name]) for name in DRAWN}
    recipe = yaml.safe_load(Path(source.recipe).read_text())
    recipe = {name: recipe[name] for name in ("faults", "receiver", "rate_hz", "axle")}
    found = numbers(scores, recovery, recipe, params.seed, params.runs)
    save(
        output,
        map=fault_ablation.drive(study, shown["separation"], tracks),
        sensors=fault_ablation.sensors({name: shown[name] for name in SCHEMES}),
        runs=fault_ablation.schemes(scores),
        schemes=(scores, schemes_page(scores, recovery)),
        kinds=(kinds, kinds_page(kinds)),
        numbers=found | {"duration_s": study.drive.duration_s, "schemes": fault_ablation.TITLES},
    )

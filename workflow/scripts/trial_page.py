"""Lay out the real trials: the figure, log against reference, estimates from the rests, errors, numbers of the text."""

import numpy as np
import pandas as pd

from imugap.estimation.result import Identifiability
from imugap.figures import attitude
from imugap.io.catalogue.datasets import load
from imugap.io.references.reference import ERROR
from imugap.log import GYRO
from imugap.units import from_si
from imugap.workflow import tables
from imugap.workflow.job_log import job
from imugap.workflow.products import save

MODELS = {"rest": "of the rest", "margin": "with a margin"}
ANGLES = {"north": "tilt about north", "east": "tilt about east", "down": "heading"}
ESTIMATES = {
    ("gyro", "density"): ("gyroscope N [°/√h]", "deg/sqrt(h)"),
    ("gyro", "std"): ("gyroscope σ [°/h]", "deg/h"),
    ("gyro", "correlation_time"): ("gyroscope T [s]", "s"),
    ("accel", "density"): ("accelerometer N [m/s/√h]", "m/s/sqrt(h)"),
    ("accel", "density_k"): ("accelerometer K [m/s/h/√h]", "m/s/h/sqrt(h)"),
}


def names():
    """Return the name of each trial from that of its file."""
    files = load("data", "workflow/schemas")["broad"].files
    return {file.runs[0]: " ".join(file.name.removesuffix(".mat").split("_")[2:-1]) for file in files}


def alignment_page(data, titles):
    """Lay the alignment out: a row per trial."""
    for trial, one in data.groupby("trial", sort=False):
        found = one.set_index("quantity")[["value", "low", "high"]]
        row = {"trial": titles[trial], "lag [ms]": tables.interval(*(1e3 * found.loc["lag"]))}
        for kind, head in {"frame": "axes {} [°]", "change": "bias change {} [°/s]"}.items():
            for axis in "xyz":
                row[head.format(axis)] = tables.interval(*from_si(found.loc[f"{kind}_{axis}"], "deg"))
        for axis in ("north", "east"):
            row[f"level {axis} [°]"] = tables.number(from_si(found.loc[f"tilt_{axis}", "value"], "deg"), 2)
        yield row


def rests(estimates):
    """Yield per parameter and scheme the share identified, the median, and how far two rests of a trial disagree.

    The disagreement is the factor exp(rms log(last/first)) over axes and trials, zeros left out.
    """
    known = estimates[estimates["parameter"] != "driving_psd"].copy()
    known["kind"] = np.where(known["axis"].isin(GYRO), "gyro", "accel")
    known["identified"] = known["verdict"] == Identifiability.IDENTIFIED
    for (kind, parameter, scheme), one in known.groupby(["kind", "parameter", "scheme"], sort=False):
        both = one.pivot(index=["trial", "axis"], columns="rest", values="value").replace(0.0, np.nan).dropna()
        apart = np.log(both["last"] / both["first"]) if len(both) else pd.Series(dtype=float)
        yield {"kind": kind, "parameter": parameter, "scheme": scheme, "fits": len(one),
                     "identified": int(one["identified"].sum()), "median": one["value"].median(),
                     "pairs": len(both), "disagreement": np.exp(np.sqrt((apart**2).mean()))}  # fmt: skip


def rests_page(data):
    """Lay the table out: a row per parameter, three columns per scheme."""
    known, rows = data.set_index(["kind", "parameter", "scheme"]), []
    for (kind, parameter), (title, unit) in ESTIMATES.items():
        row = {"parameter": title}
        for scheme in known.index.unique("scheme"):
            one, name = known.loc[(kind, parameter, scheme)], attitude.TITLES[scheme]
            row[f"{name}: median"] = tables.number(from_si(one["median"], unit), 2)
            row["identified" + " " * len(row)] = f"{one['identified']:.0f} of {one['fits']:.0f}"
            row["rests differ by" + " " * len(row)] = f"×{tables.number(one['disagreement'], 2)}"
        rows.append(row)
    return pd.DataFrame(rows).rename(columns=str.strip)


def trials_page(scores, differences, titles):
    """Lay the errors out: a row per trial, model and angle."""
    rms = scores.set_index(["trial", "model", "angle", "scheme"])["rms"]
    rows = []
    for one in differences.itertuples():
        key = one.trial, one.model, one.angle
        errors = [tables.number(from_si(rms[(*key, scheme)], "deg")) for scheme in attitude.TITLES if scheme != "truth"]
        difference = tables.interval(
            *(from_si(from_si(value, "deg"), "deg") for value in (one.value, one.low, one.high))
        )
        said = "too few blocks" if np.isinf(one.high) else ("beyond chance" if one.differs else "chance")
        rows.append([titles[one.trial], MODELS[one.model], ANGLES[one.angle], *errors, difference, one.blocks, said])
    heads = [f"{title}: rms [°]" for scheme, title in attitude.TITLES.items() if scheme != "truth"]
    heads = ["trial", "model", "error", *heads, "variance, 2 less 1 [°²]", "blocks", "2 against 1"]
    return pd.DataFrame(rows, columns=heads)


def numbers(alignment, scores, differences, estimates):
    """Collect what the text quotes."""
    lag = alignment[alignment["quantity"] == "lag"]["value"]
    change = alignment[alignment["quantity"].str.startswith("change")]["value"].abs()
    axes = alignment[alignment["quantity"].str.startswith("frame")]["value"].abs()
    said = {
        "lag_ms": [tables.number(1e3 * end, 2) for end in (lag.min(), lag.max())],
        "largest_change_deg_per_s": tables.number(from_si(change.max(), "deg"), 2),
        "largest_axes_deg": tables.number(from_si(axes.max(), "deg"), 2),
        "models": {},
    }
    tilt = scores[scores["angle"].isin(ERROR[:2])].assign(square=lambda one: one["rms"] ** 2)
    tilt = np.sqrt(tilt.groupby(["model", "scheme", "trial"])["square"].sum())
    nees = scores.groupby(["model", "scheme", "trial"])["nees"].first()
    heading = scores[scores["angle"] == "down"].groupby("model")["rms"]
    rest, margin = (tilt[model] for model in MODELS)
    for model in MODELS:
        alone = differences[differences["model"] == model]
        said["models"][model] = {
            "tilt_deg": [tables.number(from_si(end(tilt[model]), "deg"), 2) for end in (min, max)],
            "heading_deg": [tables.number(from_si(end[model], "deg"), 2) for end in (heading.min(), heading.max())],
            "nees": [tables.number(end(nees[model]), 2) for end in (min, max)],
            "cases": len(alone), "better": int((alone["high"] < 0).sum()), "worse": int((alone["low"] > 0).sum()),
            "mute": int(np.isinf(alone["high"]).sum()),
            "tilt_smaller": int((margin < rest).sum()), "tilt_cases": len(rest),
        }  # fmt: skip
    times = estimates[(estimates["parameter"] == "correlation_time")]
    said["identified_times"] = f"{times['identified'].sum()} of {times['fits'].sum()}"
    return said


with job(snakemake) as (source, _, output):
    alignment, scores, differences = (pd.read_csv(source[name]) for name in ("alignment", "scores", "differences"))
    errors, titles, estimates = (
        pd.read_parquet(source.errors),
        names(),
        pd.DataFrame(rests(pd.read_csv(source.estimates))),
    )
    chosen = {trial: titles[trial] for trial in errors["trial"].unique()}
    save(
        output,
        figure=attitude.trials(errors, chosen, list(MODELS)),
        alignment=(alignment, alignment_page(alignment, titles)),
        rests=(estimates, rests_page(estimates)),
        trials=(differences, trials_page(scores, differences, titles)),
        numbers=numbers(alignment, scores, differences, estimates),
    )

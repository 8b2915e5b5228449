"""Lay out the simulated flights: figures, table 5 of the source, estimated parameters, numbers of the text."""

from pathlib import Path

import numpy as np
import pandas as pd
import yaml

from imugap.estimation.result import Identifiability
from imugap.figures import attitude
from imugap.log import GYRO
from imugap.numerics.fitting import block_bootstrap as bootstrap
from imugap.stream import stream
from imugap.units import from_si
from imugap.workflow import tables
from imugap.workflow.job_log import job
from imugap.workflow.products import save

MEASURES = {"variance": "error variance [°²]", "mean_abs": "mean absolute error [°]", "range": "range [°]"}
PARAMETERS = {
    ("gyro", "density"): "gyroscope N",
    ("gyro", "std"): "gyroscope σ",
    ("gyro", "correlation_time"): "gyroscope T",
    ("accel", "density"): "accelerometer N",
    ("accel", "density_k"): "accelerometer K",
}
ESTIMATED = ("allan", "indirect", "likelihood")


def degrees(value, measure):
    """Return a score in degrees, or in their square where it is a variance."""
    once = from_si(value, "deg")
    return from_si(once, "deg") if measure == "variance" else once


def comparison(scores, seed):
    """Return means over the flights per length, angle and scheme, and the paired difference of schemes 2 and 1."""
    known, rows = scores.set_index(["minutes", "angle", "scheme", "run"]).sort_index(), []
    for minutes in sorted(set(scores["minutes"]) - {0}):
        for angle in attitude.ANGLES:
            for measure in ("variance", "mean_abs"):
                of = {one: known.loc[(minutes, angle, one), measure] for one in ESTIMATED}
                of["truth"] = known.loc[(0, angle, "truth"), measure]
                rng = stream(seed, "flights", minutes, angle, measure)
                difference = bootstrap.mean((of["indirect"] - of["allan"]).to_numpy(), rng, block=1)
                row = {"minutes": minutes, "angle": angle, "measure": measure}
                row |= {one: float(values.mean()) for one, values in of.items()}
                row |= {
                    "difference": difference.value,
                    "low": difference.low,
                    "high": difference.high,
                    "differs": difference.differs,
                }
                rows.append(row | {"smaller": float((of["indirect"] < of["allan"]).mean())})
    return pd.DataFrame(rows)


def printed(published, angle, measure):
    """Return the printed values of schemes 1 and 2 as text."""
    name = {"variance": "error_variance", "mean_abs": "mean_abs_error", "range": "error_range"}[measure]
    row = published.loc[f"{attitude.ANGLES[angle]}_{name}", ["allan", "indirect"]]
    return " → ".join("lost" if pd.isna(one) else str(one) for one in row)


def spans(scores, minutes, angle, scheme):
    """Return the mean lowest and highest error as text."""
    one = scores[(scores["minutes"] == minutes) & (scores["angle"] == angle) & (scores["scheme"] == scheme)]
    return " to ".join(tables.number(degrees(one[end].mean(), end)) for end in ("lowest", "highest"))


def page(compared, scores, published):
    """Lay table 5 out: a row per length, angle and measure."""
    rows = []
    for (minutes, angle), group in compared.groupby(["minutes", "angle"], sort=False):
        for row in group.itertuples():
            means = [tables.number(degrees(getattr(row, one), row.measure)) for one in (*ESTIMATED, "truth")]
            difference = tables.interval(*(degrees(v, row.measure) for v in (row.difference, row.low, row.high)))
            head = [f"{minutes} min", attitude.ANGLES[angle], MEASURES[row.measure]]
            rows.append([*head, *means, difference, printed(published, angle, row.measure)])
        ranges = [spans(scores, minutes, angle, one) for one in ESTIMATED] + [spans(scores, 0, angle, "truth")]
        head = [f"{minutes} min", attitude.ANGLES[angle], MEASURES["range"]]
        rows.append([*head, *ranges, "—", printed(published, angle, "range")])
    heads = ["static log", "angle", "error", *(attitude.TITLES[one] for one in (*ESTIMATED, "truth"))]
    return pd.DataFrame(rows, columns=[*heads, "2 less 1", "printed, 1 → 2"])


def parameters(estimates, model):
    """Return estimated over true parameters, a row per length, parameter and scheme."""
    true = {
        (axis, effect, name): value
        for axis, effects in model.items()
        for one in effects
        for effect, values in one.items()
        for name, value in values.items()
    }
    known = estimates[estimates["parameter"] != "driving_psd"].copy()
    key = zip(known["axis"], known["effect"], known["parameter"], strict=True)
    known["ratio"] = known["value"] / [true[one] for one in key]
    known["kind"] = np.where(known["axis"].isin(GYRO), "gyro", "accel")
    known["identified"] = known["verdict"] == Identifiability.IDENTIFIED
    groups = known.groupby(["minutes", "kind", "parameter", "scheme"], sort=False)
    found = groups["ratio"].quantile([0.05, 0.5, 0.95]).unstack().set_axis(["low", "median", "high"], axis=1)
    return found.assign(identified=groups["identified"].mean()).reset_index()


def parameter_page(data):
    """Lay the table of parameters out: a row per length and parameter, a column per scheme."""
    rows = []
    for minutes in sorted(data["minutes"].unique()):
        for (kind, name), title in PARAMETERS.items():
            cells = [f"{minutes} min", title]
            for scheme in ESTIMATED:
                chosen = (data["minutes"] == minutes) & (data["kind"] == kind)
                one = data[chosen & (data["parameter"] == name) & (data["scheme"] == scheme)].iloc[0]
                low, middle, high = (tables.fixed(one[end], 3) for end in ("low", "median", "high"))
                cells.append(f"{middle} [{low}, {high}], {100 * one['identified']:.0f} %")
            rows.append(cells)
    return pd.DataFrame(rows, columns=["static log", "parameter", *(attitude.TITLES[one] for one in ESTIMATED)])


def numbers(compared, scores, differences, published, params):
    """Collect what the text quotes."""
    said = {"trials": list(params.trials), "course": params.course, "rate_hz": params.rate_hz}
    said |= {"flights": int(scores["run"].nunique()), "lengths": {}}
    said["printed"] = {
        name: printed(published, angle, "variance") for angle, name in attitude.ANGLES.items() if angle != "heading"
    }
    nees = scores.groupby(["minutes", "scheme"])["nees"].mean()
    said["nees"] = tables.number(nees[0, "truth"], 2)
    for minutes, group in compared.groupby("minutes"):
        angles = {}
        for row in group[group["measure"] == "variance"].itertuples():
            alone = differences[(differences["minutes"] == minutes) & (differences["angle"] == row.angle)]
            angles[attitude.ANGLES[row.angle]] = {
                "ratio": tables.number(row.indirect / row.allan, 2),
                "printed_ratio": ratio_of(published, row.angle),
                "gap": tables.interval(*(degrees(v, "variance") for v in (row.difference, row.low, row.high))),
                "differs": bool(row.differs),
                "better": bool(row.difference < 0),
                "smaller_percent": f"{100 * row.smaller:.0f}",
                "truth_ratio": tables.number(row.truth / row.allan, 2),
                "alone_better": int((alone["high"] < 0).sum()),
                "alone_worse": int((alone["low"] > 0).sum()),
                "alone_mute": int(np.isinf(alone["high"]).sum()),
            }
        believed = {one: tables.number(nees[minutes, one], 2) for one in ESTIMATED}
        said["lengths"][str(minutes)] = {"angles": angles, "nees": believed}
    return said


def ratio_of(published, angle):
    """Return the printed ratio of the error variances, scheme 2 over scheme 1, as text; None where a value is lost."""
    row = published.loc[f"{attitude.ANGLES[angle]}_error_variance", ["allan", "indirect"]].astype(float)
    return None if row.isna().any() else tables.number(row["indirect"] / row["allan"], 2)


with job(snakemake) as (source, params, output):
    scores, errors = pd.read_csv(source.scores), pd.read_parquet(source.errors)
    published = pd.read_csv(source.published).set_index("quantity")
    shortest = scores.loc[scores["minutes"] > 0, "minutes"].min()
    drawn = errors[errors["minutes"].isin([0, shortest]) & errors["scheme"].isin(["allan", "indirect", "truth"])]
    swing = params.course["disturbance"]
    gust = swing["start_s"], swing["start_s"] + swing["duration_s"]
    compared = comparison(scores, params.seed)
    model = yaml.safe_load(Path(source.model).read_text())[0]["truth"]
    data = parameters(pd.concat(map(pd.read_csv, source.estimates)), model)
    save(
        output,
        flight=attitude.flight(pd.read_parquet(source.truth), drawn, gust),
        runs=attitude.runs(scores),
        table=(compared, page(compared, scores, published)),
        parameters=(data, parameter_page(data)),
        numbers=numbers(compared, scores, pd.read_csv(source.differences), published, params),
    )

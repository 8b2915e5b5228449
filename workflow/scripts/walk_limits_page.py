"""Lay out what limits a walk: variance budget, sensitivity to the detector, consistency, numbers of the text."""

from pathlib import Path

import numpy as np
import pandas as pd

from imu_benchmark.scores import rate
from imugap.figures import pedestrian, style
from imugap.stream import stream
from imugap.study import verdicts
from imugap.study.walk.end_consistency import SQUARES, in_ellipse, interval_columns, mean_row
from imugap.workflow import tables
from imugap.workflow.job_log import job
from imugap.workflow.products import save

SETS = {"embedded": "embedded"} | pedestrian.SETS
EFFECTS = {
    "white_noise": "noise",
    "random_walk": "random walk",
    "turn_on_bias": "turn-on bias",
    "scale_factor": "scale factor",
    "misalignment": "misalignment",
    "g_sensitivity": "g-sensitivity",
    "time_offset": "delay",
    "stance_motion": "slip at stance",
}
TRIADS = {"gyro": "gyro", "accel": "accel.", "foot": "foot"}
QUANTITIES = {"horizontal": ["north", "east"], "height": ["down"]}
DETECTORS = ("GLRT", "rate", "variance", "norm")
SETTINGS = {
    "threshold": ("threshold of the detector", 1.0),
    "detector": ("detector", 0.0),
    "velocity": ("velocity at stance", 1.0),
    "noise": ("noise of accelerometers", 1.0),
}
"""What is chosen: its name, and its usual value."""
LEFT_OUT = ["setting", "dataset", "chosen", "with_chosen", "usual", "with_usual", "best", "with_best"]
"""Columns of what others choose for a set: values, and the median end errors of the set with them [%]."""
LEVELS = (0.9, 0.99)
IN_MOTION = ("scale_factor", "misalignment", "g_sensitivity", "time_offset")
"""Errors that a log at rest does not show."""
SMALL = 0.01
"""Share of the variance below which an effect goes under "others" in the figure."""


def contributions(errors):
    """Yield root mean squares over walks and devices: of what each effect adds, of all, of none [m]."""
    walks = errors.set_index(["set", "walk", "draw", "triad", "effect"])[["north", "east", "down"]]
    whole = walks.xs(("all", "all"), level=("triad", "effect"))
    for (name, triad, effect), one in walks.groupby(level=["set", "triad", "effect"], sort=False):
        here = one.droplevel(["triad", "effect"])
        if triad not in ("all", "none"):
            here = whole.loc[here.index] - here
        row = {"set": name, "triad": triad, "effect": effect}
        for quantity, columns in QUANTITIES.items():
            row[quantity] = np.sqrt((here[columns] ** 2).sum(axis=1).mean())
        yield row


def title(triad, effect):
    """Return the name of an error."""
    return {"all": "all of them", "none": "none of them"}.get(triad) or f"{TRIADS[triad]}: {EFFECTS[effect]}"


def shares(found, quantity):
    """Return the share of each effect in the sum of the variances, a column for each set."""
    single = found[~found["triad"].isin(["all", "none"])]
    names = [title(*pair) for pair in zip(single["triad"], single["effect"], strict=True)]
    square = single.assign(name=names, square=single[quantity] ** 2).pivot(index="name", columns="set", values="square")
    square = square[[name for name in SETS if name in square]].rename(columns=SETS)
    return square.loc[list(dict.fromkeys(names))] / square.sum()


def drawn(found):
    """Return the shares for the figure: what is small everywhere is one."""
    both = {quantity: shares(found, quantity) for quantity in QUANTITIES}
    large = pd.concat(both.values(), axis=1).max(axis=1) > 5 * SMALL
    heads = {"horizontal": "horizontal end error", "height": "height at the end"}
    return {
        heads[quantity]: pd.concat([one[large], one[~large].sum().to_frame("all others").T])
        for quantity, one in both.items()
    }


def budget_page(found, real):
    """Lay the budget out: a row per error, root mean square in centimetres, two columns per set."""
    names = [name for name in SETS if name in set(found["set"])]
    of = found.set_index(["set", "triad", "effect"])
    for triad, effect in dict.fromkeys(zip(found["triad"], found["effect"], strict=True)):
        row = {"error": title(triad, effect)}
        for name in names:
            one = of.loc[(name, triad, effect)]
            row[SETS[name]] = " / ".join(tables.number(100 * one[quantity], 2) for quantity in QUANTITIES)
        yield row
    ends = {"error": "the real walks"}
    for name in names:
        one = real[real["dataset"] == name]
        ends[SETS[name]] = " / ".join(
            tables.number(100 * np.sqrt((one[key] ** 2).mean()), 2) for key in ("end", "height_alone")
        ) if len(one) else "—"  # fmt: skip
    yield ends


def consistency(ends, real, seed):
    """Yield the share of ends in the ellipses with binomial intervals, and the mean NEES with bootstrap intervals."""
    groups = dict(list(ends.groupby("foot", sort=False))) | ({"real walks": real} if len(real) else {})
    for name, one in groups.items():
        row = {"foot": name, "walks": len(one)}
        for level in LEVELS:
            row |= {f"{key}_{level:g}": value for key, value in rate(in_ellipse(one["nees"], level)).items()}
        for square, (_, degrees) in SQUARES.items():
            if square in one:
                values = one[square].to_numpy() / degrees
                row |= mean_row(square, values, stream(seed, "walk consistency", name, square))
        yield row


def consistency_page(data):
    """Lay the table out."""
    for one in data.to_dict("records"):
        row = {"walks": f"{one['foot']} ({one['walks']})"}
        for level in LEVELS:
            values = (100 * one[f"{key}_{level:g}"] for key in ("rate", "low", "high"))
            middle, low, high = (tables.fixed(value, 1) for value in values)
            row[f"in the {level:.0%} ellipse [%]"] = f"{middle} [{low}, {high}]"
        for square, (title, _) in SQUARES.items():
            row[title] = (
                tables.interval(*(one[key] for key in interval_columns(square))) if np.isfinite(one[square]) else "—"
            )
        yield row


def numbers(found, counted, varied, real):
    """Collect what the text quotes."""
    said = {"sets": {}, "within": {}}
    for name in found["set"].unique():
        one = found[found["set"] == name].set_index(["triad", "effect"])
        single = one.drop(index=[("all", "all"), ("none", "none")])
        said["sets"][name] = {
            quantity: {
                "first": [title(*pair) for pair in single[quantity].nlargest(2).index],
                "all_cm": tables.number(100 * one.loc[("all", "all"), quantity], 2),
                "misaligned_cm": tables.number(
                    100 * np.hypot(*single.loc[pd.IndexSlice[:, "misalignment"], quantity]), 2
                ),
            }
            for quantity in QUANTITIES
        }
    single = found[~found["triad"].isin(["all", "none"])]
    moving = single["effect"].isin(IN_MOTION)
    for quantity in QUANTITIES:
        square = single[quantity] ** 2
        part = 100 * square[moving].groupby(single["set"]).sum() / square.groupby(single["set"]).sum()
        said[f"in_motion_{quantity}"] = [f"{end(part):.0f}" for end in (min, max)]
    for row in counted.to_dict("records"):
        said["within"][row["foot"]] = {f"{level:.0%}": f"{100 * row[f'rate_{level:g}']:.0f}" for level in LEVELS} | {
            "covers": bool(all(row[f"low_{one:g}"] <= one <= row[f"high_{one:g}"] for one in LEVELS)),
            "nees": tables.interval(*(row[key] for key in interval_columns("nees"))),
            "nees_verdict": verdicts.consistency((row["nees_low"], row["nees_high"])),
        }
    if varied is not None:
        said |= of_choices(varied)
    return said


def of_choices(varied):
    """Collect what the text says of thresholds, detectors and delays."""
    share = {
        kind: varied[varied["varied"] == kind].groupby("value")["share"].agg(["median", "max"])
        for kind in ("threshold", "detector")
    }
    fine = share["threshold"][share["threshold"]["median"] < 0.5].index
    delay = varied[varied["varied"] == "delay"]
    best = delay.groupby(["dataset", "run"])[["value", "nis"]].apply(least)
    slope = delay.groupby(["dataset", "run"])[["value", "height"]].apply(
        lambda one: np.polyfit(*one.to_numpy().T, 1)[0]
    )
    return {
        "fine_thresholds": [tables.number(end(fine), 2) for end in (min, max)],
        "detectors_percent": {
            DETECTORS[int(value)]: [tables.number(one["median"], 2), tables.number(one["max"], 2)]
            for value, one in share["detector"].iterrows()
        },
        "least_delay_ms": {
            name: [tables.fixed(end(one), 1) for end in (min, max)] for name, one in best.groupby(level=0)
        },
        "settings": chosen_elsewhere(left_out(varied)),
        "slope_cm_per_ms": {name: tables.number(100 * one.mean(), 2) for name, one in slope.groupby(level=0)},
    }  # fmt: skip


def chosen_elsewhere(data):
    """Collect how often others choose the usual, and what their choice costs the set left out at most, and mostly."""
    more = data["with_chosen"] / data["with_usual"]
    return {
        "cases": len(data),
        "usual": int((data["chosen"] == data["usual"]).sum()),
        "ratios": [tables.number(end(more), 2) for end in (min, np.median, max)] if len(data) else [],
    }


def left_out(varied):
    """Return for each set and setting what the others choose, and the median end error of the set with it [%].

    The choice is the value with the least median, over the walks of all other sets, of the error of the end in space
    over the distance.
    """
    usual = varied[(varied["varied"] == "threshold") & (varied["value"] == 1)]
    rows = []
    for setting, (_, own) in SETTINGS.items():
        table = varied[varied["varied"] == setting]
        if own not in set(table["value"]):
            table = pd.concat([table, usual.assign(varied=setting, value=own)])
        share = 100 * np.hypot(table["end"], table["height"]) / table["distance"]
        table = table.assign(space=share)
        for name in table["dataset"].unique():
            here = table["dataset"] == name
            others, one = (part.groupby("value")["space"].median() for part in (table[~here], table[here]))
            if others.empty:
                continue
            chosen = others.idxmin()
            row = {"setting": setting, "dataset": name, "chosen": chosen, "with_chosen": one[chosen]}
            rows.append(row | {"usual": own, "with_usual": one[own], "best": one.idxmin(), "with_best": one.min()})
    return pd.DataFrame(rows, columns=LEFT_OUT)


def settings_page(data):
    """Lay the table out: a row per setting, a column per set left out."""
    for setting, group in data.groupby("setting", sort=False):
        row = {"setting": SETTINGS[setting][0]}
        for one in group.to_dict("records"):
            value = DETECTORS[int(one["chosen"])] if setting == "detector" else f"× {one['chosen']:g}"
            ends = (tables.number(one[f"with_{key}"], 2) for key in ("chosen", "usual", "best"))
            row[f"without {SETS[one['dataset']]}"] = f"{value}: {' / '.join(ends)}"
        yield row


def least(one):
    """Return the delay at which the sum of the NIS is least, by a parabola through its three lowest neighbours."""
    value, nis = one["value"].to_numpy(), one["nis"].to_numpy()
    middle = int(np.clip(np.argmin(nis), 1, len(nis) - 2))
    a, b, _ = np.polyfit(value[middle - 1 : middle + 2], nis[middle - 1 : middle + 2], 2)
    return float(np.clip(-b / (2 * a), value[0], value[-1]))


with job(snakemake) as (source, params, output):
    errors = pd.concat(
        pd.read_parquet(path).assign(set=Path(path).stem, walk=lambda one: one["walk"].astype(str))
        for path in source.budgets
    )
    real = pd.concat(map(pd.read_csv, source.walks)) if source.walks else pd.DataFrame(columns=["dataset"])
    found, counted = map(
        pd.DataFrame, (contributions(errors), consistency(pd.read_csv(source.consistency), real, params.seed))
    )
    varied, sensitivity, settings = None, style.text_figure("no real walk is here"), pd.DataFrame(columns=LEFT_OUT)
    if source.choices:
        varied = pd.concat(map(pd.read_csv, source.choices))
        varied["share"] = 100 * varied["end"] / varied["distance"]
        present = {name: SETS[name] for name in SETS if name in set(varied["dataset"])}
        sensitivity, settings = pedestrian.sensitivity(varied, present, DETECTORS), left_out(varied)
    nothing = pd.DataFrame([{"setting": "fewer than two sets of walks are here"}])
    save(
        output,
        budget_figure=pedestrian.budget(drawn(found)),
        budget=(found, budget_page(found, real)),
        consistency=(counted, consistency_page(counted)),
        sensitivity=sensitivity,
        settings=(settings, settings_page(settings) if len(settings) else nothing),
        numbers=numbers(found, counted, varied, real),
    )

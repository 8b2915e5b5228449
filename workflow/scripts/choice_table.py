"""Tabulate the effects chosen for every axis of a device, and draw where the models fail."""

import pandas as pd

from imugap.effects import title_of
from imugap.estimation.result import Identifiability
from imugap.figures import estimation
from imugap.figures.style import AXIS_TITLES
from imugap.workflow.job_log import job
from imugap.workflow.products import read_json, save


def rows(choice):
    """Yield one row per axis and estimate."""
    for axis, of in choice.items():
        for one in of["estimates"]:
            row = {"axis": axis, "effects": of["effects"], "verdict": of["verdict"], "p_value": of["p_value"]}
            yield row | {f"estimate_{key}" if key == "verdict" else key: value for key, value in one.items()}


def page(choice):
    """Lay the table out: a row per axis."""
    for axis, of in choice.items():
        values = [shown(one) for one in of["estimates"] if one["parameter"] != "driving_psd"]
        yield {
            "axis": AXIS_TITLES[axis],
            "chosen": in_words(of["effects"]),
            "parameters (SI)": ", ".join(values),
            "not distinguished from it": "; ".join(map(in_words, of["alternatives"])) or "—",
            "does it fit?": of["verdict"],
        }


def in_words(model):
    """Return the names of the effects of a model in words."""
    return " + ".join(map(title_of, model.split(" + ")))


def shown(one):
    """Show an estimate with its symbol, or the bound that the log sets."""
    symbol = estimation.SYMBOLS[one["effect"], one["parameter"]]
    symbol += str(one["ordinal"]) if one["ordinal"] > 1 else ""
    match one["verdict"]:
        case Identifiability.UPPER_BOUND:
            return f"{symbol} ≤ {one['high']:.2g}"
        case Identifiability.LOWER_BOUND:
            return f"{symbol} ≥ {one['low']:.2g}"
    return f"{symbol} {one['value']:.3g}"


def numbers(choice):
    """Count the axes, and those whose chosen model passes its test of fit."""
    return {"axes": len(choice), "fits": sum(of["verdict"] == "fits" for of in choice.values())}


with job(snakemake) as (source, _, output):
    choice = read_json(source.choice)
    figure = estimation.goodness(pd.read_csv(source.goodness))
    save(output, figure=figure, table=(pd.DataFrame(rows(choice)), page(choice)), numbers=numbers(choice))

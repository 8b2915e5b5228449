"""Tabulate the effects chosen for every axis of a device, and draw where the models fail."""

import json
from pathlib import Path

import pandas as pd

from imugap.estimation.result import Identifiability
from imugap.figures import estimation, style
from imugap.figures.style import AXIS_TITLES
from imugap.workflow import tables
from imugap.workflow.job_log import journal


def rows(choice):
    """Return one row per axis and estimate."""
    return pd.DataFrame(
        [
            {"axis": axis, "effects": of["effects"], "verdict": of["verdict"], "p_value": of["p_value"]}
            | {f"estimate_{key}" if key == "verdict" else key: value for key, value in one.items()}
            for axis, of in choice.items()
            for one in of["estimates"]
        ]
    )


def page(choice):
    """Lay the table out: a row per axis."""
    found = []
    for axis, of in choice.items():
        values = [shown(one) for one in of["estimates"] if one["parameter"] != "driving_psd"]
        found.append(
            {
                "axis": AXIS_TITLES[axis],
                "chosen": of["effects"].replace("_", " "),
                "parameters (SI)": ", ".join(values),
                "not distinguished from it": "; ".join(of["alternatives"]).replace("_", " ") or "—",
                "does it fit?": of["verdict"],
            }
        )
    return pd.DataFrame(found)


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


if __name__ == "__main__":
    with journal(snakemake.log[0]):
        choice = json.loads(Path(snakemake.input.choice).read_text())
        style.save(estimation.goodness(pd.read_csv(snakemake.input.goodness)), snakemake.output[0])
        tables.write(snakemake.output[1].removesuffix(".csv"), rows(choice), page(choice))

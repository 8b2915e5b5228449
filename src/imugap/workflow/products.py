"""Products of a rule, written to its outputs of the same names."""

import json
from collections.abc import Mapping
from pathlib import Path

import pandas as pd
import yaml

from imugap.workflow import tables

METADATA = {"svg": {"Date": None}, "png": {"Software": None}, "pdf": {"CreationDate": None, "Producer": None}}
"""Formats of figures, and what is left out of each: times and versions, which would change the bytes."""
PNG_DPI = 200


def write_figure(figure, path: str | Path, kind: str = "svg") -> None:
    """Write a matplotlib figure in one of the formats of :data:`METADATA`, the same bytes for the same figure."""
    figure.savefig(path, format=kind, metadata=METADATA[kind], dpi=PNG_DPI if kind == "png" else "figure")


def read_json(path: str | Path) -> dict:
    """Read plain data."""
    return json.loads(Path(path).read_text())


def record_of(source: Mapping[str, object]) -> dict:
    """Return date, commit and machine of a recorded run, from the input ``record``; nothing for a run made here."""
    return yaml.safe_load(Path(source["record"]).read_text()) if "record" in source else {}


def save(output: Mapping[str, object], **products: object) -> None:
    """Write products to the outputs of their names.

    Parameters
    ----------
    output
        Paths by name; of a table of the paper the paths of its CSV, JSON and LaTeX.
    products
        A table of the paper as a pair (tidy numbers, rows as the page shows them); another table as a DataFrame,
        without its index, in the format of the suffix; plain data for JSON; a figure.
    """
    for name, product in products.items():
        match product:
            case (data, shown):
                tables.write(output[name][0].removesuffix(".csv"), data, pd.DataFrame(shown))
            case pd.DataFrame() if output[name].endswith(".parquet"):
                product.to_parquet(output[name], index=False)
            case pd.DataFrame():
                product.to_csv(output[name], index=False)
            case dict():
                Path(output[name]).write_text(json.dumps(product, indent=1) + "\n")
            case _:
                write_figure(product, output[name])

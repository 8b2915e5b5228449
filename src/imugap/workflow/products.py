"""Products of a rule, written to its outputs of the same names."""

import json
from collections.abc import Mapping
from pathlib import Path

import pandas as pd

from imugap.workflow import tables


def write_svg(figure, path: str | Path) -> None:
    """Write a matplotlib figure as SVG, the same bytes for the same figure."""
    figure.savefig(path, format="svg", metadata={"Date": None})


def read_json(path: str | Path) -> dict:
    """Read plain data."""
    return json.loads(Path(path).read_text())


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
                write_svg(product, output[name])

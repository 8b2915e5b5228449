"""Tables in memory, as columns of a file."""

from pathlib import Path

import pandas as pd

from imugap.io.formats.source import Source
from imugap.log import LogError

NAME = "table"
"""Path of a table."""


def table_source(table: pd.DataFrame) -> Source:
    """Return the columns of a table, the index first if it has a name; a LogError names a column that is no number."""
    whole = table if table.index.name is None else table.reset_index()
    names = tuple(map(str, whole.columns))

    def batches(columns):
        yield [_numbers(whole.iloc[:, number], names[number]) for number in columns]

    return Source(Path(NAME), names, len(whole), batches)


def _numbers(column: pd.Series, name: str):
    if column.dtype.kind == "M":
        return column.dt.as_unit("ns").astype("int64").to_numpy()
    if column.dtype.kind not in "iuf":
        raise LogError(NAME, f"column {name}", "numbers", str(column.dtype))
    return column.to_numpy()

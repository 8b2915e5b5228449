"""Parquet tables; those that this package wrote are canonical by their mark."""

import json
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet

from imugap.io.formats.source import Source
from imugap.log import ATTRIBUTES, MARK, LogError

MAGIC = b"PAR1"


def recognises(path: Path, head: bytes) -> bool:
    """Return whether a file begins as Parquet does, or ends in its name."""
    return head.startswith(MAGIC) or path.suffix.lower() == ".parquet"


def open_source(path: Path, settings) -> Source:
    """Return the columns of a Parquet file; LogError where one that is read is no number."""
    with path.open("rb") as handle:  # the library opens no name that is not UTF-8
        file = pa.parquet.ParquetFile(handle)
        schema, rows = file.schema_arrow, file.metadata.num_rows
    counted = _counted_index(schema)
    names = (*schema.names, *counted)

    def batches(columns):
        with path.open("rb") as handle:
            file, row = pa.parquet.ParquetFile(handle), 0
            for group in range(file.num_row_groups):
                stored = [names[k] for k in columns if names[k] not in counted]
                table = file.read_row_group(group, columns=stored)
                inside = slice(row, row := row + file.metadata.row_group(group).num_rows)
                yield [
                    counted[name][inside] if name in counted else _numbers(path, name, table.column(name))
                    for name in (names[k] for k in columns)
                ]

    attributes = json.loads((schema.metadata or {}).get(ATTRIBUTES, b"{}"))
    return Source(path, names, rows, batches, canonical=attributes == MARK)


def _counted_index(schema: pa.Schema) -> dict[str, np.ndarray]:
    """Return an index of equal steps, which pandas keeps as its begin, end and step, by its name."""
    found = (schema.pandas_metadata or {}).get("index_columns", [])
    return {
        one["name"]: np.arange(one["start"], one["stop"], one["step"])
        for one in found
        if isinstance(one, dict) and one.get("name")
    }


def _numbers(path: Path, name: str, values: pa.ChunkedArray) -> np.ndarray:
    kind = values.type
    if pa.types.is_timestamp(kind):
        return values.cast(pa.timestamp("ns")).cast(pa.int64()).to_numpy()
    if not (pa.types.is_integer(kind) or pa.types.is_floating(kind)):
        raise LogError(path, f"column {name}", "numbers", str(kind))
    return values.to_numpy()

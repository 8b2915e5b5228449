"""Parquet tables; those that this package wrote are canonical by their mark."""

import json
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet

from imugap.io.formats.source import Source
from imugap.log import MARK, LogError

MAGIC = b"PAR1"
ATTRIBUTES = b"PANDAS_ATTRS"
"""Key under which pandas keeps the attributes of a table."""


def recognises(path: Path, head: bytes) -> bool:
    """Return whether a file begins as Parquet does, or ends in its name."""
    return head.startswith(MAGIC) or path.suffix.lower() == ".parquet"


def open_source(path: Path, settings) -> Source:
    """Return the columns of a Parquet file; LogError where one that is read is no number."""
    file = pa.parquet.ParquetFile(path.open("rb"))  # the library opens no name that is not UTF-8
    schema = file.schema_arrow
    names = tuple(schema.names)

    def batches(columns):
        for group in range(file.num_row_groups):
            table = file.read_row_group(group, columns=[names[k] for k in columns])
            yield [_numbers(path, names[k], table.column(names[k])) for k in columns]

    attributes = json.loads((schema.metadata or {}).get(ATTRIBUTES, b"{}"))
    return Source(path, names, file.metadata.num_rows, batches, canonical=attributes == MARK)


def _numbers(path: Path, name: str, values: pa.ChunkedArray) -> np.ndarray:
    kind = values.type
    if pa.types.is_timestamp(kind):
        return values.cast(pa.timestamp("ns")).cast(pa.int64()).to_numpy()
    if not (pa.types.is_integer(kind) or pa.types.is_floating(kind)):
        raise LogError(path, f"column {name}", "numbers", str(kind))
    return values.to_numpy()

"""The threads of Arrow that read a text ahead: none holds it, or calls Python, when the reader is left."""

import gc
from types import FunctionType

import numpy as np
import pyarrow as pa

from imugap.io.formats import text

ATTEMPTS = 30


def test_a_reading_that_is_left_early_is_let_go_by_its_threads(tmp_path):
    """A thread that calls Python while Python ends kept the command from ending, about one refusal in three."""
    path = tmp_path / "log.csv"
    rows = np.random.default_rng(1).normal(size=(120_000, 3)).round(6)
    np.savetxt(path, rows, "%.6f", ",", header="gyro_x,gyro_y,gyro_z", comments="")
    dialect = text.sniff(path)
    for _ in range(ATTEMPTS):
        batches = text._read(path, dialect, {0: pa.float64()}, [])
        next(batches)
        batches.close()
        held = [one for one in gc.get_objects() if type(one) in (FunctionType, text.WholeLines)]
        assert not [one for one in held if type(one) is text.WholeLines or one.__qualname__ == "_read.<locals>.skip"]

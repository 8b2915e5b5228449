from pathlib import Path

import numpy as np
import pytest
from scipy.io import savemat

from imugap.io.formats.mat_elements import HEADER, require_sound
from imugap.io.recording import read
from imugap.log import LogError
from imugap.stream import stream

ROWS = 40


@pytest.fixture(params=[False, True], ids=["plain", "compressed"])
def written(request, tmp_path) -> Path:
    """Write a file with arrays of every kind."""
    rng = stream(1, "mat")
    columns = {name: rng.standard_normal(ROWS) for name in ("t", "gyro_x", "gyro_y", "gyro_z")}
    content = {"imu": columns | {"note": "at rest", "cells": np.array([1, "b"], object)}, "count": np.uint16(ROWS)}
    path = tmp_path / "log.mat"
    savemat(path, content, do_compression=request.param)
    return path


def test_what_scipy_writes_is_sound(written):
    require_sound(written)


def test_every_array_has_its_type(tmp_path):
    path = tmp_path / "log.mat"
    savemat(path, {"gyro_x": np.arange(5.0)})
    content = bytearray(path.read_bytes())
    content[HEADER + 8] = 77  # the type of the flags of the first array
    path.write_bytes(content)
    with pytest.raises(LogError, match="expected a sound MATLAB file of level 5; found an element of type 77"):
        require_sound(path)


def test_an_array_that_is_cut_is_refused(written):
    written.write_bytes(written.read_bytes()[:-9])
    with pytest.raises(LogError, match="expected a sound MATLAB file of level 5"):
        require_sound(written)


@pytest.mark.parametrize("number", range(5))
def test_a_damaged_file_is_read_or_refused(written, number):
    """The reader of scipy ends the process at some types that the format does not have."""
    rng = stream(2, "damage", written.stat().st_size, number)
    content = np.frombuffer(written.read_bytes(), np.uint8)
    for _ in range(60):
        damaged = content.copy()
        damaged[rng.integers(HEADER, len(damaged), rng.integers(1, 4))] = rng.integers(256)
        written.write_bytes(damaged.tobytes())
        try:
            read(written)
        except LogError:
            continue

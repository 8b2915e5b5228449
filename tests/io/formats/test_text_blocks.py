from pathlib import Path

import numpy as np
import pytest

from imugap.io.formats import text, text_blocks
from imugap.io.formats.text_blocks import blocks

TASKS = Path("/proc/self/task")
LINES = [f"{k},{k / 7:.6f},Ångström" for k in range(4000)]


@pytest.fixture(params=[64, 1000, 1 << 20])
def size(request, monkeypatch):
    monkeypatch.setattr(text_blocks, "BLOCK_BYTES", request.param)
    return request.param


@pytest.mark.parametrize("ending", ["\n", "\r\n", "\r"])
@pytest.mark.parametrize("encoding", ["utf-8", "utf-16", "utf-16-be", "latin-1"])
def test_the_blocks_of_a_text_are_its_whole_lines(tmp_path, size, encoding, ending):
    path, content = tmp_path / "log.txt", ending.join([*LINES, "0,1,ĊĊ".encode(encoding, "ignore").decode(encoding)])
    path.write_bytes(content.encode(encoding))
    found = [one.decode() for one in blocks(path, encoding, path.stat().st_size)]
    assert "".join(found) == content
    assert all(one.endswith("\n") for one in found[:-1])


def test_a_text_is_read_up_to_an_end(tmp_path, size):
    path = tmp_path / "log.txt"
    path.write_text("\n".join(LINES), encoding="utf-8")
    end = len("\n".join(LINES[:7]).encode())
    assert b"".join(blocks(path, "utf-8", end)).decode() == "\n".join(LINES[:7])


def test_bytes_that_are_no_text_are_replaced(tmp_path, size):
    path = tmp_path / "log.txt"
    path.write_bytes(b"1,2\n3,\xff4\n")
    assert b"".join(blocks(path, "utf-8", 9)).decode() == "1,2\n3,\N{REPLACEMENT CHARACTER}4\n"


def test_a_text_that_ends_within_a_character_is_an_error(tmp_path, size):
    path = tmp_path / "log.txt"
    path.write_bytes("1,2\n3".encode("utf-16-le")[:-1])
    with pytest.raises(UnicodeDecodeError):
        list(blocks(path, "utf-16-le", path.stat().st_size))


@pytest.mark.skipif(not TASKS.exists(), reason="threads are listed on Linux alone")
def test_a_reading_that_is_left_early_leaves_no_thread(tmp_path):
    """A thread that calls Python while Python ends keeps the command from ending, or ends it by an abort."""
    path = tmp_path / "log.csv"
    rows = np.random.default_rng(1).normal(size=(120_000, 3)).round(6)
    np.savetxt(path, rows, "%.6f", ",", header="gyro_x,gyro_y,gyro_z", comments="")
    source = text.open_source(path, None)
    before = len(list(TASKS.iterdir()))
    for _ in range(5):
        batches = source.batches([0])
        next(batches)
        assert len(list(TASKS.iterdir())) == before

"""Compressed logs, archives of arrays, and files that are recognised but not read."""

import bz2
import gzip
import lzma
import pickle
import zipfile

import numpy as np
import pytest
from tests.io.devices import at_rest, times, write_text

from imugap.io.recording import RecordingSettings, read
from imugap.log import AXES, LogError

COUNT = 600
SAMPLES = at_rest(COUNT, up=(0, 0, -1))


def table():
    return np.column_stack([times(COUNT), SAMPLES])


@pytest.mark.parametrize(("opener", "ending"), [(gzip.open, "gz"), (bz2.open, "bz2"), (lzma.open, "xz")])
def test_a_compressed_log_is_read_as_it_is(tmp_path, opener, ending):
    plain = write_text(tmp_path / "run.csv", ["time", *AXES], table(), form="{:.17g}")
    path = tmp_path / f"run.csv.{ending}"
    with opener(path, "wb") as packed:
        packed.write(plain.read_bytes())
    found = read(path)
    assert found.source == path
    np.testing.assert_array_equal(found.log.to_numpy(), SAMPLES)


def test_an_error_in_a_compressed_log_names_the_file_and_the_line(tmp_path):
    plain = write_text(tmp_path / "run.csv", ["time", *AXES], table()).read_bytes()
    path = tmp_path / "run.csv.gz"
    path.write_bytes(gzip.compress(plain.replace(b"\n0.02,", b"\nx,", 1)))
    with pytest.raises(LogError, match=r"run.csv.gz: line 4, column time: expected a number; found 'x'"):
        read(path)
    path.write_bytes(gzip.compress(plain)[:2000])
    with pytest.raises(LogError, match="bytes that cannot be read"):
        read(path)


def test_archives_of_arrays_have_their_names(tmp_path):
    path = tmp_path / "run.npz"
    np.savez(path, t=times(COUNT), gyr=SAMPLES[:, :3], acc=SAMPLES[:, 3:])
    found = read(path, RecordingSettings(units={"gyro": "rad/s"}))
    np.testing.assert_array_equal(found.log.to_numpy(), SAMPLES)


def test_a_table_with_texts_in_an_archive_is_read(tmp_path):
    lines = [",".join(["time", "device", *AXES])]
    lines += [",".join([repr(row[0]), "left foot", *map(repr, row[1:])]) for row in table().tolist()]
    path = tmp_path / "run.zip"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("run.csv", "\n".join([*lines, ""]))
    np.testing.assert_array_equal(read(path).log.to_numpy(), SAMPLES)


def unread(kind, path):
    if kind == "spreadsheet":
        with zipfile.ZipFile(path, "w") as archive:
            archive.writestr("xl/worksheets/sheet1.xml", "<sheet/>")
    else:
        path.write_bytes({"HDF5": b"\x89HDF\r\n\x1a\n" + bytes(99), "pickle": pickle.dumps([1.0] * 9)}[kind])
    return path


@pytest.mark.parametrize(("kind", "words"), [
    ("spreadsheet", "save the sheet as CSV"), ("HDF5", "write its arrays as CSV"), ("pickle", "would run as code"),
])  # fmt: skip
def test_what_is_not_read_says_what_to_save_instead(tmp_path, kind, words):
    with pytest.raises(LogError, match=words):
        read(unread(kind, tmp_path / "run.dat"))

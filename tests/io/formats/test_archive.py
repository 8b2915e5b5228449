import zipfile

import pytest

from imugap.io.formats.archive import BEGIN, members
from imugap.io.recording import read
from imugap.log import LogError


@pytest.fixture
def packed(tmp_path):
    path = tmp_path / "log.zip"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("a.csv", "x")
        archive.writestr("b/c.npy", "y")
    return path


def test_an_archive_has_the_names_of_its_members(packed):
    assert members(packed, packed.read_bytes()) == ("a.csv", "b/c.npy")


def test_another_file_is_no_archive(tmp_path):
    path = tmp_path / "log.csv"
    path.write_text("time,gyro_x\n")
    assert members(path, path.read_bytes()) is None


@pytest.mark.parametrize("place", range(-40, 0))
def test_a_damaged_directory_is_read_or_refused(packed, place):
    content = bytearray(packed.read_bytes())
    content[place] ^= 0xFF
    packed.write_bytes(content)
    found = members(packed, bytes(content[: len(BEGIN)]))
    assert found in (None, ()) or len(found) == 2
    with pytest.raises(LogError, match="expected"):
        read(packed)

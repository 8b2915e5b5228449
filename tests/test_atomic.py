import errno
import os
import subprocess
import sys
from pathlib import Path
from threading import Thread
from time import sleep

import pytest

from imugap.atomic import atomic, write_folder, write_together
from imugap.stream import stream


def test_a_file_appears_whole_and_its_folder_with_it(tmp_path):
    path = tmp_path / "deep" / "file.txt"
    with atomic(path) as partial:
        partial.write_text("whole")
        assert not path.exists()
    assert path.read_text() == "whole"
    assert list(path.parent.iterdir()) == [path]


def write_half(path):
    with atomic(path) as partial:
        partial.write_text("half")
        raise OSError("disk full")


def test_a_failure_leaves_the_old_file_and_nothing_else(tmp_path):
    path = tmp_path / "file.txt"
    path.write_text("old")
    with pytest.raises(OSError, match="disk full"):
        write_half(path)
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_a_link_stays_and_its_target_is_written(tmp_path):
    (tmp_path / "there").mkdir()
    link = tmp_path / "link.txt"
    link.symlink_to("there/file.txt")
    for text in ("new", "newer"):
        with atomic(link) as partial:
            partial.write_text(text)
        assert link.is_symlink()
        assert (tmp_path / "there" / "file.txt").read_text() == text


def test_an_existing_file_keeps_its_mode_and_a_new_one_has_the_usual_one(tmp_path):
    old, new, usual = (tmp_path / name for name in ("old", "new", "usual"))
    old.write_text("old")
    old.chmod(0o640)
    usual.write_text("usual")
    for path in (old, new):
        with atomic(path) as partial:
            partial.write_text("written")
    assert old.stat().st_mode & 0o777 == 0o640
    assert new.stat().st_mode == usual.stat().st_mode


def test_a_partial_file_of_somebody_else_is_left_alone(tmp_path):
    other = tmp_path / "file.txt.partial"
    other.write_text("theirs")
    with atomic(tmp_path / "file.txt") as partial:
        partial.write_text("mine")
    assert other.read_text() == "theirs"
    assert (tmp_path / "file.txt").read_text() == "mine"


def test_a_folder_made_for_a_file_goes_with_its_failure(tmp_path):
    with pytest.raises(OSError, match="disk full"):
        write_half(tmp_path / "deep" / "deeper" / "file.txt")
    assert not list(tmp_path.iterdir())


def test_a_failure_of_the_system_names_the_file_that_was_to_be_written(tmp_path):
    path = tmp_path / "file.txt"
    with pytest.raises(OSError, match="No space") as caught, atomic(path):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
    assert caught.value.filename == str(path)


def test_a_pipe_gets_the_bytes_and_stays_a_pipe(tmp_path):
    pipe, read = tmp_path / "pipe", []
    os.mkfifo(pipe)
    reader = Thread(target=lambda: read.append(pipe.read_bytes()))
    reader.start()
    with atomic(pipe) as partial:
        partial.write_bytes(b"bytes")
    reader.join()
    assert read == [b"bytes"]
    assert pipe.is_fifo()


def test_a_device_takes_the_bytes():
    with atomic("/dev/null") as partial:
        partial.write_text("nothing")
    assert Path("/dev/null").is_char_device()


def test_files_that_are_written_together_are_written_all_or_none(tmp_path):
    paths = [tmp_path / name for name in "abc"]
    write_together({path: lambda partial: partial.write_text("old") for path in paths})

    def fail(partial):
        raise ValueError("c")

    with pytest.raises(ValueError, match="c"):
        write_together({path: lambda partial: partial.write_text("new") for path in paths[:2]} | {paths[2]: fail})
    assert [path.read_text() for path in sorted(tmp_path.iterdir())] == ["old"] * 3


def writers(text, names=("a.txt", "b.txt")):
    return {name: lambda path: path.write_text(text) for name in names}


def test_a_folder_appears_whole_and_other_files_in_it_stay(tmp_path):
    folder = tmp_path / "made" / "folder"
    write_folder(folder, writers("old"))
    (folder / "notes.txt").write_text("mine")
    (folder / "deep").mkdir()
    (folder / "deep" / "a.txt").write_text("mine, too")
    folder.chmod(0o750)
    write_folder(folder, writers("new"))
    assert {path.name: path.read_text() for path in folder.iterdir() if path.is_file()} == {
        "a.txt": "new", "b.txt": "new", "notes.txt": "mine",
    }  # fmt: skip
    assert (folder / "deep" / "a.txt").read_text() == "mine, too"
    assert folder.stat().st_mode & 0o777 == 0o750
    assert [path.name for path in folder.parent.iterdir()] == ["folder"]


def test_a_folder_that_cannot_be_finished_is_the_old_one(tmp_path):
    folder = tmp_path / "folder"
    write_folder(folder, writers("old"))

    def fail(path):
        path.write_text("half")
        raise OSError("disk full")

    with pytest.raises(OSError, match="disk full"):
        write_folder(folder, writers("new") | {"c.txt": fail})
    assert {path.name: path.read_text() for path in folder.iterdir()} == {"a.txt": "old", "b.txt": "old"}
    assert list(tmp_path.iterdir()) == [folder]


KILLED = """
import sys
from imugap.atomic import write_folder
writers = {f"{k}.txt": lambda path: path.write_text(text) for k in range(9)}
for text in 10_000 * ["one", "two"]:
    write_folder(sys.argv[1], writers)
"""


def test_a_folder_is_old_or_new_whenever_the_process_is_killed(tmp_path):
    folder, rng = tmp_path / "folder", stream(1, "killed")
    write_folder(folder, writers("one", [f"{k}.txt" for k in range(9)]))
    for _ in range(8):
        process = subprocess.Popen([sys.executable, "-c", KILLED, str(folder)])
        sleep(0.15 + rng.uniform(0, 0.1))
        process.kill()
        process.wait()
        texts = [path.read_text() for path in folder.iterdir()]
        assert len(texts) == 9
        assert len(set(texts)) == 1

"""Atomic writing of files and folders: completely or not at all, also if the process is killed.

A file is written under a temporary name in its folder, and renamed when it is complete. A folder is written under a
temporary name next to it, and both are exchanged in one step. A symbolic link stays, and its target is written. An
existing file keeps its mode. A pipe or a device gets the bytes when they are complete.
"""

import ctypes
import errno
import os
import shutil
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from secrets import token_hex
from stat import S_ISREG
from tempfile import TemporaryDirectory

AT_FDCWD, RENAME_EXCHANGE = -100, 2
"""Arguments of renameat2(2): paths from the working folder; exchange both paths."""
PARTIAL = ".partial"
"""Ending of temporary names."""


@contextmanager
def atomic(path: str | Path) -> Iterator[Path]:
    """Yield a temporary path to write to; put the file in the place of ``path`` if the block succeeds.

    Nothing is left behind if it fails. An OSError names ``path``.
    """
    path = Path(path)
    with _named(path), _streamed(path) if is_stream(path) else _renamed(Path(os.path.realpath(path))) as partial:
        yield partial


def is_stream(path: str | Path) -> bool:
    """Return whether a path is a pipe or a device, which takes bytes and is no file to replace."""
    path = Path(path)
    try:
        status = path.stat()
    except (FileNotFoundError, NotADirectoryError):
        return False
    return not (S_ISREG(status.st_mode) or path.is_dir()) or _standard_stream(path) is not None


def write_together(writers: Mapping[str | Path, Callable[[Path], object]]) -> None:
    """Write several files, or none if one of them fails; each writer gets a temporary path."""
    with ExitStack() as stack:
        for path, write in writers.items():
            write(stack.enter_context(atomic(path)))


def write_folder(
    folder: str | Path, writers: Mapping[str, Callable[[Path], object]], outdated: Iterable[str] = ()
) -> None:
    """Write the files of a folder, which appear in one step; other files in it stay, but those that are outdated.

    Parameters
    ----------
    folder
        Folder that may exist. It must not be a mount point or hold the working folder, because it is replaced.
    writers
        Name of each file to the function that writes it to a given path.
    outdated
        Names of files of an earlier output that are gone in the new one.
    """
    place = Path(os.path.realpath(folder))
    with _named(Path(folder)), _made(place.parent):
        staged = _temporary(place)
        staged.mkdir()
        try:
            for name, write in writers.items():
                write(staged / name)
            _put(staged, place, (*writers, *outdated))
        finally:
            shutil.rmtree(staged, ignore_errors=True)


def _temporary(place: Path) -> Path:
    """Return a new name in the folder of ``place``."""
    return place.with_name(f".imugap.{token_hex(8)}{PARTIAL}")


@contextmanager
def _named(path: Path) -> Iterator[None]:
    """Give an OSError of a temporary file, or of none, the name of the file to be written."""
    try:
        yield
    except OSError as error:
        if error.filename is not None and PARTIAL not in str(error.filename):
            raise
        reason = os.strerror(error.errno) if error.errno else str(error)  # without what a library adds
        raise OSError(error.errno or errno.EIO, reason, str(path)) from error


@contextmanager
def _renamed(target: Path) -> Iterator[Path]:
    if target.exists() and not os.access(target, os.W_OK):
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), str(target))
    with _made(target.parent):
        partial = _temporary(target)
        partial.open("xb").close()
        try:
            if target.exists():
                shutil.copymode(target, partial)
            yield partial
            partial.replace(target)
        finally:
            partial.unlink(missing_ok=True)


@contextmanager
def _streamed(path: Path) -> Iterator[Path]:
    with TemporaryDirectory() as folder:
        partial = Path(folder) / f"output{PARTIAL}"
        yield partial
        standard = _standard_stream(path)
        if standard is not None:
            standard.flush()  # what was printed before comes first
        with partial.open("rb") as source, open(path if standard is None else os.dup(standard.fileno()), "wb") as sink:  # noqa: PTH123
            shutil.copyfileobj(source, sink)


def _standard_stream(path: Path):
    """Return the standard output or error if ``path`` names it (``/dev/stdout``), else None."""
    for stream in (sys.stdout, sys.stderr):
        with suppress(OSError, ValueError, AttributeError):  # closed, or no file of the system
            if os.path.samestat(path.stat(), os.fstat(stream.fileno())):
                return stream
    return None


@contextmanager
def _made(folder: Path) -> Iterator[None]:
    """Make a folder and its parents; remove those that were missing if the block fails."""
    missing = [one for one in (folder, *folder.parents) if not one.exists()]
    folder.mkdir(parents=True, exist_ok=True)
    try:
        yield
    except BaseException:
        for one in missing:
            with suppress(OSError):  # somebody else has put something there
                one.rmdir()
        raise


def _put(staged: Path, place: Path, names: Iterable[str]) -> None:
    """Put a complete folder in its place; of a folder that is there, all but ``names`` stay."""
    if not place.exists():
        staged.rename(place)
        return

    def replaced(folder: str, found: list[str]) -> set[str]:
        return set(names) & set(found) if Path(folder) == place else set()

    shutil.copytree(place, staged, symlinks=True, ignore=replaced, copy_function=_linked, dirs_exist_ok=True)
    _exchange(staged, place)


def _linked(source: str, target: str) -> None:
    """Make a hard link to a file, or a copy where the file system has no links."""
    try:
        os.link(source, target, follow_symlinks=False)
    except OSError:
        shutil.copy2(source, target, follow_symlinks=False)


def _exchange(one: Path, other: Path) -> None:
    """Exchange two folders in one step, or in two where the system cannot."""
    rename = getattr(ctypes.CDLL(None, use_errno=True), "renameat2", None)
    if rename and rename(AT_FDCWD, os.fsencode(one), AT_FDCWD, os.fsencode(other), RENAME_EXCHANGE) == 0:
        return
    aside = one.with_name(f"{one.name}.old")
    other.rename(aside)
    one.rename(other)
    aside.rename(one)

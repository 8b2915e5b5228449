"""Provenance of a result: its inputs, settings, and the command that makes it again."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from os import PathLike, fspath
from pathlib import Path

from imugap.io.formats.source import sha256_of


@dataclass(frozen=True)
class InputFile:
    """Input of a result.

    Attributes
    ----------
    role
        What it is for, such as ``log`` or ``reference``.
    path
        Path as it was given, or the name of a table.
    sha256
        SHA-256 of the file, of all files of a folder, or of the samples of a table.
    recognised
        Sentences on what was recognised in it.
    """

    role: str
    path: str
    sha256: str
    recognised: tuple[str, ...] = ()

    @classmethod
    def of(cls, role: str, path: str | PathLike[str], recognised: tuple[str, ...] = ()) -> "InputFile":
        """Take the digest of a file that is no recording."""
        return cls(role, fspath(path), sha256_of(Path(path)), recognised)


@dataclass(frozen=True)
class Provenance:
    """Where a result comes from.

    Attributes
    ----------
    command
        Command line or call that makes it again.
    inputs
        Files that were read.
    settings
        Settings that differ from the default, by name.
    """

    command: str
    inputs: tuple[InputFile, ...]
    settings: Mapping[str, object] = field(default_factory=dict)

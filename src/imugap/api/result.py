"""What all results have in common: a verdict, a figure, a page, and a folder."""

from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from os import PathLike, fspath
from pathlib import Path
from typing import TYPE_CHECKING, Self, TypeAlias

from imugap.api.folder import write_folder
from imugap.pages.provenance import InputFile, Provenance

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from imugap.pages.page import Page

PAGE = "report.html"
"""Name of the page in the folder of a result."""
INPUTS = "inputs.json"
"""Name of the file with the inputs of a result: role, path, SHA-256, and what was recognised."""
SourcePath: TypeAlias = str | PathLike[str]


@dataclass(frozen=True, eq=False, kw_only=True)
class Result(ABC):
    """Result of an analysis.

    Attributes
    ----------
    provenance
        Inputs, settings, and the command line or call that makes the result again.
    """

    provenance: Provenance

    @property
    def inputs(self) -> tuple[InputFile, ...]:
        """Files that were read, with their SHA-256."""
        return self.provenance.inputs

    def made_by(self, command: str) -> Self:
        """Return the result with the command line that makes it again."""
        return replace(self, provenance=replace(self.provenance, command=command))

    @property
    @abstractmethod
    def verdict(self) -> str:
        """Answer in words, one sentence per line."""

    @abstractmethod
    def plot(self) -> "Figure":
        """Draw the figure that shows most of the result; ``plot().savefig(path)`` writes it."""

    @abstractmethod
    def files(self, kind: str = "svg") -> Mapping[str, object]:
        """Return the content of each file of the folder but page and inputs, by name; ``.svg`` is that of any figure.

        ``kind`` is the format of the figures to which a text refers.
        """

    @abstractmethod
    def _page(self) -> "Page":
        """Return the page."""

    def html(self) -> str:
        """Return the page as a complete HTML document, which needs no other file and no network."""
        from imugap.pages.render import document

        return document(self._page(), self.provenance)

    def report(self, folder: SourcePath, formats: Sequence[str] = ("svg",)) -> Path:
        """Write page, inputs, tables and figures into a folder, all or none; return the path of the page.

        Other files in the folder stay.

        Parameters
        ----------
        formats
            Formats of the figures, among ``svg``, ``png`` and ``pdf``; those of an earlier output in others are gone.
        """
        inputs = [asdict(one) for one in self.inputs]
        write_folder(folder, {**self.files(formats[0]), INPUTS: inputs, PAGE: self.html}, formats)
        return Path(folder) / PAGE

    def recognised(self, role: str) -> tuple[str, ...]:
        """Return what was recognised in the inputs of a role."""
        return tuple(sentence for one in self.inputs if one.role == role for sentence in one.recognised)

    def _repr_html_(self) -> str:
        from imugap.pages.render import fragment

        return fragment(self._page())

    def __str__(self) -> str:
        """Return the verdict."""
        return self.verdict

    def __repr__(self) -> str:
        """Return the first sentence of the verdict."""
        return f"<{type(self).__name__}: {self.verdict.splitlines()[0]}>"


def call(function: str, sources: Iterable[object], **given: object) -> str:
    """Return a call of a function of this package as text; what is None, empty or false is left out."""
    shown = [*map(_shown, sources), *(f"{name}={_shown(value)}" for name, value in given.items() if value)]
    return f"imugap.{function}({', '.join(shown)})"


def _shown(value: object) -> str:
    """Return a value as it is typed, or the name of its kind where it is a large one."""
    if isinstance(value, PathLike):
        return repr(fspath(value))
    return repr(value) if isinstance(value, str | int | float | tuple | list) else f"<{type(value).__name__}>"

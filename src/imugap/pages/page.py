"""Blocks of a page: what a page says, without how it looks."""

from dataclasses import dataclass, field

import pandas as pd
from matplotlib.figure import Figure


@dataclass(frozen=True)
class Text:
    """Paragraph."""

    text: str
    kind: str = field(default="text", init=False)


@dataclass(frozen=True)
class Points:
    """List of sentences."""

    items: tuple[str, ...]
    kind: str = field(default="points", init=False)


@dataclass(frozen=True)
class Snippet:
    """Text of a file or a command, to be copied."""

    text: str
    kind: str = field(default="snippet", init=False)


@dataclass(frozen=True)
class DataTable:
    """Table: titles of the columns, and the cells as text; the first cell of a row names it."""

    caption: str
    titles: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    kind: str = field(default="table", init=False)

    @classmethod
    def of(cls, caption: str, table: pd.DataFrame) -> "DataTable":
        """Take the cells of a table of text."""
        rows = tuple(tuple(map(str, row)) for row in table.to_numpy(object))
        return cls(caption, tuple(map(str, table.columns)), rows)


@dataclass(frozen=True, eq=False)
class Picture:
    """Figure with the sentence that explains it; ``alternative`` says in words what it shows."""

    figure: Figure
    sentence: str
    alternative: str


@dataclass(frozen=True, eq=False)
class Gallery:
    """Pictures side by side, as many as the screen has room for."""

    pictures: tuple[Picture, ...]
    kind: str = field(default="gallery", init=False)


@dataclass(frozen=True, eq=False)
class Fold:
    """Blocks that a reader opens; on paper they are open."""

    title: str
    blocks: tuple["Block", ...]
    kind: str = field(default="fold", init=False)


@dataclass(frozen=True, eq=False)
class Topic:
    """Blocks under a heading of their own within a part."""

    title: str
    blocks: tuple["Block", ...]
    kind: str = field(default="topic", init=False)


Block = Topic | Text | Points | Snippet | DataTable | Gallery | Fold


@dataclass(frozen=True, eq=False)
class Part:
    """Heading with blocks; a part without blocks is not shown."""

    title: str
    blocks: tuple[Block, ...]


@dataclass(frozen=True, eq=False)
class Page:
    """Page.

    Attributes
    ----------
    title
        Question that the page answers.
    verdict
        Answer in words.
    sound
        Whether nothing speaks against the input or the model.
    parts
        The rest, in the order of reading.
    """

    title: str
    verdict: tuple[str, ...]
    sound: bool
    parts: tuple[Part, ...]

"""Formats that are read and written, in the words of the readers themselves."""

from collections.abc import Iterable
from inspect import cleandoc
from types import ModuleType

from imugap.interchange.conventions import CONVENTIONS, Convention
from imugap.interchange.export import Target
from imugap.interchange.start_models.catalogue import READERS
from imugap.io.fixes import reading
from imugap.io.formats import catalogue
from imugap.site.markdown import code, plain, prose, table


def logs() -> str:
    """Return the formats of logs, in the order in which they are tried."""
    return _words(catalogue.FORMATS)


def fixes() -> str:
    """Return the formats of the fixes of a receiver."""
    return _words(reading.FORMATS)


def start_models() -> str:
    """Return the files of other tools that are taken for a start model, and what is read from them."""
    return "\n\n".join(_tool(one.tool, one.convention) for one in READERS) + "\n"


def targets() -> str:
    """Return the names of the targets of an export."""
    return table(("target",), ((code(one),) for one in Target)) + "\n"


def conventions() -> str:
    """Return what each tool takes for the noise of a sensor, and where that was read."""
    return "\n\n".join(_tool(one.tool, one) for one in CONVENTIONS) + "\n"


def _words(modules: Iterable[ModuleType]) -> str:
    return "\n".join(f"- {prose(cleandoc(one.__doc__ or ''))}" for one in modules) + "\n"


def _tool(name: str, convention: Convention) -> str:
    rows = [(code(one.name), code(one.unit), plain(one.meaning), code(one.formula)) for one in convention.parameters()]
    return "\n\n".join(
        (
            f"### {plain(name)}",
            table(("parameter", "unit", "meaning", "value"), rows),
            f"Read in: {plain(convention.source)}",
        )
    )

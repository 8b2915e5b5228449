"""Render pages as HTML: figures as SVG within it, style within it, nothing fetched.

Equal pages give equal bytes: no time stamp, no random identifier.
"""

import platform
import re
from collections.abc import Iterator
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from io import StringIO
from itertools import count

import matplotlib as mpl
from jinja2 import Environment, PackageLoader, StrictUndefined, Template
from markupsafe import Markup
from matplotlib.figure import Figure

from imugap import __version__
from imugap.pages.page import Page
from imugap.pages.provenance import Provenance

PACKAGES = ("numpy", "scipy", "pandas", "numba", "matplotlib")
"""Packages whose versions a result may depend on."""
TEMPLATE = "page.html"
CODE = re.compile("`([^`]+)`")
IDENTIFIER = re.compile(r'(\bid="|url\(#|href="#)')
"""What stands before an identifier in an SVG file."""


def document(page: Page, provenance: Provenance) -> str:
    """Return a page as a complete HTML document."""
    return _template().render(page=page, provenance=provenance, versions=_versions(), svg=_numbered(), whole=True)


def fragment(page: Page) -> str:
    """Return title, verdict and parts of a page as HTML to be shown within another page, such as a notebook."""
    return _template().render(page=page, provenance=None, versions={}, svg=_numbered(), whole=False)


@cache
def _template() -> Template:
    loader = PackageLoader("imugap.pages", "templates")
    environment = Environment(
        loader=loader,
        autoescape=True,
        finalize=_unbroken,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["coded"] = _coded
    return environment.get_template(TEMPLATE)


def _coded(value: str) -> Markup:
    """Show what stands between backticks as code."""
    return Markup(CODE.sub(r"<code>\1</code>", str(Markup.escape(_unbroken(value)))))


def _unbroken(value: object) -> object:
    """Keep a number and its percent sign in one line."""
    plain = isinstance(value, str) and not isinstance(value, Markup)
    return value.replace(" %", "\N{NO-BREAK SPACE}%") if plain else value


def _numbered():
    """Return a function that draws a figure as SVG; its identifiers differ from those of the figures before."""
    numbers: Iterator[int] = count(1)

    def svg(figure: Figure, alternative: str) -> Markup:
        return _svg(figure, alternative, f"f{next(numbers)}-")

    return svg


def _svg(figure: Figure, alternative: str, prefix: str) -> Markup:
    """Return a figure as an SVG element with text as text, and a title for readers who do not see it."""
    sink = StringIO()
    with mpl.rc_context({"svg.fonttype": "none"}):
        figure.savefig(sink, format="svg", metadata={"Date": None, "Creator": None})
    drawn = sink.getvalue()
    drawn = IDENTIFIER.sub(rf"\g<1>{prefix}", drawn[drawn.index("<svg") :])
    drawn = re.sub(r"<metadata>.*?</metadata>", "", drawn, flags=re.DOTALL)
    label = Markup.escape(alternative)
    return Markup(drawn.replace("<svg ", f'<svg role="img" aria-label="{label}" ', 1))


def _versions() -> dict[str, str]:
    """Return the versions of Python, of this package, and of those that a result may depend on."""
    found = {"imugap": __version__, "Python": platform.python_version()}
    for name in PACKAGES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:  # installed without its metadata
            continue
    return found

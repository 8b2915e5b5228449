"""Reference of the public names, from their docstrings."""

import inspect

import imugap

HEADING = "```{eval-rst}\n.. currentmodule:: imugap\n\n"


def page() -> str:
    """Return the directives that show the docstrings: functions, then results."""
    public = [(name, getattr(imugap, name)) for name in imugap.__all__ if not name.startswith("__")]
    functions = [name for name, one in public if inspect.isfunction(one)]
    classes = [name for name, one in public if inspect.isclass(one)]
    parts = ["## Functions", _directives("autofunction", functions), "## Results and values"]
    return "\n\n".join([*parts, _directives("autoclass", classes, ":members:", ":inherited-members: Exception")]) + "\n"


def _directives(kind: str, names: list[str], *options: str) -> str:
    blocks = ["\n   ".join([f".. {kind}:: {name}", *options]) for name in names]
    return HEADING + "\n\n".join(blocks) + "\n```"

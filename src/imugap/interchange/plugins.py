"""Plug-ins: add the effects that a module defines to the catalogue."""

import sys
from importlib import import_module
from inspect import getmembers, isclass
from pathlib import Path

from imugap.effects import CATALOGUE
from imugap.effects.effect import Effect, Role


def catalogue(module: str | None) -> dict[str, type[Effect]]:
    """Return the catalogue with the effects that ``module`` defines, by name.

    Parameters
    ----------
    module
        Dotted name of a module, installed or in the working directory; None for the catalogue alone. Its effects
        are the frozen dataclasses derived from :class:`imugap.effects.effect.Effect` that have a name and a role.
    """
    if module is None:
        return dict(CATALOGUE)
    kinds = {kind.name: kind for _, kind in getmembers(_imported(module), isclass) if _own(kind, module)}
    if not kinds:
        raise ValueError(
            f"effects: expected a module that defines an Effect with a name and a role; found none in {module}"
        )
    taken = sorted(set(kinds) & set(CATALOGUE))
    if taken:
        raise ValueError(f"effects: expected names that are not in the catalogue; found {', '.join(taken)} in {module}")
    return CATALOGUE | kinds


def _own(kind: type, module: str) -> bool:
    named = isinstance(getattr(kind, "name", None), str)
    return kind.__module__ == module and issubclass(kind, Effect) and kind.role is not Role.UNFITTED and named


def _imported(module: str):
    """Import a module, also from the working directory; any exception becomes a ValueError."""
    folder = str(Path.cwd())
    if folder not in sys.path:
        sys.path.append(folder)
    try:
        return import_module(module)
    except Exception as error:  # a user's module may raise any kind of exception
        cause = f"{type(error).__name__}: {error}".splitlines()[0]
        raise ValueError(f"effects: {module}: expected a module that can be imported; found {cause}") from error

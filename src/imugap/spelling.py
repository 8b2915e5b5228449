"""Misspelt names: the known name that was probably meant."""

from collections.abc import Iterable
from difflib import get_close_matches

CUTOFF, CUTOFF_SHORT = 0.65, 0.5
"""Least similarity of a name to the one that was meant, and that of a short name."""
SHORT = 3
"""Number of characters of a short name; a longer one may be the begin of the one that was meant."""


def nearest(name: str, known: Iterable[str]) -> str | None:
    """Return the known name that is nearest to a misspelt one, letters of both cases alike; None if none is near."""
    by_plain = {one.lower(): one for one in known}
    plain = name.lower()
    begun = [one for one in by_plain if len(plain) > SHORT and one.startswith(plain)]
    cutoff = CUTOFF if len(plain) > SHORT else CUTOFF_SHORT
    near = begun if len(begun) == 1 else get_close_matches(plain, by_plain, 1, cutoff)
    return by_plain[near[0]] if near else None


def hint(name: str, known: Iterable[str]) -> str:
    """Return the question whether the nearest known name was meant, with a blank before it; nothing if none is near."""
    near = nearest(name, known)
    return "" if near is None else f" (did you mean {near}?)"


def expected(name: str, known: Iterable[str]) -> str:
    """Return what is expected in the place of a name that is not known: the nearest one, or all."""
    known = list(known)
    return f"a known name{question}" if (question := hint(name, known)) else f"one of {', '.join(known)}"

"""Accelerations whose gravity is in columns of its own, as phones state them: their sum is the specific force."""

from collections.abc import Sequence
from dataclasses import replace

from imugap.io.formats.source import Source
from imugap.io.recognition.column_names import LETTERS, parts_of

GRAVITY = frozenset(["gravity", "grav"])
LESS = frozenset(["user", "linear", "lin"]), frozenset(["acceleration", "accel", "acc", "accelerometer"])
"""Words of accelerations less gravity: one of each."""


def with_gravity(source: Source) -> Source:
    """Return the columns of a source, and where it has accelerations and gravity apart alone, their sums as well."""
    parts = {k: parts_of(name) for k, name in enumerate(source.names)}
    gravity = _triad({k: one for k, one in parts.items() if GRAVITY & {*one[0]} and not (LESS[0] & {*one[0]})})
    less = _triad({k: one for k, one in parts.items() if all(words & {*one[0]} for words in LESS)})
    whole = [words for words, _ in parts.values() if LESS[1] & {*words} and not LESS[0] & {*words}]
    if gravity is None or less is None or any(LETTERS.keys() & {*words} for words in whole):
        return source
    count = len(source.names)
    unit = parts[less[0]][1]
    names = tuple(f"accel_{axis}{f' [{unit}]' if unit else ''}" for axis in LETTERS)
    terms = [(k,) for k in range(count)] + list(zip(less, gravity, strict=True))

    def batches(columns: Sequence[int]):
        needed = sorted({term for k in columns for term in terms[k]})
        for values in source.batches(needed):
            found = dict(zip(needed, values, strict=True))
            yield [found[terms[k][0]] if len(terms[k]) == 1 else sum(found[term] for term in terms[k]) for k in columns]

    def texts(column: int):
        return source.texts(column) if column < count else (values.astype(str) for (values,) in batches([column]))

    notes = (*source.notes, f"accel {source.names[less[0]]} + {source.names[gravity[0]]} and so on")
    return replace(source, names=(*source.names, *names), batches=batches, cells=texts, notes=notes)


def _triad(parts: dict[int, tuple[list[str], str | None]]) -> list[int] | None:
    """Return the places of the x, y and z axes; None where one is missing, or there are several."""
    places = [[k for k, (words, _) in parts.items() if axis in words] for axis in LETTERS]
    return [one[0] for one in places] if all(len(one) == 1 for one in places) else None

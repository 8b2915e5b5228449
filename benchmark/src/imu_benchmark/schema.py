"""Check plain data against the JSON schemas of this package (folder ``schemas``), with faults stated in one line.

The schemas use the keywords of :data:`CHECKS`, ``$ref`` to their own ``$defs``, and annotations.
"""

import json
from collections.abc import Callable, Iterator, Mapping
from importlib.resources import files
from math import isfinite
from pathlib import Path
from typing import Any

ANNOTATIONS = {"$schema", "$id", "$defs", "title", "description"}
KINDS: dict[str, Callable[[Any], bool]] = {
    "object": lambda value: isinstance(value, dict),
    "array": lambda value: isinstance(value, list),
    "string": lambda value: isinstance(value, str),
    "number": lambda value: isinstance(value, int | float) and not isinstance(value, bool),
    "integer": lambda value: isinstance(value, int) and not isinstance(value, bool),
    "boolean": lambda value: isinstance(value, bool),
    "null": lambda value: value is None,
}
"""Types of JSON Schema. A whole number written with a point is no integer here."""
LONGEST = 60
"""Most characters of a value that a message shows."""


class FormatError(ValueError):
    """Data that are not what they should be: source, place, expected and found, in one line."""

    def __init__(self, source: object, place: str, expected: str, found: object) -> None:
        """Compose the message."""
        where = f"{source}: {place}" if place else str(source)
        super().__init__(f"{where}: expected {expected}; found {found}".replace("\n", " "))


def load(name: str) -> dict:
    """Return the schema ``name`` of this package."""
    return json.loads(files("imu_benchmark").joinpath(f"schemas/{name}.schema.json").read_text())


def read_json(path: str | Path) -> Any:
    """Read a file of JSON whose numbers are finite."""
    try:
        return json.loads(Path(path).read_text(encoding="utf-8"), parse_float=_finite, parse_constant=_finite)
    except (FileNotFoundError, NotADirectoryError):
        raise FormatError(path, "", "a file", "none") from None
    except (ValueError, RecursionError, OSError) as error:
        raise FormatError(path, "", "JSON with finite numbers", str(error)) from None


def check(value: Any, schema: Mapping, source: object) -> None:
    """Raise a :class:`FormatError` at the first place where ``value`` breaks the schema."""
    for place, expected, found in _faults(value, schema, schema, ""):
        raise FormatError(source, place, expected, found)


def _finite(text: str) -> float:
    number = float(text)
    if not isfinite(number):
        raise ValueError(f"the number {text}")
    return number


def _faults(value: Any, schema: Mapping, root: Mapping, place: str) -> Iterator[tuple[str, str, str]]:
    """Yield place, expected and found of every fault."""
    if "$ref" in schema:
        yield from _faults(value, root["$defs"][schema["$ref"].removeprefix("#/$defs/")], root, place)
        return
    kinds = schema.get("type", list(KINDS))
    kinds = [kinds] if isinstance(kinds, str) else kinds
    if not any(KINDS[kind](value) for kind in kinds):
        yield place, f"a value of type {' or '.join(kinds)}", _shown(value)
        return
    for keyword, bound in schema.items():
        if keyword in CHECKS:
            fault = CHECKS[keyword](value, bound)
            if fault:
                yield place, fault, _shown(value)
        elif keyword not in ANNOTATIONS | PARTS:
            raise KeyError(f"schema: expected the keywords of this module; found {keyword}")
    for name, part, inner in _parts(value, schema):
        if inner is False:
            yield place, f"the keys {', '.join(schema['properties'])}", repr(name)
        elif isinstance(inner, Mapping):
            yield from _faults(part, inner, root, f"{place}[{name}]" if isinstance(name, int) else f"{place}.{name}")


def _parts(value: Any, schema: Mapping) -> Iterator[tuple[str | int, Any, Mapping | bool]]:
    """Yield name or number, value and schema of the parts of an object or a list."""
    if isinstance(value, dict):
        known = schema.get("properties", {})
        for name, part in value.items():
            yield name, part, known.get(name, schema.get("additionalProperties", True))
    if isinstance(value, list):
        yield from ((number, part, schema.get("items", True)) for number, part in enumerate(value))


def _shown(value: Any) -> str:
    if isinstance(value, list):
        return f"a list of {len(value)}"
    if isinstance(value, dict):
        return f"an object with {', '.join(map(repr, value))[:LONGEST] or 'no key'}"
    return repr(value)[:LONGEST]


def _number(value: Any) -> bool:
    return KINDS["number"](value)


PARTS = {"type", "properties", "additionalProperties", "items"}
CHECKS: dict[str, Callable[[Any, Any], str | None]] = {
    "enum": lambda value, some: None if value in some else f"one of {', '.join(map(str, some))}",
    "required": lambda value, keys: _missing(value, keys),
    "minimum": lambda value, low: f"{low} or more" if _number(value) and value < low else None,
    "maximum": lambda value, high: f"{high} or less" if _number(value) and value > high else None,
    "exclusiveMinimum": lambda value, low: f"more than {low}" if _number(value) and value <= low else None,
    "minItems": lambda value, low: f"{low} or more items" if isinstance(value, list) and len(value) < low else None,
    "maxItems": lambda value, high: f"{high} or fewer items" if isinstance(value, list) and len(value) > high else None,
    "minLength": lambda value, low: (
        f"{low} or more characters" if isinstance(value, str) and len(value) < low else None
    ),
    "minProperties": lambda value, low: f"{low} or more keys" if isinstance(value, dict) and len(value) < low else None,
}
"""Checks of the keywords: what was expected instead of the value, or None."""


def _missing(value: Any, keys: list[str]) -> str | None:
    missing = [key for key in keys if isinstance(value, dict) and key not in value]
    return f"the key {missing[0]}" if missing else None

"""Reader of YAML files of a user: strict, bounded, and with the line of every fault.

Mappings with text keys, lists, text, decimal numbers, true, false and null are read, and aliases of complete values.
What YAML 1.1 reads as something else than it looks like is refused: ``0100`` (64), ``1:30`` (90), ``yes`` (true), a key
that is given twice. Size, depth and number of values are bounded, aliases counted by what they stand for.
"""

import math
import re
from collections.abc import Iterator
from pathlib import Path

import yaml

MAX_BYTES, MAX_DEPTH, MAX_VALUES, MAX_DIGITS = 1_000_000, 20, 50_000, 300
EXCERPT = 40
"""Largest number of characters of a value in a message."""
DECIMAL = re.compile(r"[-+]?(0|[1-9][0-9]*)")
FRACTIONAL = re.compile(r"[-+]?((0|[1-9][0-9]*)([.][0-9]*)?|[.][0-9]+)([eE][-+]?[0-9]+)?")
AMBIGUOUS = re.compile(
    r"[-+]?[0-9][0-9_]*([.][0-9_]*)?([eE][-+]?[0-9]+)?|0[xXbBoO][0-9a-fA-F_]+|[-+]?[0-9]+(:[0-9]+)+([.][0-9]*)?"
    r"|[-+]?[.](inf|Inf|INF)|[.](nan|NaN|NAN)|yes|Yes|YES|no|No|NO|on|On|ON|off|Off|OFF|<<"
)
"""What YAML 1.1, or a part of its readers, takes for a number or a truth value that it does not look like."""
WORDS = {"": None, "~": None, "null": None, "Null": None, "NULL": None}
WORDS |= {"true": True, "True": True, "TRUE": True, "false": False, "False": False, "FALSE": False}
LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


class StrictYamlError(ValueError):
    """YAML that is not read; the message has source, line, column, expected and found."""


def read(path: str | Path):
    """Return the value of a file, None for an empty one; raise a StrictYamlError with the place of a fault."""
    with Path(path).open("rb") as file:
        content = file.read(MAX_BYTES + 1)
    if len(content) > MAX_BYTES:
        raise StrictYamlError(f"{path}: file: expected at most {MAX_BYTES} bytes; found more")
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        raise StrictYamlError(
            f"{path}: line {line}: expected UTF-8; found the byte {content[error.start]:#x}"
        ) from None
    return parse(text, path)


def parse(text: str, source: str | Path):
    """Return the value of a text (:func:`read`); ``source`` names it in messages."""
    try:
        return _Builder(yaml.parse(text, Loader=LOADER), source).document()
    except yaml.YAMLError as error:
        raise StrictYamlError(f"{source}: {_syntax(error)}") from None


def number_in(text: str) -> int | float | None:
    """Return the decimal number that a text is, or None."""
    if DECIMAL.fullmatch(text) and len(text) <= MAX_DIGITS:
        return int(text)
    return float(text) if FRACTIONAL.fullmatch(text) else None


def excerpt(value: object) -> str:
    """Return a value for a message: a mapping or list by its kind, text in quotes and cut short."""
    if isinstance(value, dict | list):
        return f"a {'mapping' if isinstance(value, dict) else 'list'} of {len(value)}"
    if value is None or isinstance(value, bool):
        return {None: "null", True: "true", False: "false"}[value]
    shown = repr(value)
    return shown if len(shown) <= EXCERPT else f"{shown[:EXCERPT]}... ({len(shown)} characters)"


class _Builder:
    """Builder of values from the events of a parser, without recursion deeper than the largest depth."""

    def __init__(self, events: Iterator[yaml.Event], source: str | Path) -> None:
        self.events, self.source = events, source
        self.anchors: dict[str, tuple[object, int]] = {}

    def document(self) -> object:
        next(self.events)  # start of the stream
        if isinstance(next(self.events), yaml.StreamEndEvent):
            return None
        found, _ = self.value(next(self.events), 1)
        next(self.events)  # end of the document
        if not isinstance(event := next(self.events), yaml.StreamEndEvent):
            raise self.fault(event, "one document", "another one")
        return found

    def value(self, event: yaml.Event, depth: int) -> tuple[object, int]:
        """Return the value that begins with an event, and the number of values that it holds."""
        if depth > MAX_DEPTH:
            raise self.fault(event, f"at most {MAX_DEPTH} values within one another", "more")
        if isinstance(event, yaml.AliasEvent):
            found = self.anchors.get(event.anchor)
            if found is None:
                raise self.fault(event, "an alias of a complete value above", f"*{event.anchor}")
        else:
            tag = event.tag
            if tag is not None and (tag != "!" or not isinstance(event, yaml.ScalarEvent)):
                raise self.fault(event, "a value without a tag", tag[:EXCERPT])
            if isinstance(event, yaml.ScalarEvent):
                found = self.scalar(event), 1
            elif isinstance(event, yaml.SequenceStartEvent):
                found = self.sequence(depth)
            else:
                found = self.mapping(depth)
            if event.anchor:
                self.anchors[event.anchor] = found
        return found

    def sequence(self, depth: int) -> tuple[list, int]:
        values, count = [], 1
        while not isinstance(event := next(self.events), yaml.SequenceEndEvent):
            value, held = self.value(event, depth + 1)
            values.append(value)
            count = self.bounded(event, count + held)
        return values, count

    def mapping(self, depth: int) -> tuple[dict, int]:
        values, count = {}, 1
        while not isinstance(event := next(self.events), yaml.MappingEndEvent):
            key = self.value(event, depth + 1)[0]
            if not isinstance(key, str):
                raise self.fault(event, "text as a key", excerpt(key))
            if key in values:
                raise self.fault(event, "every key once", f"{excerpt(key)} again")
            values[key], held = self.value(next(self.events), depth + 1)
            count = self.bounded(event, count + held)
        return values, count

    def scalar(self, event: yaml.ScalarEvent) -> object:
        text = event.value
        if event.style or event.tag == "!":
            return text
        if text in WORDS:
            return WORDS[text]
        number = number_in(text)
        if number is None and not AMBIGUOUS.fullmatch(text):
            return text
        if number is None:
            raise self.fault(event, "a decimal number, true, false, or text in quotes", excerpt(text))
        if not math.isfinite(number):
            raise self.fault(event, "a finite number", excerpt(text))
        return number

    def bounded(self, event: yaml.Event, count: int) -> int:
        if count > MAX_VALUES:
            raise self.fault(event, f"at most {MAX_VALUES} values", "more, aliases counted by what they stand for")
        return count

    def fault(self, event: yaml.Event, expected: str, found: str) -> StrictYamlError:
        mark = event.start_mark
        place = f"line {mark.line + 1}, column {mark.column + 1}"
        return StrictYamlError(f"{self.source}: {place}: expected {expected}; found {found}")


def _syntax(error: yaml.YAMLError) -> str:
    """Return place, expected and found of an error of the parser."""
    mark = getattr(error, "problem_mark", None)
    place = (
        f"line {mark.line + 1}, column {mark.column + 1}" if mark else f"character {getattr(error, 'position', '?')}"
    )
    problem = " ".join(str(getattr(error, "problem", None) or getattr(error, "reason", error)).split())
    return f"{place}: expected YAML; found a fault: {problem[: 4 * EXCERPT]}"

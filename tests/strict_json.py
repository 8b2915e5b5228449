"""Read JSON as its standard has it: with neither NaN nor Infinity."""

import json
from pathlib import Path


def refuse(constant):
    raise AssertionError(f"{constant} is no JSON")


def loads(text):
    """Return the content of a text."""
    return json.loads(text, parse_constant=refuse)


def load(path):
    """Return the content of a file."""
    return loads(Path(path).read_text())

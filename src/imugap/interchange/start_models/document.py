"""Content of a file of a simulator or filter, before it is known which: XML, a mapping (YAML, JSON), or Python."""

import ast
import json
import operator
from collections.abc import Mapping
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np

from imugap.io import strict_yaml

OPERATORS = {
    ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.Div: operator.truediv,
    ast.USub: operator.neg, ast.UAdd: operator.pos,
}  # fmt: skip
"""Arithmetic of the values of a dictionary in Python."""
CONSTANTS = {"pi": np.pi, "inf": np.inf}
DEEPEST = 50
"""Largest depth of an expression."""
VALUE_KINDS = int | float | str | bool

Document = ElementTree.Element | Mapping[str, Any] | tuple[dict[str, Any], ...]
"""Root of an XML file; mapping of a YAML or JSON file; dictionaries of a Python file."""


def read(path: str | Path) -> Document | None:
    """Return the content of a file; None for an empty one. ValueError with the place of a fault."""
    with Path(path).open("rb") as file:
        content = file.read(strict_yaml.MAX_BYTES + 1)
    if len(content) > strict_yaml.MAX_BYTES:
        raise ValueError(f"{path}: file: expected at most {strict_yaml.MAX_BYTES} bytes; found more")
    head = content.lstrip(b"\xef\xbb\xbf \t\r\n")
    if head.startswith(b"<"):
        return _xml(content, path)
    if head.startswith(b"{"):
        return _json(content, path)
    if Path(path).suffix == ".py":
        return _python(content, path)
    if head.startswith(b"%YAML:1.0"):  # header of OpenCV, which is none of YAML
        return strict_yaml.parse(content.decode("utf-8-sig", errors="replace").split("\n", 1)[-1], path)
    return strict_yaml.read(path)


def _xml(content: bytes, path: str | Path) -> ElementTree.Element:
    if b"<!DOCTYPE" in content:
        raise ValueError(f"{path}: expected XML without a document type; found one")
    try:
        return ElementTree.fromstring(content)
    except ElementTree.ParseError as error:
        line, column = error.position
        raise ValueError(f"{path}: line {line}, column {column + 1}: expected XML; found a fault: {error}") from None


def _json(content: bytes, path: str | Path) -> Document:
    try:
        return json.loads(content.decode("utf-8-sig"))
    except (ValueError, RecursionError):
        return strict_yaml.read(path)  # a mapping of YAML in braces, or the place of the fault


def _python(content: bytes, path: str | Path) -> tuple[dict[str, Any], ...]:
    """Return all dictionaries with text keys, and the named arguments of all calls.

    Values that are no numbers, texts, lists or arithmetic are None.
    """
    try:
        tree = ast.parse(content)
    except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
        line = getattr(error, "lineno", None) or 1
        raise ValueError(f"{path}: line {line}: expected Python; found a fault: {error}") from None
    nodes = [node for node in ast.walk(tree) if isinstance(node, ast.Dict | ast.Call)]
    every = (_dictionary(node, DEEPEST) if isinstance(node, ast.Dict) else _arguments(node) for node in nodes)
    return tuple(one for one in every if one)


def _arguments(node: ast.Call) -> dict[str, Any]:
    return {one.arg: _value(one.value, DEEPEST - 1) for one in node.keywords if one.arg is not None}


def _dictionary(node: ast.Dict, depth: int) -> dict[str, Any]:
    found = {}
    for key, value in zip(node.keys, node.values, strict=True):
        if isinstance(key, ast.Constant) and isinstance(key.value, str):
            found[key.value] = _value(value, depth - 1)
    return found


def _value(node: ast.expr, depth: int) -> Any:
    """Return the value of an expression: numbers, texts, lists, dictionaries, arithmetic, ``np.array``; else None."""
    if depth <= 0:
        return None
    inner = depth - 1
    match node:
        case ast.Constant(value=value):
            return value if isinstance(value, VALUE_KINDS) else None
        case ast.Name(id=name) | ast.Attribute(attr=name):
            return CONSTANTS.get(name)
        case ast.List(elts=elements) | ast.Tuple(elts=elements):
            return [_value(one, inner) for one in elements]
        case ast.Dict():
            return _dictionary(node, inner)
        case ast.UnaryOp(op=op, operand=operand):
            return _computed(op, _value(operand, inner))
        case ast.BinOp(left=left, op=op, right=right):
            return _computed(op, _value(left, inner), _value(right, inner))
        case ast.Call(func=ast.Attribute(attr="array") | ast.Name(id="array"), args=[ast.List() as values]):
            return np.array(_value(values, inner), object)
        case ast.Call(func=ast.Name(id="float"), args=[ast.Constant(value="inf")]):
            return np.inf
    return None


def _computed(op: ast.operator | ast.unaryop, *values: Any) -> Any:
    try:
        return OPERATORS[type(op)](*values)
    except (KeyError, TypeError, ValueError, ArithmeticError):
        return None

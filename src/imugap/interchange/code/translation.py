"""Translation of the steps of effects (:mod:`imugap.effects.block`) to methods in Python and C++."""

import ast
import inspect
import textwrap
from collections.abc import Callable, Mapping

from imugap.effects.block import CONSTANTS, FUNCTIONS, Value

KNOWN = {function.__name__ for function in FUNCTIONS} | {"rint", "fabs", "len", "range"}
"""Functions that a step may call."""
OPERATORS = {
    ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/", ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=",
    ast.Eq: "==", ast.NotEq: "!=", ast.And: "&&", ast.Or: "||", ast.Not: "!", ast.USub: "-",
}  # fmt: skip
"""Operators of a step, in C++."""
INDENT = "  "


def to_python(function: Callable) -> str:
    """Return the statements of a step as those of a method, ``own`` being ``self``."""
    tree = _parsed(function)
    for node in ast.walk(tree):
        if isinstance(node, ast.Name) and node.id == "own":
            node.id = "self"
    return "\n".join(ast.unparse(statement) for statement in tree.body)


def to_cpp(function: Callable, values: Mapping[str, Value]) -> str:
    """Return the statements of a step as those of a member function; ``values`` are those of its block."""
    whole = {name for name, value in values.items() if isinstance(value, int)}
    return "\n".join(_Cpp(whole).statements(_parsed(function).body))


def draws(function: Callable) -> bool:
    """Return whether a step draws random numbers."""
    return any(isinstance(node, ast.Attribute) and node.attr == "draw" for node in ast.walk(_parsed(function)))


def _parsed(function: Callable) -> ast.FunctionDef:
    """Return the tree of a step; ValueError where a name is none of the subset."""
    tree = ast.parse(textwrap.dedent(inspect.getsource(function))).body[0]
    tree.body = [one for one in tree.body if not (isinstance(one, ast.Expr) and isinstance(one.value, ast.Constant))]
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id not in KNOWN:
            raise ValueError(
                f"{function.__module__}: expected a call of {', '.join(sorted(KNOWN))}; found {node.func.id}"
            )
    return tree


class _Cpp:
    """Translator of one function; ``whole`` are the values and variables that are whole numbers."""

    def __init__(self, whole: set[str]) -> None:
        self.whole, self.declared = set(whole), {"x"}

    def statements(self, body: list[ast.stmt]) -> list[str]:
        """Return the lines of statements; variables that they declare end with them."""
        outer = set(self.declared)
        lines = [line for statement in body for line in self._statement(statement)]
        self.declared = outer
        return lines

    def _statement(self, node: ast.stmt) -> list[str]:
        match node:
            case ast.Assign(targets=[ast.Name(id=name)], value=value) if name not in self.declared:
                self.declared.add(name)
                return [f"{'int' if self._is_whole(value) else 'double'} {name} = {self._text(value)};"]
            case ast.Assign(targets=[target], value=value):
                return [f"{self._text(target)} = {self._text(value)};"]
            case ast.If(test=test, body=body, orelse=orelse):
                lines = [f"if ({self._text(test)}) {{", *self._inner(body)]
                return [*lines, "} else {", *self._inner(orelse), "}"] if orelse else [*lines, "}"]
            case ast.For(target=ast.Name(id=name), iter=ast.Call(args=arguments), body=body):
                self.whole.add(name)
                first, last, step = (
                    (["0"] if len(arguments) == 1 else [])
                    + [self._text(one) for one in arguments]
                    + (["1"] if len(arguments) < 3 else [])
                )
                sign = ">" if step.startswith("-") else "<"
                move = f"--{name}" if sign == ">" else f"++{name}"
                return [f"for (int {name} = {first}; {name} {sign} {last}; {move}) {{", *self._inner(body), "}"]
            case ast.Return(value=value):
                return [f"return {self._text(value)};"]
        raise ValueError(f"line {node.lineno}: expected a statement of the subset; found {ast.unparse(node)!r}")

    def _inner(self, body: list[ast.stmt]) -> list[str]:
        return [INDENT + line for line in self.statements(body)]

    def _is_whole(self, node: ast.expr) -> bool:
        match node:
            case ast.Constant(value=value):
                return isinstance(value, int)
            case ast.Name(id=name) | ast.Attribute(attr=name):
                return name in self.whole
            case ast.BinOp(left=left, right=right):
                return self._is_whole(left) and self._is_whole(right)
        return False

    def _text(self, node: ast.expr) -> str:
        match node:
            case ast.Constant(value=value):
                return repr(value)
            case ast.Name(id=name):
                return CPP_CONSTANTS.get(name, name)
            case ast.Attribute(value=ast.Name(id="own"), attr=name):
                return f"this->{name}"
            case ast.Attribute(value=value, attr=name):
                return f"{self._text(value)}.{name}"
            case ast.Subscript(value=value, slice=index):
                return f"{self._text(value)}[{self._text(index)}]"
            case ast.BinOp(left=left, op=op, right=right):
                return f"({self._text(left)} {OPERATORS[type(op)]} {self._text(right)})"
            case ast.UnaryOp(op=op, operand=operand):
                return f"{OPERATORS[type(op)]}{self._text(operand)}"
            case ast.BoolOp(op=op, values=values):
                return f"({f' {OPERATORS[type(op)]} '.join(map(self._text, values))})"
            case ast.Compare(left=left, ops=[op], comparators=[right]):
                return f"{self._text(left)} {OPERATORS[type(op)]} {self._text(right)}"
            case ast.IfExp(test=test, body=body, orelse=orelse):
                return f"({self._text(test)} ? {self._text(body)} : {self._text(orelse)})"
            case ast.Call(func=ast.Name(id="len"), args=[value]):
                return f"static_cast<int>({self._text(value)}.size())"
            case ast.Call(func=ast.Name(id=name), args=arguments):
                return f"std::{name}({', '.join(map(self._text, arguments))})"
            case ast.Call(func=function, args=arguments):
                return f"{self._text(function)}({', '.join(map(self._text, arguments))})"
        raise ValueError(f"line {node.lineno}: expected an expression of the subset; found {ast.unparse(node)!r}")


CPP_CONSTANTS = {
    name: f"std::numeric_limits<double>::{'infinity' if name == 'inf' else 'quiet_NaN'}()" for name in CONSTANTS
}
"""Values that a step may name, in C++."""

"""Show what an effect of an error model is: formula and source, parameters with their units, a picture.

Stages: find the effect; give its parameters example values, or those of the command line; describe it; draw it.
"""

import argparse
import re
from collections.abc import Sequence
from dataclasses import MISSING, fields
from inspect import getdoc
from math import inf

from imugap import spelling
from imugap.atomic import atomic
from imugap.commands.arguments import add_effects, add_examples
from imugap.commands.outputs import format_of, require_files
from imugap.commands.shown import number, table_text
from imugap.effects import CATALOGUE
from imugap.effects.effect import TINY, Effect, Stage, StochasticEffect
from imugap.interchange.plugins import catalogue
from imugap.io.strict_yaml import number_in
from imugap.log import ACCEL, AXES, GYRO, TIME
from imugap.workflow.products import write_figure

UNITS = {GYRO: "rad/s", ACCEL: "m/s^2"}
"""Unit of the axes of each triad."""
EXAMPLES = {"s": 10.0, "Hz": 2.0, "1/s": 0.3, "degC": 25.0, "rad": 0.3, "1": 0.02}
"""Example value of a parameter by its unit; 1 in any other."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    add_examples(
        parser,
        "imugap effects",
        "imugap effects gauss_markov",
        "imugap effects gauss_markov std=0.01 correlation_time=5 --out gauss_markov.svg",
    )
    parser.description = (
        "Show the effects that an error model may have; of one its formula and source, its parameters with their "
        "units, a line for a model, and a picture."
    )
    parser.add_argument("name", nargs="?", help="effect (default: all)").completer = lambda **_: list(CATALOGUE)
    parser.add_argument("values", nargs="*", metavar="NAME=VALUE", help="parameters of the picture, in SI units")
    add_effects(parser)
    parser.add_argument("--out", help="file for the picture (.svg, .png, .pdf)")


def run(options: argparse.Namespace) -> None:
    """Print the effects, or what one of them is, and draw it into ``--out``."""
    kinds = catalogue(options.effects)
    if options.name is None:
        print(table_text(["effect", "what it is"], [[name, _summary(kind)] for name, kind in kinds.items()]))
        return
    if options.name not in kinds:
        raise ValueError(f"effect: expected {spelling.expected(options.name, kinds)}; found {options.name!r}")
    effect = example(kinds[options.name], options.values)
    if options.out:
        _draw(effect, options.out)
    print(describe(effect))


def example(kind: type[Effect], values: Sequence[str] = ()) -> Effect:
    """Return an effect with values given as ``name=value``, and with example values for all other parameters."""
    found = {}
    for item in fields(kind):
        unit, low, high = (item.metadata[key] for key in ("unit", "low", "high"))
        usual = EXAMPLES.get(unit, 1.0) if item.default is MISSING else item.default
        found[item.name] = min(max(usual, low), high)
    for text in values:
        name, _, value = text.partition("=")
        if name not in found:
            raise ValueError(f"{kind.name}: parameter: expected {spelling.expected(name, found)}; found {name!r}")
        if number_in(value) is None:
            raise ValueError(f"{kind.name}: {name}: expected a number; found {value!r}")
        found[name] = float(number_in(value))
    return kind(**found)


def axis_of(effect: Effect) -> str:
    """Return the first axis on which an effect has a place, or the pseudo-axis of the clock."""
    return next((axis for axis in AXES if _has_place(effect, axis)), TIME)


def describe(effect: Effect) -> str:
    """Return what an effect is, as text: its formula, its parameters, and a line for an error model."""
    kind, axis = type(effect), axis_of(effect)
    units = [kind.units(unit) for triad, unit in UNITS.items() if axis not in AXES or _has_place(effect, triad[0])]
    rows = []
    for item in fields(kind):
        shown = " or ".join(dict.fromkeys(found[item.name] for found in units))
        rows.append([item.name, _plain(item.metadata["meaning"]), shown, _limits(*kind.limits()[item.name])])
    values = ", ".join(f"{name}: {number(value)}" for name, value in effect.parameters().items())
    parts = [
        f"{kind.name}: {_plain(getdoc(kind) or '')}",
        *(f"{title}: {text}" for title, text in _formulas(kind)),
        "",
        table_text(["parameter", "meaning", "unit", "limits"], rows),
        "",
        "in a model:",
        f"  {axis}: [{{{kind.name}: {{{values}}}}}]",
    ]
    return "\n".join(parts)


def _limits(low: float, high: float) -> str:
    if high < inf:
        return f"{low:g} .. {high:g}"
    return "any" if low == -inf else "> 0" if low == TINY else f">= {low:g}"


def _summary(kind: type[Effect]) -> str:
    return _plain(getdoc(kind) or "").partition("\n")[0]


def _formulas(kind: type[Effect]) -> list[tuple[str, str]]:
    """Return the spectrum and the Allan variance of a random effect in the words of its methods."""
    if not issubclass(kind, StochasticEffect):
        return []
    methods = {"spectrum": kind.psd, "Allan variance": kind.allan_variance}
    return [
        (title, _plain((getdoc(method) or "").removeprefix("Return ")).partition("\n")[0])
        for title, method in methods.items()
    ]


def _plain(text: str) -> str:
    """Return a docstring without its marks for other names."""
    return re.sub(r":\w+:`~?([^`]*)`|``([^`]*)``", lambda found: found[1] or found[2], text)


def _has_place(effect: Effect, axis: str) -> bool:
    try:
        effect.check_axis(axis)
    except ValueError:
        return False
    return True


def _draw(effect: Effect, out: str) -> None:
    kind = format_of(out)
    require_files({"--out": out}, [])
    if effect.stage is Stage.STANCE:
        raise ValueError(f"{effect.name}: expected an effect that acts on a log; found one of the stance of a foot")
    from imugap.figures import effects  # figures take longer to import than the rest

    figure = effects.picture(effect, axis_of(effect))
    with atomic(out) as partial:
        write_figure(figure, partial, kind)

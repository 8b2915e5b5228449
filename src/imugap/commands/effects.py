"""Show what an effect of an error model is: formula and source, parameters with their units, a picture.

Stages: find the effect; give its parameters example values, or those of the command line; describe it; draw it.
"""

import argparse
from collections.abc import Sequence
from dataclasses import fields
from math import inf

from imugap import spelling
from imugap.analysis.effect_description import EffectDescription, axis_of, example, summary
from imugap.atomic import atomic
from imugap.commands.arguments import add_effects, add_examples
from imugap.commands.outputs import format_of, require_files
from imugap.effects import CATALOGUE
from imugap.effects.effect import TINY, Effect, Stage
from imugap.interchange.plugins import catalogue
from imugap.io.strict_yaml import number_in
from imugap.pages.shown import number, table_text
from imugap.workflow.products import write_figure


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
        print(table_text(["effect", "what it is"], [[name, summary(kind)] for name, kind in kinds.items()]))
        return
    if options.name not in kinds:
        raise ValueError(f"effect: expected {spelling.expected(options.name, kinds)}; found {options.name!r}")
    effect = given_effect(kinds[options.name], options.values)
    if options.out:
        _draw(effect, options.out)
    print(describe(effect))


def given_effect(kind: type[Effect], values: Sequence[str] = ()) -> Effect:
    """Return an effect with values given as ``name=value``, and with example values for all other parameters."""
    names, found = [item.name for item in fields(kind)], {}
    for text in values:
        name, _, value = text.partition("=")
        if name not in names:
            raise ValueError(f"{kind.name}: parameter: expected {spelling.expected(name, names)}; found {name!r}")
        if number_in(value) is None:
            raise ValueError(f"{kind.name}: {name}: expected a number; found {value!r}")
        found[name] = float(number_in(value))
    return example(kind, found)


def describe(effect: Effect) -> str:
    """Return what an effect is, as text: its formula, its parameters, and a line for an error model."""
    of = EffectDescription.of(effect)
    rows = [[one.name, one.meaning, " or ".join(one.units), _limits(one.low, one.high)] for one in of.parameters]
    values = ", ".join(f"{name}: {number(value)}" for name, value in effect.parameters().items())
    parts = [
        f"{of.name}: {of.text}",
        *(f"{title}: {text}" for title, text in of.formulas.items()),
        "",
        table_text(["parameter", "meaning", "unit", "limits"], rows),
        "",
        "in a model:",
        f"  {axis_of(effect)}: [{{{of.name}: {{{values}}}}}]",
    ]
    return "\n".join(parts)


def _limits(low: float, high: float) -> str:
    if high < inf:
        return f"{low:g} .. {high:g}"
    return "any" if low == -inf else "> 0" if low == TINY else f">= {low:g}"


def _draw(effect: Effect, out: str) -> None:
    kind = format_of(out)
    require_files({"--out": out}, [])
    if effect.stage is Stage.STANCE:
        raise ValueError(f"{effect.name}: expected an effect that acts on a log; found one of the stance of a foot")
    from imugap.figures import effects  # figures take longer to import than the rest

    figure = effects.picture(effect, axis_of(effect))
    with atomic(out) as partial:
        write_figure(figure, partial, kind)

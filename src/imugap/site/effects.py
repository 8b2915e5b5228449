"""Catalogue of the effects: what each is, formula, parameters with units, and its picture."""

from collections.abc import Iterable, Mapping
from math import inf

from imugap.analysis.effect_description import EffectDescription, ParameterDescription, axis_of, example, summary
from imugap.effects import CATALOGUE
from imugap.effects.effect import TINY, Effect, Role, Stage
from imugap.site.markdown import code, plain, table

ROLES: Mapping[Role, str] = {
    Role.MEAN: "term of the mean",
    Role.NOISE: "random process",
    Role.FILTER: "filter",
    Role.OUTLIERS: "outliers",
    Role.VARIANCE: "noise that changes",
    Role.BIAS: "bias, free in every fit",
    Role.RUN: "seen over several runs",
    Role.OUTPUT: "seen in the samples themselves",
    Role.CLOCK: "seen in the stamps themselves",
    Role.UNFITTED: "simulated, not searched for",
}
"""What discovery makes of an effect of each role."""


def examples() -> dict[str, Effect]:
    """Return an example of each effect of the catalogue, by name."""
    return {name: example(kind) for name, kind in CATALOGUE.items()}


def drawn() -> tuple[str, ...]:
    """Return the names of the effects that have a picture: all that act on a log."""
    return tuple(name for name, kind in CATALOGUE.items() if kind.stage is not Stage.STANCE)


def page(folder: str) -> str:
    """Return the catalogue; ``folder`` has the pictures, ``<name>.png``."""
    rows = [
        (f"[{name}](#effect-{name.replace('_', '-')})", plain(summary(kind)), ROLES[kind.role])
        for name, kind in CATALOGUE.items()
    ]
    parts = [table(("effect", "what it is", "in discovery"), rows)]
    for name, one in examples().items():
        parts += _section(one, f"{folder}/{name}.png" if name in drawn() else None)
    return "\n\n".join(parts) + "\n"


def _section(effect: Effect, picture: str | None) -> Iterable[str]:
    of = EffectDescription.of(effect)
    yield f"(effect-{of.name.replace('_', '-')})=\n## {of.name}"
    yield from (plain(paragraph) for paragraph in of.text.split("\n\n"))
    yield from (f"{title.capitalize()}: {code(text)}" for title, text in of.formulas.items())
    yield table(("parameter", "meaning", "unit", "limits"), map(_row, of.parameters))
    values = ", ".join(f"{name}: {value:.4g}" for name, value in effect.parameters().items())
    yield f"In a model: {code(f'{axis_of(effect)}: [{{{of.name}: {{{values}}}}}]')}"
    if picture:
        yield f"![Signal and error of a simulated axis with the effect {of.name}]({picture})"


def _row(one: ParameterDescription) -> tuple[str, ...]:
    if one.high < inf:
        limits = f"{one.low:g} .. {one.high:g}"
    else:
        limits = "any" if one.low == -inf else "> 0" if one.low == TINY else f"≥ {one.low:g}"
    return code(one.name), plain(one.meaning), " or ".join(map(code, one.units)), plain(limits)

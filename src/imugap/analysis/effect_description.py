"""What an effect is, in words and units: from its docstrings and the declaration of its parameters."""

import re
from collections.abc import Mapping
from dataclasses import MISSING, dataclass, fields
from inspect import getdoc
from types import MappingProxyType

from imugap.effects.effect import Effect, StochasticEffect
from imugap.log import ACCEL, AXES, GYRO, TIME

UNITS = {GYRO: "rad/s", ACCEL: "m/s^2"}
"""Unit of the axes of each triad."""
EXAMPLES = {"s": 10.0, "Hz": 2.0, "1/s": 0.3, "degC": 25.0, "rad": 0.3, "1": 0.02}
"""Example value of a parameter by its unit; 1 in any other."""


@dataclass(frozen=True)
class ParameterDescription:
    """Parameter of an effect.

    Attributes
    ----------
    name, meaning
        Name in a model, and what it is.
    units
        SI units, one for each triad that differs.
    low, high
        Physical limits.
    """

    name: str
    meaning: str
    units: tuple[str, ...]
    low: float
    high: float


@dataclass(frozen=True)
class EffectDescription:
    """Effect in words.

    Attributes
    ----------
    name, text
        Name in a model; what it is; its first line is a summary.
    formulas
        Spectrum and Allan variance of a random effect, by title.
    parameters
        Its parameters.
    """

    name: str
    text: str
    formulas: Mapping[str, str]
    parameters: tuple[ParameterDescription, ...]

    @classmethod
    def of(cls, effect: Effect) -> "EffectDescription":
        """Describe the kind of an effect; the parameters do not matter."""
        kind, axis = type(effect), axis_of(effect)
        triads = [unit for triad, unit in UNITS.items() if axis not in AXES or _has_place(effect, triad[0])]
        units = [kind.units(unit) for unit in triads]
        parameters = tuple(
            ParameterDescription(
                item.name,
                _plain(item.metadata["meaning"]),
                tuple(dict.fromkeys(found[item.name] for found in units)),
                *kind.limits()[item.name],
            )
            for item in fields(kind)
        )
        return cls(kind.name, _plain(getdoc(kind) or ""), _formulas(kind), parameters)


def summary(kind: type[Effect]) -> str:
    """Return what an effect is, in one line."""
    return _plain(getdoc(kind) or "").partition("\n")[0]


def example(kind: type[Effect], given: Mapping[str, float] = MappingProxyType({})) -> Effect:
    """Return an effect with given parameters, and with example values for all others."""
    found = {}
    for item in fields(kind):
        unit, low, high = (item.metadata[key] for key in ("unit", "low", "high"))
        usual = EXAMPLES.get(unit, 1.0) if item.default is MISSING else item.default
        found[item.name] = min(max(usual, low), high)
    return kind(**found | given)


def axis_of(effect: Effect) -> str:
    """Return the first axis on which an effect has a place, or the pseudo-axis of the clock."""
    return next((axis for axis in AXES if _has_place(effect, axis)), TIME)


def _formulas(kind: type[Effect]) -> dict[str, str]:
    """Return the spectrum and the Allan variance of a random effect in the words of its methods."""
    if not issubclass(kind, StochasticEffect):
        return {}
    methods = {"spectrum": kind.psd, "Allan variance": kind.allan_variance}
    return {
        title: _plain((getdoc(method) or "").removeprefix("Return ")).partition("\n")[0]
        for title, method in methods.items()
    }


def _plain(text: str) -> str:
    """Return a docstring without its marks for other names."""
    return re.sub(r":\w+:`~?([^`]*)`|``([^`]*)``", lambda found: found[1] or found[2], text)


def _has_place(effect: Effect, axis: str) -> bool:
    try:
        effect.check_axis(axis)
    except ValueError:
        return False
    return True

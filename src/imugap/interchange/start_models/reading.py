"""What is read from a file of a simulator or filter: a model, and what of the file the model does not hold."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import MISSING, dataclass, fields
from math import isfinite, sqrt
from numbers import Real
from typing import Any

import numpy as np

from imugap.effects.effect import AxisModel, Effect
from imugap.interchange.conventions import Convention
from imugap.interchange.start_models.document import Document
from imugap.model import ErrorModel
from imugap.units import from_si, to_si


@dataclass(frozen=True)
class Key:
    """Number of a file as a function of an effect of an axis.

    Attributes
    ----------
    name, unit
        As the file has them; the unit is one of :mod:`imugap.units`.
    kind
        Kind of the effect.
    si
        Function of the effect that returns the number in SI units.
    """

    name: str
    unit: str
    kind: type[Effect]
    si: Callable[[Effect], float]

    @classmethod
    def of(cls, convention: Convention, parameter: str, kind: type[Effect], si: Callable, name: str = "") -> "Key":
        """Return the key of a parameter of a convention, with its unit; ``name`` where the file has it otherwise."""
        return cls(name or parameter, convention.unit(parameter), kind, si)

    def value(self, effect: Effect) -> float:
        """Return the number in the unit of the file."""
        return from_si(self.si(effect), self.unit)


Keys = Mapping[str, tuple[Key, ...]]
"""Keys of a file for ``gyro`` and ``accel``."""


@dataclass(frozen=True)
class Reading:
    """Model of a file, sentences on what the file holds that the model does not, and its keys.

    ``keys`` is None for a file of this library, which has the parameters of the effects themselves.
    """

    model: ErrorModel
    remarks: tuple[str, ...] = ()
    keys: Keys | None = None


@dataclass(frozen=True)
class Reader:
    """Reader of the files of one tool.

    Attributes
    ----------
    tool
        Name of the tool.
    convention
        Meaning and units of its numbers, with their source.
    recognises
        Whether a document is a file of the tool.
    read
        Function of a document and the sampling rate [Hz], or None where it is not known, that returns the reading;
        ValueError without the name of the file where a value is none that the tool takes.
    """

    tool: str
    convention: Convention
    recognises: Callable[[Document], bool]
    read: Callable[[Document, float | None], Reading]


def model_of(axes: Mapping[str, Iterable[Effect]]) -> ErrorModel:
    """Return the model of effects by axis, without those that are zero."""
    return ErrorModel({axis: AxisModel(tuple(_present(effects))) for axis, effects in axes.items()})


def _present(effects: Iterable[Effect]) -> Iterable[Effect]:
    """Yield the effects but those of which the first parameter, their size if it has no default, is zero."""
    for one in effects:
        size = fields(one)[0]
        if size.default is not MISSING or getattr(one, size.name) != 0:
            yield one


def numbers(values: Mapping[str, Any], name: str, count: int, default: float | None = None) -> np.ndarray:
    """Return ``count`` numbers of a key, of which the file gives one or all; ValueError for anything else."""
    value = values.get(name, default)
    flat = list(value) if isinstance(value, list | tuple | np.ndarray) else [value]
    good = [isinstance(one, Real) and not isinstance(one, bool) for one in flat]
    if not all(good) or len(flat) not in (1, count) or any(np.isnan(float(one)) for one in flat):
        expected = "a number" if count == 1 else f"one number or {count}"
        raise ValueError(f"{name}: expected {expected}; found {value!r:.80}")
    return np.resize(np.array(flat, float), count)


def number(values: Mapping[str, Any], name: str, default: float | None = None) -> float:
    """Return the finite number of a key; ValueError for anything else."""
    (found,) = numbers(values, name, 1, default)
    if not isfinite(found):
        raise ValueError(f"{name}: expected a finite number; found {found}")
    return float(found)


def in_si(convention: Convention, name: str, values: np.ndarray | float):
    """Return the values of a parameter of a tool in SI units."""
    return to_si(values, convention.unit(name))


def require_rate(rate: float | None, what: str) -> float:
    """Return the rate; ValueError where it is not known."""
    if rate is None:
        raise ValueError(f"{what}: expected a sampling rate, at which it is the noise of a sample; found none")
    return rate


def density(effect: Effect) -> float:
    """Return the density of white noise."""
    return effect.density


def walk_density(walk: Effect) -> float:
    """Return the density of the noise that drives a random walk."""
    return walk.density_k


def per_sample(rate: float) -> Callable[[Effect], float]:
    """Return the standard deviation of a sample at a rate [Hz], as a function of white noise."""
    return lambda white: density(white) * sqrt(rate)


def driving_density(markov: Effect) -> float:
    """Return the density of the noise that drives a Gauss-Markov process."""
    return sqrt(markov.driving_psd)


def std(effect: Effect) -> float:
    """Return the standard deviation of a Gauss-Markov process or a turn-on bias."""
    return effect.std


def correlation_time(markov: Effect) -> float:
    """Return the correlation time [s] of a Gauss-Markov process."""
    return markov.correlation_time


def level(bias: Effect) -> float:
    """Return the value of a bias."""
    return bias.value

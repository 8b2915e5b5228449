"""What is read from a file of a simulator or filter: a model, and what of the file the model does not hold."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import MISSING, dataclass, fields
from math import isfinite
from numbers import Real
from typing import Any

import numpy as np

from imugap import log
from imugap.effects.effect import AxisModel, Effect
from imugap.interchange.conventions import Convention
from imugap.interchange.start_models.document import Document
from imugap.model import ErrorModel
from imugap.units import to_si

TRIADS = {"gyro": log.GYRO, "accel": log.ACCEL}


@dataclass(frozen=True)
class Reading:
    """Model of a file, and sentences on what the file holds that the model does not."""

    model: ErrorModel
    remarks: tuple[str, ...] = ()


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

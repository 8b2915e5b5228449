"""Error models of a device: an immutable sum of effects for each axis, for simulation, estimation and filters."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import MISSING, dataclass, fields, replace
from pathlib import Path
from types import MappingProxyType

import pandas as pd
import yaml

from imugap import log, spelling
from imugap.effects import CATALOGUE, Bias, WhiteNoise
from imugap.effects.conditions import Conditions, Run
from imugap.effects.effect import AxisModel, Effect, StochasticEffect
from imugap.io import strict_yaml

SMALLEST, LARGEST = 1e-30, 1e12
"""Magnitudes of a parameter other than 0 [SI]: far beyond physics, and with powers that a float holds."""
MOST_EFFECTS = 100
"""Largest number of effects of an axis."""


def white_noise(density: float) -> StochasticEffect:
    """Return the white noise that the simplest model of an axis has, of a density [unit/sqrt(Hz)]."""
    return WhiteNoise(density)


def with_offset(value: float, effects: Iterable[Effect] = ()) -> AxisModel:
    """Return effects with a constant bias [unit of the axis]."""
    return AxisModel((Bias(value), *effects))


def shifted(model: AxisModel, shift: float) -> AxisModel:
    """Return the model with its constant bias changed by a shift [unit of the axis], where it has one."""
    return AxisModel(tuple(Bias(one.value + shift) if isinstance(one, Bias) else one for one in model))


def offset_of(model: AxisModel) -> float:
    """Return the constant bias of a model [unit of the axis]."""
    return sum(one.value for one in model if isinstance(one, Bias))


def conditions(ideal: pd.DataFrame, motion: pd.DataFrame | None = None) -> dict[str, Conditions]:
    """Return the conditions of each axis of an error-free log; ``motion`` is the same over more time."""
    temperature = ideal[log.TEMPERATURE].to_numpy() if log.TEMPERATURE in ideal else None
    everywhere = Conditions(ideal.index.to_numpy(), log.interval(ideal), temperature, ideal=ideal, motion=motion)
    return {axis: replace(everywhere, axis=axis) for axis in log.axes(ideal)}


@dataclass(frozen=True)
class ErrorModel:
    """Error model of a device: an :class:`AxisModel` for each axis (canonical names), and for the clock (``time``)."""

    axes: Mapping[str, AxisModel]

    def __post_init__(self) -> None:
        """Store a read-only copy; ValueError where an effect is not defined on its axis."""
        object.__setattr__(self, "axes", MappingProxyType(dict(self.axes)))
        for axis, model in self.axes.items():
            for effect in model:
                try:
                    effect.check_axis(axis)
                except ValueError as error:
                    raise ValueError(f"{axis}: {error}") from error

    def __reduce__(self) -> tuple:
        """Pickle as a plain mapping: a read-only mapping cannot be pickled."""
        return type(self), (dict(self.axes),)

    def __getitem__(self, axis: str) -> AxisModel:
        """Return the model of one axis."""
        return self.axes[axis]

    @property
    def sensors(self) -> dict[str, AxisModel]:
        """Return the models of the sensor axes, without that of the clock."""
        return {axis: model for axis, model in self.axes.items() if axis != log.TIME}

    def require_axes(self, source: object) -> "ErrorModel":
        """Return the model if it has all six axes; else a ValueError names its source and those that it lacks."""
        missing = [axis for axis in log.AXES if axis not in self.axes]
        if missing:
            expected = f"a model of all of {', '.join(log.AXES)}"
            raise ValueError(f"{source}: expected {expected}; found none of {', '.join(missing)}")
        return self

    def simulate(
        self, ideal: pd.DataFrame, seed: int, *labels: object, at: Mapping[str, Conditions] | None = None
    ) -> pd.DataFrame:
        """Simulate the log of the device for the error-free log ``ideal``.

        Axes without a model are unchanged. The errors of the clock are applied last. ``at`` are the conditions of
        ``ideal`` (:func:`conditions` by default), which several simulations may share.
        """
        at = at or conditions(ideal)
        measured = {
            axis: self.axes[axis].simulate(ideal[axis].to_numpy(), at[axis], seed, *labels)
            for axis in log.axes(ideal)
            if axis in self.axes
        }
        kept = ideal.assign(**measured)
        for effect, rng in self.axes.get(log.TIME, AxisModel()).streams(seed, *labels, axis=log.TIME):
            kept = effect.keep(kept, rng)
        return kept

    def simulate_parts(
        self, ideal: Callable[[], Iterator[pd.DataFrame]], count: int, interval: float, seed: int, *labels: object
    ) -> Iterator[pd.DataFrame] | None:
        """Return :meth:`simulate` of a device at rest part by part, in the memory of a part.

        The samples are those of :meth:`simulate` to rounding; flicker noise and noise of any slope come from other
        draws. None where an effect needs the whole run.

        Parameters
        ----------
        ideal
            Function that iterates over the parts of the error-free log, which is constant, as often as it is called.
        count, interval
            Number of its rows, and sampling interval [s].
        """

        def at(axis: str, part: pd.DataFrame) -> Conditions:
            return Conditions(part.index.to_numpy(), interval, axis=axis, ideal=part)

        axes = {}
        for axis, model in self.sensors.items():
            run = Run(count, interval, lambda axis=axis: (at(axis, part) for part in ideal()))
            axes[axis] = model.in_parts(run, axis, seed, *labels)
        if None in axes.values():
            return None
        parts = (
            part.assign(**{axis: step(part[axis].to_numpy(), at(axis, part)) for axis, step in axes.items()})
            for part in ideal()
        )
        for effect, rng in self.axes.get(log.TIME, AxisModel()).streams(seed, *labels, axis=log.TIME):
            parts = effect.keep_parts(parts, count, rng)
            if parts is None:
                return None
        return parts

    def to_mapping(self) -> dict[str, list[dict[str, dict[str, float]]]]:
        """Return plain data: axis -> list of {effect name: {parameter: value}}."""
        return {
            axis: [{effect.name: {key: float(v) for key, v in effect.parameters().items()}} for effect in model]
            for axis, model in self.axes.items()
        }

    @classmethod
    def from_mapping(cls, mapping: Mapping, catalogue: Mapping[str, type[Effect]] = CATALOGUE) -> "ErrorModel":
        """Build from plain data; ValueError with the nearest name for an unknown axis, effect or parameter."""
        axes = {}
        for axis, items in _kind(mapping, Mapping, "model", "a mapping of axes").items():
            _known(axis, (*log.AXES, log.TIME), "axis")
            named = [
                (name, values)
                for item in _kind(items, list | tuple, axis, "a list of effects")
                for name, values in _kind(item, Mapping, axis, "an effect, name: {parameter: value}").items()
            ]
            if len(named) > MOST_EFFECTS:
                raise ValueError(f"{axis}: expected at most {MOST_EFFECTS} effects; found {len(named)}")
            axes[axis] = AxisModel(tuple(_effect(axis, name, values, catalogue) for name, values in named))
        return cls(axes)

    def write(self, path: str | Path) -> None:
        """Write as YAML."""
        Path(path).write_text(yaml.safe_dump(self.to_mapping(), sort_keys=False))

    @classmethod
    def read(cls, path: str | Path, catalogue: Mapping[str, type[Effect]] = CATALOGUE) -> "ErrorModel":
        """Read from YAML; ``catalogue`` holds the kinds of effects by name.

        A model without an axis, or anything else that is none, is a ValueError with the path.
        """
        mapping = strict_yaml.read(path)
        try:
            model = cls.from_mapping(mapping or {}, catalogue)
        except ValueError as error:
            raise ValueError(f"{path}: {error}") from error
        if not model.axes:
            raise ValueError(f"{path}: expected a model of at least one axis; found none")
        return model


def _effect(axis: str, name: str, values: Mapping | None, catalogue: Mapping[str, type[Effect]]) -> Effect:
    _known(name, catalogue, f"{axis}: effect")
    given = {} if values is None else _kind(values, Mapping, f"{axis}: {name}", "a mapping of parameters")
    for key in given:
        _known(key, catalogue[name].units(""), f"{axis}: parameter of {name}")
    missing = [one.name for one in fields(catalogue[name]) if one.name not in given and one.default is MISSING]
    if missing:
        raise ValueError(f"{axis}: {name}: expected the parameter {', '.join(missing)}; found none")
    try:
        effect = catalogue[name](**{key: _number(value) for key, value in given.items()})
    except ValueError as error:
        raise ValueError(f"{axis}: {name}: {error}") from error
    for key, value in effect.parameters().items():
        if value and not SMALLEST <= abs(value) <= LARGEST:
            expected = f"0 or a magnitude in [{SMALLEST:g}, {LARGEST:g}]"
            raise ValueError(f"{axis}: {name}: {name}.{key}: expected {expected}; found {value:g}")
    return effect


def _kind(value: object, kind: type, place: str, expected: str):
    """Return a value of a kind; raise a ValueError for another."""
    if not isinstance(value, kind):
        raise ValueError(f"{place}: expected {expected}; found {strict_yaml.excerpt(value)}")
    return value


def _number(value: object) -> object:
    """Convert a decimal number that is given as text, as other readers take ``1e-4``; return anything else as it is."""
    number = strict_yaml.number_in(value) if isinstance(value, str) else value
    return value if number is None else float(number) if type(number) is int else number


def _known(name: str, known, subject: str) -> None:
    if name not in known:
        raise ValueError(
            f"{subject}: expected {spelling.expected(str(name), known)}; found {strict_yaml.excerpt(name)}"
        )

"""Error models: an immutable sum of effects for each axis; the same object simulates, estimates and filters."""

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from difflib import get_close_matches
from pathlib import Path
from types import MappingProxyType

import numpy as np
import pandas as pd
import yaml

from imugap import log as canonical
from imugap.effects import CATALOGUE
from imugap.effects.effect import AllanEffect, Conditions, Effect, Stage, StochasticEffect
from imugap.statespace import StateSpace
from imugap.stream import stream


@dataclass(frozen=True)
class AxisModel:
    """The error of one axis: a sum of effects, kept in the order of the signal chain."""

    effects: tuple[Effect, ...] = ()

    def __post_init__(self) -> None:
        """Sort by stage; within a stage the given order stays."""
        object.__setattr__(self, "effects", tuple(sorted(self.effects, key=lambda effect: effect.stage)))

    def __add__(self, other: "Effect | AxisModel") -> "AxisModel":
        """Add an effect or all effects of another axis model."""
        if isinstance(other, Effect):
            return AxisModel((*self.effects, other))
        return AxisModel(self.effects + other.effects) if isinstance(other, AxisModel) else NotImplemented

    def __iter__(self) -> Iterator[Effect]:
        """Iterate over the effects."""
        return iter(self.effects)

    def streams(
        self, seed: int, *labels: object, axis: str | None = None
    ) -> Iterator[tuple[Effect, np.random.Generator]]:
        """Iterate over the effects with the random stream of each; a shared one has no axis in its name."""
        count: Counter = Counter()
        for effect in self.effects:
            count[effect.name] += 1
            own = () if axis is None or effect.shared else (axis,)
            yield effect, stream(seed, *labels, *own, effect.name, count[effect.name])

    def simulate(self, ideal: np.ndarray, conditions: Conditions, seed: int, *labels: object) -> np.ndarray:
        """Return the output, shape (n,), for the error-free input ``ideal``; each effect draws from its own stream."""
        error, output = np.zeros(len(conditions)), None
        for effect, rng in self.streams(seed, *labels, axis=conditions.axis):
            if effect.stage < Stage.FILTER:
                error = effect.apply(error, conditions, rng)
            else:
                output = effect.apply(ideal + error if output is None else output, conditions, rng)
        return ideal + error if output is None else output

    def stochastic(self) -> tuple[StochasticEffect, ...]:
        """Return the effects that have a spectrum."""
        return tuple(effect for effect in self.effects if isinstance(effect, StochasticEffect))

    def psd(self, frequency: np.ndarray) -> np.ndarray:
        """Return the two-sided PSD [unit^2/Hz] of the stochastic effects at ``frequency`` [Hz]."""
        return sum((effect.psd(frequency) for effect in self.stochastic()), np.zeros(np.shape(frequency)))

    def sampled_psd(self, frequency: np.ndarray, interval: float) -> np.ndarray:
        """Return the two-sided PSD [unit^2/Hz], aliases included, of the samples of the stochastic effects."""
        zero = np.zeros(np.shape(frequency))
        return sum((effect.sampled_psd(frequency, interval) for effect in self.stochastic()), zero)

    def allan_variance(self, tau: np.ndarray) -> np.ndarray:
        """Return the Allan variance [unit^2] at ``tau`` [s] of the effects that have one, stochastic or ramp."""
        return sum((effect.allan_variance(tau) for effect in self._with_allan()), np.zeros(np.shape(tau)))

    def sampled_allan_variance(self, averaging: np.ndarray, interval: float) -> np.ndarray:
        """Return the Allan variance [unit^2] of their samples, exactly, at averaging factors ``averaging``."""
        zero = np.zeros(np.shape(averaging))
        return sum((effect.sampled_allan_variance(averaging, interval) for effect in self._with_allan()), zero)

    def _with_allan(self) -> tuple[AllanEffect, ...]:
        return tuple(effect for effect in self.effects if isinstance(effect, AllanEffect))

    def state_space(self) -> StateSpace:
        """Return the state space of the stochastic effects."""
        return sum((effect.state_space() for effect in self.stochastic()), StateSpace.white(0.0))


def conditions(ideal: pd.DataFrame) -> dict[str, Conditions]:
    """Return the conditions of each axis of an error-free log."""
    temperature = ideal[canonical.TEMPERATURE].to_numpy() if canonical.TEMPERATURE in ideal else None
    everywhere = Conditions(ideal.index.to_numpy(), canonical.interval(ideal), temperature, ideal=ideal)
    return {axis: replace(everywhere, axis=axis) for axis in canonical.axes(ideal)}


@dataclass(frozen=True)
class ErrorModel:
    """The errors of a device: an :class:`AxisModel` for each axis (canonical names), and for the clock (``time``)."""

    axes: Mapping[str, AxisModel]

    def __post_init__(self) -> None:
        """Keep a copy that nobody can change; every effect has to be at home on its axis."""
        object.__setattr__(self, "axes", MappingProxyType(dict(self.axes)))
        for axis, model in self.axes.items():
            for effect in model:
                try:
                    effect.check_axis(axis)
                except ValueError as error:
                    raise ValueError(f"{axis}: {error}") from error

    def __reduce__(self) -> tuple:
        """Pickle as a plain mapping: what guards it cannot be pickled."""
        return type(self), (dict(self.axes),)

    def __getitem__(self, axis: str) -> AxisModel:
        """Return the model of one axis."""
        return self.axes[axis]

    @property
    def sensors(self) -> dict[str, AxisModel]:
        """Return the models of the sensor axes, without that of the clock."""
        return {axis: model for axis, model in self.axes.items() if axis != canonical.TIME}

    def simulate(
        self, ideal: pd.DataFrame, seed: int, *labels: object, at: Mapping[str, Conditions] | None = None
    ) -> pd.DataFrame:
        """Return the log that the device would have written for the error-free log ``ideal``.

        Axes without a model pass unchanged. The temperature, where ``ideal`` has one, drives the effects. The errors
        of the clock come last. ``at`` are the conditions of ``ideal`` (:func:`conditions`), which know what several
        logs share.
        """
        at = at or conditions(ideal)
        measured = {
            axis: self.axes[axis].simulate(ideal[axis].to_numpy(), at[axis], seed, *labels)
            for axis in canonical.axes(ideal)
            if axis in self.axes
        }
        kept = ideal.assign(**measured)
        for effect, rng in self.axes.get(canonical.TIME, AxisModel()).streams(seed, *labels, axis=canonical.TIME):
            kept = effect.keep(kept, rng)
        return kept

    def to_mapping(self) -> dict[str, list[dict[str, dict[str, float]]]]:
        """Return plain data: axis -> list of {effect name: {parameter: value}}."""
        return {
            axis: [{effect.name: {key: float(v) for key, v in effect.parameters().items()}} for effect in model]
            for axis, model in self.axes.items()
        }

    @classmethod
    def from_mapping(cls, mapping: Mapping, catalogue: Mapping[str, type[Effect]] = CATALOGUE) -> "ErrorModel":
        """Build from plain data; an unknown axis, effect or parameter is a ValueError that names the nearest."""
        axes = {}
        for axis, items in mapping.items():
            _known(axis, (*canonical.AXES, canonical.TIME), "axis")
            named = [(name, values) for item in items for name, values in item.items()]
            axes[axis] = AxisModel(tuple(_effect(axis, name, values, catalogue) for name, values in named))
        return cls(axes)

    def write(self, path: str | Path) -> None:
        """Write as YAML."""
        Path(path).write_text(yaml.safe_dump(self.to_mapping(), sort_keys=False))

    @classmethod
    def read(cls, path: str | Path, catalogue: Mapping[str, type[Effect]] = CATALOGUE) -> "ErrorModel":
        """Read from YAML; ``catalogue`` holds the kinds of effects by name."""
        try:
            return cls.from_mapping(yaml.safe_load(Path(path).read_text()), catalogue)
        except (AttributeError, TypeError, ValueError, yaml.YAMLError) as error:
            raise ValueError(f"{path}: {' '.join(str(error).split())}") from error


def _effect(axis: str, name: str, values: Mapping | None, catalogue: Mapping[str, type[Effect]]) -> Effect:
    _known(name, catalogue, f"{axis}: effect")
    for key in values or {}:
        _known(key, catalogue[name].units(""), f"{axis}: parameter of {name}")
    try:
        return catalogue[name](**{key: _number(value) for key, value in (values or {}).items()})
    except (TypeError, ValueError) as error:
        raise ValueError(f"{axis}: {name}: {error}") from error


def _number(value):
    """Return what YAML took for text because it has an exponent without a point (1e-4) as the number that it is."""
    try:
        return float(value)
    except (TypeError, ValueError):
        return value


def _known(name: str, known, what: str) -> None:
    if name not in known:
        near = get_close_matches(str(name).lower(), list(known), 1) or [", ".join(known)]
        raise ValueError(f"{what}: expected {near[0]}; found {name!r}")

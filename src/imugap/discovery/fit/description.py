"""Description of one axis: its effects, the parameters that a fit adjusts, and which of them the start model has."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from functools import cached_property
from math import exp

import numpy as np

from imugap.discovery.fit.whittle import Noise
from imugap.effects.effect import Effect, Role, VarianceEffect


@dataclass(frozen=True)
class Entry:
    """Effect of a description.

    Attributes
    ----------
    effect
        The effect.
    free
        Names of the parameters that a fit adjusts.
    known
        Whether it is an effect of the start model; a search added the others.
    """

    effect: Effect
    free: tuple[str, ...]
    known: bool = False

    @classmethod
    def of(cls, item: "Effect | Entry") -> "Entry":
        """Return an effect as an entry with the parameters that a fit of its kind adjusts; an entry as it is."""
        return item if isinstance(item, Entry) else cls(item, item.free())

    def moved(self, step: np.ndarray) -> "Entry":
        """Return the entry with its free parameters changed by ``step``, kept within their physical limits."""
        values = {item: self._moved(item, change) for item, change in zip(self.free, step.tolist(), strict=True)}
        return replace(self, effect=replace(self.effect, **values))

    def _moved(self, name: str, change: float) -> float:
        """Return a parameter after a change; a positive one changes by a factor of at most e."""
        value, (low, high) = getattr(self.effect, name), self.effect.limits()[name]
        if low > 0:
            return min(max(value * exp(min(max(change / value, -1.0), 1.0)), low), high)
        return min(max(value + change, low), high)


@dataclass(frozen=True)
class Description:
    """Effects of an axis, apart from its offset.

    Attributes
    ----------
    entries
        The effects, in the order of :class:`imugap.effects.effect.Role`; of one role, those of the start model first.
    """

    entries: tuple[Entry, ...]

    def __post_init__(self) -> None:
        """Put the entries in order."""
        ordered = sorted(self.entries, key=lambda entry: (entry.effect.role, not entry.known))
        object.__setattr__(self, "entries", tuple(ordered))

    @classmethod
    def known(cls, *items: Effect | Entry) -> "Description":
        """Return the description of a start model with some effects."""
        return cls(tuple(replace(Entry.of(item), known=True) for item in items))

    def adding(self, *items: Effect | Entry) -> "Description":
        """Return the description with further effects, which the start model does not have."""
        return Description((*self.entries, *map(Entry.of, items)))

    def keeping(self, which: Callable[[Entry], bool]) -> "Description":
        """Return the description with those entries for which ``which`` holds."""
        return Description(tuple(filter(which, self.entries)))

    def without(self, indices: Iterable[int]) -> "Description":
        """Return the description without the entries at some indices."""
        left_out = set(indices)
        return Description(tuple(entry for index, entry in enumerate(self.entries) if index not in left_out))

    def with_effect(self, index: int, effect: Effect) -> "Description":
        """Return the description with another effect, or other values of it, in the entry at ``index``."""
        return self.with_entry(index, replace(self.entries[index], effect=effect))

    def with_entry(self, index: int, entry: Entry) -> "Description":
        """Return the description with another entry at ``index``."""
        return Description((*self.entries[:index], entry, *self.entries[index:][1:]))

    def exchanging(self, role: Role, entries: Iterable[Entry] = ()) -> "Description":
        """Return the description with other entries of a role, by default none."""
        return Description((*(entry for entry in self.entries if entry.effect.role is not role), *entries))

    def with_noise(self, noise: Noise) -> "Description":
        """Return the description with other values of its random processes and its filter, in their order."""
        values = iter(noise)
        entries = (
            replace(entry, effect=next(values)) if entry.effect.role in (Role.NOISE, Role.FILTER) else entry
            for entry in self.entries
        )
        return Description(tuple(entries))

    def of(self, role: Role) -> tuple[Entry, ...]:
        """Return the entries of a role."""
        return tuple(entry for entry in self.entries if entry.effect.role is role)

    @cached_property
    def terms(self) -> tuple[Entry, ...]:
        """Entries of the mean, which come first."""
        return self.of(Role.MEAN)

    @cached_property
    def noise(self) -> Noise:
        """The random processes and the filter behind them."""
        output_filter = next((entry.effect for entry in self.of(Role.FILTER)), None)
        return Noise(tuple(entry.effect for entry in self.of(Role.NOISE)), output_filter)

    @cached_property
    def changes(self) -> tuple[VarianceEffect, ...]:
        """Changes of the variance."""
        return tuple(entry.effect for entry in self.of(Role.VARIANCE))

    @cached_property
    def outliers(self) -> Effect | None:
        """Outliers, or None."""
        return next((entry.effect for entry in self.of(Role.OUTLIERS)), None)

    def effects(self) -> tuple[Effect, ...]:
        """Return all effects."""
        return tuple(entry.effect for entry in self.entries)

    def size(self) -> int:
        """Return the number of fitted parameters."""
        return sum(len(entry.free) for entry in self.entries)

"""Correct effects fitted to rounded values to those before the rounding."""

from collections.abc import Iterable
from dataclasses import replace
from typing import Protocol

import numpy as np

from imugap.discovery.preparation.sequence import AxisSequence
from imugap.effects.conditions import Conditions
from imugap.effects.effect import Effect, Role


class Lattice(Protocol):
    """An effect that rounds the output."""

    @property
    def lattice(self) -> float:
        """Distance of the levels."""

    def mean_ahead(self, mean: float, std: float) -> float:
        """Return the mean of normal values from their mean once they are rounded."""

    def std_ahead(self, mean: float, variance: float) -> float:
        """Return the standard deviation of normal values from mean and variance once they are rounded."""


FREQUENCIES = 1000
"""Number of frequencies over which the gain of a filter is averaged."""


def unrounded(effects: Iterable[Effect], outputs: Iterable[Effect], sequence: AxisSequence) -> tuple[Effect, ...]:
    """Return the effects fitted to a sequence, with its white noise before the rounding among ``outputs``.

    Behind a filter, the fit has separated white noise and rounding already.
    """
    interval, found = sequence.conditions.interval, tuple(effects)
    if any(one.role is Role.FILTER for one in found):
        return found
    for lattice in _lattices(outputs):
        found = tuple(
            replace(one, density=_std(lattice, one, sequence) * np.sqrt(interval)) if one.white else one
            for one in found
        )
    return found


def level_before_rounding(mean: float, effects: Iterable[Effect], interval: float) -> float:
    """Return the level before rounding of a device at rest whose output has the given mean.

    Of its effects only the white noise is assumed to move values across the steps of the rounding.
    """
    known = tuple(effects)
    variance = sum(one.density**2 for one in known if one.white) / interval
    frequency = np.linspace(0.0, 0.5 / interval, FREQUENCIES)
    passed = [np.mean(one.gain(frequency, interval)) for one in known if one.role is Role.FILTER]
    std = float(np.sqrt(variance * np.prod(passed)))
    for lattice in _lattices(known):
        mean = lattice.mean_ahead(mean, std) if std > 0 else mean
    return mean


def mean_of_terms(effects: Iterable[Effect], conditions: Conditions) -> float:
    """Return the mean of what the systematic effects of a device at rest add to its level."""
    terms = (one for one in effects if one.role is Role.MEAN and not one.of_motion)
    return sum(float(np.mean(one.sample(conditions, None))) for one in terms)


def _lattices(effects: Iterable[Effect]) -> tuple[Lattice, ...]:
    return tuple(one for one in effects if one.lattice)


def _std(lattice: Lattice, white: Effect, sequence: AxisSequence) -> float:
    """Return the standard deviation before rounding; in motion, values are uniform within a step."""
    variance = white.density**2 / sequence.conditions.interval
    if sequence.conditions.ideal is not None:
        return float(np.sqrt(max(variance - lattice.lattice**2 / 12, 0.0)))
    return lattice.std_ahead(float(sequence.values.mean()), variance)

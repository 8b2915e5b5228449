"""The start model on one axis: what a fit adjusts of it, and what a log cannot tell."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from imugap.discovery.fit.description import Description, Entry
from imugap.discovery.preparation.sequence import AxisSequence
from imugap.effects.conditions import Conditions
from imugap.effects.effect import Effect, FilterEffect, Role, Stage, StochasticEffect, SystematicEffect
from imugap.model import white_noise

MAX_CUTOFF_SHARE = 0.98
"""Share of the highest cutoff that a fit can tell above which a run two percent slower does not show it."""


def described(effects: Sequence[Effect], sequence: AxisSequence) -> Description:
    """Return the start model of an axis as a description: what a fit can adjust of it; a bias is the offset."""
    random = [effect for effect in effects if noisy(effect)]
    filters = [_seen(effect, sequence) for effect in effects if effect.role is Role.FILTER]
    terms = [_term(effect, sequence) for effect in effects if _shows(effect, sequence.conditions)]
    changes = [effect for effect in effects if effect.role is Role.VARIANCE]
    outliers = [effect for effect in effects if effect.role is Role.OUTLIERS]
    return Description.known(*terms, *(random or [_white(sequence)]), *filters[:1], *outliers[:1], *changes)


def noisy(effect: Effect) -> bool:
    """Return whether an effect is random noise, and none of size zero."""
    return effect.role is Role.NOISE and all(effect.parameters().values())


def undetermined(effects: Sequence[Effect], sequence: AxisSequence) -> tuple[Effect, ...]:
    """Return the effects that no fit to the log of one axis adjusts, and that its output does not show either.

    What takes a motion or a temperature that is not known, and what differs between runs only.
    """
    fitted = (Role.BIAS, Role.NOISE, Role.FILTER, Role.VARIANCE, Role.OUTLIERS)
    return tuple(
        effect
        for effect in effects
        if effect.stage < Stage.FILTER and effect.role not in fitted and not _shows(effect, sequence.conditions)
    )


def _shows(effect: Effect, conditions: Conditions) -> bool:
    """Return whether an effect is a mean that follows from the conditions that are known."""
    if effect.role is not Role.MEAN:
        return False
    try:
        effect.slopes(conditions)
        effect.sample(conditions, np.random.default_rng(0))
    except ValueError:
        return False
    return True


def _seen(effect: FilterEffect, sequence: AxisSequence) -> Effect:
    highest = effect.highest(sequence.conditions.interval)
    return effect.adjusted_to(min(effect.adjusted, MAX_CUTOFF_SHARE * highest))


def _white(sequence: AxisSequence) -> StochasticEffect:
    """Return white noise of the size of the differences of neighbours."""
    spread = np.std(np.diff(sequence.values)) / np.sqrt(2)
    return white_noise(float(max(spread, 1e-12) * np.sqrt(sequence.conditions.interval)))


def _term(effect: SystematicEffect, sequence: AxisSequence) -> Entry:
    if effect.line:
        turns = np.exp(-2j * np.pi * effect.frequency * sequence.conditions.time)
        effect = replace(effect, phase=float(np.angle(np.mean((sequence.values - sequence.values.mean()) * turns))))
    return Entry(effect, tuple(effect.slopes(sequence.conditions)))

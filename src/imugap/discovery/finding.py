"""Results of discovery: locations where simulation and measurement disagree, and effects that explain them."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from imugap.effects.effect import Effect, Evidence

MIN_LOG_P = -690.0
"""Minimum log-probability that is reported; its exponential is above zero."""


@dataclass(frozen=True)
class Discrepancy:
    """Location in a view where measured data disagree with simulations of a model.

    Attributes
    ----------
    view
        Name of the view.
    axis
        Canonical name of the axis (two, joined by a comma, for a view of pairs; ``time`` for the stamps).
    low, high, unit
        Range of the location in the view, and its unit.
    p_value
        Probability of a disagreement as large anywhere in this view of this axis under the model.
    """

    view: str
    axis: str
    low: float
    high: float
    unit: str
    p_value: float


@dataclass(frozen=True)
class Interval:
    """Estimate of a parameter with its 95 % interval; SI."""

    value: float
    low: float
    high: float
    unit: str


@dataclass(frozen=True)
class Rival:
    """Another name for what a log shows.

    Attributes
    ----------
    name
        The name.
    log_bayes_factor
        Logarithm of its Bayes factor over the chosen name.
    effects
        All effects of the axis with it in the place of the chosen one, fitted.
    """

    name: str
    log_bayes_factor: float
    effects: tuple[Effect, ...]


@dataclass(frozen=True)
class Finding:
    """Named effect on one or several axes, with the evidence for it.

    Attributes
    ----------
    effects
        The effect on each axis that has it (axis name or ``time`` to effect).
    parameters
        Its parameters; loadings, which differ from axis to axis, carry the axis in their name.
    log_p
        Log p-value of the evidence.
    log_score_gain
        Gain of the log-density of held-out data. Outliers and telegraph noise, which a spectrum does not determine, are
        scored on the whole log; effects that only the last part of the log shows, on this part after fitting to it; 0
        for effects that were not found by likelihood.
    alternatives
        (name, gain) of effects that the data cannot distinguish from it.
    axis_effects
        All effects of its axis, fitted, itself among them; none for one that no fit adjusts or that axes share.
    rivals
        Effects that were fitted in its place.
    misfit_log_p
        Smallest log p-value of the tests of its shape; 0 for an effect without such tests.
    probabilities
        Probability of each explanation of what was seen (:mod:`imugap.discovery.posterior`), the likeliest first.
    """

    effects: dict[str, Effect]
    parameters: dict[str, Interval]
    log_p: float
    log_score_gain: float = 0.0
    alternatives: tuple[tuple[str, float], ...] = field(default=())
    axis_effects: tuple[Effect, ...] = ()
    rivals: tuple[Rival, ...] = ()
    misfit_log_p: float = 0.0
    probabilities: Mapping[str, float] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """Return the name of the effect."""
        return next(iter(self.effects.values())).name

    @property
    def axes(self) -> tuple[str, ...]:
        """Return the axes that have it."""
        return tuple(self.effects)


@dataclass(frozen=True)
class Unnamed:
    """What was seen on an axis but is not named.

    Attributes
    ----------
    axis
        Name of the axis.
    name, reason
        Nearest name, and why it is withheld.
    probabilities
        Probability of each explanation of what was seen (:mod:`imugap.discovery.posterior`), the likeliest first.
    """

    axis: str
    name: str
    reason: str
    probabilities: Mapping[str, float]


def finding(effects: dict[str, Effect], evidence: Evidence, unit: str) -> Finding:
    """Return evidence as a finding on some axes, which have the SI unit ``unit``."""
    effect = evidence.effect
    units = effect.units(unit)
    parameters = {
        name: Interval(value, *map(float, evidence.intervals[name]), units[name])
        for name, value in effect.parameters().items()
    }
    return Finding(effects, parameters, float(evidence.log_p))

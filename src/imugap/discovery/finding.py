"""What discovery says: places where simulation and measurement differ, and effects that explain them."""

from dataclasses import dataclass, field

from imugap.effects.effect import Effect, Evidence

CERTAIN = -690.0
"""Logarithm of the least probability that is told from zero."""


@dataclass(frozen=True)
class Gap:
    """A place where measured data leave what a model simulates.

    Attributes
    ----------
    view
        Name of the view in which it shows.
    axis
        Canonical name of the axis (two, joined by a comma, for a view of pairs; ``time`` for the stamps).
    low, high, unit
        Where in the view: range of the location and its unit.
    p_value
        Probability of anything as extreme anywhere in this view of this axis if the model were right.
    """

    view: str
    axis: str
    low: float
    high: float
    unit: str
    p_value: float


@dataclass(frozen=True)
class Interval:
    """A parameter with its 95 % interval; SI."""

    value: float
    low: float
    high: float
    unit: str


@dataclass(frozen=True)
class Finding:
    """An effect that explains a gap.

    Attributes
    ----------
    effects
        The effect on each axis that has it (axis name or ``time`` to effect).
    parameters
        Its parameters; loadings, which differ from axis to axis, carry the axis in their name.
    log_p
        Logarithm of the probability that chance makes as much of it.
    log_score_gain
        Gain of the log-density of data that the fit has not seen. Of the whole log for outliers and telegraph noise,
        which no spectrum tells; of the last part, which the fit has seen, for what shows there only; 0 for what was
        not weighed by its likelihood.
    alternatives
        (name, gain) of what the data cannot tell from it.
    """

    effects: dict[str, Effect]
    parameters: dict[str, Interval]
    log_p: float
    log_score_gain: float = 0.0
    alternatives: tuple[tuple[str, float], ...] = field(default=())

    @property
    def name(self) -> str:
        """Return the name of the effect."""
        return next(iter(self.effects.values())).name

    @property
    def axes(self) -> tuple[str, ...]:
        """Return the axes that have it."""
        return tuple(self.effects)


def finding(effects: dict[str, Effect], evidence: Evidence, unit: str) -> Finding:
    """Return what evidence shows as a finding of some axes, which have the SI unit ``unit``."""
    effect = evidence.effect
    units = effect.units(unit)
    parameters = {
        name: Interval(value, *map(float, evidence.intervals[name]), units[name])
        for name, value in effect.parameters().items()
    }
    return Finding(effects, parameters, float(evidence.log_p))

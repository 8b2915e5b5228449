"""Which further log would separate the names that a log leaves open.

Every proposal of a log is simulated with the chosen name and with each rival of the ambiguity set. Both are fitted to
what was simulated, and compared as the search compares them. A proposal separates the names if, whichever of them is
true, the other falls out of the ambiguity set in most simulations. A proposal is a log by itself, not joined with the
present one.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import permutations

import numpy as np
from threadpoolctl import threadpool_limits

from imugap.discovery.finding import Finding, Rival
from imugap.discovery.fit.axis_fit import fit
from imugap.discovery.fit.start_model import described
from imugap.discovery.posterior import LEVEL, ambiguity_set
from imugap.discovery.preparation.sequence import AxisSequence
from imugap.discovery.search.search import PARAMETER_COST
from imugap.effects import title_of
from imugap.effects.conditions import Conditions
from imugap.effects.effect import AxisModel, Effect

TIMES = (2, 4, 8)
"""Lengths of a further log of the same kind, over that of the present one."""
FASTER = 4
"""Sampling rate of a further log, over the present one."""
SWING_DEGC = 20.0
"""Rise of the temperature of a device that is warmed, in the first half of a log, and cools in the second."""
LARGER = 2.0
"""Size of a larger motion, over the present one."""
MAX_SAMPLES = 1_000_000
"""Largest number of samples of a log that is simulated."""
DRAWS, MIN_SHARE = 4, 0.75
"""Simulations of each name, and share of them that have to separate the names."""
Effects = Sequence[Effect]
MIN_LOG_ODDS = float(np.log(LEVEL / (1 - LEVEL)))
"""Log-odds of a name against the other beyond which the other is not in the ambiguity set."""


@dataclass(frozen=True)
class Proposal:
    """A further log: what to do, how long it takes [s], and the conditions of the axis in it."""

    action: str
    duration: float
    conditions: Conditions


@dataclass(frozen=True)
class Advice:
    """What to record next, so that a name is separated from its rivals.

    Attributes
    ----------
    axes
        Axes that have the effect.
    name, rivals
        The chosen name, and the others of the ambiguity set.
    best
        The shortest proposal among those that separate the name from most rivals; None if none does from any.
    left
        Rivals that it leaves.
    longer
        Length [s] of a log of the same kind that separates as many, or None where none that was tried is long enough.
    longest
        Length [s] of the longest log of the same kind that was tried; 0 for none.
    """

    axes: tuple[str, ...]
    name: str
    rivals: tuple[str, ...]
    best: Proposal | None
    left: tuple[str, ...]
    longer: float | None
    longest: float

    def sentence(self) -> str:
        """Return the advice as a sentence."""
        separated = [one for one in self.rivals if one not in self.left] or self.rivals
        begin = f"{', '.join(self.axes)}: to tell {_words([self.name])} from {_words(separated)}, "
        if self.best is None:
            return f"{begin}none of the further logs that were tried is enough."
        text = f"{begin}record {self.best.action} ({self.best.duration:.0f} s)"
        if self.longer is None and self.longest:
            text += f"; more of the same, up to {self.longest:.0f} s, is not enough"
        elif self.longer is not None and self.longer > self.best.duration:
            text += f"; more of the same takes {self.longer:.0f} s"
        return f"{text}; {_words(self.left)} may remain." if self.left else f"{text}."


def advise(findings: Sequence[Finding], at: Callable[[str], Conditions], seed: int = 0) -> tuple[Advice, ...]:
    """Return what to record next for each finding with an ambiguous name.

    Parameters
    ----------
    findings
        Findings with their probabilities.
    at
        Function that returns the conditions of an axis in the present log.
    seed
        Seed of the simulations.
    """
    with threadpool_limits(1):
        return tuple(_advice(one, rivals, at(one.axes[0]), seed) for one in findings if (rivals := _open(one)))


def _open(finding: Finding) -> tuple[Rival, ...]:
    """Return the rivals in the ambiguity set of a finding."""
    chosen = ambiguity_set(finding.probabilities)
    return tuple(one for one in finding.rivals if one.name in chosen)


def _advice(finding: Finding, rivals: Sequence[Rival], conditions: Conditions, seed: int) -> Advice:
    """Return the shortest log that separates a name from most of its rivals, and the length of more of the same."""

    def left(proposal: Proposal) -> tuple[str, ...]:
        return tuple(one.name for one in rivals if not _separates(finding.axis_effects, one.effects, proposal, seed))

    same = [(proposal, left(proposal)) for proposal in _longer(conditions)]
    other = [(proposal, left(proposal)) for proposal in _other(conditions)]
    best, remain = min((*other, *same), key=lambda pair: (len(pair[1]), pair[0].duration), default=(None, ()))
    names = tuple(one.name for one in rivals)
    longest = max((proposal.duration for proposal, _ in same), default=0.0)
    if best is None or len(remain) == len(rivals):
        return Advice(finding.axes, finding.name, names, None, names, None, longest)
    longer = (proposal.duration for proposal, rest in same if len(rest) <= len(remain))
    return Advice(finding.axes, finding.name, names, best, remain, next(longer, None), longest)


def _words(names: Sequence[str]) -> str:
    return ", ".join(title_of(one) for one in names)


def _longer(conditions: Conditions) -> Iterator[Proposal]:
    """Yield logs of the same kind, the shortest first; none for a device in motion, whose motion ends."""
    if conditions.ideal is not None:
        return
    for times in TIMES:
        count = times * len(conditions)
        if count <= MAX_SAMPLES:
            yield _at_rest(f"one log {times} times as long", conditions, count, conditions.interval)


def _other(conditions: Conditions) -> Iterator[Proposal]:
    """Yield logs of other kinds, as long as the present one."""
    count, interval = len(conditions), conditions.interval
    if conditions.ideal is not None:
        moved = _scaled(conditions)
        yield Proposal(f"the motion {LARGER:g} times as large", count * interval, moved)
        return
    if conditions.temperature is not None:
        same = _at_rest(f"the device warmed by {SWING_DEGC:g} °C and cooled again", conditions, count, interval)
        swing = SWING_DEGC * (1 - np.abs(np.linspace(-1, 1, count)))
        warmed = replace(same.conditions, temperature=float(np.mean(conditions.temperature)) + swing)
        yield replace(same, conditions=warmed)
    if FASTER * count <= MAX_SAMPLES:
        rate = FASTER / interval
        yield _at_rest(f"the same at {rate:g} samples a second", conditions, FASTER * count, interval / FASTER)


def _at_rest(action: str, conditions: Conditions, count: int, interval: float) -> Proposal:
    """Return a log of a device at rest; the temperature goes on as it was, from the end to the begin and back."""
    time = interval * np.arange(count)
    degrees = conditions.temperature
    if degrees is not None:
        there_and_back = np.r_[degrees, degrees[::-1]]
        degrees = there_and_back[np.floor(time / conditions.interval).astype(int) % len(there_and_back)]
    return Proposal(action, count * interval, Conditions(time, interval, degrees, conditions.axis))


def _scaled(conditions: Conditions) -> Conditions:
    """Return the conditions of a larger motion: rates and accelerations about their means are multiplied."""
    ideal, motion = (
        None if one is None else one.mean() + LARGER * (one - one.mean())
        for one in (conditions.ideal, conditions.motion)
    )
    return replace(conditions, ideal=ideal, motion=motion)


def _separates(one: Effects, other: Effects, proposal: Proposal, seed: int) -> bool:
    """Return whether a log separates two models of the axis, whichever of them is true."""
    return all(
        np.mean([_log_odds(true, false, proposal, seed, draw) > MIN_LOG_ODDS for draw in range(DRAWS)]) >= MIN_SHARE
        for true, false in permutations((one, other))
    )


def _log_odds(true: Effects, false: Effects, proposal: Proposal, seed: int, draw: int) -> float:
    """Return the log-odds of a true model against a false one, both fitted to a simulation of the true one."""
    conditions = proposal.conditions
    ideal = np.zeros(len(conditions)) + conditions.error_free
    values = AxisModel(true).simulate(ideal, conditions, seed, "next_log", proposal.action, draw) - ideal
    sequence = AxisSequence(values, conditions)
    right, wrong = (fit(sequence, described(one, sequence)) for one in (true, false))
    cost = PARAMETER_COST * (right.description.size() - wrong.description.size())
    return right.log_likelihood - wrong.log_likelihood - cost

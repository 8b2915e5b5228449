"""What is missing on one axis: effects are added, exchanged and removed until none improves the description.

Every effect of the catalogue proposes itself (:meth:`imugap.effects.Effect.proposals`); each proposal is fitted
together with all that is there, and the one that chance explains least is taken. After an addition each effect is
taken out again and exchanged for every other, so that what came first by masquerade does not stay.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import gammaln
from scipy.stats import chi2

from imugap.discovery.axis import AxisFit, Description, Term, fit
from imugap.effects import OutputFilter, VarianceChange
from imugap.effects.effect import Effect, Start, SystematicEffect

LIMIT = 12
"""Additions to one axis."""
FAR = 300.0
"""Gain of log-likelihood above which the probability of a chance is its asymptote."""
MARGIN = 2.0
"""Gain of evidence that an exchange has to make."""


@dataclass(frozen=True)
class Proposal:
    """An effect that may be missing.

    Attributes
    ----------
    name
        Its name.
    description
        The whole description with it, at start values.
    trials
        Number of independent places or shapes among which it was chosen.
    """

    name: str
    description: Description
    trials: float = 1.0


@dataclass(frozen=True, eq=False)
class Trial:
    """A fitted proposal: its gain of log-likelihood over the description without it, and the chance of that gain."""

    name: str
    fit: AxisFit
    gain: float
    log_p: float


def judged(proposal: Proposal, before: AxisFit) -> Trial:
    """Fit a proposal and judge it against the fit without it (likelihood ratio, Bonferroni over its trials)."""
    after = fit(before.sequence, proposal.description)
    gain = after.log_likelihood - before.log_likelihood
    more = max(after.description.size() - before.description.size(), 1)
    return Trial(proposal.name, after, gain, min(_log_chance(gain, more) + np.log(proposal.trials), 0.0))


def _log_chance(gain: float, more: int) -> float:
    """Return the log-probability of a gain of log-likelihood by chance (Wilks), by its asymptote where it underflows."""
    if gain <= 0:
        return 0.0
    if gain < FAR:
        return float(chi2.logsf(2 * gain, more))
    return float(-gain + (more / 2 - 1) * np.log(gain) - gammaln(more / 2))


def proposals(before: AxisFit, catalogue: Iterable[type[Effect]]) -> Iterator[Proposal]:
    """Yield what each effect of the catalogue proposes for the residual of a fit."""
    for kind in catalogue:
        for start in kind.starts(before):
            yield Proposal(kind.name, with_effect(before.description, start), start.trials)


def with_effect(description: Description, start: Start) -> Description:
    """Return the description with an effect more, in the part of it where its kind belongs."""
    effect = start.effect
    if isinstance(effect, SystematicEffect):
        return description.with_term(Term(effect, start.free))
    if isinstance(effect, VarianceChange):
        return replace(description, changes=(*description.changes, effect))
    noise = description.noise
    if isinstance(effect, OutputFilter):
        return replace(description, noise=replace(noise, output_filter=effect))
    return replace(description, noise=replace(noise, effects=(*noise.effects, effect)))


def explore(before: AxisFit, catalogue: tuple[type[Effect], ...], log_alpha: float, fixed: int = 0) -> list[Trial]:
    """Return the effects that are added, in order, each judged when it came; the last one holds the final fit.

    Parameters
    ----------
    before
        Fit of the start description.
    log_alpha
        Logarithm of the probability that any one proposal is taken by chance.
    """
    history: list[Trial] = []
    for _ in range(LIMIT):
        trials = [judged(proposal, before) for proposal in proposals(before, catalogue)]
        best = min(trials, key=lambda trial: trial.log_p, default=None)
        if best is None or best.log_p > log_alpha:
            break
        history.append(best)
        before = best.fit
    return history

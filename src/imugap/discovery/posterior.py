"""Posterior probability of each explanation of one place where a log and its model disagree.

The explanations are the name that the search chose, the names that were fitted in its place, another name of the
catalogue (:data:`OTHER`), an effect that is in no catalogue (:data:`UNKNOWN`), and nothing at all (:data:`NONE`).
Their odds are

* a rival against the chosen name: the Bayes factor of both fits, by the criterion of the search (Schwarz 1978, Ann.
  Stat. 6(2), with the cost of the places among which each was chosen);
* nothing against the chosen name: the least Bayes factor that its p-value allows, ``-e p ln p`` (Sellke, Bayarri &
  Berger 2001, Am. Stat. 55(1)), times the number of proposals;
* anything else against the chosen name: prior odds, over the same bound for the p-value of the tests of its shape.
"""

from collections.abc import Iterable, Mapping

import numpy as np
from scipy.special import logsumexp

from imugap.discovery.finding import MIN_LOG_P

NONE, OTHER, UNKNOWN = "none", "other", "unknown"
IN_WORDS = {NONE: "nothing at all", OTHER: "another name of the catalogue", UNKNOWN: "an effect that has no name"}
"""The explanations that are no name, as text."""
LOG_ODDS_ELSE = -4.2
"""Prior log-odds of anything else against the chosen name.

This and the next three constants are maximum-likelihood estimates from 100 sealed cases of a seed of their own.
"""
UNKNOWN_SHARE = 0.86
"""Share of the effects in no catalogue in anything else."""
MAX_LOG_ODDS_ELSE = 3.0
"""Largest log-odds of anything else against the chosen name, however small the p-value of a test is."""
NOT_SEEN = {NONE: 0.5, OTHER: 0.37, UNKNOWN: 0.13}
"""Probabilities of what a report does not show: how many logs in which nothing was seen hide an effect too small for
it, among those cases and the 400 of the recorded benchmark (sizes from 0.3 to 30 detection limits)."""
LEVEL = 0.95
"""Probability that an ambiguity set has at least."""
MIN_SHARE = 0.01
"""Probability below which, and one minus it above which, only this bound is said."""


def posterior(
    name: str, log_p: float, misfit_log_p: float, rivals: Iterable[tuple[str, float]], proposals: int
) -> dict[str, float]:
    """Return the probability of each explanation, the likeliest first; they add up to one.

    Parameters
    ----------
    name
        Name that the search chose.
    log_p
        Log p-value of the effect against nothing.
    misfit_log_p
        Smallest log p-value of the tests of its shape; 0 where there are none.
    rivals
        (name, log Bayes factor over the chosen one) of names that were fitted in its place.
    proposals
        Number of names times axes among which the effect was proposed: the prior odds against each.
    """
    anything_else = min(LOG_ODDS_ELSE - _log_least_bayes_factor(misfit_log_p), MAX_LOG_ODDS_ELSE)
    weights = dict(rivals) | {
        name: 0.0,
        UNKNOWN: anything_else + np.log(UNKNOWN_SHARE),
        OTHER: anything_else + np.log(1 - UNKNOWN_SHARE),
        NONE: np.log(proposals) + _log_least_bayes_factor(log_p),
    }
    total = logsumexp(list(weights.values()))
    shares = {one: float(np.exp(weight - total)) for one, weight in weights.items()}
    return dict(sorted(shares.items(), key=lambda item: -item[1]))


def ambiguity_set(probabilities: Mapping[str, float], level: float = LEVEL) -> tuple[str, ...]:
    """Return the fewest explanations that together have the probability ``level``, the likeliest first."""
    ordered = sorted(probabilities.items(), key=lambda item: -item[1])
    before = np.cumsum([0.0, *(share for _, share in ordered)])
    return tuple(name for (name, _), less in zip(ordered, before, strict=False) if less < level)


def percent(share: float) -> str:
    """Return a probability as text; near its ends only the bound, for nothing is certain."""
    if share < MIN_SHARE:
        return f"below {100 * MIN_SHARE:.0f} %"
    return f"above {100 - 100 * MIN_SHARE:.0f} %" if share > 1 - MIN_SHARE else f"{100 * share:.0f} %"


def _log_least_bayes_factor(log_p: float) -> float:
    """Return the logarithm of the least Bayes factor for a null hypothesis with this log p-value."""
    bounded = max(log_p, MIN_LOG_P)
    return 1 + bounded + np.log(-bounded) if bounded < -1 else 0.0

"""Are outliers what their name says? Single samples, at any time, in noise that is normal otherwise."""

import numpy as np
from scipy.special import ndtr
from scipy.stats import ncx2

from imugap.discovery.checks.misfit import LEVEL, Misfit
from imugap.discovery.checks.motion import outliers_against_motion
from imugap.discovery.fit.axis_fit import AxisFit
from imugap.discovery.search.search import Search
from imugap.effects.effect import TINY
from imugap.stream import stream

CORE, INSIDE = 2.0, 0.7737413
"""Standard deviations within which most samples are no outliers, and the mean of the squares of normal ones there."""
ROUNDS, BINS = 40, 12
"""Rounds in which mean and deviation of the core settle; bins of equal probability in it."""
RARE = 0.1
"""Share of the samples above which they are none, but the tails of another distribution."""
SLIGHT = 0.005
"""Squared relative deviation of the core's density that leaves the name as it is: no real noise is quite normal."""


def outliers_misfit(search: Search, fit: AxisFit) -> Misfit:
    """Ask whether outliers come by themselves and at any time, and whether the other samples are normal.

    Where the variance changes they need not be as many at one time as at another.
    """
    found = search.tails[fit.description.outliers]
    misfits = [
        Misfit("they are not rare", LEVEL - 1.0 if found.probability > RARE else 0.0),
        Misfit("they come in clusters", found.clustered),
        Misfit("they come with the motion", outliers_against_motion(fit, found.flagged)),
        Misfit("they come at a beat", found.beating),
        Misfit("all samples are of another distribution", _another_core(fit)),
    ]
    if not fit.description.changes:
        misfits.append(Misfit("they come at some times more often than at others", found.uneven))
    return min(misfits, key=lambda misfit: misfit.log_p)


def _another_core(fit: AxisFit) -> float:
    """Return the log-probability that most samples are as far from normal, those of the outliers having been replaced.

    Fine steps of the values are spread over their width.
    """
    axis, step = fit.sequence.conditions.axis, 0.0 if fit.sequence.coarse else fit.sequence.step
    width = step / fit.unit
    values = fit.unrounded + width * (stream(0, "core", axis).random(len(fit.unrounded)) - 0.5)
    middle, scale = np.median(values), values.std()
    for _ in range(ROUNDS):
        core = (values[np.abs(values - middle) < CORE * scale] - middle) / scale
        middle, scale = middle + 2 * core.mean() * scale, scale * np.mean(core**2) / INSIDE
    place = (ndtr(core) - ndtr(-CORE)) / (ndtr(CORE) - ndtr(-CORE))
    counts = np.bincount((place * BINS).astype(int).clip(0, BINS - 1), minlength=BINS)
    expected = len(core) / BINS
    chance = ncx2.sf(np.sum((counts - expected) ** 2) / expected, BINS - 3, SLIGHT * len(core))
    return float(np.log(max(chance, TINY)))

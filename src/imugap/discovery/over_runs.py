"""Noise of a device over several of its runs: its parameters, their scatter from run to run, and what does not recur.

The likelihood of all runs together has its maximum at the parameters of the device. The scores of the runs there
scatter more than their information where the parameters differ from run to run (the sandwich of Huber 1967, with each
run as one independent unit); what exceeds the information is the scatter of the parameters.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from imugap.discovery.fit.axis_fit import AxisFit, fit, log_score
from imugap.discovery.fit.description import Description
from imugap.discovery.fit.whittle import PRIOR_LOG_STD, NoiseFit, NoiseSpectra
from imugap.discovery.fit.whittle import fit as fit_noise
from imugap.effects.effect import Effect, Role

RECURRING = (Role.MEAN, Role.NOISE, Role.FILTER)
"""Roles of the effects that another run of the device has, too, apart from events and lines."""
MIN_ODDS = 20.0
"""Odds of the likelihood of further runs without an effect to that with it, from which it does not recur.

Runs of a device that has it reach them with a probability of at most 1/20 (Markov's inequality).
"""


def recurring(description: Description) -> Description:
    """Return the part of a description that another run has, too: without events, lines and changes of the variance."""
    return description.keeping(
        lambda entry: entry.effect.role in RECURRING and not (entry.effect.event or entry.effect.line)
    )


def fit_over_runs(runs: Sequence[AxisFit]) -> AxisFit:
    """Return the fit of the first run with the noise of all runs of the device.

    The runs have the same random processes. The information is that of the mean over the runs.
    """
    first = runs[0]
    if len(runs) == 1:
        return first
    spectra = [(one.sequence.bins, one.power) for one in runs]
    together = fit_noise(first.description.noise, *spectra[0], others=spectra[1:])
    description = first.description.with_noise(together.noise)
    noise = replace(together, **_scattered(together, spectra))
    return replace(first, description=description, log_likelihood=log_score(first.sequence, description), noise=noise)


def _scattered(together: NoiseFit, spectra: Sequence[tuple]) -> dict[str, np.ndarray]:
    """Return the information of the mean over the runs, and the covariance from run to run, of the log parameters."""
    theta, count = together.noise.theta(), len(spectra)
    scores = np.array([NoiseSpectra(together.noise, bins).expand(theta, power)[1] for bins, power in spectra])
    prior = np.eye(len(theta)) / PRIOR_LOG_STD**2
    own = np.linalg.inv(together.information + prior)
    sandwich = own @ np.cov(scores.T, ddof=1).reshape(prior.shape) @ own * count
    values, vectors = np.linalg.eigh(count * (sandwich - own))
    between = (vectors * np.maximum(values, 0.0)) @ vectors.T
    return {"information": np.linalg.inv(own + between / count), "between": between}


def not_recurring(first: AxisFit, others: Sequence[AxisFit]) -> Effect | None:
    """Return the effect found in the first run without which further runs are far more likely, or None to keep all.

    Further runs are scored by the values of the first run; without an effect the others stay or are fitted to it anew,
    whichever scores higher.
    """
    score, left_out = _score(first.description, others) + np.log(MIN_ODDS), None
    for entry in recurring(first.description).entries:
        kept = first.description.keeping(lambda one, of=entry: one != of)
        if entry.known or not kept.noise.effects:
            continue
        without = max(_score(one, others) for one in (kept, fit(first.sequence, kept).description))
        if without > score:
            score, left_out = without, entry.effect
    return left_out


def _score(description: Description, runs: Sequence[AxisFit]) -> float:
    """Return the log-density of further runs under the description of the first."""
    return sum(log_score(run.sequence, recurring(description)) for run in runs)

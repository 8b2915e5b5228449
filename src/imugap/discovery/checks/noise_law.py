"""Law of the white noise of an axis, which its spectrum does not show: the samples of a fit made white do."""

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from imugap.discovery.checks.distribution import shows_law
from imugap.discovery.finding import MIN_LOG_P, Finding, Interval
from imugap.discovery.fit.axis_fit import AxisFit
from imugap.discovery.search.intervals import intervals
from imugap.effects.effect import Distribution, Effect
from imugap.numerics.samples.white_samples import WhiteSamples

MIN_SHARE = 0.9
"""Least share of the white noise in the standard deviation of what a fit makes white."""
MIN_SAMPLES = 2000
"""Least number of samples, for the scores of skewness and kurtosis."""


@dataclass(frozen=True, eq=False)
class NoiseLaw:
    """White noise that is not normal, in the place of the normal one of a fit.

    Attributes
    ----------
    fit
        The fit with it.
    index
        Index of the noise among the entries of the description.
    distribution
        How the samples show it.
    kurtosis
        Kurtosis of a sample.
    """

    fit: AxisFit
    index: int
    distribution: Distribution
    kurtosis: float

    def finding(self) -> Finding:
        """Return the noise as a finding; the deviation of its density is that of a variance of such samples."""
        wider = np.sqrt((self.kurtosis - 1) / 2)
        ends = self.distribution.intervals
        parameters = {
            name: replace(one, low=ends[name][0], high=ends[name][1]) if name in ends else _widened(one, wider)
            for name, one in intervals(self.fit, self.index).items()
        }
        axis = self.fit.sequence.conditions.axis
        log_p = max(self.distribution.log_p, MIN_LOG_P)
        return Finding({axis: self.distribution.effect}, parameters, log_p, self.distribution.gain)


def noise_law(fit: AxisFit, kinds: Iterable[type[Effect]], log_alpha: float) -> NoiseLaw | None:
    """Return the white noise of a fit as one of some kinds, where its samples are independent and of such a law."""
    found = _white_samples(fit)
    if found is None:
        return None
    index, samples = found
    white = fit.description.entries[index].effect
    shown = [one for kind in kinds if (one := kind.shown(samples, white.density)) and one.log_p < log_alpha]
    if not shown or samples.dependent:
        return None
    surest = max(shown, key=lambda one: one.gain)
    described = fit.description.with_effect(index, surest.effect)
    return NoiseLaw(replace(fit, description=described), index, surest, samples.kurtosis)


def _white_samples(fit: AxisFit) -> tuple[int, WhiteSamples] | None:
    """Return the index of the white noise of a fit, and its samples, or None where the log does not show its law.

    Behind a filter each sample is of many, and so it is where other noise is much of a sample.
    """
    white = [index for index, entry in enumerate(fit.description.entries) if entry.effect.white]
    values = fit.unrounded[~fit.sequence.flawed]
    if len(white) != 1 or fit.description.noise.output_filter is not None or len(values) < MIN_SAMPLES:
        return None
    std = fit.description.entries[white[0]].effect.density / np.sqrt(fit.sequence.conditions.interval)
    share = 1.0 if fit.cells is not None else std / fit.unit
    return (white[0], WhiteSamples.of(values, share)) if share > MIN_SHARE and shows_law(fit) else None


def _widened(interval: Interval, factor: float) -> Interval:
    """Return an interval whose ends are further off by a factor, in the logarithm."""
    low, high = (interval.value * (end / interval.value) ** factor for end in (interval.low, interval.high))
    return replace(interval, low=float(low), high=float(high))

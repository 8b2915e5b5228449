"""Random part of an axis: sums of spectra, fitted to the cosine coefficients of what the mean leaves.

In the cosine basis (DCT-II) the coefficients of white noise and of a random walk are independent with the variances
S(f_k)/interval, f_k = k/(2 n interval); for other processes this is Whittle's approximation, whose leakage is that of
a sequence without jumps at its ends (:mod:`imugap.estimation.likelihood`).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from math import isfinite

import numpy as np
from numba import njit

from imugap.discovery.preparation.cosine_bins import Bins
from imugap.effects.effect import TINY, FilterEffect, Role, StochasticEffect
from imugap.numerics.fitting.damped_steps import Damping, optimise

DIFFERENCE_STEP = 1e-4
"""Step of a log parameter in a difference quotient."""
MAX_ITERATIONS = 60
DAMPING = Damping(first=1e-3, floor=1e-3, least=1e-9, most=1e9, down=5.0, up=8.0)
MAX_LOG_STEP = 1.5
"""Largest change of a log parameter in one iteration."""
MIN_PREDICTED_GAIN = 1e-5
"""Predicted gain of log-likelihood at which a climb ends."""
MAX_AMPLITUDE_RATIO = 20.0
"""Largest amplitude, over that which alone would make the highest power there is."""
PRIOR_LOG_STD = 1.0
"""Standard deviation of the logarithm of a parameter that the data say nothing of."""
MEDIAN_BINS = 8
"""Bins whose median is what a spectrum is at their place."""
CACHED_SHAPES = 16
"""Number of processes of unit size whose spectra are cached."""
MIN_POWER_SHARE = 1e-7
"""Share of the power, in every bin, below which a process counts as absent."""


@dataclass(frozen=True)
class Noise:
    """The random effects of an axis and the filter behind them.

    Attributes
    ----------
    effects
        Random processes with a sampled spectrum.
    output_filter
        Low-pass filter of the output, or None.
    """

    effects: tuple[StochasticEffect, ...]
    output_filter: FilterEffect | None = None

    def variance(self, bins: Bins) -> np.ndarray:
        """Return the variance of a cosine coefficient in each bin, shape (bins,).

        Rounding comes after a filter. Without one what it adds is a part of the white noise.
        """
        return self.passed(bins) + (0.0 if self.output_filter is None else bins.rounding)

    def passed(self, bins: Bins) -> np.ndarray:
        """Return that variance ahead of the rounding, shape (bins,): S/interval, filtered."""
        total = sum(effect.sampled_psd(bins.frequency, bins.interval) for effect in self.effects) / bins.interval
        if self.output_filter is None:
            return total
        return total * self.output_filter.mean_gain(bins.frequency, bins.width, bins.interval)

    def gain(self, bins: Bins) -> np.ndarray:
        """Return the power gain of the filter at each cosine coefficient k = 1..n-1, unaveraged if rippled."""
        passes = self.output_filter
        if passes is None:
            return np.ones(bins.count - 1)
        if passes.rippled:
            return passes.gain(np.arange(1, bins.count) / (2 * bins.count * bins.interval), bins.interval)
        return bins.spread(passes.gain(bins.frequency, bins.interval))

    def spread(self, bins: Bins) -> np.ndarray:
        """Return the variance of each cosine coefficient k = 1..n-1."""
        if self.output_filter is None or not self.output_filter.rippled:
            return bins.spread(self.variance(bins))
        return bins.spread(Noise(self.effects).variance(bins)) * self.gain(bins) + bins.rounding

    def share(self, index: int, bins: Bins) -> np.ndarray:
        """Return the share of one process in the variance ahead of the rounding, shape (bins,)."""
        return Noise((self.effects[index],), self.output_filter).passed(bins) / self.passed(bins)

    def beneath(self, bins: Bins, power: np.ndarray) -> "Noise":
        """Return the same processes behind the same filter, each as large as it is alone beneath a spectrum.

        Above the cutoff a spectrum says little of what the filter lets through, and is not asked beyond its first bins.
        """
        filtered = self.output_filter
        cutoff = None if filtered is None else filtered.centre
        below = np.sum(bins.frequency < (np.inf if cutoff is None else cutoff))
        asked = np.arange(min(max(below, MEDIAN_BINS), len(bins.frequency)))
        groups = np.array_split(asked, max(len(asked) // MEDIAN_BINS, 1))
        level = power / bins.number
        effects = []
        for effect in self.effects:
            ratio = level / Noise((effect,), filtered).passed(bins)
            size = effect.size()
            factor = np.sqrt(min(np.median(ratio[group]) for group in groups))
            effects.append(replace(effect, **{size: float(getattr(effect, size) * factor)}))
        return replace(self, effects=tuple(effects))

    def __iter__(self):
        """Iterate over all effects, the filter last."""
        return iter(self.effects if self.output_filter is None else (*self.effects, self.output_filter))

    @cached_property
    def parameters(self) -> tuple[tuple[int, str], ...]:
        """(index of the effect, parameter) of all that a fit adjusts.

        A loading of common noise has a sign, and its size is that of the density.
        """
        return tuple((i, name) for i, effect in enumerate(self) for name in effect.free())

    def theta(self) -> np.ndarray:
        """Return the logarithms of the parameters."""
        effects = list(self)
        return np.log([getattr(effects[i], name) for i, name in self.parameters])

    def at(self, theta: np.ndarray) -> "Noise":
        """Return the same effects with log parameters ``theta``."""
        effects = list(self)
        for (i, name), value in zip(self.parameters, np.exp(theta).tolist(), strict=True):
            effects[i] = replace(effects[i], **{name: value})
        if self.output_filter is None:
            return Noise(tuple(effects))
        return Noise(tuple(effects[:-1]), effects[-1])


@dataclass(frozen=True, eq=False)
class NoiseFit:
    """Random effects at the maximum of Whittle's likelihood.

    Attributes
    ----------
    noise
        The effects.
    log_likelihood
        Log-density of the coefficients.
    information
        Expected information of the log parameters, in the order of :attr:`Noise.parameters`.
    gradient
        That of the log-density in the same: zero but for what was held, or is at a limit.
    between
        Covariance of the log parameters from run to run of the device; zero for the fit of one run.
    """

    noise: Noise
    log_likelihood: float
    information: np.ndarray
    gradient: np.ndarray
    between: np.ndarray | float = 0.0

    @property
    def covariance(self) -> np.ndarray:
        """Return the covariance of the log parameters of a run, with the prior deviation :data:`PRIOR_LOG_STD`."""
        own = np.linalg.inv(self.information + np.eye(len(self.information)) / PRIOR_LOG_STD**2)
        return own + self.between


def log_likelihood(variance: np.ndarray, power: np.ndarray, number: np.ndarray) -> float:
    """Return the log-density of coefficients with sums of squares ``power`` and variances ``variance`` per bin."""
    return float(-0.5 * np.sum(number * np.log(2 * np.pi * variance) + power / variance))


def fit(
    start: Noise,
    bins: Bins,
    power: np.ndarray,
    held: bool = False,
    others: Sequence[tuple[Bins, np.ndarray]] = (),
) -> NoiseFit:
    """Climb Whittle's likelihood from ``start`` by damped Fisher scoring.

    Parameters
    ----------
    power
        Sums of the squared cosine coefficients over the bins, shape (bins,).
    held
        Whether the cutoff of the filter stays as it is.
    others
        Bins and power of further sequences of the same noise; the likelihood is that of all together.
    """
    sequences = [(NoiseSpectra(start, of, held), sums) for of, sums in ((bins, power), *others)]
    low, high = limits(start, bins, power)
    if held:
        low[-1] = high[-1] = start.theta()[-1]

    def at(theta: np.ndarray) -> tuple:
        parts = zip(*(spectra.expand(theta, sums) for spectra, sums in sequences), strict=True)
        return theta, *map(sum, parts)

    def propose(path: list[tuple], damping: float) -> tuple | None:
        theta, _, gradient, information = path[-1]
        ends = np.maximum(low - theta, -MAX_LOG_STEP), np.minimum(high - theta, MAX_LOG_STEP)
        trial = theta + damped_step(gradient, information, damping, *ends)
        return None if abs(gradient @ (trial - theta)) < MIN_PREDICTED_GAIN else at(trial)

    first = at(np.clip(start.theta(), low, high))
    path, _ = optimise(first, propose, lambda one, other: one[1] > other[1], DAMPING, MAX_ITERATIONS)
    theta, value, gradient, information = path[-1]
    return NoiseFit(start.at(theta), value, information, gradient)


@njit(cache=True)
def damped_step(gradient, information, damping, low, high):
    """Return the damped step to the top of a quadratic within a box; what leads out of it stays at the end.

    The rest follows. A process much fainter than the others leads far out: a step shortened as a whole would not move
    the others. Where the quadratic is not finite, the step is not a number.
    """
    damped = information + np.diag(damping * (np.diag(information) + 1e-9))
    if not (np.isfinite(damped).all() and np.isfinite(gradient).all()):
        return np.full(len(gradient), np.nan)
    step = np.linalg.solve(damped, gradient)
    beyond = (step < low) | (step > high)
    free = ~beyond
    while beyond.any():
        step = np.where(beyond, np.minimum(np.maximum(step, low), high), step)
        if not free.any():
            break
        left = damped[free]
        step[free] = np.linalg.solve(left[:, free], gradient[free] - left[:, ~free] @ step[~free])
        beyond = free & ((step < low) | (step > high))
        free &= ~beyond
    return step


@dataclass(frozen=True, eq=False)
class _Process:
    """A random effect as a function of its log parameters, of which its size only scales the spectrum.

    ``places`` are those of its parameters in the vector; ``unit`` is its spectrum at unit size, where nothing else
    shapes it.
    """

    effect: StochasticEffect
    names: tuple[str, ...]
    places: tuple[int, ...]
    unit: np.ndarray | None

    def shape(self, theta: np.ndarray, bins: Bins) -> np.ndarray:
        """Return the variance of a coefficient at unit size, shape (bins,)."""
        if self.unit is not None:
            return self.unit
        values = {name: float(np.exp(theta[i])) for name, i in zip(self.names, self.places, strict=True)}
        return _variance(replace(self.effect, **(values | {self.effect.size(): 1.0})), bins)


def _variance(effect: StochasticEffect, bins: Bins) -> np.ndarray:
    """Return the variance that a process alone gives a coefficient in each bin, shape (bins,)."""
    return effect.sampled_psd(bins.frequency, bins.interval) / bins.interval


@lru_cache(maxsize=CACHED_SHAPES)
def _unit_variance(effect: StochasticEffect, bins: Bins) -> np.ndarray:
    """Return the variance in each bin of a process of unit size, shape (bins,), cached for fits of its size alone."""
    shape = _variance(effect, bins)
    shape.flags.writeable = False
    return shape


class NoiseSpectra:
    """Variances of the coefficients and their derivatives as functions of the log parameters."""

    def __init__(self, noise: Noise, bins: Bins, held: bool = False) -> None:
        """Prepare the spectra of ``noise`` at the frequencies of ``bins``; the cutoff of its filter may be ``held``."""
        self.noise, self.bins, self.processes = noise, bins, []
        self.held = self._filter(noise.theta()[-1]) if held else None
        for i, effect in enumerate(noise.effects):
            mine = [(name, j) for j, (index, name) in enumerate(noise.parameters) if index == i]
            names, places = zip(*mine, strict=True)
            unit = _unit_variance(replace(effect, **{effect.size(): 1.0}), bins) if len(names) == 1 else None
            self.processes.append(_Process(effect, names, places, unit))

    def expand(self, theta: np.ndarray, power: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
        """Return log-likelihood, gradient and expected information in the log parameters."""
        total, slopes = np.zeros(len(power)), np.zeros((len(theta), len(power)))
        for process in self.processes:
            self._add(process, theta, total, slopes)
        slopes /= total
        if self.noise.output_filter is not None:
            gain, slopes[-1] = self.held or self._filter(theta[-1])
            passed, total = total * gain, total * gain + self.bins.rounding
            slopes *= passed / total
        gradient = 0.5 * slopes @ (power / total - self.bins.number)
        information = 0.5 * (slopes * self.bins.number) @ slopes.T
        return log_likelihood(total, power, self.bins.number), gradient, information

    def _add(self, process: _Process, theta: np.ndarray, total: np.ndarray, slopes: np.ndarray) -> None:
        """Add the variances of a process and their derivatives in place."""
        factor = np.exp(2 * theta[process.places[process.names.index(process.effect.size())]])
        variance = factor * process.shape(theta, self.bins)
        total += variance
        for name, place in zip(process.names, process.places, strict=True):
            if name == process.effect.size():
                slopes[place] = 2 * variance
                continue
            ends = []
            for side in (-DIFFERENCE_STEP, DIFFERENCE_STEP):
                moved = theta.copy()
                moved[place] += side
                ends.append(process.shape(moved, self.bins))
            slopes[place] = factor * (ends[1] - ends[0]) / (2 * DIFFERENCE_STEP)

    def _filter(self, log_value: float) -> tuple[np.ndarray, np.ndarray]:
        """Return gain of the filter and the derivative of its logarithm in the log of what a fit adjusts."""
        gains = [
            self.noise.output_filter.adjusted_to(float(np.exp(log_value + side))).mean_gain(
                self.bins.frequency, self.bins.width, self.bins.interval
            )
            for side in (-DIFFERENCE_STEP, 0.0, DIFFERENCE_STEP)
        ]
        return gains[1], np.log(gains[2] / gains[0]) / (2 * DIFFERENCE_STEP)


def limits(noise: Noise, bins: Bins, power: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the limits of the log parameters: powers by the power there is, times by the log, cutoffs by the rate.

    What correlates over less than a sampling interval is white noise to the samples, or the work of a filter.
    """
    effects, spans = list(noise), []
    level, duration = power / bins.number, bins.count * bins.interval
    for i, name in noise.parameters:
        effect, (least, most) = effects[i], effects[i].limits()[name]
        if isfinite(most):
            spans.append((least * (1 + 2 * DIFFERENCE_STEP), most * (1 - 2 * DIFFERENCE_STEP)))
        elif effect.role is Role.FILTER:
            spans.append((1e-3 / bins.interval, effect.highest(bins.interval)))
        elif name == effect.size():
            ratio = level / (effect.sampled_psd(bins.frequency, bins.interval) / bins.interval)
            value = getattr(effect, name)
            spans.append(
                (value * np.sqrt(MIN_POWER_SHARE * ratio.min()), value * np.sqrt(ratio.max()) * MAX_AMPLITUDE_RATIO)
            )
        elif effect.units("")[name] == "s":
            spans.append((bins.interval, 30 * duration))
        else:
            spans.append((0.1 / duration, 1 / bins.interval))
    low, high = np.log(np.maximum(spans, TINY)).T
    return low, high

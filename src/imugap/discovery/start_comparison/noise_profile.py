"""Likelihood of the noise of an axis about its maximum, under conditions on its parameters.

Twice the loss of log-likelihood by a condition is chi-square distributed where the condition holds (Wilks 1938). With
it parameters are compared that the log determines badly, such as a correlation time of the length of the log, for
which the information at the maximum says little.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from warnings import catch_warnings, simplefilter

import numpy as np
from scipy.optimize import minimize

from imugap.discovery.fit.axis_fit import AxisFit
from imugap.discovery.fit.whittle import DIFFERENCE_STEP, Noise, NoiseFit, NoiseSpectra, fit, limits
from imugap.discovery.preparation.cosine_bins import Bins
from imugap.discovery.runs.over_runs import fit_over_runs
from imugap.effects.effect import Effect, Role
from imugap.numerics.fitting.profile_likelihood import end

MAX_WALD_ERROR = 0.1
"""Standard deviation of a log parameter below which its likelihood is that of a normal distribution."""
ITERATIONS, TOLERANCE = 100, 1e-6
"""Of a climb: most iterations, and change of the deviance at which it ends."""
FIRST_STEP = 0.1
"""First distance of the search for the end of an interval, in the logarithm."""

BEYOND = 7.0
"""Logarithm by which times and sizes may exceed the largest that a fit takes: a start model may have any."""

LogFunction = Callable[[Effect], float]
"""Logarithm of a function of an effect."""


@dataclass(frozen=True, eq=False)
class NoiseProfile:
    """Noise of one or several runs of a device at its maximum likelihood.

    Attributes
    ----------
    best
        Fit to all runs together.
    runs
        Bins and power of each run.
    scatter
        Covariance of the mean of the log parameters by their differences from run to run.
    """

    best: NoiseFit
    runs: tuple[tuple[Bins, np.ndarray], ...]
    scatter: np.ndarray | float = 0.0

    @classmethod
    def of(cls, fits: Sequence[AxisFit]) -> "NoiseProfile":
        """Return the profile of the fits of an axis, one per run, with the processes of the first."""
        runs = tuple((one.sequence.bins, one.power) for one in fits)
        return cls(_fitted(fits[0].description.noise, runs), runs, fit_over_runs(fits).noise.between / len(runs))

    @property
    def noise(self) -> Noise:
        """The processes at the maximum."""
        return self.best.noise

    def without(self, index: int) -> "NoiseProfile":
        """Return the profile without the process at ``index``."""
        effects = tuple(one for place, one in enumerate(self.noise.effects) if place != index)
        return replace(self, best=_fitted(replace(self.noise, effects=effects), self.runs))

    def holding(self, index: int, values: Mapping[str, float]) -> "_Climb":
        """Return the maximum with some parameters of the effect at ``index`` held, each at a value."""
        low, high = (one.copy() for one in self._limits)
        for place, (of, name) in enumerate(self.noise.parameters):
            if of == index and name in values:
                low[place] = high[place] = np.log(values[name])
        return self._climb(low, high)

    def loss(self, index: int, function: LogFunction, target: float) -> float:
        """Return the deviance, twice the loss of log-likelihood, where ``function`` of an effect is ``target``."""

        def excess(theta: np.ndarray) -> float:
            return function(self._effect(index, theta)) - target

        def slope(theta: np.ndarray) -> np.ndarray:
            return self._gradient(excess, theta)

        climb = self._climb(*self._limits, [{"type": "eq", "fun": excess, "jac": slope}])
        return self._deviance(climb.log_likelihood)

    def deviance(self, climb: "_Climb") -> float:
        """Return twice the loss of log-likelihood of another maximum."""
        return self._deviance(climb.log_likelihood)

    def error(self, index: int, function: LogFunction) -> float:
        """Return the standard deviation of a function of an effect by the information; infinite if it has none."""
        theta = self.noise.theta()
        slope = self._gradient(lambda at: function(self._effect(index, at)), theta)
        information = self.best.information
        values, vectors = np.linalg.eigh(information)
        known = values > 1e-9 * max(values.max(), 1e-300)
        parts = vectors.T @ slope
        if np.any(np.abs(parts[~known]) > 1e-6 * np.linalg.norm(slope)):
            return np.inf
        return float(np.sqrt(np.sum(parts[known] ** 2 / values[known])))

    def excess(self, index: int) -> float:
        """Return the largest factor of the variance of a parameter of an effect by its differences from run to run."""
        if not np.any(self.scatter):
            return 1.0
        own = np.linalg.pinv(self.best.information, rcond=1e-9, hermitian=True)
        mine = [place for place, (of, _) in enumerate(self.noise.parameters) if of == index]
        ratios = [self.scatter[place, place] / own[place, place] for place in mine if own[place, place] > 0]
        return 1.0 + max(ratios, default=0.0)

    def sized(self, index: int, effect: Effect, size: str, deviance: float, none: bool) -> "Size":
        """Return the size of a process whose other parameters are those of ``effect``.

        Its interval is that within a deviance, from zero where ``none`` of the process may be there; the deviance of
        the result is that of the size of ``effect``.
        """
        others = {name: value for name, value in effect.parameters().items() if name in effect.free() and name != size}
        top = self.holding(index, others)
        best = max(top.log_likelihood, self.without(index).best.log_likelihood if none else -np.inf)
        value = float(getattr(list(top.noise)[index], size))

        def loss(at: float) -> float:
            return max(2 * (best - self.holding(index, others | {size: at}).log_likelihood), 0.0)

        far = 3 * BEYOND
        high = value * np.exp(end(lambda out: loss(value * np.exp(out)), deviance, FIRST_STEP, far))
        low = 0.0 if none else value * np.exp(-end(lambda out: loss(value * np.exp(-out)), deviance, FIRST_STEP, far))
        own = getattr(effect, size)
        return Size(value, float(low), float(high), 0.0 if none and own <= value else loss(own))

    def interval(self, index: int, function: LogFunction, deviance: float) -> tuple[float, float]:
        """Return the ends of the interval of a function of an effect within a deviance; infinite where none is."""
        best, error = function(list(self.noise)[index]), self.error(index, function)
        if error < MAX_WALD_ERROR:
            return best - np.sqrt(deviance) * error, best + np.sqrt(deviance) * error
        reach = self._reach(index, function)

        def distance(side: int, limit: float) -> float:
            return end(lambda far: self.loss(index, function, best + side * far), deviance, FIRST_STEP, limit)

        return best - distance(-1, best - reach[0]), best + distance(1, reach[1] - best)

    def at(self, index: int, function: LogFunction, target: float) -> float:
        """Return the deviance at a value of a function of an effect, as :meth:`interval` takes it."""
        best, error = function(list(self.noise)[index]), self.error(index, function)
        if error < MAX_WALD_ERROR:
            return ((target - best) / error) ** 2
        return self.loss(index, function, target)

    def _reach(self, index: int, function: LogFunction) -> tuple[float, float]:
        """Return the range of a function of an effect within the limits of its parameters."""
        low, high = self._limits
        theta, ends = self.noise.theta(), []
        mine = [place for place, (of, _) in enumerate(self.noise.parameters) if of == index]
        for corner in range(2 ** len(mine)):
            at = theta.copy()
            for bit, place in enumerate(mine):
                at[place] = (high if corner >> bit & 1 else low)[place]
            ends.append(function(self._effect(index, at)))
        return min(ends), max(ends)

    def _effect(self, index: int, theta: np.ndarray) -> Effect:
        return list(self.noise.at(theta))[index]

    def _deviance(self, log_likelihood: float) -> float:
        return max(2 * (self.best.log_likelihood - log_likelihood), 0.0)

    @cached_property
    def _limits(self) -> tuple[np.ndarray, np.ndarray]:
        low, high = limits(self.noise, *self.runs[0])
        theta, effects = self.noise.theta(), list(self.noise)
        free = [np.isinf(effects[index].limits()[name][1]) for index, name in self.noise.parameters]
        beyond = np.array([
            BEYOND if unlimited and effects[index].role is not Role.FILTER else 0.0
            for unlimited, (index, _) in zip(free, self.noise.parameters, strict=True)
        ])  # fmt: skip
        return np.minimum(low, theta), np.maximum(high + beyond, theta)

    @cached_property
    def _spectra(self) -> tuple[NoiseSpectra, ...]:
        return tuple(NoiseSpectra(self.noise, bins) for bins, _ in self.runs)

    def _climb(self, low: np.ndarray, high: np.ndarray, conditions: Sequence[dict] = ()) -> "_Climb":
        """Return the maximum within limits, and under conditions, of the log parameters."""
        best = self.best.log_likelihood

        def loss(theta: np.ndarray) -> tuple[float, np.ndarray]:
            parts = [spectra.expand(theta, power) for spectra, (_, power) in zip(self._spectra, self.runs, strict=True)]
            return best - sum(one[0] for one in parts), -sum(one[1] for one in parts)

        first = np.clip(self.noise.theta(), low, high)
        with catch_warnings(), np.errstate(all="ignore"):
            simplefilter("ignore", RuntimeWarning)  # steps out of the limits, which are clipped
            found = minimize(
                loss, first, jac=True, method="SLSQP", bounds=list(zip(low, high, strict=True)),
                constraints=conditions, options={"maxiter": ITERATIONS, "ftol": TOLERANCE},
            )  # fmt: skip
        return _Climb(self.noise.at(found.x), best - float(found.fun))

    @staticmethod
    def _gradient(function: Callable[[np.ndarray], float], theta: np.ndarray) -> np.ndarray:
        steps = DIFFERENCE_STEP * np.eye(len(theta))
        return np.array([function(theta + step) - function(theta - step) for step in steps]) / (2 * DIFFERENCE_STEP)


@dataclass(frozen=True)
class Size:
    """Size of a process with its interval, and the deviance of another size."""

    value: float
    low: float
    high: float
    deviance: float


@dataclass(frozen=True)
class _Climb:
    """Noise at a maximum of the likelihood under conditions."""

    noise: Noise
    log_likelihood: float


def _fitted(noise: Noise, runs: Sequence[tuple[Bins, np.ndarray]]) -> NoiseFit:
    return fit(noise, *runs[0], others=runs[1:])

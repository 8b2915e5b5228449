"""Maximum-likelihood estimates of an error model from a log, with profile-likelihood intervals."""

from collections.abc import Iterable, Iterator, Sequence
from itertools import combinations

import numpy as np
from numba import njit
from scipy.optimize import brentq
from scipy.special import chdtri, ndtr, ndtri

from imugap.effects import GaussMarkov, RateRamp
from imugap.estimation.cramer_rao import fisher
from imugap.estimation.likelihood import Composition, Cosines, Grid, Quantity, constant, density, slope, statistics
from imugap.estimation.result import Fit, Identifiability, ParameterEstimate, identifiability
from imugap.numerics.fitting.profile_likelihood import end
from imugap.numerics.small_matrix import invert

TIMES = {0: 1, 1: 14, 2: 10, 3: 8}
"""Grid points of the correlation time at which the search starts, by number of Gauss-Markov processes."""
UPDATES = 30
"""Multiplicative updates of the densities at each grid point."""
STARTS = 3
"""Number of best grid points from which the likelihood is maximised."""
ITERATIONS = 200
LONGEST_STEP = 2.0
"""Largest change of a log parameter in one iteration."""
FLAT = 1e-6
"""Predicted gain of log-likelihood below which a maximum is reached."""
VANISH = 14.0
"""Distance of a log density below that which alone explains the power of the log, at which a process is absent."""
EXCEED = 7.0
"""Distance of the logarithm above it at which a density is unbounded."""
HIGHER = 0.01
"""Difference of log-likelihood by which another maximum is higher."""
SPACING = 0.3
"""Largest spacing of a log density over which the slope of a ramp is integrated."""
FALL = 8.0
"""Decrease of the log-likelihood at which a profile ends."""
ABSENT = 1e-3
"""Decrease of log-likelihood without a process below which its density is set to zero."""


def fit(
    sequence: np.ndarray,
    interval: float,
    kinds: Sequence[type],
    ramp: bool = False,
    highest: float = np.inf,
    level: float = 0.95,
    share: float = 1.0,
) -> Fit:
    """Fit a sum of processes to an error sequence of unknown mean.

    Parameters
    ----------
    sequence, interval
        Samples, shape (n,), and sampling interval [s].
    kinds
        Types of the processes, e.g. ``(WhiteNoise, GaussMarkov, RandomWalk)``.
    ramp
        Whether the mean may have a ramp. Its slope is then estimated too (generalised least squares); the likelihood
        is that of the contrasts free of it.
    highest
        Highest frequency [Hz] that is used (e.g. below the cutoff of the filter of the device).
    level
        Confidence level of the intervals.
    share
        Share of the samples that were measured; the others are drawn given these.
    """
    problem = LikelihoodProblem(Composition.of(*kinds), Cosines.of(sequence, interval, highest, ramp, share))
    return problem.estimate(problem.maximise(starts=[*problem.starts_without_one_density()])[0], level)


class HigherMaximumError(Exception):
    """A profile found a point of higher likelihood than the maximum from which it started."""

    def __init__(self, theta: np.ndarray) -> None:
        """Keep the point of higher likelihood."""
        super().__init__("a profile found a higher likelihood")
        self.theta = theta


class LikelihoodProblem:
    """Likelihood of a log under one composition, to be maximised and profiled.

    The log may be in independent parts of equal length, each with a mean (and a ramp) of its own. Information counts
    with the share of the samples that were measured.
    """

    def __init__(self, composition: Composition, *parts: Cosines) -> None:
        """Prepare the likelihood of the composition for the statistics of the parts of the log."""
        self.composition, self.parts, self.grid = composition, parts, parts[0].grid
        self.share = parts[0].share
        self.power = sum(part.power for part in parts)
        self.number = len(parts) * self.grid.number
        self.shapes = composition.shapes(self.grid)
        self.low, self.high = self._limits()
        self.arguments = self.low, self.high, self.shapes, *statistics(*parts)
        self.constant = constant(*parts)

    def _limits(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the log parameters at which a process counts as absent or unbounded."""
        grid, power = self.grid, self.power.sum()
        whole = np.log(power / (self.shapes @ self.number)) / 2
        std = np.log(power / self.number.sum()) / 2
        shortest, longest = np.log(grid.interval) - 1, np.log(grid.interval * grid.count) + 5
        low = np.r_[whole - VANISH, [std - VANISH, shortest] * self.composition.markov]
        high = np.r_[whole + EXCEED, [std + EXCEED, longest] * self.composition.markov]
        return low, high

    def __call__(self, theta: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
        """Return log-likelihood, gradient and information, with a quadratic penalty outside the limits."""
        value, gradient, information = _penalised(theta, self.arguments)
        return value + self.constant, gradient, information

    def estimate(self, start: np.ndarray, level: float) -> Fit:
        """Return the fit at the local maximum from ``start``, or at a higher one that a profile finds."""
        best, value, converged = self.local_maximum(start)
        best = self._ordered(best)
        try:
            ends = self.profiles(best, value, chdtri(1, 1 - level) / self.share)
        except HigherMaximumError as found:
            return self.estimate(found.theta, level)
        return self.result(best, value, converged, ends, level)

    def maximise(
        self, times: Iterable[tuple[float, ...]] | None = None, starts: Sequence[np.ndarray] = ()
    ) -> tuple[np.ndarray, float, bool]:
        """Return the highest local maximum from the best of ``times`` and from further ``starts``.

        ``times`` are sets of correlation times [s], one for each Gauss-Markov process: all of a grid if not given.
        """
        maxima = (
            self.local_maximum(start) for start in (*starts, *self.starts(self.times() if times is None else times))
        )
        best, value, converged = max(maxima, key=lambda maximum: maximum[1])
        return self._ordered(best), value, converged

    def times(self) -> Iterable[tuple[float, ...]]:
        """Return all sets of correlation times [s] of a grid, which is coarser for more processes."""
        markov = self.composition.markov
        return combinations(correlation_times(self.grid, TIMES.get(markov, 7)), markov)

    def starts_without_one_density(self) -> Iterator[np.ndarray]:
        """Yield the maximum without each density, where there are others: starts from which the fit is no worse."""
        densities, markov = self.composition.densities, self.composition.markov
        for index in range(len(densities) if len(self.low) > 1 else 0):
            rest = Composition(densities[:index] + densities[index + 1 :], markov)
            yield np.insert(LikelihoodProblem(rest, *self.parts).maximise()[0], index, self.low[index])

    def _ordered(self, theta: np.ndarray) -> np.ndarray:
        """Return the log parameters with the Gauss-Markov processes ordered by correlation time."""
        processes = theta[len(self.shapes) :].reshape(-1, 2)
        return np.r_[theta[: len(self.shapes)], processes[np.argsort(processes[:, 1])].ravel()]

    def starts(self, times: Iterable[tuple[float, ...]]) -> list[np.ndarray]:
        """Return the best start values for given sets of correlation times [s]."""
        grid, split, ranked = self.grid, len(self.shapes), []
        for chosen in times:
            rows = [
                GaussMarkov(1.0, time).sampled_psd(grid.frequency, grid.interval) / grid.interval for time in chosen
            ]
            densities = np.log(
                _densities(np.concatenate([self.shapes, *np.array(rows)[:, None]]), self.power, self.number)
            )
            theta = np.r_[densities[:split], np.c_[densities[split:], np.log(chosen)].ravel()]
            theta = np.clip(theta, self.low, self.high)
            ranked.append((self(theta)[0], theta))
        ranked.sort(key=lambda pair: -pair[0])
        return [theta for _, theta in ranked[:STARTS]]

    def local_maximum(self, theta: np.ndarray, normal: np.ndarray | None = None) -> tuple[np.ndarray, float, bool]:
        """Return the maximum by damped Fisher scoring from ``theta``, its log-likelihood, and whether it converged.

        With ``normal`` the steps stay on the plane normal' theta = constant.
        """
        plane = np.zeros(len(theta)) if normal is None else normal
        best, value, converged = _fisher_scoring(np.asarray(theta, float), plane, self.arguments)
        return best, value + self.constant, converged

    def profiles(self, best: np.ndarray, value: float, target: float) -> list[tuple[float, float]]:
        """Return the limits of the intervals of all quantities (logs), where the profile deviance is ``target``.

        They are infinite where it stays below. A point of higher likelihood raises :class:`HigherMaximumError`.
        """
        information = self(best)[2] + 1e-6 * np.eye(len(best))
        return [
            tuple(
                float(quantity.direction @ best)
                + side * self._distance(best, value, target, quantity, side, information)
                for side in (-1, 1)
            )
            for quantity in self.composition.quantities()
        ]

    def _distance(
        self, best: np.ndarray, value: float, target: float, quantity: Quantity, side: int, information: np.ndarray
    ) -> float:
        """Return the distance from ``best`` at which the deviance is ``target`` on one side; infinity if nowhere."""
        normal, theta = quantity.direction, best
        along = np.linalg.solve(information, normal)
        along, error = along / (normal @ along), np.sqrt(normal @ along)

        def deviance(distance: float) -> float:
            nonlocal theta
            ahead = (side * distance - normal @ (theta - best)) * along
            if np.abs(ahead).max() > 2 * LONGEST_STEP:  # nearly flat: the quadratic approximation gives no direction
                ahead = (normal @ ahead) * normal / (normal @ normal)
            theta, height, _ = self.local_maximum(theta + ahead, normal)
            if height > value + HIGHER:
                raise HigherMaximumError(theta)
            return 2 * (value - height)

        first = min(np.sqrt(target) * error, LONGEST_STEP)
        return end(deviance, target, first, self._reach(best, quantity, side))

    def _reach(self, best: np.ndarray, quantity: Quantity, side: int) -> float:
        """Return the distance from the best value of a quantity to its limit; a derived quantity has that of a std."""
        single = np.flatnonzero(quantity.direction)
        if len(single) > 1:
            return 2 * (VANISH if side < 0 else EXCEED)
        limit = (self.low if side < 0 else self.high)[single[0]]
        return max(side * (limit - best[single[0]]), 0.0)

    def result(
        self, best: np.ndarray, value: float, converged: bool, ends: list[tuple[float, float]], level: float
    ) -> Fit:
        """Return the fit; a process without which the likelihood is no lower gets density zero."""
        ramp = self.parts[0].ramp
        information = self.share * fisher(best, self.shapes, self.grid, ramp)
        covariance = np.linalg.inv(information + 1e-12 * np.eye(len(best)))
        absent = np.array([self._absent(best, value, index) for index in range(len(best))])
        estimates = []
        for quantity, (low, high) in zip(self.composition.quantities(), ends, strict=True):
            direction = quantity.direction
            zero = bool((absent & (direction > 0)).any())
            limits = np.exp(quantity.offset + np.array([-np.inf if zero else low, high]))
            middle = 0.0 if zero else float(np.exp(quantity.offset + direction @ best))
            error = float(np.sqrt(direction @ covariance @ direction))
            estimates.append(
                ParameterEstimate(*quantity.key, middle, *limits.tolist(), error, identifiability(*limits))
            )
        model = self.composition.model(np.where(absent, -np.inf, best))
        if ramp:
            estimates.append(self.slope(best, covariance, level))
            model += RateRamp(estimates[-1].value)
        return Fit(model, tuple(estimates), value, converged)

    def slope(self, best: np.ndarray, covariance: np.ndarray, level: float) -> ParameterEstimate:
        """Return the slope of the ramp, with an interval that includes the uncertainty of the model.

        Given the model, the slope is normal about its generalised least squares. The contribution of a weak process to
        its variance is poorly known, in particular where the estimated density is zero. The interval is therefore that
        of a mixture over the densities of a process, the widest over the processes.
        """
        first = len(self.shapes)
        sizes = [*range(first), *range(first, len(best), 2)]
        mixtures = [self._slopes(best, index, np.sqrt(covariance[index, index])) for index in sizes]
        low = min(quantile((1 - level) / 2, *mixture) for mixture in mixtures)
        high = max(quantile((1 + level) / 2, *mixture) for mixture in mixtures)
        value, variance = self._slope(best)
        known = Identifiability.IDENTIFIED if low * high > 0 else Identifiability.UPPER_BOUND
        return ParameterEstimate(
            RateRamp.name, 1, "slope", value, low, high, float(np.sqrt(variance) / abs(value)), known
        )

    def _slope(self, theta: np.ndarray) -> tuple[float, float]:
        """Return the slope of the ramp and its variance under the model."""
        value, variance = slope(theta, self.shapes, self.parts[0])
        return value, variance / self.share

    def _slopes(self, best: np.ndarray, index: int, error: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return weights, means and deviations of the slope along the profile of the density (or std) ``index``.

        The weights are the likelihood times a prior that is flat in the standard deviation that the process adds to
        the slope: for a random walk, in its density (Gelman 2006, Bayesian Analysis 1, 515-533). ``error`` is that of
        the log density.
        """
        below, above = (self._profile_points(best, index, side * min(SPACING, error / 1.5)) for side in (-1, 1))
        points = [*reversed(below), best, *above]
        heights = self.share * np.array([self(point)[0] for point in points])
        means, variances = np.array([self._slope(point) for point in points]).T
        without = self._slope(self._without(best, index))[1]
        added, deviations = np.sqrt(np.maximum(variances - without, 0.0)), np.sqrt(variances)
        prior = np.abs(np.gradient(added)) + 1e-9 * deviations  # not zero for a process that adds nothing
        weights = prior * np.exp(heights - heights.max())
        return weights / weights.sum(), means, deviations

    def _profile_points(self, best: np.ndarray, index: int, step: float) -> list[np.ndarray]:
        """Return the points of the profile at steps of log parameter ``index`` from ``best``, to a decrease of FALL."""
        normal, lowest, points = np.eye(len(best))[index], self(best)[0] - FALL, [best]
        end = self.low[index] if step < 0 else self.high[index]
        for _ in range(int(max((end - best[index]) / step, 0.0))):
            theta, height, _ = self.local_maximum(points[-1] + step * normal, normal)
            points.append(theta)
            if height < lowest:
                break
        return points[1:]

    def _without(self, best: np.ndarray, index: int) -> np.ndarray:
        """Return the point with log parameter ``index`` at its lower limit."""
        without = best.copy()
        without[index] = self.low[index]
        return without

    def _absent(self, best: np.ndarray, value: float, index: int) -> bool:
        """Return whether the fit is as good without the process of density ``index``; false for a correlation time."""
        first = len(self.shapes)
        if index >= first and (index - first) % 2:
            return False
        return bool(self(self._without(best, index))[0] > value - ABSENT)


def correlation_times(grid: Grid, number: int) -> np.ndarray:
    """Return start values [s], shape (number,), from half an interval, nearly white, to a third of the log."""
    return np.geomspace(grid.interval / 2, grid.count * grid.interval / 3, number)


def quantile(probability: float, weights: np.ndarray, means: np.ndarray, deviations: np.ndarray) -> float:
    """Return the quantile of a mixture of normal deviates; all shapes (points,), the weights sum to one."""
    reach = means + ndtri(probability) * deviations
    return brentq(lambda x: weights @ ndtr((x - means) / deviations) - probability, reach.min(), reach.max())


@njit(cache=True)
def _densities(basis, power, number):
    """Return the densities of the rows of ``basis`` [power of a coefficient] after multiplicative updates.

    The updates raise Whittle's likelihood, whose terms are Itakura-Saito distances (Fevotte, Bertin, Durrieu 2009,
    Neural Computation 21, 793-830).
    """
    rows, bins = basis.shape
    weights, whole = np.zeros(rows), 0.0
    for m in range(bins):
        whole += power[m]
        for i in range(rows):
            weights[i] += basis[i, m] * number[m]
    for i in range(rows):
        weights[i] = whole / weights[i]
    for _ in range(UPDATES):
        seen, expected = np.zeros(rows), np.zeros(rows)
        for m in range(bins):
            total = 0.0
            for i in range(rows):
                total += weights[i] * basis[i, m]
            for i in range(rows):
                seen[i] += basis[i, m] * power[m] / total**2
                expected[i] += basis[i, m] * number[m] / total
        for i in range(rows):
            weights[i] *= np.sqrt(seen[i] / expected[i])
    return np.sqrt(weights)


@njit(cache=True)
def _penalised(theta, arguments):
    value, gradient, information = density(theta, *arguments[2:])
    for k in range(len(theta)):
        outside = theta[k] - min(max(theta[k], arguments[0][k]), arguments[1][k])
        value -= outside**2 / 2
        gradient[k] -= outside
        information[k, k] += outside != 0
    return value, gradient, information


@njit(cache=True)
def _fisher_scoring(theta, normal, arguments):
    value, gradient, information = _penalised(theta, arguments)
    damping = 1e-3
    for _ in range(ITERATIONS):
        step, ahead, bend = _step(gradient, information, damping, normal)
        if ahead < FLAT:
            return theta, value, True
        trial, slopes, curvature = _penalised(theta + step, arguments)
        share = (trial - value) / (ahead - bend / 2)
        if share > 0:
            theta, value, gradient, information = theta + step, trial, slopes, curvature
        if share > 0.5:
            damping = max(damping / 2, 1e-4)
        elif share < 0.25:
            damping *= 3
    return theta, value, False


@njit(cache=True)
def _step(gradient, information, damping, normal):
    """Return the damped scoring step, its gain by slope, and its curvature.

    It is on the plane of ``normal`` if that is not zero; no component exceeds LONGEST_STEP.
    """
    size = len(gradient)
    scale, matrix = np.empty(size), np.empty((size, size))
    for i in range(size):
        scale[i] = np.sqrt(information[i, i] + 1e-3)
    for i in range(size):
        for j in range(size):
            matrix[i, j] = information[i, j] / (scale[i] * scale[j]) if i != j else 1 + damping
    inverse, _ = invert(matrix)
    step, across, off, norm = np.zeros(size), np.zeros(size), 0.0, 0.0
    for i in range(size):
        for j in range(size):
            step[i] += inverse[i, j] * gradient[j] / (scale[i] * scale[j])
            across[i] += inverse[i, j] * normal[j] / (scale[i] * scale[j])
        off, norm = off + normal[i] * step[i], norm + normal[i] * across[i]
    longest = LONGEST_STEP
    for i in range(size):
        step[i] -= across[i] * off / norm if norm > 0 else 0.0
        longest = max(longest, abs(step[i]))
    ahead, bend = 0.0, 0.0
    for i in range(size):
        step[i] *= LONGEST_STEP / longest
        ahead += gradient[i] * step[i]
    for i in range(size):
        for j in range(size):
            bend += step[i] * information[i, j] * step[j]
    return step, ahead, bend

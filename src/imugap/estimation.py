"""Maximum-likelihood estimates of an error model from a log, with intervals and a verdict on what the log can tell."""

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from enum import StrEnum
from itertools import combinations

import numpy as np
import pandas as pd
from scipy.stats import chi2

from imugap.bound import fisher
from imugap.effects import GaussMarkov
from imugap.likelihood import Composition, Cosines, Quantity, value_and_gradient
from imugap.model import AxisModel

Objective = Callable[[np.ndarray], tuple[float, np.ndarray, np.ndarray]]

TIMES = {0: 1, 1: 12, 2: 9, 3: 8}
"""Grid points of the correlation time at which the search starts, by number of Gauss-Markov processes."""
UPDATES = 30
"""Multiplicative updates of the densities at each grid point."""
CLIMBS = 3
"""Best grid points from which the likelihood is climbed."""
ITERATIONS = 200
LONGEST_STEP = 2.0
"""Largest change of a log parameter in one iteration."""
FLAT = 1e-6
"""Predicted gain of log-likelihood at which a climb ends."""
VANISH = 14.0
"""Log distance below the density that would explain the whole log at which a process counts as absent."""
EXCEED = 7.0
"""Log distance above it at which a density counts as unbounded."""
ABSENT = 1e-3
"""Loss of log-likelihood below which leaving out a process is no loss."""


class Verdict(StrEnum):
    """What an interval says."""

    IDENTIFIED = "identified"
    UPPER_BOUND = "upper bound"
    """Zero is within the interval: the log does not show that the process exists, only that it is no larger.

    The upper end keeps the level of two sides, so that the bound errs on the safe side.
    """
    LOWER_BOUND = "lower bound"
    """Infinity is within the interval, as of a correlation time that the log is too short to see the end of."""
    UNDETERMINED = "undetermined"


@dataclass(frozen=True)
class Estimate:
    """A parameter with its profile-likelihood interval; SI.

    Attributes
    ----------
    effect, ordinal, parameter
        Name of the effect, its ordinal among its kind, name of the parameter.
    value, low, high
        Maximum-likelihood estimate and interval; ``low`` is 0 and ``high`` infinite where the log sets no limit.
    error
        Relative standard deviation from the expected information at the estimate.
    verdict
        What the interval says.
    """

    effect: str
    ordinal: int
    parameter: str
    value: float
    low: float
    high: float
    error: float
    verdict: Verdict


@dataclass(frozen=True)
class Fit:
    """A fitted model.

    Attributes
    ----------
    model
        The estimates as a model; a process that the log does not need has density zero.
    estimates
        One for each parameter, and for the driving PSD of each Gauss-Markov process (ordered by correlation time).
    log_likelihood
        Of the contrasts free of the mean (:mod:`imugap.likelihood`).
    converged
        Whether the gradient vanishes at the estimate.
    """

    model: AxisModel
    estimates: tuple[Estimate, ...]
    log_likelihood: float
    converged: bool

    def table(self) -> pd.DataFrame:
        """Return the estimates, index ``effect``, ``ordinal``, ``parameter``."""
        return pd.DataFrame(map(asdict, self.estimates)).set_index(["effect", "ordinal", "parameter"])


def fit(
    sequence: np.ndarray,
    interval: float,
    kinds: Sequence[type],
    ramp: bool = False,
    highest: float = np.inf,
    level: float = 0.95,
) -> Fit:
    """Fit a sum of processes to an error sequence of unknown mean.

    Parameters
    ----------
    sequence, interval
        Samples, shape (n,), and sampling interval [s].
    kinds
        Types of the processes, e.g. ``(WhiteNoise, GaussMarkov, RandomWalk)``.
    ramp
        Whether the mean may have a ramp.
    highest
        Frequency [Hz] above which the log is left out of account (e.g. the filter of the device).
    level
        Confidence level of the intervals.
    """
    problem = Problem(Composition.of(*kinds), Cosines.of(sequence, interval, highest, ramp))
    best, value, converged = problem.maximise()
    target = np.sqrt(chi2.ppf(level, 1))
    ends, beyond = problem.profiles(best, value, target)
    while beyond is not None:  # a profile found a higher hill
        best, value, converged = problem.climb(beyond)
        ends, beyond = problem.profiles(best, value, target)
    return problem.result(best, value, converged, ends)


class Problem:
    """The likelihood of one log under one composition, ready to be climbed and profiled."""

    def __init__(self, composition: Composition, cosines: Cosines) -> None:
        """Take the processes and the statistics of the log."""
        self.composition, self.cosines = composition, cosines
        self.shapes = composition.shapes(cosines.grid)
        self.low, self.high = self._limits()

    def _limits(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the log parameters at which a process counts as absent or unbounded."""
        grid, power = self.cosines.grid, self.cosines.power.sum()
        whole = np.log(power / (self.shapes @ grid.number)) / 2
        std = np.log(power / grid.number.sum()) / 2
        shortest, longest = np.log(grid.interval) - 1, np.log(grid.interval * grid.count) + 5
        low = np.r_[whole - VANISH, [std - VANISH, shortest] * self.composition.markov]
        high = np.r_[whole + EXCEED, [std + EXCEED, longest] * self.composition.markov]
        return low, high

    def __call__(self, theta: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
        """Return log-likelihood, gradient and information, with a parabolic wall outside the limits."""
        value, gradient, information = value_and_gradient(theta, self.shapes, self.cosines)
        outside = theta - np.clip(theta, self.low, self.high)
        return value - outside @ outside / 2, gradient - outside, information + np.diag((outside != 0) * 1.0)

    def maximise(self) -> tuple[np.ndarray, float, bool]:
        """Return the highest of the hills that start at the best grid points."""
        best, value, converged = max((self.climb(start) for start in self.starts()), key=lambda hill: hill[1])
        return self._ordered(best), value, converged

    def _ordered(self, theta: np.ndarray) -> np.ndarray:
        """Return the same point with the Gauss-Markov processes ordered by correlation time."""
        processes = theta[len(self.shapes) :].reshape(-1, 2)
        return np.r_[theta[: len(self.shapes)], processes[np.argsort(processes[:, 1])].ravel()]

    def starts(self) -> list[np.ndarray]:
        """Return the best start values: densities by multiplicative updates on a grid of correlation times.

        The updates raise Whittle's likelihood, whose terms are Itakura-Saito distances (Fevotte, Bertin, Durrieu
        2009, Neural Computation 21, 793-830).
        """
        grid, markov = self.cosines.grid, self.composition.markov
        times = np.geomspace(2 * grid.interval, grid.count * grid.interval / 3, TIMES.get(markov, 7))
        ranked = []
        for chosen in combinations(times, markov):
            rows = [GaussMarkov(1.0, time).sampled_psd(grid.frequency, grid.interval) for time in chosen]
            basis = np.concatenate([self.shapes, np.reshape(rows, (markov, len(grid.index))) / grid.interval])
            weights = self.cosines.power.sum() / (basis @ grid.number)
            for _ in range(UPDATES):
                total = weights @ basis
                weights *= np.sqrt(basis @ (self.cosines.power / total**2) / (basis @ (grid.number / total)))
            densities = np.log(weights) / 2
            split = len(self.shapes)
            theta = np.r_[densities[:split], np.c_[densities[split:], np.log(chosen)].ravel()]
            theta = np.clip(theta, self.low, self.high)
            ranked.append((self(theta)[0], theta))
        ranked.sort(key=lambda pair: -pair[0])
        return [theta for _, theta in ranked[:CLIMBS]]

    def climb(self, theta: np.ndarray, normal: np.ndarray | None = None) -> tuple[np.ndarray, float, bool]:
        """Return the top that damped scoring steps reach, its height, and whether it is one.

        With ``normal`` the climb stays on the plane normal' theta = constant.
        """
        value, gradient, information = self(theta)
        damping = 1e-3
        for _ in range(ITERATIONS):
            step = _step(gradient, information, damping, normal)
            if gradient @ step < FLAT:
                return theta, value, True
            trial = self(theta + step)
            share = (trial[0] - value) / (gradient @ step - step @ information @ step / 2)
            if share > 0:
                theta, (value, gradient, information) = theta + step, trial
            if share > 0.5:
                damping = max(damping / 2, 1e-4)
            elif share < 0.25:
                damping *= 3
        return theta, value, False

    def profiles(
        self, best: np.ndarray, value: float, target: float
    ) -> tuple[list[tuple[float, float]], np.ndarray | None]:
        """Return the ends of the intervals of all quantities (logs), or the first point found that lies higher."""
        information = self(best)[2] + 1e-6 * np.eye(len(best))
        ends = []
        for quantity in self.composition.quantities():
            pair = []
            for side in (-1, 1):
                end, beyond = self._end(best, value, target, quantity, side, information)
                if beyond is not None:
                    return [], beyond
                pair.append(end)
            ends.append(tuple(pair))
        return ends, None

    def _end(
        self, best: np.ndarray, value: float, target: float, quantity: Quantity, side: int, information: np.ndarray
    ) -> tuple[float, np.ndarray | None]:
        """Return where the root of the deviance reaches ``target`` on one side (by secants), infinity if nowhere.

        The root of the deviance is nearly linear in the log of a parameter.
        """
        normal = quantity.direction
        along = np.linalg.solve(information, normal)
        along, error = along / (normal @ along), np.sqrt(normal @ along)
        limit = self._reach(best, quantity, side)
        inner, outer, theta = (0.0, 0.0), None, best
        distance = min(target * error, LONGEST_STEP, limit)
        for _ in range(30):
            ahead = (side * distance - normal @ (theta - best)) * along
            if np.abs(ahead).max() > 2 * LONGEST_STEP:  # nearly flat: the parabola says nothing about the way
                ahead = (normal @ ahead) * normal / (normal @ normal)
            theta, height, _ = self.climb(theta + ahead, normal)
            if height > value + 0.01:
                return 0.0, theta
            root = np.sqrt(max(2 * (value - height), 0.0))
            if abs(root - target) < 1e-3 * target:
                break
            if root > target:
                outer = (distance, root)
            elif distance >= limit:
                return side * np.inf, None
            else:
                inner = (distance, root)
            distance = _next(inner, outer, target, limit)
        return float(normal @ best) + side * distance, None

    def _reach(self, best: np.ndarray, quantity: Quantity, side: int) -> float:
        """Return the distance from the best value of a quantity to its limit; a derived quantity has that of a std."""
        single = np.flatnonzero(quantity.direction)
        if len(single) > 1:
            return 2 * (VANISH if side < 0 else EXCEED)
        limit = (self.low if side < 0 else self.high)[single[0]]
        return max(side * (limit - best[single[0]]), 0.0)

    def result(self, best: np.ndarray, value: float, converged: bool, ends: list[tuple[float, float]]) -> Fit:
        """Return the estimates with verdicts; a process without which the likelihood is no lower gets density zero."""
        covariance = np.linalg.inv(
            fisher(best, self.shapes, self.cosines.grid, self.cosines.ramp) + 1e-12 * np.eye(len(best))
        )
        absent = np.array([self._absent(best, value, index) for index in range(len(best))])
        estimates = []
        for quantity, (low, high) in zip(self.composition.quantities(), ends, strict=True):
            direction = quantity.direction
            zero = bool((absent & (direction > 0)).any())
            limits = np.exp(quantity.offset + np.array([-np.inf if zero else low, high]))
            middle = 0.0 if zero else float(np.exp(quantity.offset + direction @ best))
            error = float(np.sqrt(direction @ covariance @ direction))
            estimates.append(Estimate(*quantity.key, middle, *limits.tolist(), error, _verdict(*limits)))
        theta = np.where(absent, -np.inf, best)
        return Fit(self.composition.model(theta), tuple(estimates), value, converged)

    def _absent(self, best: np.ndarray, value: float, index: int) -> bool:
        """Return whether leaving out the process with density ``index`` is no loss (never for a correlation time)."""
        first = len(self.shapes)
        if index >= first and (index - first) % 2:
            return False
        without = best.copy()
        without[index] = self.low[index]
        return bool(self(without)[0] > value - ABSENT)


def _step(gradient: np.ndarray, information: np.ndarray, damping: float, normal: np.ndarray | None) -> np.ndarray:
    """Return the damped scoring step, on the plane of ``normal``, no component longer than LONGEST_STEP."""
    scale = np.sqrt(np.diag(information) + 1e-3)
    matrix = information / np.outer(scale, scale)
    matrix[np.diag_indices_from(matrix)] = 1 + damping
    sides = gradient if normal is None else np.c_[gradient, normal]
    solution = (np.linalg.solve(matrix, (sides.T / scale).T).T / scale).T
    if normal is not None:
        step, across = solution.T
        solution = step - across * (normal @ step) / (normal @ across)
    return solution * min(1.0, LONGEST_STEP / max(np.abs(solution).max(), 1e-300))


def _next(inner: tuple[float, float], outer: tuple[float, float] | None, target: float, limit: float) -> float:
    """Return the next distance to try: linear in the root between two points, else outwards, up to the limit."""
    if outer is not None:
        share = (target - inner[1]) / (outer[1] - inner[1])
        return inner[0] + np.clip(share, 0.05, 0.95) * (outer[0] - inner[0])
    ahead = inner[0] * (target / max(inner[1], 1e-3) - 1)
    return min(inner[0] + np.clip(1.1 * ahead, 0.05, LONGEST_STEP), limit)


def _verdict(low: float, high: float) -> Verdict:
    if low > 0:
        return Verdict.IDENTIFIED if np.isfinite(high) else Verdict.LOWER_BOUND
    return Verdict.UPPER_BOUND if np.isfinite(high) else Verdict.UNDETERMINED

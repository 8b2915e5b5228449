"""Model selection: the composition of effects of a log, and the compositions that the data do not separate from it.

Candidates are sums of :data:`TERMS`, each once, Gauss-Markov processes up to three times. Two rules decide.

Criterion
    Log-likelihood of the contrasts free of the mean, less a :func:`penalty` for every parameter: a term is kept if its
    likelihood ratio exceeds that of an absent term by chance, so that the true composition gets a wrong term with a
    probability of at most 1 - level.
Held-out score
    The log is divided into :data:`FOLDS` blocks. Each is scored by the log-density of its contrasts, its own mean
    unknown, under the parameters (and the slope) fitted to the others. A composition is rejected if one with no more
    parameters predicts better by odds of 1 to (1 - level): it then fits a feature of one part of the log. The true
    density is rejected with a probability of at most 1 - level (Markov's inequality).

The search starts with white noise alone and follows every move (:data:`MOVES`: additions, omissions) that raises the
criterion. The selection is the composition of the highest criterion that is not rejected. Its alternatives are the
other compositions that are not rejected, whose held-out score is not significantly lower, that no move improves, of
which neither is part of the other, and that a likelihood test does not distinguish.
"""

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, fields
from itertools import combinations

import numpy as np
import pandas as pd
from scipy.special import chdtri

from imugap.effects import BiasInstability, GaussMarkov, Quantization, RandomWalk, RateRamp, WhiteNoise
from imugap.estimation.likelihood import Composition, Cosines, slope, slope_density, value_and_gradient
from imugap.estimation.maximum_likelihood import LikelihoodProblem, correlation_times
from imugap.estimation.result import Fit

Kinds = tuple[type, ...]
"""The effects of a composition, in the order of :data:`TERMS`."""

TERMS: Kinds = (Quantization, WhiteNoise, BiasInstability, RandomWalk, GaussMarkov, RateRamp)
MOST = Counter({kind: 3 if kind is GaussMarkov else 1 for kind in TERMS})
"""Largest number of each term in a composition."""
FOLDS = 6
SHORTEST = 256
"""Fewest samples of a log."""
NONE, MARKOV, WHITE = Counter(), Counter([GaussMarkov]), Counter([WhiteNoise])
MOVES = (
    *((Counter([kind]), NONE) for kind in TERMS),
    *((NONE, Counter([kind])) for kind in TERMS),
    (MARKOV, WHITE),
    (WHITE, MARKOV),
)
"""Terms that a move adds and removes; white noise is a Gauss-Markov process of correlation time zero."""
TIMES = 12
"""Grid points of the correlation time at which a new Gauss-Markov process starts."""


@dataclass(frozen=True)
class Choice:
    """Selected composition of a log.

    Attributes
    ----------
    kinds, fit
        Selected kinds of effects and their estimates with intervals.
    candidates
        All fitted compositions, best criterion first: index ``composition``; columns ``parameters`` (their number),
        ``log_likelihood``, ``criterion``, ``held_out`` (score), ``held_out_error`` (standard error of its difference
        to that of the selection), ``overfits`` (rejected by the held-out score), ``alternative`` (not separated from
        the selection).
    alternatives
        Compositions that the data do not separate from the selection, best criterion first.
    """

    kinds: Kinds
    fit: Fit
    candidates: pd.DataFrame
    alternatives: tuple[Kinds, ...]


def title(kinds: Kinds) -> str:
    """Return the names of the effects of a composition, e.g. ``white_noise + gauss_markov``."""
    return " + ".join(kind.name for kind in kinds)


def penalty(level: float) -> float:
    """Return the penalty of one parameter: half the likelihood ratio that a superfluous one reaches.

    The ratio is twice the gain of log-likelihood. For a parameter that cannot be negative and is zero it is zero half
    the time, else chi-square (Self and Liang 1987, JASA 82, 605-610). The limit is exceeded with the probability
    p = (1 - level)/5, as there are five kinds of terms to add.

    - Densities are such parameters. A walk that only the lowest coefficients show stays below that limit.
    - A Gauss-Markov process has two. It contains white noise (T = 0) and a random walk (1/T = 0), to each of which it
      adds one such parameter. Added to both, its T is not identified where the process is absent: the ratio is the
      maximum over log T of squares of a process with correlation sech(d/2) at distance d (Lorentzians beside white
      noise). Its upcrossings bound the probability (Davies 1987, Biometrika 74, 33-43) to exceed the limit x for two
      by the chi-square one + log(n)/(4 pi) exp(-x/2), which is below p for any n within reach.
    - A slope is taken as a deviate with a variance (:func:`imugap.estimation.likelihood.slope_density`). Beside white
      noise its ratio stays below the limit; beside the least favourable random walk, the one that takes over from white
      noise at about the fourth coefficient (K duration = 25 N), it exceeds 5.1 once in a hundred times by simulation,
      and the limit is 5.4 there.
    """
    p = (1 - level) / (len(TERMS) - 1)
    return float(chdtri(1, 2 * p)) / 2


def joint_level(level: float, axes: int) -> float:
    """Return the confidence level of the decisions on one axis, of which those on all axes together have ``level``."""
    return 1 - (1 - level) / axes


def choose(
    sequence: np.ndarray,
    interval: float,
    highest: float = np.inf,
    level: float = 0.95,
    share: float = 1.0,
    terms: Kinds = TERMS,
    axes: int = 1,
) -> Choice:
    """Select the effects of an error sequence of unknown mean.

    Parameters
    ----------
    sequence, interval
        Samples, shape (n,), evenly spaced by the sampling interval [s].
    highest
        Highest frequency [Hz] that is used (e.g. below the cutoff of the filter of the device).
    level
        Confidence level of the intervals, and of the decisions on all axes together.
    share
        Share of the samples that were measured; the others are drawn given these.
    terms
        Kinds of effects to select from, of :data:`TERMS`.
    axes
        Number of axes for which effects are selected, this one included (Bonferroni's inequality).
    """
    if len(sequence) < SHORTEST:
        raise ValueError(f"choice: expected at least {SHORTEST} samples; found {len(sequence)}")
    search = _Search(np.asarray(sequence, float), interval, highest, joint_level(level, axes), share, terms)
    search.search()
    return search.select(level)


@dataclass(frozen=True, eq=False)
class _Fitted:
    """Maximum of the likelihood of a composition."""

    kinds: Kinds
    problem: LikelihoodProblem
    theta: np.ndarray
    likelihood: float
    criterion: float


class _Search:
    """Fitted compositions of one log."""

    def __init__(
        self, sequence: np.ndarray, interval: float, highest: float, level: float, share: float, terms: Kinds
    ) -> None:
        self.terms, self.level, self.share, self.penalty = terms, level, share, penalty(level) / share
        self.whole = [Cosines.of(sequence, interval, highest, ramp, share) for ramp in (False, True)]
        blocks = sequence[: len(sequence) // FOLDS * FOLDS].reshape(FOLDS, -1)
        self.blocks = [
            [Cosines.of(block, interval, highest, ramp, share) for block in blocks] for ramp in (False, True)
        ]
        self.fits: dict[Kinds, _Fitted] = {}

    def search(self) -> None:
        """Fit white noise alone, all compositions that moves which raise the criterion reach, and their neighbours."""
        queue: list[Kinds] = [(WhiteNoise,)]
        self._fit(queue[0])
        for here in queue:
            for there in _neighbours(here, self.terms):
                self._fit_from(there, here)
                if self.fits[there].criterion > self.fits[here].criterion and there not in queue:
                    queue.append(there)
        for here in sorted(self.fits, key=len):  # from maxima that were found later
            for there in filter(self.fits.get, _neighbours(here)):
                self._fit_from(there, here)

    def _fit_from(self, kinds: Kinds, origin: Kinds) -> None:
        """Fit ``kinds`` from the maximum of its neighbour ``origin``, unless its known maximum is no lower."""
        known, start = self.fits.get(kinds), self.fits[origin]
        if known is None or (len(kinds) > len(origin) and known.likelihood < start.likelihood):
            self._fit(kinds, start)

    def _fit(self, kinds: Kinds, origin: _Fitted | None = None) -> None:
        ramp = RateRamp in kinds
        problem = LikelihoodProblem(Composition.of(*_stochastic(kinds)), self.whole[ramp])
        if origin is None:
            theta, value, _ = problem.maximise()
        else:
            theta, value, _ = problem.maximise(_times(problem, origin), _extended(problem, origin))
        if ramp:
            value += slope_density(*slope(theta, problem.shapes, *problem.parts), problem.grid)
        self.fits[kinds] = _Fitted(kinds, problem, theta, value, value - self.penalty * parameters(kinds))

    def _scores(self, fitted: _Fitted) -> np.ndarray:
        """Return the log-density of each block, shape (FOLDS,), under the parameters fitted to the others."""
        ramp, scores = RateRamp in fitted.kinds, []
        blocks = self.blocks[ramp]
        for k, block in enumerate(blocks):
            problem = LikelihoodProblem(fitted.problem.composition, *blocks[:k], *blocks[k + 1 :])
            theta = problem.local_maximum(fitted.theta)[0]
            if ramp:
                block = block.less(_common_slope(theta, problem))
            scores.append(value_and_gradient(theta, problem.shapes, block)[0])
        return np.array(scores)

    def select(self, level: float) -> Choice:
        """Return the selection by the criterion and the held-out score, with intervals of a confidence level."""
        fits = sorted(self.fits.values(), key=lambda fitted: -fitted.criterion)
        scores = np.array([self._scores(fitted) for fitted in fits])
        number = np.array([parameters(fitted.kinds) for fitted in fits])
        total = scores.sum(axis=1)
        worse_than = total - total[:, None] > -np.log(1 - self.level) / self.share
        rejected = (worse_than & (number <= number[:, None])).any(axis=1)
        best = int(np.flatnonzero(~rejected)[0])
        chosen = fits[best]
        candidate = [self._is_local_best(fitted) and self._is_alternative(fitted, chosen) for fitted in fits]
        alternative = np.array(candidate) & ~rejected & ~worse_than[:, best]
        alternative[best] = False
        columns = {
            "parameters": number,
            "log_likelihood": [fitted.likelihood for fitted in fits],
            "criterion": [fitted.criterion for fitted in fits],
            "held_out": total,
            "held_out_error": np.sqrt(FOLDS) * np.std(scores - scores[best], axis=1, ddof=1),
            "overfits": rejected,
            "alternative": alternative,
        }
        index = pd.Index([title(fitted.kinds) for fitted in fits], name="composition")
        alternatives = tuple(fitted.kinds for fitted, is_one in zip(fits, alternative, strict=True) if is_one)
        fit = chosen.problem.estimate(chosen.theta, level)
        return Choice(chosen.kinds, fit, pd.DataFrame(columns, index=index), alternatives)

    def _is_local_best(self, fitted: _Fitted) -> bool:
        """Return whether no move raises the criterion of a composition."""
        near = (self.fits.get(kinds) for kinds in _neighbours(fitted.kinds, self.terms))
        return all(other is not None and other.criterion <= fitted.criterion for other in near)

    def _is_alternative(self, fitted: _Fitted, chosen: _Fitted) -> bool:
        """Return whether neither composition is part of the other, and their union fits no better.

        The union is at least as likely as the selection.
        """
        here, there = Counter(fitted.kinds), Counter(chosen.kinds)
        needed = chosen.likelihood - fitted.likelihood > self.penalty * parameters(tuple((there - here).elements()))
        return not (here <= there or there <= here or needed)


def parameters(kinds: Kinds) -> int:
    """Return the number of parameters of a composition."""
    return sum(len(fields(kind)) for kind in kinds)


def _stochastic(kinds: Kinds) -> Kinds:
    return tuple(kind for kind in kinds if kind is not RateRamp)


def _neighbours(kinds: Kinds, terms: Kinds = TERMS) -> Iterator[Kinds]:
    """Yield the compositions of ``terms`` that one move reaches, with at least one random process each."""
    here = Counter(kinds)
    for gain, loss in MOVES:
        there = here + gain - loss
        if loss <= here and there <= MOST and there.keys() - {RateRamp} and there.keys() <= {*terms}:
            yield tuple(sorted(there.elements(), key=TERMS.index))


def _times(problem: LikelihoodProblem, origin: _Fitted) -> list[tuple[float, ...]]:
    """Return the correlation times [s] of a neighbour, with one more of a grid or with one less."""
    markov, known = problem.composition.markov, tuple(np.exp(origin.theta[len(origin.problem.shapes) + 1 :: 2]))
    if len(known) < markov:
        return [(*known, time) for time in correlation_times(problem.grid, TIMES)]
    return list(combinations(known, markov))


def _extended(problem: LikelihoodProblem, origin: _Fitted) -> list[np.ndarray]:
    """Return the parameters of a neighbour with the new terms at their lower limits, if it has all other terms."""
    old = origin.problem.composition.densities
    if not set(old) <= set(problem.composition.densities) or len(origin.theta) > len(problem.low):
        return []
    kept = dict(zip(old, origin.theta, strict=False))
    densities = [kept.get(kind, low) for kind, low in zip(problem.composition.densities, problem.low, strict=False)]
    markov = origin.theta[len(old) :]
    return [np.r_[densities, markov, problem.low[len(densities) + len(markov) :]]]


def _common_slope(theta: np.ndarray, problem: LikelihoodProblem) -> float:
    """Return the weighted mean of the slopes of all parts [unit/s]."""
    values, variances = np.transpose([slope(theta, problem.shapes, part) for part in problem.parts])
    return float(np.average(values, weights=1 / variances))

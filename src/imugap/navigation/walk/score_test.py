"""Score test for sensor errors that several walks share, by blocks of innovations.

The innovations of a filter with given weights are linear in a small sensor error of size x: ``e = e0 - J x``. The
weights are those of the original log. Weights of the log without a part of the error would differ, and turn the
innovations themselves into slopes. A block of normalised innovations gives the score ``J' e0`` and the information
``J' J`` of each candidate error; both add over blocks and walks. Since zero velocity observes little, known positions
are measurements too, from cameras or from a return to the start
(:class:`imugap.navigation.walk.pedestrian.PositionAiding`).

A filter does not model the motion of a foot at stance exactly, so the innovations are neither white nor of the expected
size. Each walk is weighted by the scatter of its own innovations. Blocks of several strides are nearly independent:
their scatter gives the intervals (Liang and Zeger 1986), by the jackknife, since a return to the start is one block
that outweighs the others (MacKinnon and White 1985). Random signs of the blocks give the p-value of each candidate
(wild cluster bootstrap of Cameron, Gelbach and Miller 2008), adjusted for all candidates together (least p-value of
Westfall and Young 1993). Of the significant candidates the one with the largest likelihood is named.

Only one error is named: on simulated walks, once the hidden error is compensated, the next one to be named is an effect
of the gait that looks like a small sensor error.

The angular rate of a standing body is left out: there an error proportional to the input is proportional to its noise,
and a smaller scale factor would always look more likely.

Sources: K.-Y. Liang, S. L. Zeger, Longitudinal data analysis using generalized linear models, Biometrika 73 (1986)
13-22; J. G. MacKinnon, H. White, Some heteroskedasticity-consistent covariance matrix estimators with improved finite
sample properties, J. Econometrics 29 (1985) 305-325; A. C. Cameron, J. B. Gelbach, D. L. Miller, Bootstrap-based
improvements for inference with clustered errors, Rev. Econ. Stat. 90 (2008) 414-427; P. H. Westfall, S. S. Young,
Resampling-Based Multiple Testing, 1993.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
from scipy.special import stdtrit

from imugap.filters.error_state import NAVIGATION
from imugap.filters.zero_velocity import STANCE
from imugap.model import ErrorModel
from imugap.navigation.walk.pedestrian import PositionAiding, WalkAssumptions, align, innovations
from imugap.navigation.walk.stance_innovations import INDISTINGUISHABLE, CandidateError

BLOCK_S = 5.0
"""Length of a block [s]: several strides."""
SIGN_DRAWS = 9999
"""Number of draws of the signs."""
ROUNDING = 1e-9
"""Relative difference up to which two deviates are equal."""


@dataclass(frozen=True, eq=False)
class BlockScores:
    """Scores of candidate errors by blocks of innovations.

    Attributes
    ----------
    score
        ``J' e0``, shape (blocks, candidates).
    information
        ``J' J``, shape (blocks, candidates).
    """

    score: np.ndarray
    information: np.ndarray

    def __add__(self, other: "BlockScores") -> "BlockScores":
        """Return the blocks of both."""
        pairs = (self.score, other.score), (self.information, other.information)
        return BlockScores(*(np.concatenate(pair) for pair in pairs))

    def of(self, candidates: Sequence[int]) -> "BlockScores":
        """Return the scores of some of the candidates, by number."""
        return BlockScores(self.score[:, list(candidates)], self.information[:, list(candidates)])

    @property
    def gain(self) -> np.ndarray:
        """Twice the log-likelihood gain of each candidate, shape (candidates,)."""
        return self.score.sum(axis=0) ** 2 / self.information.sum(axis=0)

    def sizes(self, signs: np.ndarray | None = None) -> tuple[np.ndarray, np.ndarray]:
        """Return the size of each candidate alone, and its standard deviation by the jackknife over the blocks.

        A block that outweighs the others draws the size to itself, and would show no scatter about it: each block is
        compared with the size that the others give.

        Parameters
        ----------
        signs
            Signs of the scores, shape (draws, blocks), for results of shape (draws, candidates); None for the original
            scores and results of shape (candidates,).
        """
        signs = np.ones(len(self.score)) if signs is None else signs
        pairs = zip(self.score.T, self.information.T, strict=True)
        size, std = zip(*(_jackknife(signs * score, information) for score, information in pairs), strict=True)
        return np.stack(size, axis=-1), np.stack(std, axis=-1)

    def p_values(self, rng: np.random.Generator) -> np.ndarray:
        """Return the p-value of each candidate, adjusted for all candidates, shape (candidates,)."""
        size, std = self.sizes()
        drawn = np.divide(*self.sizes(rng.choice([-1.0, 1.0], size=(SIGN_DRAWS, len(self.score)))))
        together = np.abs(np.vstack([(1 - ROUNDING) * size / std, drawn]))
        ranks = np.argsort(np.argsort(together, axis=0), axis=0)
        return 1 - np.searchsorted(np.sort(ranks.max(axis=1)), ranks[0]) / len(ranks)


def _jackknife(score: np.ndarray, information: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the size by scores, shape (..., blocks), and information, shape (blocks,), and its standard deviation."""
    total, count = information.sum(), len(information)
    others = np.maximum(total - information, np.finfo(float).tiny)
    gathered = score.sum(axis=-1, keepdims=True)
    apart = score - information / others * (gathered - score)
    scatter = np.maximum((apart**2).sum(axis=-1), np.finfo(float).tiny)
    return gathered[..., 0] / total, np.sqrt(scatter * max(count - 1, 1) / count) / total


@dataclass(frozen=True)
class NamedError:
    """Number of a candidate, with its size, standard deviation and 95 % interval in the unit of its parameter."""

    number: int
    value: float
    std: float
    low: float
    high: float


@dataclass(frozen=True)
class ScoreTest:
    """Result of the score test.

    Attributes
    ----------
    named
        The most likely candidate, then those that are indistinguishable from it; none if none is significant.
    most_significant
        Number of the candidate with the least p-value, or of the named one.
    p_value
        Its p-value, adjusted for all candidates.
    """

    named: tuple[NamedError, ...]
    most_significant: int
    p_value: float


def block_scores(
    log: pd.DataFrame, aiding: PositionAiding, candidates: Sequence[CandidateError], model: ErrorModel,
    assumptions: WalkAssumptions | None = None,
) -> BlockScores:  # fmt: skip
    """Return the scores of the candidates by the blocks of a walk.

    Parameters
    ----------
    aiding
        Known positions of the device.
    model, assumptions
        Error model and assumptions of the filter.
    """
    aligned = align(log, model, assumptions, aiding=aiding)
    plain, variance = innovations(aligned)
    known, std, stance = np.isfinite(plain), np.sqrt(variance), aligned.phase == STANCE
    known[~stance, : NAVIGATION - 3] = False
    columns = []
    for one in candidates:
        if one.velocity is None:
            shifted, _ = innovations(aligned.with_samples(log - (one.model.simulate(log, 0) - log)))
        else:
            shifted, _ = innovations(aligned.with_samples(log, one.small * np.outer(stance, one.velocity)))
        columns.append(((plain - shifted) / std)[known] / one.small)
    first = (plain / std)[known]
    slopes, square = np.column_stack(columns), np.mean(first**2)
    block = ((log.index.to_numpy() - log.index[0]) // BLOCK_S).astype(int)[np.nonzero(known)[0]]
    parts = [(slopes[block == number], first[block == number]) for number in np.unique(block)]
    score, information = [slope.T @ one for slope, one in parts], [(slope**2).sum(axis=0) for slope, _ in parts]
    return BlockScores(np.array(score) / square, np.array(information) / square)


def score_test(
    scores: BlockScores, alpha: float, rng: np.random.Generator, among: Sequence[int] | None = None
) -> ScoreTest:
    """Test the candidates, and name the most likely of the significant ones.

    Candidates are indistinguishable if their log-likelihoods differ by at most
    :data:`imugap.navigation.walk.stance_innovations.INDISTINGUISHABLE`, in units of the scatter of the blocks.

    Parameters
    ----------
    alpha
        Probability of naming any candidate without a hidden error.
    among
        Numbers of the candidates to test; None for all.
    """
    among = range(scores.score.shape[1]) if among is None else among
    tested = scores.of(among)
    (size, std), p_values = tested.sizes(), tested.p_values(rng)
    gain = np.where(p_values < alpha, tested.gain, -np.inf)
    best = int(np.argmax(gain))
    if p_values[best] >= alpha:
        most_significant = int(np.argmin(p_values))
        return ScoreTest((), among[most_significant], float(p_values[most_significant]))
    scatter = std[best] ** 2 * tested.information[:, best].sum()
    tied = np.flatnonzero(gain > gain[best] - 2 * INDISTINGUISHABLE * scatter)
    half = stdtrit(len(tested.score) - 1, 0.975) * std
    named = [
        NamedError(
            among[one], float(size[one]), float(std[one]), float(size[one] - half[one]), float(size[one] + half[one])
        )
        for one in sorted(tied, key=lambda number: -gain[number])
    ]
    return ScoreTest(tuple(named), among[best], float(p_values[best]))

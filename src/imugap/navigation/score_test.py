"""What walks say together of an error that all of them would have, block by block.

The innovations of a filter are linear in a small error of the sensors: ``e = e0 - J x`` with x its size. A block of
them, each over its standard deviation, gives the score ``J' e0`` and the information ``J' J`` of each suspect, and sums
over blocks and walks give what all of them say. Zero velocity alone leaves much unseen; so where cameras saw the foot,
or it came back to where it began, that is measured too (:class:`imugap.navigation.pedestrian.PositionAiding`).

No filter knows how a foot moves at stance, and so its innovations are neither white nor as large as it takes them for.
A walk counts as its own innovations scatter. Blocks of several strides know little of one another: their scatter gives
the intervals (Liang and Zeger 1986). Signs drawn for the blocks give the chance that any suspect is as sure where none
is there (the wild cluster bootstrap of Cameron, Gelbach and Miller 2008, and the least of all chances of Westfall and
Young 1993): it is one of all suspects together. Of those beyond chance the likelihood tells which.

One name is given and no second: what a filter does not know of a gait looks like a small error of a device, and on
simulated walks, once the hidden effect is out, that is what would be named next.

The angular rate of a body that stands is left out: an error in proportion to the input is in proportion to its noise
there, and a smaller scale would always look likelier.

Sources: K.-Y. Liang, S. L. Zeger, Longitudinal data analysis using generalized linear models, Biometrika 73 (1986)
13-22; A. C. Cameron, J. B. Gelbach, D. L. Miller, Bootstrap-based improvements for inference with clustered errors,
Rev. Econ. Stat. 90 (2008) 414-427; P. H. Westfall, S. S. Young, Resampling-Based Multiple Testing, 1993.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
from scipy.special import stdtrit

from imugap.filters.error_state import NAVIGATION
from imugap.filters.zero_velocity import STANCE
from imugap.model import ErrorModel
from imugap.navigation.pedestrian import PositionAiding, WalkAssumptions, WalkSolution, innovations
from imugap.navigation.stance_innovations import ALIKE, Suspect

BLOCK_S = 5.0
"""Length of a block [s]: several strides."""
DRAWN = 9999
"""Draws of the signs."""
ROUNDING = 1e-9
"""Relative difference up to which two deviates are one."""


@dataclass(frozen=True, eq=False)
class Testimony:
    """What blocks of innovations say of suspects.

    Attributes
    ----------
    score
        ``J' e0``, shape (blocks, suspects).
    information
        ``J' J``, shape (blocks, suspects).
    """

    score: np.ndarray
    information: np.ndarray

    def __add__(self, other: "Testimony") -> "Testimony":
        """Return what both say."""
        pairs = (self.score, other.score), (self.information, other.information)
        return Testimony(*(np.concatenate(pair) for pair in pairs))

    def of(self, suspects: Sequence[int]) -> "Testimony":
        """Return what is said of some of the suspects, by their numbers."""
        return Testimony(self.score[:, list(suspects)], self.information[:, list(suspects)])

    @property
    def gain(self) -> np.ndarray:
        """Twice the gain of log-likelihood by each suspect, shape (suspects,)."""
        return self.score.sum(axis=0) ** 2 / self.information.sum(axis=0)

    def sizes(self, signs: np.ndarray | None = None) -> tuple[np.ndarray, np.ndarray]:
        """Return the size of each suspect on its own and its standard deviation from the scatter of the blocks.

        Parameters
        ----------
        signs
            Signs of the scores, shape (draws, blocks): the results have the shape (draws, suspects). None for those
            that they have, and the shape (suspects,).
        """
        signs = np.ones(len(self.score)) if signs is None else signs
        total = self.information.sum(axis=0)
        size = signs @ self.score / total
        left = (self.score**2).sum(axis=0) - 2 * size * (signs @ (self.score * self.information))
        left = np.maximum(left + size**2 * (self.information**2).sum(axis=0), np.finfo(float).tiny)
        return size, np.sqrt(left * len(self.score) / max(len(self.score) - 1, 1)) / total

    def chances(self, rng: np.random.Generator) -> np.ndarray:
        """Return for each suspect the chance that any is as sure where none is there, shape (suspects,)."""
        size, std = self.sizes()
        drawn = np.divide(*self.sizes(rng.choice([-1.0, 1.0], size=(DRAWN, len(self.score)))))
        together = np.abs(np.vstack([(1 - ROUNDING) * size / std, drawn]))
        ranks = np.argsort(np.argsort(together, axis=0), axis=0)
        return 1 - np.searchsorted(np.sort(ranks.max(axis=1)), ranks[0]) / len(ranks)


@dataclass(frozen=True)
class Named:
    """A suspect by its number, with its size, standard deviation and 95 % interval in the unit of its parameter."""

    number: int
    value: float
    std: float
    low: float
    high: float


@dataclass(frozen=True)
class Verdict:
    """What walks lack.

    Attributes
    ----------
    named
        The likeliest suspect, then those that nobody can tell from it; none where nothing is beyond chance.
    surest
        Number of the suspect that is named or, where none is, of the surest.
    p_value
        Chance that any suspect is as sure as that one, where none is there.
    """

    named: tuple[Named, ...]
    surest: int
    p_value: float


def heard(
    log: pd.DataFrame, solution: WalkSolution, sight: PositionAiding, suspects: Sequence[Suspect], model: ErrorModel,
    assumptions: WalkAssumptions | None = None,
) -> Testimony:  # fmt: skip
    """Return what a walk says of the suspects.

    Parameters
    ----------
    solution
        Of the filter on the log as it is: stance is told from it, for all suspects alike.
    sight
        What is known of where the device was.
    model, assumptions
        As of the solution.
    """

    def residuals(of: pd.DataFrame, velocity: np.ndarray | None = None) -> tuple[np.ndarray, np.ndarray]:
        return innovations(of, model, assumptions, velocity, sight, solution.phase)

    plain, variance = residuals(log)
    known, std = np.isfinite(plain), np.sqrt(variance)
    known[solution.phase != STANCE, : NAVIGATION - 3] = False
    columns = []
    for one in suspects:
        if one.velocity is None:
            spared, _ = residuals(log - (one.model.simulate(log, 0) - log))
        else:
            spared, _ = residuals(log, one.small * np.outer(solution.phase == STANCE, one.velocity))
        columns.append(((plain - spared) / std)[known] / one.small)
    first = (plain / std)[known]
    slopes, square = np.column_stack(columns), np.mean(first**2)
    block = ((log.index.to_numpy() - log.index[0]) // BLOCK_S).astype(int)[np.nonzero(known)[0]]
    parts = [(slopes[block == number], first[block == number]) for number in np.unique(block)]
    score, information = [slope.T @ one for slope, one in parts], [(slope**2).sum(axis=0) for slope, _ in parts]
    return Testimony(np.array(score) / square, np.array(information) / square)


def judge(testimony: Testimony, alpha: float, rng: np.random.Generator, among: Sequence[int] | None = None) -> Verdict:
    """Name, of the suspects that are sure beyond chance, the likeliest.

    Those are not told from it whose log-likelihoods are within :data:`imugap.navigation.stance_innovations.ALIKE` of
    its own, in units of the scatter of the blocks.

    Parameters
    ----------
    alpha
        Chance with which any suspect may be named where none is there.
    among
        Numbers of those that are suspected at all; None for all.
    """
    among = range(testimony.score.shape[1]) if among is None else among
    asked = testimony.of(among)
    (size, std), chance = asked.sizes(), asked.chances(rng)
    gain = np.where(chance < alpha, asked.gain, -np.inf)
    best = int(np.argmax(gain))
    if chance[best] >= alpha:
        surest = int(np.argmin(chance))
        return Verdict((), among[surest], float(chance[surest]))
    scatter = std[best] ** 2 * asked.information[:, best].sum()
    alike = np.flatnonzero(gain > gain[best] - 2 * ALIKE * scatter)
    half = stdtrit(len(asked.score) - 1, 0.975) * std
    named = [
        Named(among[one], float(size[one]), float(std[one]), float(size[one] - half[one]), float(size[one] + half[one]))
        for one in sorted(alike, key=lambda number: -gain[number])
    ]
    return Verdict(tuple(named), among[best], float(chance[best]))

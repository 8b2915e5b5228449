"""Continuous models of the tutorial, each from the readings of one Allan curve (Farrell et al. 2022, eqs. 22-38).

Every model has a state space; its Allan deviation follows from its spectrum (eq. 16), and samples from its exact
discretisation.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import floor, log10

import numpy as np
import pandas as pd

from imugap.effects import GaussMarkov, RandomWalk, WhiteNoise
from imugap.effects.bias_instability import FLOOR
from imugap.effects.effect import AxisModel
from imugap.effects.gauss_markov import FLAT_TOP
from imugap.estimation.variances import allan
from imugap.estimation.variances.allan_slopes import PEAK_RATIO
from imugap.interchange import flicker_bank

KNOWN = 0.25
"""Largest relative standard deviation (eq. 15) of points among which the floor is looked for."""


def white_and_walk(white: float, walk: float, tau: float) -> float:
    """Return the Allan deviation of N and K together (eq. 30)."""
    return float(np.sqrt((WhiteNoise(white) + RandomWalk(walk)).allan_variance(tau)))


def left(floor: float, white: float, walk: float, tau: float) -> float:
    """Return the Allan deviation of the floor without N and K; 0 if they exceed it."""
    return float(np.sqrt(max(floor**2 - white_and_walk(white, walk, tau) ** 2, 0.0)))


@dataclass(frozen=True)
class Readings:
    """Readings of an Allan curve in the tutorial.

    Attributes
    ----------
    white
        N of the tangent of slope -1/2; where the slope holds nowhere, of the line that touches the curve from below.
    walk
        K of the tangent of slope +1/2; where the slope holds nowhere, of the line that touches the curve from below
        beyond its floor, if the curve is known to rise there (its lower limit passes the floor), else 0.
    floor, place
        Lowest Allan deviation and its averaging time [s].
    shortest, longest
        Range of averaging times of the curve [s].
    """

    white: float
    walk: float
    floor: float
    place: float
    shortest: float
    longest: float

    @classmethod
    def of(cls, asd: pd.DataFrame) -> "Readings":
        """Read a curve of :func:`imugap.estimation.variances.allan.curve`."""
        white, walk = (allan.tangent(asd, allan.LAWS[symbol]) for symbol in ("N", "K"))
        known = asd[asd["error"] < KNOWN]
        place = known["deviation"].idxmin()
        lowest, beyond = float(known["deviation"][place]), known.loc[place:]
        touching = (beyond["deviation"] / allan.LAWS["K"].deviation(1.0, beyond.index)).min()
        rises = bool((beyond["low"] > lowest).any())
        density_k = walk.value if walk.holds else float(touching) * rises
        return cls(white.value, density_k, lowest, float(place), *asd.index[[0, -1]].astype(float))

    @property
    def left(self) -> float:
        """Return the Allan deviation of the floor without N and K."""
        return left(self.floor, self.white, self.walk, self.place)


def n(of: Readings) -> AxisModel:
    """Return white noise (eq. 22): no state."""
    return AxisModel((WhiteNoise(of.white),))


def k(of: Readings) -> AxisModel:
    """Return a random walk (eqs. 24-25): one integrating state."""
    return AxisModel((RandomWalk(of.walk),))


def nk(of: Readings) -> AxisModel:
    """Return white noise + random walk (eqs. 28-30)."""
    return n(of) + k(of)


def gm(of: Readings) -> AxisModel:
    """Return the Gauss-Markov process whose flat top is the floor (eqs. 33-38)."""
    return AxisModel((GaussMarkov(of.floor / PEAK_RATIO, of.place / FLAT_TOP),))


def nbk(of: Readings) -> AxisModel:
    """Return N + B + K with one Gauss-Markov state that has the whole floor, as in the tutorial."""
    return nk(of) + gm(of)


def nbk_freed(of: Readings) -> AxisModel:
    """Return N + B + K with one Gauss-Markov state that has the floor without N and K."""
    return nk(of) + GaussMarkov(of.left / PEAK_RATIO, of.place / FLAT_TOP)


def nbk_bank(of: Readings) -> AxisModel:
    """Return N + B + K with a bank of states for flicker noise that has the floor without N and K."""
    return nk(of) + bank_alone(of)


def bank_alone(of: Readings) -> AxisModel:
    """Return the flicker bank alone: one state for each whole decade of the curve."""
    states = max(floor(log10(of.longest / of.shortest)), 1)
    return flicker_bank.bank(of.left / FLOOR, of.shortest, of.longest, states)


MODELS: dict[str, Callable[[Readings], AxisModel]] = {
    builder.__name__: builder for builder in (n, k, nk, gm, nbk, nbk_freed, nbk_bank)
}
COMPOSED = ("nk", "nbk", "nbk_freed", "nbk_bank")
"""The models of more than one process."""
TITLES = {
    "n": "N",
    "k": "K",
    "nk": "N + K",
    "gm": "GM",
    "nbk": "N + B + K, as read",
    "nbk_freed": "N + B + K, freed",
    "nbk_bank": "N + bank + K",
}

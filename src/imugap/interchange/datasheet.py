"""Error models from the figures of a data sheet (Farrell et al. 2022)."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from imugap.effects import BiasInstability, GaussMarkov, RandomWalk, TurnOnBias, WhiteNoise
from imugap.effects.bias_instability import FLOOR
from imugap.effects.effect import AxisModel
from imugap.effects.gauss_markov import FLAT_TOP


class Slow(StrEnum):
    """Slow process of a model."""

    WALK = "K"
    GAUSS_MARKOV = "B"
    """Bias instability as one Gauss-Markov state."""
    FLICKER = "flicker"
    """Bias instability as flicker noise, which has no state space of finite order."""


@dataclass(frozen=True)
class DataSheet:
    """Figures of one sensor; SI, ``u`` its unit.

    Attributes
    ----------
    white, flicker, walk
        N [u/sqrt(Hz)], B [u], K [u/s/sqrt(Hz)].
    correlation_time
        T_B [s], at which the peak of a Gauss-Markov process is at the averaging time of the floor.
    turn_on
        Standard deviation of the bias from power-on to power-on [u].
    """

    white: float
    flicker: float
    correlation_time: float
    walk: float
    turn_on: float

    def gauss_markov(self) -> GaussMarkov:
        """Return the process whose Allan deviation peaks at the floor 0.664 B (eqs. 32, 37 and 38)."""
        unit = GaussMarkov(1.0, self.correlation_time)
        top = np.sqrt(unit.allan_variance(FLAT_TOP * self.correlation_time))
        return GaussMarkov(float(FLOOR * self.flicker / top), self.correlation_time)

    def model(self, slow: Collection[Slow]) -> AxisModel:
        """Return turn-on bias and white noise with the processes ``slow``."""
        known = {
            Slow.WALK: RandomWalk(self.walk),
            Slow.GAUSS_MARKOV: self.gauss_markov(),
            Slow.FLICKER: BiasInstability(self.flicker),
        }
        chosen = (effect for process, effect in known.items() if process in slow)
        return AxisModel((TurnOnBias(self.turn_on), WhiteNoise(self.white), *chosen))


MODELS: Mapping[str, tuple[Slow, ...]] = {
    "N": (),
    "N + K": (Slow.WALK,),
    "N + B": (Slow.GAUSS_MARKOV,),
    "N + B + K": (Slow.GAUSS_MARKOV, Slow.WALK),
}
"""Models of a filter by their titles; each also has a turn-on bias."""

TRUTHS: Mapping[str, tuple[Slow, ...]] = {
    "gauss_markov": (Slow.GAUSS_MARKOV, Slow.WALK),
    "flicker": (Slow.FLICKER, Slow.WALK),
}
"""True processes of the sensors: the largest model itself, or the flicker noise that it approximates."""

"""What a data sheet says of a sensor, and the error models that can be made from it (Farrell et al. 2022)."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from imugap.effects import BiasInstability, GaussMarkov, RandomWalk, TurnOnBias, WhiteNoise
from imugap.effects.bias_instability import FLOOR
from imugap.effects.effect import AxisModel
from imugap.effects.gauss_markov import FLAT_TOP


class Slow(StrEnum):
    """A slow process of a model."""

    WALK = "K"
    GAUSS_MARKOV = "B"
    """Bias instability as one Gauss-Markov state."""
    FLICKER = "flicker"
    """Bias instability as it is: no filter of finite order holds it."""


@dataclass(frozen=True)
class DataSheet:
    """The figures of one sensor; SI, ``u`` its unit.

    Attributes
    ----------
    white, flicker, walk
        N [u/sqrt(Hz)], B [u], K [u/s/sqrt(Hz)].
    correlation_time
        T_B [s], which puts the flat top of a Gauss-Markov process at the averaging time of the floor.
    turn_on
        Standard deviation of the bias from power-on to power-on [u].
    """

    white: float
    flicker: float
    correlation_time: float
    walk: float
    turn_on: float

    def gauss_markov(self) -> GaussMarkov:
        """Return the process whose Allan deviation has its flat top at the floor 0.664 B (eqs. 32, 37 and 38)."""
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
"""The models that a filter may take, by the title that pages show; a turn-on bias is in each."""

TRUTHS: Mapping[str, tuple[Slow, ...]] = {
    "gauss_markov": (Slow.GAUSS_MARKOV, Slow.WALK),
    "flicker": (Slow.FLICKER, Slow.WALK),
}
"""What the sensors really do: the largest model itself, or the flicker noise that it stands for."""

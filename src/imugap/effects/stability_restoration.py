"""Statistical restoration (He et al. 2023)."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from imugap.effects.conditions import Conditions
from imugap.effects.effect import TINY, Effect, Stage, parameter
from imugap.numerics.samples.bias_stability import bias_stability


@dataclass(frozen=True)
class StabilityRestoration(Effect):
    """Scaling of the error about its mean to a prescribed bias stability (He et al. 2023, eqs. 16-18)."""

    name: ClassVar[str] = "stability_restoration"
    stage: ClassVar[Stage] = Stage.SEQUENCE
    stability: float = parameter("{u}", "bias stability that the sequence is given")
    period: float = parameter("s", "averaging period of the bias stability", low=TINY)

    def apply(self, sequence: np.ndarray, conditions: Conditions, rng: np.random.Generator) -> np.ndarray:
        """Return Q Bs/Bs_real + mean (1 - Bs/Bs_real) (eq. 18)."""
        real = bias_stability(sequence, conditions.interval, self.period)
        if real == 0:
            raise ValueError("stability_restoration: expected an error that varies; found a constant one")
        ratio = self.stability / real
        return ratio * sequence + (1 - ratio) * sequence.mean()

"""Resolution of the output word."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from imugap.effects.effect import TINY, Conditions, Effect, Evidence, Stage, parameter
from imugap.grain import decimal, spacing

FORMAT = 0.05
"""Step of decimal numbers, in standard deviations of the noise, below which it is that of the file."""
FINE = 0.005
"""Step, in standard deviations of the noise, below which any lattice is of no account."""
BLOCK = 64
"""Samples over which noise is told from what drifts."""


@dataclass(frozen=True)
class Resolution(Effect):
    """Output rounded to a lattice of values (least significant bit of the output word)."""

    name: ClassVar[str] = "resolution"
    stage: ClassVar[Stage] = Stage.WORD
    step: float = parameter("{u}", "distance of neighbouring output values", low=TINY)

    def apply(self, sequence: np.ndarray, conditions: Conditions, rng: np.random.Generator) -> np.ndarray:
        """Round to the nearest multiple of the step."""
        return np.rint(sequence / self.step) * self.step

    @classmethod
    def found(cls, values: np.ndarray, conditions: Conditions) -> Evidence | None:
        """Return the lattice of the output ``values``, shape (n,), NaN where lost, or None.

        Samples keep their place on the lattice and none is flawed: whoever looks at them afterwards has to expect the
        variance step^2/12 in white noise, and less kurtosis than that of a normal law, of a step that is not small.
        """
        known = np.isfinite(values)
        step, error = spacing(values[known])
        level = noise(values, conditions)
        if not step or step < FINE * level or (decimal(step) and step < FORMAT * level):
            return None
        returns = np.count_nonzero(np.diff(values[known])) + 1 - len(np.unique(values[known]))
        log_p = -float(returns) * np.log(step / max(error, np.spacing(step)))
        return Evidence(cls(step), {"step": (step - error, step + error)}, min(log_p, 0.0), np.zeros(len(values), bool))


def noise(values: np.ndarray, conditions: Conditions) -> float:
    """Return the standard deviation of the noise of an output, NaN where lost: the median of that of short blocks."""
    values = values - conditions.error_free
    values = values[np.isfinite(values)]
    blocks = max(len(values) // BLOCK, 1)
    return float(np.median([block.std() for block in np.array_split(values, blocks)]))

"""Low-pass filter of the output."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from scipy.signal import butter, sosfilt, sosfilt_zi

from imugap.effects.effect import TINY, Conditions, Effect, Stage, Start, parameter

if TYPE_CHECKING:
    from imugap.discovery.axis import AxisFit

DEFICIT = -2.5
"""Standard deviations by which the power near half the rate is too low where a search tries a filter."""
ORDERS = (1, 2, 3, 4)
"""Orders that a search tries."""


@dataclass(frozen=True)
class OutputFilter(Effect):
    """Butterworth low-pass filter of the output, digital through the bilinear transform."""

    name: ClassVar[str] = "output_filter"
    stage: ClassVar[Stage] = Stage.FILTER
    cutoff: float = parameter("Hz", "frequency at which the power gain is 1/2", low=TINY)
    order: float = parameter("1", "order", low=1.0, high=8.0, whole=True, default=1)

    def apply(self, sequence: np.ndarray, conditions: Conditions, rng: np.random.Generator) -> np.ndarray:
        """Filter the output, as if its first value had been there for ever."""
        self._check(conditions.interval)
        sections = butter(int(self.order), self.cutoff, fs=1 / conditions.interval, output="sos")
        return sosfilt(sections, sequence, zi=sosfilt_zi(sections) * sequence[0])[0]

    def gain(self, frequency: np.ndarray, interval: float) -> np.ndarray:
        """Return the power gain 1/(1 + (tan(pi f interval)/tan(pi cutoff interval))^(2 order)) at ``frequency`` [Hz].

        It is that of the analogue filter at the frequencies that the bilinear transform puts there.
        """
        self._check(interval)
        warped = np.tan(np.pi * np.asarray(frequency, float) * interval) / np.tan(np.pi * self.cutoff * interval)
        return 1 / (1 + np.abs(warped) ** (2 * self.order))

    @classmethod
    def starts(cls, fit: "AxisFit") -> Iterator[Start]:
        """Yield filters of a few orders, where there is none yet."""
        if fit.description.noise.output_filter is None and fit.top < DEFICIT:
            for order in ORDERS:
                yield Start(cls(0.3 / fit.sequence.conditions.interval, order), ("cutoff",), trials=len(ORDERS))

    def _check(self, interval: float) -> None:
        if self.cutoff * interval >= 0.5:
            raise ValueError(
                f"{self.name}.cutoff: expected less than half the rate, {0.5 / interval:g} Hz; found {self.cutoff:g} Hz"
            )

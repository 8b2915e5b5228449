"""Fixes on the clock of the device, position and velocity at one time.

The velocity of a receiver is often that of another time than its position. The position is carried to the time of the
velocity by the way that the velocities say: the noise of a velocity stays its own, where velocities between two fixes
would have less of it, and errors in common with their neighbours.
"""

from typing import NamedTuple

import numpy as np


class DueFixes(NamedTuple):
    """Fixes on the clock of the device.

    Attributes
    ----------
    due
        Times [s], shape (n,).
    seen, std
        :data:`imugap.io.gnss.COMPONENTS`, NaN where missing, and their standard deviations, shape (n, 6).
    """

    due: np.ndarray
    seen: np.ndarray
    std: np.ndarray

    @property
    def with_velocity(self) -> np.ndarray:
        """Whether a fix has a horizontal velocity, shape (n,)."""
        return np.isfinite(self.seen[:, 3:5]).all(axis=1)

    def with_timely_positions(self, delay_s: float) -> "DueFixes":
        """Return the fixes at the times of their velocities, ``delay_s`` before those of their positions [s]."""
        known = self.with_velocity
        if delay_s == 0 or not known.any():
            return self
        seen, std = self.seen.copy(), self.std.copy()
        for k in range(3):
            own = known & np.isfinite(seen[:, 3 + k])
            if own.any():
                middle = np.interp(self.due + delay_s / 2, self.due[own], seen[own, 3 + k])
                seen[:, k] -= delay_s * middle
                std[:, k] = np.hypot(std[:, k], delay_s * std[:, 3 + k])
        return DueFixes(self.due - delay_s, seen, std)

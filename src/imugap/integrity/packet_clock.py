"""Clock of a log whose samples arrive in packets of equal size: the packets are even, the rows within them are not.

The rows of a packet have the same stamp, or stamps that are much closer than packets are. Packets may be lost.
"""

import numpy as np

from imugap.integrity.lattice_clock import lattice_interval, lattice_slots

APART = 1.6
"""Smallest ratio of the steps between packets and within."""
WITHIN, BETWEEN = 0.2, 0.02
"""Smallest shares of the steps within packets, and between them."""
WHOLE = 0.8
"""Smallest share of packets of the usual size; others are incomplete."""
FEWEST = 4
"""Smallest number of packets, and of rows."""
TINY = 1e-3
"""Step that is neglected, in mean steps."""


def packet_slots(time: np.ndarray) -> tuple[np.ndarray, float] | None:
    """Return the sample of each row, shape (n,), and the interval [s]; None if the rows do not come in packets.

    ``time``, shape (n,) [s], does not decrease. The samples missing in an incomplete packet are taken as its last.
    """
    if len(time) < FEWEST or time[-1] == time[0]:
        return None
    steps = np.diff(time)
    begins = _between(steps + TINY * steps.mean())
    if begins is None:
        return None
    first = np.flatnonzero(np.r_[True, begins])
    sizes = np.diff(np.r_[first, len(time)])
    size = int(np.bincount(sizes).argmax())
    if len(sizes) < FEWEST or size < 2 or np.mean(sizes[1:-1] == size) < WHOLE or sizes.max() > size:
        return None
    period = lattice_interval(time[first], 0.0)
    if period is None:
        return None
    packets = lattice_slots(time[first], period)
    period = float(np.polyfit(packets, time[first] - time[0], 1)[0])
    offset = size - sizes[0]
    slots = np.repeat(packets * size - first, sizes) + np.arange(len(time))
    slots[sizes[0] :] -= offset
    return slots, period / size


def _between(steps: np.ndarray) -> np.ndarray | None:
    """Return which steps, shape (n,), are between packets; None if no gap separates two sizes of steps."""
    ordered = np.sort(steps)
    low, high = ordered[:-1], ordered[1:]
    ratio = np.where(low < steps.mean(), high / low, 0.0)[: int((1 - BETWEEN) * len(steps))]
    ratio[: int(WITHIN * len(steps))] = 0.0
    at = int(np.argmax(np.r_[ratio, 0.0]))
    return steps > ordered[at] if at < len(ratio) and ratio[at] > APART else None

"""Full scale of gyroscopes that are clipped, from the shape of the largest rates.

A device clips its sensors ahead of its filter and its calibration, so that clipped samples are near one value, and not
equal to it. Their excursions have flat tops. Of the time that a smooth excursion, a parabola near its largest value,
spends above ``1 - 4 e`` of it, half is above ``1 - e``; of a pointed one less, of a clipped one more. Of the excursions
near the largest rate of a log, those with more and those with less than half are therefore counted (sign test).
"""

from collections.abc import Iterator

import numpy as np
from scipy.special import bdtrc

TOP = 0.03
"""Depth e of the top of an excursion, as a share of its largest value."""
NEAR = 0.9
"""Largest value of an excursion that counts, as a share of the largest of the log."""
RESOLVED = 3
"""Fewest samples above ``1 - 4 e``."""
ALPHA = 0.01
"""Probability of a full scale where nothing is clipped. A false one costs little: some samples get less weight."""


def full_scale(rates: np.ndarray) -> float:
    """Return the full scale that angular rates of several axes show, shape (n, axes), in their unit; inf for none."""
    top = np.abs(rates).max()
    found = [one for column in rates.T for one in _excursions(np.abs(column), NEAR * top)]
    flat = [largest for largest, share in found if share > 0.5]
    if not flat or bdtrc(len(flat) - 1, len(found), 0.5) >= ALPHA:
        return np.inf
    return float(np.median(flat))


def _excursions(size: np.ndarray, least: float) -> Iterator[tuple[float, float]]:
    """Yield the largest value of each excursion to ``least`` or more, and the share of its time in its top."""
    edges = np.diff(np.r_[0, size > (1 - 4 * TOP) * least, 0])
    for first, last in zip(np.flatnonzero(edges == 1), np.flatnonzero(edges == -1), strict=True):
        one = size[first:last]
        largest = one.max()
        above = one[one > (1 - 4 * TOP) * largest]
        if largest >= least and len(above) >= RESOLVED:
            yield largest, np.mean(above > (1 - TOP) * largest)

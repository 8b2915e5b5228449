"""Period of the changes of a sequence that repeats its values."""

import numpy as np

FEWEST = 20
"""Fewest changes that show a period."""


def change_period(columns: np.ndarray) -> tuple[int, int] | None:
    """Return the samples from one possible change to the next and the number of the first, or None.

    ``columns`` has shape (n, m), NaN where not known; it changes where any of a row differs from the row before. All
    changes are at one number modulo the period, which is more than one.
    """
    known = np.isfinite(columns).all(axis=1)
    changed = 1 + np.flatnonzero(known[1:] & known[:-1] & np.any(columns[1:] != columns[:-1], axis=1))
    if len(changed) < FEWEST:
        return None
    period = int(np.gcd.reduce(np.diff(changed)))
    return (period, int(changed[0] % period)) if period > 1 else None

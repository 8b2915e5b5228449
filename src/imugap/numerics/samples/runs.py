"""Runs of true values in a mask."""

import numpy as np


def runs_of(mask: np.ndarray) -> np.ndarray:
    """Return first and end (one past the last) of each run of true values of a mask (n,), shape (runs, 2), in order."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], mask, [False]]).astype(int)))
    return edges.reshape(-1, 2)

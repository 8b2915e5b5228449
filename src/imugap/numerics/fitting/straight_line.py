"""Straight lines through long sequences."""

import numpy as np


def slope(places: np.ndarray, values: np.ndarray) -> float:
    """Return the slope of the least-squares line through ``values`` at ``places``, shape (n,) each.

    By moments about the means, in the memory of two sequences.
    """
    centred = places - np.mean(places)
    return float(centred @ (values - np.mean(values)) / (centred @ centred))

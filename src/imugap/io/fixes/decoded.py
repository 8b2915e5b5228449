"""Fixes as a format gives them, before they are checked."""

from collections.abc import Callable
from dataclasses import dataclass

import pandas as pd


@dataclass(frozen=True, eq=False)
class Decoded:
    """Table of fixes, unchecked.

    Attributes
    ----------
    table
        Index ``time`` [s], columns of :data:`imugap.io.gnss.COLUMNS`, latitude and longitude in degrees.
    notes
        Sentences on what was recognised.
    place
        From the number of a row, where it is in the file.
    """

    table: pd.DataFrame
    notes: tuple[str, ...] = ()
    place: Callable[[int], str] = "row {}".format

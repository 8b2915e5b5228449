"""One scale of the axes of a sensor, and of each axis in several runs; LogError where integers had several."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from imugap.integrity.scales import Scale, odd_axis, odd_run
from imugap.io.recognition.units import PLACES
from imugap.log import AXES, TRIADS, LogError


def require_one_scale(columns: Mapping[str, np.ndarray]) -> None:
    """Raise a LogError where lattice and noise of one axis of a sensor are those of another scale."""
    for sensor, triad in TRIADS.items():
        odd = odd_axis({axis: Scale.of(columns[axis]) for axis in triad if axis in columns})
        if odd is not None:
            expected = f"one scale of all axes (rescale {odd.name} in the file, or leave it out by --columns)"
            found = f"{odd.shown_by} of {odd.name} {odd.times} those of the two others"
            raise LogError("log", PLACES[sensor], expected, found)


def require_same_scale(sources: Sequence[Path], tables: Sequence[pd.DataFrame]) -> None:
    """Raise a LogError where the scale of an axis in one run is not that of the others."""
    for axis in AXES:
        runs = {run: Scale.of(table[axis].to_numpy(float)) for run, table in enumerate(tables) if axis in table}
        found = odd_run(runs)
        if found is not None:
            odd, middle = found
            expected = f"the scale that it has in {sources[middle]} (rescale it, or --units with the right counts)"
            raise LogError(sources[odd.name], f"column {axis}", expected, f"{odd.shown_by} {odd.times} those there")

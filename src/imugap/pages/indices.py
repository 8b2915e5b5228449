"""Page of performance indices: what a data sheet would say of the device, with intervals."""

import pandas as pd

from imugap.estimation.indices import INDICES
from imugap.figures.indices import intervals
from imugap.figures.style import AXIS_TITLES
from imugap.pages.page import DataTable, Gallery, Page, Part, Picture, Points, Text
from imugap.units import from_si
from imugap.workflow.tables import number

MEANING = (
    "An index is read from the Allan deviation only where the curve has the slope of its law. Where it has not, the "
    "value is an upper bound: the device is better than this, and the log does not show by how much."
)


def page(table: pd.DataFrame, remarks: tuple[str, ...], verdict: str) -> Page:
    """Compose the page of the indices of a device, from a table of :func:`imugap.estimation.indices.over_runs`."""
    picture = Picture(
        intervals(table),
        "Each index of each axis with its 95 % interval. Grey triangles are upper bounds.",
        "Values of the indices with their intervals, a panel for each index and triad",
    )
    return Page(
        "What would a data sheet say of the device?",
        tuple(verdict.splitlines()),
        True,
        (
            Part("Indices", (Text(MEANING), _rows(table))),
            Part("Intervals", (Gallery((picture,)),)),
            Part("What was left out", (Points(remarks),) if remarks else ()),
        ),
    )


def _rows(table: pd.DataFrame) -> DataTable:
    rows = []
    for one in table.itertuples():
        index = INDICES[one.symbol]
        unit = index.unit(one.axis)
        value, low, high = (number(from_si(item, unit)) for item in (one.value, one.low, one.high))
        kind = "reading" if one.holds else "upper bound"
        rows.append((AXIS_TITLES[one.axis], index.title, value, f"{low} to {high}", unit, str(one.runs), kind))
    titles = ("axis", "index", "value", "95 % interval", "unit", "runs", "")
    return DataTable("Indices in the units of data sheets.", titles, tuple(rows))

"""Page of a walk: where it went and ended, strides, and the path from above."""

from collections.abc import Mapping

from imugap.analysis.walk import STD, NavigatedWalk
from imugap.figures import walk
from imugap.figures.style import CARD
from imugap.pages.page import DataTable, Fold, Gallery, Page, Part, Picture, Text
from imugap.workflow.tables import measured

TITLES = {
    "distance_m": "distance [m]",
    "duration_s": "duration [s]",
    "strides": "strides",
    "end_horizontal_m": "horizontal offset [m]",
    "end_vertical_m": "vertical offset [m]",
    "end_heading_deg": "change of heading [°]",
}
SENTENCES = {
    "height": "Height above the begin; the band is one standard deviation.",
    "heading": "Heading relative to the begin; the band is one standard deviation.",
    "speed": "Speed of the foot; orange where the filter takes it to stand.",
}
COLUMNS = {
    "start": "begin [s]", "duration": "duration [s]", "length": "length [m]", "rise": "rise [m]",
    "peak_height": "peak height [m]", "heading": "heading [°]",
}  # fmt: skip
ACCURACY = (
    "Offsets are those of the end from the begin. Positions are relative to the begin, north is the heading of the "
    "device there. Deviations are standard deviations that the filter states; after each stance the position is held "
    "by the velocity of zero, and the heading drifts freely."
)
BETWEEN = (
    "Strides between the middles of stances, ± one standard deviation of the chord between them; the first and the "
    "last hold half of the stand beside them. The peak height is that of the device over the chord, larger than the "
    "minimum clearance of the toe."
)


def page(found: NavigatedWalk) -> Page:
    """Compose the page of a walk."""
    summary, strides = found.summary(), found.strides()
    numbers = ([_shown(row, name) for name in COLUMNS] for row in strides.to_dict("records"))
    rows = tuple((str(ordinal), *row) for ordinal, row in enumerate(numbers, start=1))
    begin_end = Picture(
        walk.plan(found.smoothed, CARD),
        "The walk from above, with the places of the stances. The cross is the end; an ellipse around it, where it is "
        f"large enough to be seen, holds it with {walk.LEVEL:.0%}.",
        f"Path from above: {found.verdict()}",
    )
    over_time = [
        Picture(walk.over_time(found.smoothed, name), sentence, f"Curve of the {name} over time")
        for name, sentence in SENTENCES.items()
    ]
    table = DataTable(BETWEEN, ("stride", *COLUMNS.values()), rows)
    medians = strides[["length", "duration", "peak_height"]].median()
    usual = "Median stride: {length:.3g} m in {duration:.3g} s, peak height {peak_height:.2g} m.".format(**medians)
    return Page(
        "Where did the walk go, and where did it end?",
        tuple(found.verdict().splitlines()),
        True,
        (
            Part(
                "Path",
                (Gallery((begin_end,)), DataTable("Extent.", ("", "value", "σ"), extent(summary)), Text(ACCURACY)),
            ),
            Part("Over time", (Gallery(tuple(over_time)),)),
            Part("Strides", (Text(usual), Fold(f"All {len(rows)} strides", (table,))) if rows else ()),
        ),
    )


def _shown(stride: Mapping[str, float], name: str) -> str:
    """Return a number of a stride: with the standard deviation where there is one, else to a hundredth or a mm."""
    if stride.get(name + STD, 0) > 0:
        return " ± ".join(measured(stride[name], stride[name + STD]))
    return f"{stride[name]:.{2 if name in ('start', 'duration') else 3}f}"


def extent(summary: Mapping[str, float]) -> tuple[tuple[str, str, str], ...]:
    """Return title, value and standard deviation of each number of the extent."""
    return tuple((title, *measured(summary[key], summary[key + STD])) for key, title in TITLES.items())

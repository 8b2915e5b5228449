"""Page of a walk: where it went and ended, strides, and the path from above."""

from collections.abc import Mapping

import pandas as pd

from imugap.analysis.walk import STD, NavigatedWalk
from imugap.figures import walk
from imugap.figures.style import CARD
from imugap.pages.page import DataTable, Fold, Gallery, Page, Part, Picture, Text
from imugap.workflow.tables import fixed, measured

TITLES = {
    "distance_m": "distance [m]",
    "walking_s": "without stands [s]",
    "strides": "strides",
    "speed_m_per_s": "speed of a stride [m/s]",
    "cadence_per_min": "strides a minute",
    "end_horizontal_m": "horizontal offset [m]",
    "end_vertical_m": "vertical offset [m]",
    "end_heading_deg": "net change of heading [°]",
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
    "by the velocity of zero, and the heading drifts freely. The distance is the sum of the horizontal chords between "
    "successive stances; its deviation holds noise and biases of the error model and the motion of the foot at stance, "
    "with what all strides have in common, but no scale factors. Speed and strides a minute are those of the foot, "
    "over the strides but the first, the last and those with a stand."
)
BETWEEN = (
    "Times are seconds since the begin of the log, at {begin:.10g} s of its clock. Strides are between the middles of "
    "stances, ± one standard deviation of the chord between them; the first and the last hold half of the stand beside "
    "them. The peak height is that of the device over the chord, larger than the minimum clearance of the toe."
)


def page(found: NavigatedWalk) -> Page:
    """Compose the page of a walk."""
    summary, strides = found.summary(), found.strides()
    cells = [strides["stride"].astype(str), *(_shown(strides, name) for name in COLUMNS)]
    rows = tuple(zip(*cells, strict=True))
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
    table = DataTable(BETWEEN.format(begin=found.smoothed.time[0]), ("stride", *COLUMNS.values()), rows)
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


def _shown(strides: pd.DataFrame, name: str) -> list[str]:
    """Return a column of the strides as text: to two digits of the median deviation, or to a hundredth or a mm."""
    decimals = 2 if name in ("start", "duration") else 3
    if name + STD not in strides or not len(strides):
        return [fixed(value, decimals) for value in strides[name]]
    _, usual = measured(0.0, float(strides[name + STD].median()))
    decimals = len(usual.partition(".")[2])
    return [
        f"{fixed(value, decimals)} ± {fixed(std, decimals)}"
        for value, std in zip(strides[name], strides[name + STD], strict=True)
    ]


def extent(summary: Mapping[str, float]) -> tuple[tuple[str, str, str], ...]:
    """Return title, value and standard deviation of each number of the extent."""
    return tuple(
        (title, *measured(summary[key], summary[key + STD])) for key, title in TITLES.items() if key in summary
    )

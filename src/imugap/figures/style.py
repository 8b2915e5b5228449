"""Style of the figures, and panels and legends that all chapters share."""

from io import BytesIO

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, MaxNLocator, NullFormatter, StrMethodFormatter

from imugap import log

AXIS_TITLES = {axis: f"{'Gyroscope' if axis in log.GYRO else 'Accelerometer'} {axis[-1]}" for axis in log.AXES}
ALLAN_UNITS = {"gyro": ("deg/h", "°/h"), "accel": ("ug", "µg")}
STYLE = {
    "font.size": 8,
    "axes.titlesize": 8,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#dddddd",
    "grid.linewidth": 0.5,
    "lines.linewidth": 1.0,
    "legend.frameon": False,
    "legend.fontsize": 7,
    "svg.hashsalt": "imugap",
    "savefig.bbox": "tight",
    "savefig.pad_inches": 0.04,
    "figure.dpi": 120,
}
WIDTH = 6.65
"""Width of a full-width figure [inch]: that of the text on the page, so that a point is a point there."""
CARD = 3.6
"""Width of a figure that a phone shows as it is [inch]."""

mpl.rcParams.update(STYLE)


class NotebookFigure(Figure):
    """Figure that shows itself in a notebook, also where pyplot is not in use."""

    def _repr_png_(self) -> bytes:
        sink = BytesIO()
        self.savefig(sink, format="png", metadata={"Software": None})
        return sink.getvalue()


def panels_of(rows: int, columns: int, height: float, **kwargs) -> tuple[Figure, np.ndarray]:
    """Return a full-width figure of ``height`` [inch] and its panels, shape (rows, columns)."""
    figure = NotebookFigure(figsize=(WIDTH, height), layout="constrained")
    return figure, figure.subplots(rows, columns, squeeze=False, **kwargs)


def card(height: float = 2.4, rows: int = 1, **kwargs) -> tuple[Figure, np.ndarray]:
    """Return a figure as wide as a phone, of ``height`` [inch], and its panels, shape (rows,)."""
    figure = NotebookFigure(figsize=(CARD, height), layout="constrained")
    return figure, figure.subplots(rows, 1, squeeze=False, **kwargs)[:, 0]


def legend_below(figure: Figure, columns: int) -> None:
    """Add one legend below the panels, with each label of any panel once."""
    found = {}
    for panel in figure.axes:
        for handle, label in zip(*panel.get_legend_handles_labels(), strict=True):
            found.setdefault(label, handle)
    figure.legend(found.values(), found.keys(), loc="outside lower center", ncols=columns)


def time_axis(begin: float, end: float) -> tuple[float, str]:
    """Return the instant from which time is drawn [s], and the label of the axis, which states it.

    It is the begin of what is drawn, ``begin`` to ``end`` [s], where that is later than it is long, as stamps since
    1970 are; else zero.
    """
    return (begin, f"time since {begin:.10g} s [s]") if begin > end - begin else (0.0, "time [s]")


def label_lowest(grid: np.ndarray, text: str) -> None:
    """Label the horizontal axes of the lowest row of panels, shape (rows, columns)."""
    for panel in grid[-1]:
        panel.set_xlabel(text)


def decades(panel: mpl.axes.Axes, parts: tuple[int, ...] = (1, 2, 5)) -> None:
    """Set a logarithmic vertical axis with plain numbers at ``parts`` of a decade."""
    panel.set_yscale("log")
    panel.yaxis.set_major_locator(LogLocator(subs=parts, numticks=8))
    panel.yaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
    panel.yaxis.set_minor_formatter(NullFormatter())


def few_ticks(panel: mpl.axes.Axes) -> None:
    """Set few ticks on linear axes, so that their labels stand apart also on a phone."""
    panel.xaxis.set_major_locator(MaxNLocator(5))
    panel.yaxis.set_major_locator(MaxNLocator(5))


def text_figure(text: str) -> Figure:
    """Return a figure that holds only a text."""
    figure, grid = panels_of(1, 1, 0.8)
    grid[0, 0].set_axis_off()
    grid[0, 0].text(0.5, 0.5, text, ha="center", va="center", transform=grid[0, 0].transAxes)
    return figure


def allan_panels() -> tuple[Figure, dict[str, mpl.axes.Axes]]:
    """Return a figure for the Allan deviations of the six axes, and its panels by axis."""
    figure, grid = panels_of(2, 3, 4.6, sharex=True, sharey="row")
    panels = dict(zip(log.AXES, grid.flat, strict=True))
    for axis, panel in panels.items():
        panel.set(title=AXIS_TITLES[axis], xscale="log")
        decades(panel, (1, 3))
    for row, kind in zip(grid, ALLAN_UNITS, strict=True):
        row[0].set_ylabel(f"Allan deviation [{ALLAN_UNITS[kind][1]}]")
    label_lowest(grid, "averaging time τ [s]")
    return figure, panels


def allan_unit(axis: str) -> str:
    """Return the unit (:mod:`imugap.units`) in which the Allan deviation of an axis is shown."""
    return ALLAN_UNITS[axis.split("_")[0]][0]


def allan_label(axis: str) -> str:
    """Return the label of the Allan deviation of an axis."""
    return f"Allan deviation [{ALLAN_UNITS[axis.split('_')[0]][1]}]"

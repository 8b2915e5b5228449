"""Figures of discovery: each function draws one figure from what was found and returns it."""

from collections.abc import Mapping, Sequence
from math import ceil

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from imugap.discovery.device import Discovery
from imugap.discovery.evaluation.distance import Distances, Drifts
from imugap.discovery.finding import Discrepancy, Interval
from imugap.discovery.views import Curve
from imugap.discovery.views.discrepancies import ViewTest, place_level
from imugap.effects import title_of
from imugap.figures.style import AXIS_TITLES, card, legend_below, panels_of, text_figure, time_axis
from imugap.figures.views import VIEWS
from imugap.workflow.tables import unit

MOST, FEW = 20, 4
"""Views that a figure shows, the surest first; those of a figure that has to fit a page."""
TALL, LOW, MANY = 1.6, 0.85, 6
"""Height of a row of drifts [inch], and where there are more than so many rows."""
LEVEL = 0.95
LOG, BEFORE, AFTER, PLACE, DESCRIBED = "black", "#D55E00", "#0072B2", "#CC79A7", "#009E73"
STATES = {"before": ("start model", BEFORE), "after": ("final model", AFTER)}
LINEAR = 20.0
"""Gain up to which a panel is linear; beyond, logarithmic."""
ASIDE = 0.18
"""Distance of the points of two logs, where rows are one apart."""
TOP = 0.95
"""Height in a panel at which its places are marked."""
LOGARITHMIC = ("allan", "spectrum", "line", "coherence")
DIRECTIONS = ("north", "east", "down")
PLAIN = FuncFormatter(lambda value, _: f"{float(f'{value:.3g}'):g}")
NAMES = {"distribution": "distribution", "navigation": "navigation drift"}


def places(found: Discovery, alpha: float) -> Figure:
    """Draw every view in which the log left the start model, before and after.

    The curve is the statistic of the log, a deviation in standard deviations or a gain of log-likelihood; beyond the
    band, from simulated logs of the model, refitted, lie the places at the false discovery rate ``alpha`` over all
    views. Of windows that overlap, the shortest make the curve; the bars at the top are the places that were named,
    also those of wider windows.
    """
    return _compared(found, alpha, _shown(found)[:MOST])


def surest(found: Discovery, alpha: float) -> Figure:
    """Draw what :func:`places` draws, of each view only the axis that is surest: what fits a page."""
    views = dict(reversed(_shown(found)))
    return _compared(found, alpha, [key for key in _shown(found) if key in views.items()][:FEW])


def _shown(found: Discovery) -> list[tuple[str, str]]:
    """Return view and axis of every place of which there is a curve, the surest first."""
    curves = {(one.curve.view, one.curve.axis) for one in found.before}
    return [key for key in dict.fromkeys((place.view, place.axis) for place in found.discrepancies) if key in curves]


def _compared(found: Discovery, alpha: float, drawn: Sequence[tuple[str, str]]) -> Figure:
    """Draw views before and after, a row for each view and axis."""
    if not drawn:
        views = sorted({place.view for place in found.discrepancies})
        return text_figure(
            f"The log leaves the start model where no curve shows it: {', '.join(views)}."
            if views
            else "No view of the log leaves the start model."
        )
    before, after = ({(one.curve.view, one.curve.axis): one for one in some} for some in (found.before, found.after))
    figure, grid = panels_of(len(drawn), 2, 1.3 * len(drawn) + 0.6, sharex="row", sharey="row")
    levels = [place_level(some, alpha) for some in (found.before, found.after)]
    for key, row in zip(drawn, grid, strict=True):
        pairs = ((before[key], found.discrepancies), (after.get(key), found.unexplained))
        for panel, (title, colour), (test, places), level in zip(row, STATES.values(), pairs, levels, strict=True):
            if test is None:
                panel.text(0.5, 0.5, "explained by what the axes share", ha="center", transform=panel.transAxes)
            else:
                _view(panel, test, level, colour, f"band of the {title}")
                _marked(panel, [place for place in places if (place.view, place.axis) == key], test.curve)
        row[0].set_title(f"{_titled(key[1])}, {VIEWS[key[0]].title}", loc="left")
        _scaled(row, before[key].curve)
    legend_below(figure, 4)
    return figure


def _view(panel: Axes, test: ViewTest, level: float, colour: str, label: str) -> None:
    """Draw one view of the log against what a model leaves anywhere with a probability of ``level``."""
    curve = test.curve
    low, high = test.envelope.bounds(level)
    cells = np.arange(len(curve.low))
    if curve.windows is not None:
        first, last = curve.windows
        cells = np.flatnonzero(last - first == 1)
    middle = ((curve.low + curve.high) / 2)[cells] - _along(curve)[0]
    order = np.argsort(middle)
    at, cells = middle[order], cells[order]
    floor = low[cells] if curve.signed else np.minimum(curve.statistic[cells].min(), 0.0)
    panel.fill_between(at, floor, high[cells], color=colour, alpha=0.25, lw=0, label=label)
    panel.plot(at, curve.statistic[cells], color=LOG, marker=".", ms=2, lw=0.7, label="log")


def _along(curve: Curve) -> tuple[float, str]:
    """Return the location from which a view is drawn, that of time from its begin, and the label of its axis."""
    name = VIEWS[curve.view].along
    if name == "time":
        return time_axis(float(curve.low.min()), float(curve.high.max()))
    return 0.0, name if curve.unit == "1" else f"{name} [{unit(curve.unit)}]"


def _marked(panel: Axes, places: Sequence[Discrepancy], curve: Curve) -> None:
    """Mark places at the top of a panel."""
    begin, _ = _along(curve)
    for place in places:
        ends = [place.low - begin, place.high - begin]
        panel.plot(ends, [TOP, TOP], color=PLACE, lw=2.5, marker="|", ms=7, mew=1.5, label="place",
                   transform=panel.get_xaxis_transform())  # fmt: skip


def _scaled(row: Sequence[Axes], curve: Curve) -> None:
    """Label the panels of one view, and give its curve room below the marks."""
    _, along = _along(curve)
    row[0].set_ylabel("deviation [σ]" if curve.signed else "gain")
    row[0].margins(y=0.15)
    for panel in row:
        panel.set_xlabel(along)
        panel.set_xscale("log" if curve.view in LOGARITHMIC else "linear")
        if not curve.signed and curve.statistic.max() > LINEAR:
            panel.set_yscale("symlog", linthresh=LINEAR)
            panel.set_ylim(bottom=min(float(curve.statistic.min()), 0.0) - 1)
            panel.yaxis.set_major_formatter(PLAIN)
        panel.minorticks_off()


def drawn_places(found: Discovery) -> list[tuple[str, str]]:
    """Return view and axis of the places to draw alone: of each view the surest axis, then those still unexplained."""
    shown = _shown(found)
    surest = dict(reversed(shown)).items()
    unexplained = {(one.view, one.axis) for one in found.unexplained}
    return [key for key in shown if key in surest] + [key for key in shown if key in unexplained and key not in surest]


def place(found: Discovery, alpha: float, key: tuple[str, str]) -> Figure:
    """Draw one view of one axis, with the start model above and with the final model below, as wide as a phone."""
    before, after = ({(one.curve.view, one.curve.axis): one for one in some} for some in (found.before, found.after))
    figure, panels = card(3.6, rows=2, sharex=True, sharey=True)
    levels = [place_level(some, alpha) for some in (found.before, found.after)]
    left = (found.discrepancies, found.unexplained)
    sides = zip(panels, STATES.values(), (before, after), left, levels, strict=True)
    for panel, (title, colour), tests, places, level in sides:
        panel.set_title(f"with the {title}")
        if key in tests:
            _view(panel, tests[key], level, colour, f"band of the {title}")
            _marked(panel, [one for one in places if (one.view, one.axis) == key], tests[key].curve)
        else:
            panel.text(0.5, 0.5, "explained by what the axes share", ha="center", transform=panel.transAxes)
    _scaled(panels, before[key].curve)
    panels[0].set_xlabel("")
    panels[1].set_ylabel(panels[0].get_ylabel())
    legend_below(figure, 2)
    return figure


def distance_of(found: Discovery, name: str) -> Figure:
    """Draw one distance of the held-out data to both models beside the floor, as wide as a phone."""
    figure, (panel,) = card(2.2)
    _distance(panel, found.distances[name], _described(found, name))
    panel.set_ylabel("distance")
    legend_below(figure, 2)
    return figure


def drift_of(path: Drifts, direction: str) -> Figure:
    """Draw the free-inertial drift of held-out data in one direction in the ensembles of both models."""
    column = DIRECTIONS.index(direction)
    figure, panels = card(3.2, rows=2, sharex=True, sharey=True)
    for panel, (state, (title, colour)) in zip(panels, STATES.items(), strict=True):
        label = f"{LEVEL:.0%} of simulations, {title}"
        _drift(panel, path, getattr(path, state)[..., column], path.measured[:, column], colour, label)
        panel.set(title=f"with the {title}", ylabel="drift [m]", ylim=(-_reach(path, column), _reach(path, column)))
    panels[-1].set_xlabel("time [s]")
    legend_below(figure, 2)
    return figure


def distance(found: Discovery) -> Figure:
    """Draw the distances of the held-out data to both models beside the floor, the band."""
    figure, grid = panels_of(1, len(found.distances), 2.0)
    for (name, apart), panel in zip(found.distances.items(), grid[0], strict=True):
        _distance(panel, apart, _described(found, name))
        panel.set_title(NAMES[name])
    grid[0, 0].set_ylabel("distance")
    legend_below(figure, 3)
    return figure


def _described(found: Discovery, name: str) -> Interval | None:
    """Return the distance with a description of what has no name, or None."""
    return None if found.nameless is None or name != "distribution" else found.nameless.distances.after


def _distance(panel: Axes, apart: Distances, described: Interval | None) -> None:
    """Draw one distance to both models, and to one with descriptions, beside the floor, the band."""
    panel.axhspan(apart.floor.low, apart.floor.high, color="#cccccc", lw=0, label="floor (95 %)")
    panel.axhline(apart.floor.value, color="#888888", lw=0.6)
    points = [(state, getattr(apart, state), *look) for state, look in STATES.items()]
    points += [] if described is None else [("described", described, "described without a name", DESCRIBED)]
    for place, (_, one, title, colour) in enumerate(points):
        ends = [[one.value - one.low], [one.high - one.value]]
        panel.errorbar([place], [one.value], ends, fmt="o", ms=5, color=colour, capsize=4, label=title)
    ticks = range(len(points))
    panel.set(xticks=ticks, xticklabels=[one[0] for one in points], xlim=(-0.6, len(points) - 0.4), yscale="log")
    panel.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    panel.yaxis.set_major_formatter(PLAIN)
    panel.yaxis.set_minor_formatter(NullFormatter())


def drift(found: Discovery) -> Figure:
    """Draw the free-inertial drift of the held-out data in the ensembles of both models, a row for each log."""
    if not found.drifts:
        return text_figure("No navigation: it takes a device at rest and all six axes.")
    rows = [(path, state) for path in found.drifts for state in STATES]
    figure, grid = panels_of(len(rows), 3, (LOW if len(rows) > MANY else TALL) * len(rows) + 0.5, sharex="row")
    for number, ((path, state), row) in enumerate(zip(rows, grid, strict=True)):
        title, colour = STATES[state]
        for column, (direction, panel) in enumerate(zip(DIRECTIONS, row, strict=True)):
            label = f"{LEVEL:.0%} of simulations, {title}"
            _drift(panel, path, getattr(path, state)[..., column], path.measured[:, column], colour, label)
            panel.set_title(f"{direction}: {title}")
            limit = _reach(path, column)
            panel.set(ylim=(-limit, limit))
        row[0].set_ylabel("drift [m]")
        if number == len(rows) - 1:
            for panel in row:
                panel.set_xlabel("time [s]")
    legend_below(figure, 3)
    return figure


def repeated(data: pd.DataFrame, scales: Mapping[str, tuple[str, float]]) -> Figure:
    """Draw the parameters that several logs of one device give, a panel for each effect and unit.

    Parameters
    ----------
    data
        Columns ``trial``, ``name``, ``axis``, ``parameter``, ``value``, ``low``, ``high``, ``unit``.
    scales
        By unit: how it is shown, and by what its values are multiplied.
    """
    if data.empty:
        return text_figure("No parameter is named on two logs.")
    groups = list(data.groupby(["name", "unit"], sort=False))
    rows = [one[["axis", "parameter"]].drop_duplicates() for _, one in groups]
    columns = 2
    grid_rows = ceil(len(groups) / columns)
    figure, grid = panels_of(grid_rows, columns, grid_rows * (0.14 * max(map(len, rows)) + 0.6) + 0.4)
    trials = sorted(data["trial"].unique())
    for ((name, one_unit), one), keys, panel in zip(groups, rows, grid.flat, strict=False):
        title, scale = scales.get(one_unit, (unit(one_unit), 1.0))
        places = {key: place for place, key in enumerate(keys.itertuples(index=False, name=None))}
        for number, trial in enumerate(trials):
            found = one[one["trial"] == trial]
            at = [places[key] for key in found[["axis", "parameter"]].itertuples(index=False, name=None)]
            value = scale * found["value"]
            ends = value - scale * found["low"], scale * found["high"] - value
            aside = ASIDE * (number - (len(trials) - 1) / 2)
            panel.errorbar(value, np.add(at, aside), xerr=ends, fmt="o", ms=2.5, elinewidth=0.7, color=f"C{number}",
                           label=f"trial {trial}")  # fmt: skip
        panel.axvline(0, color="black", lw=0.5)
        panel.set_yticks(range(len(places)), [f"{_titled(axis)}: {parameter}" for axis, parameter in places])
        panel.set_ylim(len(places) - 0.4, -0.6)
        panel.set(title=title_of(name), xlabel=title)
    for panel in grid.flat[len(groups) :]:
        panel.remove()
    legend_below(figure, len(trials))
    return figure


def _drift(panel: Axes, path: Drifts, ensemble: np.ndarray, measured: np.ndarray, colour: str, label: str) -> None:
    low, high = np.quantile(ensemble, [(1 - LEVEL) / 2, (1 + LEVEL) / 2], axis=0)
    panel.fill_between(path.time, low, high, color=colour, alpha=0.25, lw=0, label=label)
    panel.plot(path.time, ensemble.T, color=colour, alpha=0.15, lw=0.4)
    panel.plot(path.time, measured, color=LOG, label="log")


def _reach(path: Drifts, column: int) -> float:
    """Return the largest drift in one direction, the same scale before and after."""
    drawn = (path.measured[:, column], path.before[..., column], path.after[..., column])
    return 1.05 * max(float(np.abs(one).max()) for one in drawn)


def _titled(axis: str) -> str:
    titles = [AXIS_TITLES.get(one, one) for one in axis.split(",")]
    if len(titles) == 2 and titles[0].split()[0] == titles[1].split()[0]:
        return f"{titles[0].split()[0]}s {titles[0][-1]} and {titles[1][-1]}"
    return ", ".join([titles[0], *(title.lower() for title in titles[1:])])

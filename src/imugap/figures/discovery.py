"""Figures of discovery: each function draws one figure from what was found and returns it."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter

from imugap.discovery.discover import Discovery
from imugap.discovery.distance import Drifts
from imugap.discovery.gaps import Verdict
from imugap.figures import AXIS_TITLES, legend_below, panels_of, said

MOST = 20
"""Views that one figure shows, the surest first."""
LEVEL = 0.95
LOG, BEFORE, AFTER, PLACE = "black", "#D55E00", "#0072B2", "#CC79A7"
STATES = {"before": ("start model", BEFORE), "after": ("final model", AFTER)}
TITLES = {
    "allan": "Allan variance",
    "spectrum": "spectrum",
    "line": "lines",
    "mean": "mean over time",
    "variance": "variance over time",
    "marginal": "distribution of values",
    "extremes": "extremes",
    "change": "steps of the mean",
    "coherence": "coherence",
    "temperature": "mean over temperature",
    "temperature_rate": "mean over temperature rate",
    "rate": "mean over rate",
    "specific_force": "mean over specific force",
    "time_shift": "mean over the input's derivative",
    "full_scale": "mean towards full scale",
}
LOCATIONS = {"allan": "averaging time", "spectrum": "frequency", "line": "frequency", "coherence": "frequency"}
LOGARITHMIC = ("allan", "spectrum", "line", "coherence")
DIRECTIONS = ("north", "east", "down")
PLAIN = FuncFormatter(lambda value, _: f"{value:g}")
NAMES = {"distribution": "distribution", "navigation": "navigation drift"}


def places(found: Discovery, alpha: float) -> Figure:
    """Draw every view in which the log left the start model, before and after.

    The curve is the statistic of the log in standard deviations (of a gain: its excess), the band where a share 1 -
    ``alpha`` of simulated logs of the model, refitted, stays everywhere. Of windows that overlap, the shortest make
    the curve; wider ones that leave the band are bars.
    """
    wanted = list(dict.fromkeys((gap.view, gap.axis) for gap in found.gaps))
    before, after = ({(one.curve.view, one.curve.axis): one for one in some} for some in (found.before, found.after))
    drawn = [key for key in wanted if key in before][:MOST]
    if not drawn:
        return said("No view of the log leaves the start model.")
    figure, grid = panels_of(len(drawn), 2, 1.5 * len(drawn) + 0.6, sharex="row", sharey="row")
    for key, row in zip(drawn, grid, strict=True):
        for panel, (title, colour), verdict in zip(row, STATES.values(), (before[key], after.get(key)), strict=True):
            panel.set_title(f"{_titled(key[1])}, {TITLES[key[0]]}: {title}")
            if verdict is None:
                panel.text(0.5, 0.5, "explained by what the axes share", ha="center", transform=panel.transAxes)
            else:
                _view(panel, verdict, alpha, colour)
        curve = before[key].curve
        row[0].set_ylabel("statistic")
        for panel in row:
            panel.set_xlabel(
                f"{LOCATIONS.get(curve.view, TITLES[curve.view].removeprefix('mean over '))} [{curve.unit}]"
            )
            panel.set_xscale("log" if curve.view in LOGARITHMIC else "linear")
    legend_below(figure, 4)
    return figure


def _view(panel: Axes, verdict: Verdict, alpha: float, colour: str) -> None:
    """Draw one view of the log against the envelope of a model."""
    curve = verdict.curve
    low, high = verdict.envelope.bounds(alpha)
    cells = np.arange(len(curve.low))
    if curve.windows is not None:
        first, last = curve.windows
        cells = np.flatnonzero(last - first == 1)
    middle = ((curve.low + curve.high) / 2)[cells]
    order = np.argsort(middle)
    at, cells = middle[order], cells[order]
    floor = low[cells] if curve.signed else np.minimum(curve.statistic[cells].min(), 0.0)
    panel.fill_between(at, floor, high[cells], color=colour, alpha=0.25, lw=0, label=f"{1 - alpha:.0%} of simulations")
    panel.plot(at, curve.statistic[cells], color=LOG, marker=".", ms=2, lw=0.7, label="log")
    beyond = np.flatnonzero((curve.statistic > high) | (curve.statistic < low))
    label = "beyond the band"
    for one in beyond:
        panel.plot([curve.low[one], curve.high[one]], [curve.statistic[one]] * 2, color=PLACE, lw=2.5, marker="|",
                   alpha=0.8, label=label)  # fmt: skip
        label = None


def distance(found: Discovery) -> Figure:
    """Draw the distances of the held-out data to both models beside the floor, the band."""
    figure, grid = panels_of(1, len(found.distances), 2.4)
    for (name, apart), panel in zip(found.distances.items(), grid[0], strict=True):
        panel.axhspan(apart.floor.low, apart.floor.high, color="#cccccc", lw=0, label="floor (95 %)")
        panel.axhline(apart.floor.value, color="#888888", lw=0.6)
        for place, (state, (title, colour)) in enumerate(STATES.items()):
            one = getattr(apart, state)
            ends = [[one.value - one.low], [one.high - one.value]]
            panel.errorbar([place], [one.value], ends, fmt="o", ms=5, color=colour, capsize=4, label=title)
        panel.set(title=NAMES[name], xticks=[0, 1], xticklabels=list(STATES), xlim=(-0.6, 1.6), yscale="log")
        panel.yaxis.set_major_formatter(PLAIN)
        panel.yaxis.set_minor_formatter(PLAIN)
    grid[0, 0].set_ylabel("distance")
    legend_below(figure, 3)
    return figure


def drift(found: Discovery) -> Figure:
    """Draw the free-inertial drift of the held-out data in the ensembles of both models, a row for each log."""
    if not found.drifts:
        return said("No navigation: it takes a device at rest and all six axes.")
    rows = [(path, state) for path in found.drifts for state in STATES]
    figure, grid = panels_of(len(rows), 3, 1.6 * len(rows) + 0.5, sharex="row")
    for number, ((path, state), row) in enumerate(zip(rows, grid, strict=True)):
        title, colour = STATES[state]
        for column, (direction, panel) in enumerate(zip(DIRECTIONS, row, strict=True)):
            _drift(panel, path, getattr(path, state)[..., column], path.measured[:, column], colour)
            panel.set_title(f"{direction}: {title}")
            limit = _reach(path, column)
            panel.set(ylim=(-limit, limit))
        row[0].set_ylabel("drift [m]")
        if number == len(rows) - 1:
            for panel in row:
                panel.set_xlabel("time [s]")
    legend_below(figure, 3)
    return figure


def _drift(panel: Axes, path: Drifts, ensemble: np.ndarray, measured: np.ndarray, colour: str) -> None:
    low, high = np.quantile(ensemble, [(1 - LEVEL) / 2, (1 + LEVEL) / 2], axis=0)
    panel.fill_between(path.time, low, high, color=colour, alpha=0.25, lw=0, label=f"{LEVEL:.0%} of simulations")
    panel.plot(path.time, ensemble.T, color=colour, alpha=0.15, lw=0.4)
    panel.plot(path.time, measured, color=LOG, label="log")


def _reach(path: Drifts, column: int) -> float:
    """Return the largest drift in one direction, the same scale before and after."""
    drawn = (path.measured[:, column], path.before[..., column], path.after[..., column])
    return 1.05 * max(float(np.abs(one).max()) for one in drawn)


def _titled(axis: str) -> str:
    return " and ".join(AXIS_TITLES.get(one, one) for one in axis.split(","))

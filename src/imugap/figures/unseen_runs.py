"""Figure of the scores of error models on runs that they have not seen."""

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.ticker import SymmetricalLogLocator

from imugap.figures import static
from imugap.figures.style import legend_below, panels_of

TITLES = {name: static.TITLES[name] for name in ("white", "method_a", "method_b", "restoration", "nbk")} | {
    "power_law": "White + 1/f^α",
    "chosen": "Chosen by likelihood",
    "gmwm": "Chosen, GMWM",
    "discovered_nbk": "Discovered from N + B + K",
    "discovered_white": "Discovered from white",
}
"""One name per model in table and figure."""
COLOURS = {"worse": "#D55E00", "level": "black", "better": "#009E73"}
LINEAR = {"log score": 1.0, "log drift score": 0.1}
"""Loss up to which the axis of a score is linear."""
TICKS = 4
"""Greatest number of decades with a number on the axis of a score."""


def unseen_runs(found: pd.DataFrame, bands: pd.DataFrame) -> Figure:
    """Draw the loss of each model over the discovered one in each score, and its distance beside the floor.

    Parameters
    ----------
    found
        Columns ``contender``, ``score``, ``loss``, ``low``, ``high``, ``verdict``.
    bands
        Index contender; columns ``distance``, ``floor``.
    """
    names = [name for name in TITLES if name in bands.index]
    rows = np.arange(len(names))[::-1]
    scores = list(found["score"].unique())
    figure, grid = panels_of(1, len(scores) + 1, 2.6, sharey=True)
    for panel, score in zip(grid[0], scores, strict=False):
        own = found[found["score"] == score].set_index("contender")
        for name, row in zip(names, rows, strict=True):
            if name in own.index:
                one = own.loc[name]
                panel.plot([one["low"], one["high"]], [row, row], color=COLOURS[one["verdict"]])
                panel.plot(one["loss"], row, "o", ms=4, color=COLOURS[one["verdict"]])
        panel.axvline(0.0, color="black", lw=0.6)
        linear = LINEAR[score.split(",")[0]]
        panel.set_xscale("symlog", linthresh=linear)
        locator = SymmetricalLogLocator(base=10, linthresh=linear)
        locator.set_params(numticks=TICKS)
        panel.xaxis.set_major_locator(locator)
        panel.set(title=score.replace(", ", ",\n"), xlabel="loss over discovered")
    last = grid[0, -1]
    last.plot(bands.loc[names, "distance"], rows, "o", ms=4, color="black", label="distance")
    last.plot(bands.loc[names, "floor"], rows, "|", ms=9, color="#0072B2", label="upper end of its floor")
    last.set(title="distance in\ndistribution", xscale="log")
    grid[0, 0].set_yticks(rows, [TITLES[name] for name in names])
    legend_below(figure, 2)
    return figure

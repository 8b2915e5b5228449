"""Figure of the scores of error models on runs that they have not seen."""

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter

from imugap.figures import static
from imugap.figures.style import legend_below, panels_of

TITLES = {name: static.TITLES[name] for name in ("white", "method_a", "method_b", "restoration", "nbk")} | {
    "power_law": "White + 1/fᵅ",
    "chosen": "Chosen by likelihood",
    "gmwm": "Chosen, GMWM",
    "discovered_nbk": "Discovered from N + B + K",
    "discovered_white": "Discovered from white",
}
"""One name per model in table and figure."""
COLOURS = {"worse": "#D55E00", "level": "black", "better": "#009E73"}
LINEAR = {"log score": 1.0, "log drift score": 0.1}
"""Loss up to which the axis of a score is linear."""


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
        panel.set_xscale("symlog", linthresh=LINEAR[score.split(",")[0]])
        low, high = panel.get_xlim()
        decade = 10.0 ** np.floor(np.log10(max(-low, high)))
        panel.set_xticks([tick for tick in (-decade, 0.0, decade) if low <= tick <= high])
        panel.xaxis.set_major_formatter("{x:g}")
        panel.xaxis.set_minor_formatter(NullFormatter())
        panel.set(title=score.replace(", ", ",\n"), xlabel="loss over discovered")
    last = grid[0, -1]
    last.plot(bands.loc[names, "distance"], rows, "o", ms=4, color="black", label="distance")
    last.plot(bands.loc[names, "floor"], rows, "|", ms=9, color="#0072B2", label="upper end of its floor")
    last.set(title="distance in\ndistribution", xscale="log")
    last.xaxis.set_major_locator(LogLocator(subs=(1, 1.5, 2, 3, 5, 7)))
    last.xaxis.set_major_formatter("{x:g}")
    last.xaxis.set_minor_formatter(NullFormatter())
    grid[0, 0].set_yticks(rows, [TITLES[name] for name in names])
    legend_below(figure, 2)
    return figure

"""First places of error models over cases (start, navigation length, quantity), with intervals over the runs.

The navigation lengths of a run are nested, and all cases share the same few runs: cases are not independent, so that
no binomial interval applies to a count of first places. The runs are resampled instead, the same for all models and
cases, and the first places are counted anew (B. Efron, R. J. Tibshirani, An Introduction to the Bootstrap, 1993,
section 13.3).

The share of published tables, of a few trials each, that put a model first is another matter: such tables are
independent where no two of them have a trial in common, and their share has a binomial interval.
"""

import numpy as np
import pandas as pd
from scipy.special import betaincinv

CASE = ("start", "horizon", "quantity")
"""Columns that identify a case."""
DRAWS = 400
"""Resamples of the runs."""


def _arrange(table: pd.DataFrame, column: str, axes: list[str]) -> tuple[np.ndarray, list[pd.Index]]:
    """Arrange a table with every combination of ``axes`` as an array with one dimension for each of them."""
    levels = [pd.Index(table[name].unique(), name=name) for name in axes]
    values = table.set_index(axes)[column].reindex(pd.MultiIndex.from_product(levels))
    return values.to_numpy().reshape([len(level) for level in levels]), levels


def first_places(errors: pd.DataFrame, proper: pd.DataFrame, rng: np.random.Generator) -> pd.DataFrame:
    """Count the first places of each model by median e_abs and by mean CRPS, on all runs and on resampled runs.

    Parameters
    ----------
    errors
        Columns start, horizon, quantity, contender, run, trial, ``e_abs``; every combination once.
    proper
        Columns start, horizon, quantity, contender, run, ``crps``; every combination once.

    Returns
    -------
    pandas.DataFrame
        Columns score (``e_abs``, ``crps``), draw (0: the runs as they are), start, contender, count.
    """
    axes = [*CASE, "contender", "run"]
    (e_abs, levels), (crps, _) = _arrange(errors, "e_abs", [*axes, "trial"]), _arrange(proper, "crps", axes)
    starts, contenders, runs = levels[0], levels[3], len(levels[4])
    picks = np.vstack([np.arange(runs), rng.integers(runs, size=(DRAWS, runs))])
    index = pd.MultiIndex.from_product([starts, contenders], names=["start", "contender"])
    found = []
    for draw, pick in enumerate(picks):
        scores = {"e_abs": np.median(e_abs[:, :, :, :, pick], axis=(4, 5)), "crps": crps[..., pick].mean(axis=4)}
        for score, values in scores.items():
            best = values.argmin(axis=3).reshape(len(starts), -1)
            counts = [np.bincount(row, minlength=len(contenders)) for row in best]
            found.append(pd.DataFrame({"score": score, "draw": draw, "count": np.ravel(counts)}, index=index))
    return pd.concat(found).reset_index()


def interval(counts: pd.DataFrame) -> tuple[int, int, int]:
    """Return the sum of counts of :func:`first_places` on all runs, and its 95 % interval over the resampled runs."""
    total = counts.groupby("draw")["count"].sum()
    low, high = total.drop(0).quantile([0.025, 0.975], interpolation="nearest")
    return int(total[0]), int(low), int(high)


def share_interval(share: float, tables: int) -> tuple[float, float]:
    """Return the exact 95 % interval of a share of independent tables (Clopper and Pearson 1934).

    The share may be the mean over all tables that the trials make, also those with trials in common. Its variance is
    then at most that over independent tables (Hoeffding 1948, section 5), and the interval is no narrower than needed.

    Parameters
    ----------
    share
        Share of the tables, between 0 and 1.
    tables
        Number of tables, no two of which have a trial in common.
    """
    hits = share * tables
    low = float(betaincinv(hits, tables - hits + 1, 0.025)) if hits > 0 else 0.0
    high = float(betaincinv(hits + 1, tables - hits, 0.975)) if hits < tables else 1.0
    return low, high

"""Monte Carlo scores of estimation methods: bias, error, coverage, efficiency, each with its interval."""

from collections.abc import Iterator

import numpy as np
import pandas as pd

from imugap.estimation.result import Fit, Identifiability
from imugap.stream import stream
from imugap.study.verdicts import side

RESAMPLES = 1000
KEY = ["effect", "ordinal", "parameter"]


def row(fit: Fit, **labels: object) -> pd.DataFrame:
    """Return the estimates of one fit with columns for ``labels`` (method, run and the like)."""
    return fit.table().reset_index().assign(**labels)


def summary(estimates: pd.DataFrame, truth: pd.Series, bound: pd.Series, seed: int, level: float = 0.95):
    """Summarise the estimates of repeated runs, relative to the truth.

    A run whose estimate is not finite has failed: it counts as not covered and is left out of bias and error.

    Parameters
    ----------
    estimates
        Rows of :func:`row` with columns ``method`` and ``run``.
    truth, bound
        Value and Cramer-Rao bound (relative, :func:`imugap.estimation.cramer_rao.bound`) of each parameter, index
        ``effect``, ``ordinal``, ``parameter``.
    seed
        Of the bootstrap.
    level
        Confidence level of the intervals of this table.

    Returns
    -------
    pandas.DataFrame
        One row for each method and parameter: ``runs``, ``failed``, ``identified`` (share of runs), ``bias`` and
        ``bias_error``, ``median`` (of the absolute error), ``rmse`` with ``rmse_low`` and ``rmse_high`` (bootstrap),
        ``bound``, ``efficiency`` (rmse/bound) with limits, ``coverage`` with limits (Wilson).
    """
    found = []
    for key, group in estimates.groupby(["method", *KEY], sort=False):
        true = truth[key[1:]]
        found.append(dict(zip(["method", *KEY], key, strict=True)) | _one(group, true, bound[key[1:]], seed, level))
    return pd.DataFrame(found)


def worse_than(summaries: pd.DataFrame, method: str) -> Iterator[tuple[str, str, float, list[str]]]:
    """Yield effect, parameter and ``time`` where methods are worse than ``method``, with the names of these methods.

    A method is worse where the interval of its error over the bound lies wholly above that of ``method``.
    ``summaries`` are tables of :func:`summary` with the column ``time``.
    """
    for key, group in summaries.groupby(["effect", "parameter", "time"], sort=False):
        limits = group.set_index("method")[["efficiency_low", "efficiency_high"]]
        reference = tuple(limits.loc[method])
        worse = [name for name, *ends in limits.itertuples() if side(tuple(ends), reference) > 0]
        if worse:
            yield *key, worse


def _one(group: pd.DataFrame, true: float, bound: float, seed: int, level: float) -> dict[str, float]:
    error = group["value"].to_numpy() / true - 1
    finite = np.isfinite(error)
    error = error[finite]
    covered = int(((group["low"] <= true) & (true <= group["high"]) & finite).sum())
    from scipy.stats import binomtest  # takes as long to import as all else here, and only the tables need it

    coverage = binomtest(covered, len(group)).proportion_ci(level, method="wilson")
    rng = stream(seed, "rmse", group["method"].iloc[0], group["parameter"].iloc[0])
    drawn = rng.choice(error, (RESAMPLES, len(error))) if len(error) else np.full((RESAMPLES, 1), np.nan)
    low, high = np.quantile(np.sqrt(np.mean(drawn**2, axis=1)), [(1 - level) / 2, (1 + level) / 2])
    rmse = np.sqrt(np.mean(error**2)) if len(error) else np.nan
    return {
        "runs": len(group),
        "failed": int((~finite).sum()),
        "identified": float((group["verdict"] == Identifiability.IDENTIFIED).mean()),
        "bias": error.mean() if len(error) else np.nan,
        "bias_error": error.std(ddof=1) / np.sqrt(len(error)) if len(error) > 1 else np.nan,
        "median": float(np.median(np.abs(error))) if len(error) else np.nan,
        "rmse": rmse,
        "rmse_low": low,
        "rmse_high": high,
        "bound": bound,
        "efficiency": rmse / bound,
        "efficiency_low": low / bound,
        "efficiency_high": high / bound,
        "coverage": covered / len(group),
        "coverage_low": coverage.low,
        "coverage_high": coverage.high,
    }

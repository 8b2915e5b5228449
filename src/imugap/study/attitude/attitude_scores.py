"""Scores of attitude errors over time, and confidence intervals of their differences."""

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd

from imugap.navigation.attitude import COVARIANCE
from imugap.numerics.fitting import block_bootstrap
from imugap.stream import stream

SCORES = ("variance", "mean_abs", "rms", "lowest", "highest")
"""Variance about the mean [rad^2], mean absolute error, root mean square, range [rad] (Liu, Ren, Li 2016, table 5)."""


def scores(error: pd.DataFrame) -> pd.DataFrame:
    """Return the :data:`SCORES` of errors over time [rad], one row per column."""
    values = error.to_numpy()
    columns = (
        values.var(axis=0),
        np.abs(values).mean(axis=0),
        np.sqrt((values**2).mean(axis=0)),
        values.min(axis=0),
        values.max(axis=0),
    )
    return pd.DataFrame(dict(zip(SCORES, columns, strict=True)), index=error.columns.rename("angle"))


def nees(error: pd.DataFrame, solution: pd.DataFrame) -> np.ndarray:
    """Return the squared tilt error over its covariance, shape (n,): 2 on average for a filter that knows itself.

    ``error`` has columns ``north`` and ``east`` [rad], ``solution`` those of
    :data:`imugap.navigation.attitude.COVARIANCE`.
    """
    north, east = error["north"].to_numpy(), error["east"].to_numpy()
    nn, ne, ee, _ = (solution.loc[error.index, name].to_numpy() for name in COVARIANCE)
    return (ee * north**2 - 2 * ne * north * east + nn * east**2) / (nn * ee - ne**2)


def difference(error: np.ndarray, other: np.ndarray, rng: np.random.Generator) -> block_bootstrap.Mean:
    """Return by how much the variance of ``other`` exceeds that of ``error``, two errors at the same instants [rad].

    The interval is that of blocks of the difference of their squared deviations, which is what varies.
    """
    squares = [(one - one.mean()) ** 2 for one in (error, other)]
    return block_bootstrap.mean(squares[1] - squares[0], rng)


def scored(
    solution: pd.DataFrame, error: pd.DataFrame, angles: Sequence[str], labels: Mapping[str, object]
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Return the errors of a solution and the scores of some of them with the mean NEES, with columns for labels."""
    found = scores(error[list(angles)]).reset_index().assign(nees=nees(error, solution).mean())
    return error.reset_index().assign(**labels), found.assign(**labels)


def differences(errors: pd.DataFrame, by: Sequence[str], angles: Sequence[str], seed: int) -> pd.DataFrame:
    """Return by how much the variances of scheme 2 exceed those of scheme 1, with intervals by blocks.

    Parameters
    ----------
    errors
        Columns ``scheme``, ``angles`` [rad] and ``by``, by which the errors are grouped.
    """
    rows = []
    for key, one in errors.groupby(list(by), sort=False):
        pair = dict(list(one.groupby("scheme")))
        for angle in angles:
            first, second = (pair[scheme][angle].to_numpy() for scheme in ("allan", "indirect"))
            found = difference(first, second, stream(seed, "difference", *key, angle))
            labels = dict(zip(by, key, strict=True)) | {"angle": angle}
            rows.append(labels | vars(found) | {"differs": found.differs})
    return pd.DataFrame(rows)

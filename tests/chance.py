"""Judge counts and means of independent draws."""

import numpy as np
from scipy.stats import binom


def as_often_as(inside, probability, alpha=1e-4):
    """Whether the share of draws, shape (runs,), that are true agrees with its probability, two-sided."""
    low, high = binom.ppf([alpha / 2, 1 - alpha / 2], len(inside), probability)
    return low <= np.sum(inside) <= high


def mean_is(values, truth, sigmas=4.0, share=np.inf):
    """Whether the means of independent draws, shape (runs, ...), are the truth, within their standard errors.

    A standard error that is not below a ``share`` of the truth would tell nothing and fails.
    """
    values = np.asarray(values, float)
    error = values.std(axis=0, ddof=1) / np.sqrt(len(values))
    assert np.all(error < share * np.abs(truth))
    return np.all(np.abs(values.mean(axis=0) - truth) < sigmas * error)

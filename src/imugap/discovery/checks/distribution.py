"""Test of the distribution of the noise of single samples, by the kurtosis of the residual made white.

Names are found by second moments: noise of uniform numbers has the spectrum of normal ones. The kurtosis of independent
normal values is transformed to a normal one (Anscombe and Glynn 1983).
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.stats import kurtosis, kurtosistest, norm

from imugap.discovery.fit.axis_fit import AxisFit
from imugap.numerics.normal_quantile import NORMAL_QUANTILE

NORMAL = 3.0
"""Kurtosis of a normal distribution."""
TOLERATED = 2.6, 6.0
"""Tolerated range of the kurtosis, as real noise has it: nearly normal, and up to that of a Laplace law."""
MIN_SHARE = 0.9
"""Share of the frequencies that are used below which the kurtosis is not corrected for the others any more."""
MAX_ROUNDING = 0.1
"""Largest share of the rounding, which is uniform, in the variance of the noise."""
MIN_SAMPLES = 500
"""Minimum number of samples, for the transformation of the kurtosis."""
LAWS: Mapping[str, float] = {"a sine": 1.5, "uniform numbers": 1.8, "a sum of two uniform numbers": 2.4}
"""Kurtosis of laws of light tails."""


@dataclass(frozen=True)
class NoiseShape:
    """Distribution of the noise of single samples of an axis that is not normal.

    Attributes
    ----------
    axis
        Axis.
    kurtosis, low, high
        Kurtosis of the residual made white, with its 95 % interval.
    law
        Law of the nearest kurtosis, or an empty text for heavy tails.
    """

    axis: str
    kurtosis: float
    low: float
    high: float
    law: str

    def sentence(self) -> str:
        """Return what the distribution is as text."""
        found = f"kurtosis {self.kurtosis:.2f}, {self.low:.2f} to {self.high:.2f}, where a normal one has {NORMAL:g}"
        tails = f"its tails are lighter, as those of {self.law}" if self.law else "its tails are heavier"
        return f"{self.axis}: the noise is not normally distributed, {tails} ({found})."


def noise_shape(fit: AxisFit, log_alpha: float) -> NoiseShape | None:
    """Return the distribution of the noise of a fit if it is certain not to be normal, and not nearly so; else None.

    Outliers, changes of the variance, processes that are not normal themselves, and steps of the output that are not
    small make a distribution of their own: with them nothing is tested. Values on a coarse lattice are drawn anew
    within their steps.
    """
    if not shows_law(fit):
        return None
    values = fit.unrounded[~fit.sequence.flawed]
    share = fit.sequence.bins.last / len(fit.unrounded) if fit.cells is None else 1.0
    return shape_of(values, fit.sequence.conditions.axis, log_alpha, max(share, MIN_SHARE))


def shows_law(fit: AxisFit) -> bool:
    """Return whether white noise taken for normal makes the distribution of the samples of a fit, and nothing else."""
    normal = all(one.slow or (one.white and one.normal) for one in fit.description.noise.effects)
    return normal and fit.description.outliers is None and not fit.description.changes and not _stepped(fit)


def _stepped(fit: AxisFit) -> bool:
    """Return whether the rounding of the output is a large share of the noise of single samples, and is not undone."""
    bins = fit.sequence.bins
    return fit.cells is None and bins.rounding > MAX_ROUNDING * float(fit.description.noise.variance(bins).min())


def shape_of(values: np.ndarray, axis: str, log_alpha: float, share: float = 1.0) -> NoiseShape | None:
    """Return the distribution of independent values, shape (n,), as :func:`noise_shape` does.

    ``share`` is that of the frequencies in the values: without the others each is a mean of several, which has the
    excess of the kurtosis times the square of the share.
    """
    count = len(values)
    if count < MIN_SAMPLES:
        return None
    found = NORMAL + float(kurtosis(values)) / share**2
    low, high = TOLERATED
    if low <= found <= high or np.log(2) + norm.logsf(abs(kurtosistest(values).statistic)) > log_alpha:
        return None
    scaled = (values - values.mean()) / values.std()
    error = NORMAL_QUANTILE * float(np.std(scaled**4 - 2 * found * scaled**2) / np.sqrt(count) / share**2)
    law = min(LAWS, key=lambda name: abs(LAWS[name] - found)) if found < low else ""
    return NoiseShape(axis, found, found - error, found + error, law)

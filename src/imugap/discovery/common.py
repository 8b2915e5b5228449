"""Noise that axes share: the correlation of what is left of them after everything of their own is described."""

from dataclasses import dataclass
from itertools import combinations

import numpy as np
from scipy.sparse.csgraph import connected_components
from scipy.special import log_ndtr

from imugap.discovery.axis import AxisFit
from imugap.discovery.finding import Finding, Interval
from imugap.effects import CommonMode


@dataclass(frozen=True, eq=False)
class Shared:
    """A white part that axes share.

    Attributes
    ----------
    axes
        Names of the axes.
    densities
        Density on each axis with its sign relative to the first, shape (axes,).
    errors
        Their standard deviations.
    log_p
        Log-probability of chance of the strongest pair (two-sided, Bonferroni over the pairs).
    """

    axes: tuple[str, ...]
    densities: np.ndarray
    errors: np.ndarray
    log_p: float

    def finding(self, unit: str) -> Finding:
        """Return it as an effect of each axis: one density, a loading for each axis."""
        density, error = abs(float(self.densities[0])), float(self.errors[0])
        parameters = {"density": Interval(density, max(density - 1.96 * error, 0.0), density + 1.96 * error, unit)}
        effects = {}
        for axis, size, spread in zip(self.axes, self.densities, self.errors, strict=True):
            loading = float(size / density)
            relative = float(np.hypot(spread / density, loading * error / density)) if axis != self.axes[0] else 0.0
            parameters[f"loading_{axis}"] = Interval(loading, loading - 1.96 * relative, loading + 1.96 * relative, "1")
            effects[axis] = CommonMode(density, loading)
        return Finding(effects, parameters, self.log_p)


def shared(fits: dict[str, AxisFit], log_alpha: float) -> tuple[Shared, ...]:
    """Return the groups of axes whose whitened residuals are correlated beyond chance."""
    axes = tuple(fits)
    if len(axes) < 2:
        return ()
    whitened = np.array([fits[axis].whitened for axis in axes])
    good = ~np.any([fits[axis].sequence.flawed for axis in axes], axis=0)
    correlation = np.corrcoef(whitened[:, good])
    scores = np.arctanh(np.clip(correlation, -0.999999, 0.999999)) * np.sqrt(good.sum() - 3)
    pairs = list(combinations(range(len(axes)), 2))
    chance = {pair: float(np.log(2 * len(pairs)) + log_ndtr(-abs(scores[pair]))) for pair in pairs}
    linked = np.zeros((len(axes), len(axes)), bool)
    for pair in pairs:
        linked[pair] = chance[pair] < log_alpha
    _, label = connected_components(linked, directed=False)
    groups = [np.flatnonzero(label == one) for one in range(label.max() + 1)]
    return tuple(
        _group(axes, members, correlation, fits, min(chance[p] for p in pairs if set(p) <= set(members)), good.sum())
        for members in groups
        if len(members) > 1
    )


def _group(
    axes: tuple[str, ...], members: np.ndarray, correlation: np.ndarray, fits: dict[str, AxisFit], log_p: float, n: int
) -> Shared:
    """Return the densities of one factor, of equal share on two axes, by the mean of all pairs on more."""
    block = correlation[np.ix_(members, members)]
    loadings = _loadings(block)
    loadings *= np.sign(loadings[0]) or 1.0
    white = np.array(
        [np.sqrt(fits[axes[i]].variance[-1] * fits[axes[i]].sequence.conditions.interval) for i in members]
    )
    if len(members) == 2:
        product = abs(block[0, 1]) * white.prod()
        densities = np.sqrt(product) * np.array([1.0, np.sign(block[0, 1])])
        errors = np.full(2, np.sqrt(product) * (1 - block[0, 1] ** 2) / (2 * abs(block[0, 1]) * np.sqrt(n)))
    else:
        densities = loadings * white
        errors = white * np.sqrt(
            np.maximum(1 - loadings**2, 1 / n) / n / np.maximum(np.sum(loadings**2) - loadings**2, 1e-12)
        )
    return Shared(tuple(axes[i] for i in members), densities, errors, log_p)


def _white(fit: AxisFit) -> float:
    """Return the density of the noise near half the sampling rate."""
    return float(np.sqrt(fit.variance[fit.sequence.bins.last - 1] * fit.sequence.conditions.interval))


def _loadings(block: np.ndarray, rounds: int = 200) -> np.ndarray:
    """Return the loadings of one factor that fit the off-diagonal correlations best (principal factors, iterated)."""
    communality = np.max(np.abs(block - np.eye(len(block))), axis=0)
    for _ in range(rounds):
        reduced = block - np.diag(1 - communality)
        values, vectors = np.linalg.eigh(reduced)
        loadings = vectors[:, -1] * np.sqrt(max(values[-1], 0.0))
        communality = np.minimum(loadings**2, 0.999)
    return loadings

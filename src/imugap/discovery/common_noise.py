"""Noise that axes share: the correlation of what is left of them after everything of their own is described."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
from scipy.fft import irfft, rfft, rfftfreq
from scipy.sparse.csgraph import connected_components
from scipy.special import log_ndtr
from scipy.stats import ncx2

from imugap.discovery.checks import LEVEL
from imugap.discovery.finding import Finding, Interval
from imugap.discovery.fit.axis_fit import AxisFit
from imugap.effects import CommonMode, WhiteNoise
from imugap.effects.effect import TINY

FAINT = 1e-9
"""Information of a sample that keeps what axes of no loading leave open finite."""
CLEAR = 1e-3
"""Power gain of a filter above which what it lets through is the axis' own."""
WHITE = (CommonMode, WhiteNoise)
"""White noise."""
BANDS, FEWEST = 16, 32
"""Bands of frequency in which a correlation is looked at, and the coefficients in the lowest."""
SLIGHT = 0.1
"""Relative unevenness of a correlation that leaves noise white."""
BLOCKS, MOMENTS, LEFT = 20, 4, 1 / 3
"""Blocks of time, the number of those that may not hold all, and the share of the product that others have to hold."""


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
    """Return the groups of axes whose whitened residuals are correlated beyond chance, as white noise makes them."""
    axes = tuple(fits)
    if len(axes) < 2:
        return ()
    good = ~np.any([fits[axis].sequence.flawed for axis in axes], axis=0)
    spectra = [_Spectrum.of(fits[axis].without_cache(), good) for axis in axes]
    correlation, number = _correlation(spectra, good)
    scores = np.arctanh(np.clip(correlation, -0.999999, 0.999999)) * np.sqrt(np.maximum(number - 3, 1))
    pairs = list(combinations(range(len(axes)), 2))
    chance = {pair: float(np.log(2 * len(pairs)) + log_ndtr(-abs(scores[pair]))) for pair in pairs}
    linked = np.zeros((len(axes), len(axes)), bool)
    for pair in pairs:
        linked[pair] = chance[pair] < log_alpha
    _, label = connected_components(linked, directed=False)
    groups = [np.flatnonzero(label == one) for one in range(label.max() + 1)]
    several = [members for members in groups if len(members) > 1]
    white = [members for members in several if _white_together(spectra, members) and _lasting(spectra, members)]
    return tuple(
        _group(
            axes,
            members,
            correlation,
            fits,
            min(chance[p] for p in pairs if set(p) <= set(members)),
            number[np.ix_(members, members)].min(),
        )
        for members in white
    )


def _group(
    axes: tuple[str, ...], members: np.ndarray, correlation: np.ndarray, fits: dict[str, AxisFit], log_p: float, n: int
) -> Shared:
    """Return the densities of one factor, of equal share on two axes, by the mean of all pairs on more.

    The errors are those of the covariance of ``n`` samples.
    """
    block = correlation[np.ix_(members, members)]
    loadings = _loadings(block)
    loadings *= np.sign(loadings[0]) or 1.0
    white = np.array([_white(fits[axes[i]]) for i in members])
    if len(members) == 2:
        product = abs(block[0, 1]) * white.prod()
        densities = np.sqrt(product) * np.array([1.0, np.sign(block[0, 1])])
        errors = np.full(2, np.sqrt(product * (1 + block[0, 1] ** -2) / n) / 2)
    else:
        densities = loadings * white
        errors = white * loading_errors(loadings, n)
    return Shared(tuple(axes[i] for i in members), densities, errors, log_p)


def loading_errors(loadings: np.ndarray, n: int) -> np.ndarray:
    """Return the Cramer-Rao standard deviations of the loadings of one factor, each axis with noise of its own besides.

    Those of three axes or more, whose noise has unit variance, from ``n`` samples.
    """
    unit = np.eye(len(loadings))
    own = np.maximum(1 - loadings**2, 1e-6)
    inverse = np.linalg.inv(np.outer(loadings, loadings) + np.diag(own))
    slopes = [inverse @ (np.outer(one, loadings) + np.outer(loadings, one)) for one in unit]
    slopes += [inverse @ np.outer(one, one) for one in unit]
    information = n / 2 * np.array([[np.trace(a @ b) for b in slopes] for a in slopes])
    known = information + FAINT * n * np.eye(len(information))
    return np.sqrt(np.diag(np.linalg.inv(known))[: len(loadings)])


@dataclass(frozen=True, eq=False)
class _Spectrum:
    """The spectrum of an axis' whitened residual, without the phase that a filter of the output gave it.

    Attributes
    ----------
    values
        Fourier coefficients from the second on, shape (m,), complex.
    clear
        Where a filter lets through more than what leaks in from other frequencies, shape (m,).
    share
        Share of the amplitude that is white noise, shape (m,).
    """

    values: np.ndarray
    clear: np.ndarray
    share: np.ndarray

    @staticmethod
    def of(fit: AxisFit, good: np.ndarray) -> "_Spectrum":
        """Return that of a fit, of the samples that are ``good``."""
        noise, interval = fit.description.noise, fit.sequence.conditions.interval
        frequency = rfftfreq(len(good), interval)[1:]
        values = rfft(np.where(good, fit.whitened, 0.0))[1:]
        white = replace(noise, effects=tuple(one for one in noise.effects if isinstance(one, WHITE)))
        share = np.sqrt(white.variance(fit.sequence.bins) / noise.variance(fit.sequence.bins))
        share = np.interp(frequency, fit.sequence.bins.frequency, share)
        if noise.output_filter is None:
            return _Spectrum(values, np.ones(len(frequency), bool), share)
        clear = noise.output_filter.gain(frequency, interval) > CLEAR
        return _Spectrum(noise.output_filter.unturned(values, frequency, interval), clear, share)


def _correlation(spectra: Sequence[_Spectrum], good: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the correlations of the whitened residuals and from how many values each is, shape (axes, axes)."""
    correlation, number = np.eye(len(spectra)), np.full((len(spectra), len(spectra)), good.sum())
    for i, j in combinations(range(len(spectra)), 2):
        both = spectra[i].clear & spectra[j].clear
        one, other = spectra[i].values[both], spectra[j].values[both]
        product = np.vdot(one, other).real / (np.linalg.norm(one) * np.linalg.norm(other))
        correlation[i, j] = correlation[j, i] = product
        number[i, j] = number[j, i] = int(good.sum() * both.mean())
    return correlation, number


def _white_together(spectra: Sequence[_Spectrum], members: np.ndarray) -> bool:
    """Return whether chance explains how uneven over frequency the correlations of all pairs are."""
    chances = [_uneven(spectra[i], spectra[j]) for i, j in combinations(members, 2)]
    return min(chances) + np.log(len(chances)) > LEVEL


def _lasting(spectra: Sequence[_Spectrum], members: np.ndarray) -> bool:
    """Return whether axes go together all the time: noise in common is no event of a few moments."""
    pairs = [_products(spectra[i], spectra[j]) for i, j in combinations(members, 2)]
    together = np.sort(np.sum([pair * np.sign(pair.sum()) for pair in pairs], axis=0))
    return together[:-MOMENTS].sum() > LEFT * together.sum()


def _products(one: _Spectrum, other: _Spectrum) -> np.ndarray:
    """Return the sums of the product of two axes over blocks of time, shape (blocks,)."""
    a, b = (irfft(np.r_[0.0, np.where(axis.clear, axis.values, 0.0)]) for axis in (one, other))
    return np.array([block.sum() for block in np.array_split(a * b, BLOCKS)])


def _uneven(one: _Spectrum, other: _Spectrum) -> float:
    """Return the log-probability that noise which is white has a correlation as uneven in bands of frequency.

    A relative unevenness of :data:`SLIGHT` is none: no real noise is quite white.
    """
    both = one.clear & other.clear
    if both.sum() < 2 * FEWEST:
        return 0.0
    first = np.unique(np.r_[0, np.geomspace(FEWEST, both.sum(), BANDS).astype(int)])[:-1]
    a, b, share = one.values[both], other.values[both], (one.share * other.share)[both]
    cross, power, other_power = (
        np.add.reduceat(part, first) for part in ((a.conj() * b).real, np.abs(a) ** 2, np.abs(b) ** 2)
    )
    number = np.diff(np.r_[first, len(a)])
    total, expected = number * cross / np.sqrt(power * other_power), np.add.reduceat(share, first)
    size = total.sum() / expected.sum()
    variance = number * (1 + (size * expected / number) ** 2) / 2
    size = np.sum(total * expected / variance) / np.sum(expected**2 / variance)
    apart = np.sum((total - size * expected) ** 2 / variance)
    slight = np.sum((SLIGHT * size * expected) ** 2 / variance)
    return float(np.log(max(ncx2.sf(apart, len(total) - 1, slight), TINY)))


def _white(fit: AxisFit) -> float:
    """Return the density of the noise near half the sampling rate, ahead of the filter of the output."""
    noise = replace(fit.description.noise, output_filter=None)
    return float(np.sqrt(noise.variance(fit.sequence.bins)[-1] * fit.sequence.conditions.interval))


def _loadings(block: np.ndarray, rounds: int = 200) -> np.ndarray:
    """Return the loadings of one factor that fit the off-diagonal correlations best (principal factors, iterated)."""
    communality = np.max(np.abs(block - np.eye(len(block))), axis=0)
    for _ in range(rounds):
        reduced = block - np.diag(1 - communality)
        values, vectors = np.linalg.eigh(reduced)
        loadings = vectors[:, -1] * np.sqrt(max(values[-1], 0.0))
        communality = np.minimum(loadings**2, 0.999)
    return loadings

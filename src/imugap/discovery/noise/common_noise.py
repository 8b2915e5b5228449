"""White noise common to several axes: correlation of their whitened residuals, and a one-factor model of it."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
from scipy.fft import irfft, rfft, rfftfreq
from scipy.sparse.csgraph import connected_components
from scipy.stats import ncx2

from imugap.discovery.checks import MAX_LOG_P
from imugap.discovery.finding import Finding, Interval
from imugap.discovery.fit.axis_fit import AxisFit
from imugap.effects import CommonMode, WhiteNoise
from imugap.effects.effect import TINY
from imugap.numerics.normal_quantile import NORMAL_QUANTILE
from imugap.numerics.samples.white_samples import two_sided_log_p

MIN_INFORMATION = 1e-9
"""Minimum Fisher information per sample, which keeps the errors of axes without loading finite."""
MIN_POWER_GAIN = 1e-3
"""Minimum power gain of the output filter for using a frequency."""
WHITE_KINDS = (CommonMode, WhiteNoise)
"""Effects that are white noise."""
BANDS, MIN_COEFFICIENTS = 16, 32
"""Number of frequency bands for the test of whiteness, and minimum number of coefficients in the lowest."""
TOLERATED_DEVIATION = 0.1
"""Tolerated relative deviation of the correlation over frequency for white noise."""
BLOCKS, MAX_EVENT_BLOCKS, MIN_REMAINDER = 20, 4, 1 / 3
"""Number of blocks of time, maximum number of blocks of an event, and minimum share of the product in the others."""


@dataclass(frozen=True, eq=False)
class CommonNoise:
    """White noise common to several axes.

    Attributes
    ----------
    axes
        Names of the axes.
    densities
        Density on each axis with its sign relative to the first, shape (axes,).
    errors
        Their standard deviations.
    log_p
        Log p-value of the strongest pair (two-sided, Bonferroni over the pairs).
    most
        Density of all white noise of each axis, shape (axes,).
    """

    axes: tuple[str, ...]
    densities: np.ndarray
    errors: np.ndarray
    log_p: float
    most: np.ndarray

    def finding(self, unit: str) -> Finding:
        """Return a finding with one density and a loading for each axis."""
        density, error = abs(float(self.densities[0])), float(self.errors[0])
        low, high = self._open
        reach = NORMAL_QUANTILE * error
        parameters = {"density": Interval(density, max(low * density - reach, 0.0), high * density + reach, unit)}
        effects = {}
        for axis, size, spread in zip(self.axes, self.densities, self.errors, strict=True):
            loading, first = float(size / density), axis == self.axes[0]
            relative = 0.0 if first else float(np.hypot(spread / density, loading * error / density))
            margin = NORMAL_QUANTILE * relative
            ends = (loading, loading) if first else sorted((loading / high**2, loading / low**2))
            parameters[f"loading_{axis}"] = Interval(loading, ends[0] - margin, ends[1] + margin, "1")
            effects[axis] = CommonMode(density, loading)
        return Finding(effects, parameters, self.log_p)

    @property
    def _open(self) -> tuple[float, float]:
        """Return the least and the largest density of the first axis that the log leaves open, over the given one.

        Two axes determine only the product: each may have as much of it as there is white noise on it.
        """
        if len(self.axes) > 2:
            return 1.0, 1.0
        own, other = self.most / np.abs(self.densities)
        return float(min(1 / other, 1.0)), float(max(own, 1.0))


def find_common_noise(fits: dict[str, AxisFit], log_alpha: float) -> tuple[CommonNoise, ...]:
    """Return the groups of axes whose whitened residuals have a significant, white and lasting correlation."""
    axes = tuple(fits)
    if len(axes) < 2:
        return ()
    good = ~np.any([fits[axis].sequence.flawed for axis in axes], axis=0)
    spectra = [_Spectrum.of(fits[axis].without_cache(), good) for axis in axes]
    correlation, number = _correlation(spectra, good)
    scores = np.arctanh(np.clip(correlation, -0.999999, 0.999999)) * np.sqrt(np.maximum(number - 3, 1))
    pairs = list(combinations(range(len(axes)), 2))
    log_ps = {pair: float(np.log(len(pairs))) + two_sided_log_p(scores[pair]) for pair in pairs}
    linked = np.zeros((len(axes), len(axes)), bool)
    for pair in pairs:
        linked[pair] = log_ps[pair] < log_alpha
    _, label = connected_components(linked, directed=False)
    groups = [np.flatnonzero(label == one) for one in range(label.max() + 1)]
    several = [members for members in groups if len(members) > 1]
    white = [members for members in several if _is_white(spectra, members) and _is_lasting(spectra, members)]
    return tuple(
        _one_factor(
            axes,
            members,
            correlation,
            fits,
            min(log_ps[p] for p in pairs if set(p) <= set(members)),
            number[np.ix_(members, members)].min(),
        )
        for members in white
    )


def _one_factor(
    axes: tuple[str, ...], members: np.ndarray, correlation: np.ndarray, fits: dict[str, AxisFit], log_p: float, n: int
) -> CommonNoise:
    """Fit one common factor to the correlations; return its density on each axis.

    On two axes, which determine only the product, both have equal loadings. Errors are those of ``n`` samples.
    """
    block = correlation[np.ix_(members, members)]
    loadings = _loadings(block)
    loadings *= np.sign(loadings[0]) or 1.0
    white = np.array([_white_density(fits[axes[i]]) for i in members])
    if len(members) == 2:
        product = abs(block[0, 1]) * white.prod()
        densities = np.sqrt(product) * np.array([1.0, np.sign(block[0, 1])])
        errors = np.full(2, np.sqrt(product * (1 + block[0, 1] ** -2) / n) / 2)
    else:
        densities = loadings * white
        errors = white * loading_errors(loadings, n)
    return CommonNoise(tuple(axes[i] for i in members), densities, errors, log_p, white)


def loading_errors(loadings: np.ndarray, n: int) -> np.ndarray:
    """Return the Cramer-Rao standard deviations of the loadings of one factor with independent noise on each axis.

    For three or more axes of unit total variance, and ``n`` samples.
    """
    unit = np.eye(len(loadings))
    own = np.maximum(1 - loadings**2, 1e-6)
    inverse = np.linalg.inv(np.outer(loadings, loadings) + np.diag(own))
    slopes = [inverse @ (np.outer(one, loadings) + np.outer(loadings, one)) for one in unit]
    slopes += [inverse @ np.outer(one, one) for one in unit]
    information = n / 2 * np.array([[np.trace(a @ b) for b in slopes] for a in slopes])
    known = information + MIN_INFORMATION * n * np.eye(len(information))
    return np.sqrt(np.diag(np.linalg.inv(known))[: len(loadings)])


@dataclass(frozen=True, eq=False)
class _Spectrum:
    """Spectrum of the whitened residual of an axis, without the phase of the output filter.

    Attributes
    ----------
    values
        Fourier coefficients from the second on, shape (m,), complex.
    clear
        Whether the output filter passes more than leaks in from other frequencies, shape (m,).
    share
        Share of white noise in the amplitude, shape (m,).
    """

    values: np.ndarray
    clear: np.ndarray
    share: np.ndarray

    @staticmethod
    def of(fit: AxisFit, good: np.ndarray) -> "_Spectrum":
        """Return the spectrum of a fit from the samples that are ``good``, shape (n,)."""
        noise, interval = fit.description.noise, fit.sequence.conditions.interval
        frequency = rfftfreq(len(good), interval)[1:]
        values = rfft(np.where(good, fit.whitened, 0.0))[1:]
        white = replace(noise, effects=tuple(one for one in noise.effects if isinstance(one, WHITE_KINDS)))
        share = np.sqrt(white.variance(fit.sequence.bins) / noise.variance(fit.sequence.bins))
        share = np.interp(frequency, fit.sequence.bins.frequency, share)
        if noise.output_filter is None:
            return _Spectrum(values, np.ones(len(frequency), bool), share)
        clear = noise.output_filter.gain(frequency, interval) > MIN_POWER_GAIN
        return _Spectrum(noise.output_filter.unturned(values, frequency, interval), clear, share)


def _correlation(spectra: Sequence[_Spectrum], good: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the correlations of the whitened residuals and their numbers of values, each of shape (axes, axes)."""
    correlation, number = np.eye(len(spectra)), np.full((len(spectra), len(spectra)), good.sum())
    for i, j in combinations(range(len(spectra)), 2):
        both = spectra[i].clear & spectra[j].clear
        one, other = spectra[i].values[both], spectra[j].values[both]
        product = np.vdot(one, other).real / (np.linalg.norm(one) * np.linalg.norm(other))
        correlation[i, j] = correlation[j, i] = product
        number[i, j] = number[j, i] = int(good.sum() * both.mean())
    return correlation, number


def _is_white(spectra: Sequence[_Spectrum], members: np.ndarray) -> bool:
    """Return whether the correlation of each pair is constant over frequency within its uncertainty."""
    log_ps = [_whiteness_log_p(spectra[i], spectra[j]) for i, j in combinations(members, 2)]
    return min(log_ps) + np.log(len(log_ps)) > MAX_LOG_P


def _is_lasting(spectra: Sequence[_Spectrum], members: np.ndarray) -> bool:
    """Return whether axes are correlated throughout the log and not only in a short event."""
    pairs = [_block_products(spectra[i], spectra[j]) for i, j in combinations(members, 2)]
    together = np.sort(np.sum([pair * np.sign(pair.sum()) for pair in pairs], axis=0))
    return together[:-MAX_EVENT_BLOCKS].sum() > MIN_REMAINDER * together.sum()


def _block_products(one: _Spectrum, other: _Spectrum) -> np.ndarray:
    """Return the sums of the product of two axes over blocks of time, shape (blocks,)."""
    a, b = (irfft(np.r_[0.0, np.where(axis.clear, axis.values, 0.0)]) for axis in (one, other))
    return np.array([block.sum() for block in np.array_split(a * b, BLOCKS)])


def _whiteness_log_p(one: _Spectrum, other: _Spectrum) -> float:
    """Return the log-probability of the chi-square of the correlation over frequency bands for white noise.

    Noncentral for a relative deviation of :data:`TOLERATED_DEVIATION`, as real noise has it.
    """
    both = one.clear & other.clear
    if both.sum() < 2 * MIN_COEFFICIENTS:
        return 0.0
    first = np.unique(np.r_[0, np.geomspace(MIN_COEFFICIENTS, both.sum(), BANDS).astype(int)])[:-1]
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
    slight = np.sum((TOLERATED_DEVIATION * size * expected) ** 2 / variance)
    return float(np.log(max(ncx2.sf(apart, len(total) - 1, slight), TINY)))


def _white_density(fit: AxisFit) -> float:
    """Return the density of the noise at half the sampling rate, ahead of the output filter."""
    noise = replace(fit.description.noise, output_filter=None)
    return float(np.sqrt(noise.variance(fit.sequence.bins)[-1] * fit.sequence.conditions.interval))


def _loadings(block: np.ndarray, rounds: int = 200) -> np.ndarray:
    """Return the loadings of one factor by iterated principal-factor analysis of the correlations."""
    communality = np.max(np.abs(block - np.eye(len(block))), axis=0)
    for _ in range(rounds):
        reduced = block - np.diag(1 - communality)
        values, vectors = np.linalg.eigh(reduced)
        loadings = vectors[:, -1] * np.sqrt(max(values[-1], 0.0))
        communality = np.minimum(loadings**2, 0.999)
    return loadings

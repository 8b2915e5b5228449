"""Fit of the description of one axis: terms of the mean, random processes, filter, changes of the variance.

The mean is fitted by generalised least squares for the given spectrum, the spectrum by Whittle's likelihood to the
residual, in turn until both converge. Both are fitted in the basis of the cosine transform.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import TypeVar

import numpy as np
from scipy.fft import idct, irfft, rfft, rfftfreq

from imugap.discovery.fit import matched_filters as scans
from imugap.discovery.fit.boundary import Outside, over_time
from imugap.discovery.fit.description import Description, Entry
from imugap.discovery.fit.rounded_samples import Cells
from imugap.discovery.fit.whittle import Noise, NoiseFit, log_likelihood
from imugap.discovery.fit.whittle import fit as fit_noise
from imugap.discovery.preparation.cosine_bins import cosine_coefficients
from imugap.discovery.preparation.sequence import AxisSequence
from imugap.effects.effect import Effect, FilterEffect, Role, StochasticEffect, VarianceEffect
from imugap.numerics.fitting import normal_equations
from imugap.numerics.samples.contaminated_normal import Tails, parted_tails
from imugap.stream import stream

Made = TypeVar("Made")
MAX_ALTERNATIONS = 8
"""Maximum number of alternations between mean and spectrum."""
MIN_GAIN = 0.02
"""Change of log-likelihood at which the alternation has converged."""
MAX_SHORTENINGS = 6
OPEN = 1e-10
"""Singular value of the precision of the terms, over the largest one, below which a direction of them is open."""
CUTOFF_STEP, MAX_CUTOFF_STEP = 1e-4, 0.3
"""Of the logarithm of a cutoff: half the step of its difference quotient, and the longest step of a fit."""
SHAPING_ROLES = (Role.MEAN, Role.FILTER, Role.VARIANCE)
"""Roles of the effects that change the cosine coefficients of the samples, apart from their likelihood."""
RESPONSE = 64
"""Number of samples over which a single one may show in the residual made white, itself among them."""
CACHED_TRANSFORMS = 4
"""Number of systematic parts whose transforms are cached: fits that differ only in the noise share them."""


@dataclass(frozen=True, eq=False)
class AxisFit:
    """Description at its maximum likelihood on a sequence.

    Attributes
    ----------
    sequence, description
        The data and the fitted description.
    log_likelihood
        Log-density of the samples, free of their offset.
    noise
        Fit of the random part.
    """

    sequence: AxisSequence
    description: Description
    log_likelihood: float
    noise: NoiseFit

    @cached_property
    def scale(self) -> np.ndarray | float:
        """Factor of the standard deviation of each sample, shape (n,), or 1."""
        return scale(self.sequence, self.description.changes)

    @property
    def variance(self) -> np.ndarray:
        """Return the variance of each cosine coefficient k = 1..n-1."""
        return self.description.noise.spread(self.sequence.bins)

    @cached_property
    def scatter(self) -> "Scatter":
        """Return how its coefficients scatter under the noise."""
        return Scatter.of(self.sequence, self.description)

    @cached_property
    def residual(self) -> np.ndarray:
        """Samples less the systematic terms, of equal variance over time, shape (n,)."""
        centred, outside = _centred(self.sequence, self.description), self.scatter.outside
        if outside is None:
            return centred
        columns = over_time(self.description.noise, len(centred), self.sequence.conditions.interval)
        return centred - columns @ outside.sizes(_seen(self.sequence, self.description))

    @cached_property
    def power(self) -> np.ndarray:
        """Return the sums of the residual's squared cosine coefficients over the bins."""
        last = self.sequence.bins.last
        return self.sequence.bins.sums((self.coefficients[:last] * self.scatter.root[:last]) ** 2)

    def power_behind(self, output_filter: FilterEffect) -> np.ndarray:
        """Return the sums of squared cosine coefficients of the residual if the output had a filter."""
        if not self.sequence.in_motion:
            return self.power
        described = self.description.exchanging(Role.FILTER, [Entry.of(output_filter)])
        return self.sequence.bins.sums(Scatter.of(self.sequence, described).left(described) ** 2)

    @cached_property
    def coefficients(self) -> np.ndarray:
        """Return the residual's cosine coefficients over their standard deviations, k = 1..n-1; zero if not used."""
        return self.scatter.left(self.description) / self.scatter.root

    @cached_property
    def whitened(self) -> np.ndarray:
        """Return the residual made white, shape (n,): of unit variance if the description is right."""
        full = np.sqrt(len(self.coefficients) / self.sequence.bins.last)
        return full * idct(np.r_[0.0, self.coefficients], norm="ortho")

    def whiten(self, columns: np.ndarray) -> np.ndarray:
        """Return columns of the error, (n, m), in basis and scale of :attr:`coefficients`, shape (n - 1, m)."""
        return self.scatter.whiten(columns, self.description)

    def _directions(self) -> np.ndarray:
        """Return the derivatives of the mean by the terms' free parameters, whitened, shape (n - 1, parameters)."""
        return self.whiten(jacobian(self.description.terms, self.sequence))

    @cached_property
    def basis(self) -> np.ndarray:
        """Orthonormal basis of the whitened derivatives of the mean, shape (n - 1, rank)."""
        return _basis(self._directions())

    @cached_property
    def covariance(self) -> np.ndarray:
        """Return the covariance of the terms' free parameters, in their order, the spectrum taken as known."""
        columns = self._directions()
        precision = columns.T @ columns
        norms = np.sqrt(np.diag(precision))
        norms[norms == 0] = np.inf
        inverse = np.linalg.pinv(precision / np.outer(norms, norms), rcond=1e-12, hermitian=True)
        return inverse / np.outer(norms, norms)

    def without_cache(self) -> "AxisFit":
        """Return the fit without its cached arrays."""
        return replace(self)

    @cached_property
    def _made(self) -> dict[Callable, object]:
        return {}

    def once(self, make: Callable[["AxisFit"], Made]) -> Made:
        """Return ``make(self)``, computed at the first call: a search asks one fit time and again."""
        if make not in self._made:
            self._made[make] = make(self)
        return self._made[make]

    def has(self, kind: type[Effect]) -> bool:
        """Return whether the description has an effect of a kind."""
        return any(isinstance(effect, kind) for effect in self.description.effects())

    @cached_property
    def _excess(self) -> tuple[np.ndarray, np.ndarray]:
        """Return excess and variance of the power per coefficient in each bin."""
        bins = self.sequence.bins
        variance = self.description.noise.variance(bins)
        return bins.sums(self.coefficients**2) / bins.number * variance - variance, variance

    @cached_property
    def top(self) -> float:
        """Return by how many standard deviations the power of the upper fifth of what is used exceeds the fit."""
        last = self.sequence.bins.last
        upper = self.coefficients[int(0.8 * last) : last]
        return float((np.mean(upper**2) - 1) * np.sqrt(len(upper) / 2))

    def _room(self, effect: StochasticEffect) -> tuple[float, float]:
        bins, (excess, variance) = self.sequence.bins, self._excess
        shape = Noise((effect,), self.description.noise.output_filter).passed(bins)
        weight = bins.number * shape / variance**2
        return float(weight @ excess), float(weight @ shape)

    def room(self, effect: StochasticEffect) -> float:
        """Return the factor of an effect's amplitude at which the spectrum, to first order, has most room for it.

        Zero where the likelihood falls as soon as the effect is there.
        """
        score, information = self._room(effect)
        return float(np.sqrt(max(score, 0.0) / information))

    def gain_of(self, effect: StochasticEffect) -> float:
        """Return the gain of log-likelihood, to second order, of adding an effect of the given size."""
        score, information = self._room(effect)
        return 0.5 * score - 0.25 * information

    @cached_property
    def lines(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return frequencies [Hz], gains of log-likelihood of a sinusoid at each, and the level around it."""
        return scans.lines(self.whitened, self.sequence.conditions.interval)

    @cached_property
    def ripples(self) -> tuple[np.ndarray, np.ndarray]:
        """Size and gain of log-likelihood of an echo, to second order, by its delay of 1, 2, ... samples."""
        return scans.ripples(self.coefficients[: self.sequence.bins.last], len(self.coefficients) + 1)

    @cached_property
    def steps(self) -> scans.StepFilters:
        """Gain of log-likelihood of a step of the mean at each sample, before the output filter."""
        return self.steps_beside(np.empty((len(self.coefficients), 0)))

    def steps_beside(self, columns: np.ndarray) -> scans.StepFilters:
        """Return the gain of a step at each sample, fitted together with whitened columns, shape (n - 1, m)."""
        more, rest = self.beside(columns)
        even = self._unturned(np.column_stack([rest, self.basis, more]))
        return scans.steps(even[:, 0], self.scatter.root**2 / self._gain, even[:, 1:])

    @property
    def _gain(self) -> np.ndarray:
        """Return the gain of power of the filter of the output at each cosine coefficient k = 1..n-1."""
        return self.description.noise.gain(self.sequence.bins)

    def _unturned(self, coefficients: np.ndarray) -> np.ndarray:
        """Return cosine coefficients, shape (n - 1, m), without the phase of the output filter."""
        output_filter, interval = self.description.noise.output_filter, self.sequence.conditions.interval
        if output_filter is None:
            return coefficients
        values = idct(np.pad(coefficients, ((1, 0), (0, 0))), axis=0, norm="ortho")
        count = len(values)
        spectrum = output_filter.unturned(rfft(values, axis=0).T, rfftfreq(count, interval), interval)
        return cosine_coefficients(irfft(spectrum.T, count, axis=0))

    def steps_without(self, index: int) -> scans.StepFilters:
        """Return the gain of a step at each sample in place of the term at ``index``."""
        return replace(self, description=self.description.without([index])).steps

    @cached_property
    def cells(self) -> Cells | None:
        """Rounding intervals of the samples on a coarse lattice, or None where they are not informative."""
        if not self.sequence.coarse:
            return None
        return Cells.of(self.sequence, self.description.noise, self.residual, self.scale)

    @cached_property
    def unrounded(self) -> np.ndarray:
        """Whitened residual, shape (n,), before the rounding where the lattice is coarse."""
        if self.cells is None:
            return self.whitened
        return self.cells.drawn(stream(0, "cells", self.sequence.conditions.axis))

    @cached_property
    def tails(self) -> Tails:
        """Mixture of two normal distributions in the whitened residual, before a coarse rounding."""
        if self.cells is not None:
            return self.cells.tails()
        return parted_tails(self.whitened, self.sequence.bins.last / len(self.whitened), self._response)

    @property
    def _response(self) -> np.ndarray:
        """Return what a deviation of a sample adds to the whitened residual there, as one, and at the samples next."""
        kernel = irfft(np.r_[0.0, 1 / self.scatter.root, 0.0])
        return kernel[:RESPONSE] / kernel[0]

    @cached_property
    def unit(self) -> float:
        """Size [unit of the axis] of a deviation of a single sample that is one in the residual of :attr:`tails`.

        A single sample has a share of every cosine, so that it comes out of the residual made white by the mean of
        1/sqrt(S) over the frequencies, whatever the root of the mean of S is.
        """
        if self.cells is not None:
            return self.cells.unit
        last = self.sequence.bins.last
        return np.sqrt(len(self.variance) / last) / float(np.mean(self.variance[:last] ** -0.5))

    @cached_property
    def stretch(self) -> tuple[float, int, int]:
        """Return gain, first sample and last sample + 1 of the stretch whose variance differs most."""
        return scans.stretches(self.unrounded)

    @cached_property
    def swing(self) -> tuple[float, float, float, float]:
        """Return frequency [Hz], depth, phase and gain of the swing of the variance that is most likely."""
        return scans.swing(self.unrounded, self.sequence.conditions.time)

    def beyond(self, columns: np.ndarray) -> np.ndarray:
        """Return whitened columns less their projection on the terms, shape (n - 1, m)."""
        return columns - self.basis @ (self.basis.T @ columns) if self.basis.size else columns

    def beside(self, columns: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return an orthonormal basis of whitened columns beyond the terms, and the coefficients without them."""
        basis = _basis(self.beyond(columns))
        return basis, self.coefficients - basis @ (basis.T @ self.coefficients)

    def gains(self, columns: np.ndarray) -> np.ndarray:
        """Return the gain of log-likelihood of each whitened column alone, shape (m,), the terms free to move."""
        rest = self.beyond(columns)
        norm = np.einsum("ij,ij->j", rest, rest)
        lost = norm < 1e-6 * np.einsum("ij,ij->j", columns, columns)
        return np.where(lost, 0.0, 0.5 * (rest.T @ self.coefficients) ** 2 / np.where(lost, 1.0, norm))

    def joint_gain(self, columns: np.ndarray) -> tuple[float, int]:
        """Return the gain of log-likelihood of whitened columns together and their rank beyond the terms."""
        rest = self.beyond(columns)
        gram, seen = rest.T @ rest, rest.T @ self.coefficients
        norms = np.sqrt(np.diag(gram))
        kept = norms > 1e-3 * np.linalg.norm(columns, axis=0)
        values, vectors = _principal(gram[np.ix_(kept, kept)])
        parts = (vectors / norms[kept, None]).T @ seen[kept]
        return float(0.5 * np.sum(parts**2 / values)), len(values)


def scale(sequence: AxisSequence, changes: tuple[VarianceEffect, ...]) -> np.ndarray | float:
    """Return the factor of the standard deviation at each sample, shape (n,), or 1."""
    return _scale_of(sequence, changes) if changes else 1.0


@lru_cache(maxsize=CACHED_TRANSFORMS)
def _scale_of(sequence: AxisSequence, changes: tuple[VarianceEffect, ...]) -> np.ndarray:
    factor = np.sqrt(np.prod([change.factor(sequence.conditions.time) for change in changes], axis=0))
    factor.flags.writeable = False
    return factor


def _centred(sequence: AxisSequence, description: Description) -> np.ndarray:
    """Return the samples less the systematic terms and their mean, over the scale of the changes of variance."""
    rest = _rest(sequence, description)
    return (rest - _level(rest, sequence, description)) / scale(sequence, description.changes)


def _seen(sequence: AxisSequence, description: Description) -> np.ndarray:
    """Return the cosine coefficients of the samples less the systematic terms; they do not depend on the noise."""
    shaping = tuple(entry for entry in description.entries if entry.effect.role in SHAPING_ROLES)
    return _seen_of(sequence, shaping)


@lru_cache(maxsize=CACHED_TRANSFORMS)
def _seen_of(
    sequence: AxisSequence,
    entries: tuple[Entry, ...],
) -> np.ndarray:
    seen = cosine_coefficients(_centred(sequence, Description(entries)))
    seen.flags.writeable = False
    return seen


@dataclass(frozen=True, eq=False)
class Scatter:
    """How the cosine coefficients of a sequence scatter under the noise of a description.

    Attributes
    ----------
    sequence
        The samples.
    root
        Standard deviation of each coefficient, infinite where it is not used, shape (n - 1,).
    outside
        What may be in them from outside the log.
    """

    sequence: AxisSequence
    root: np.ndarray
    outside: Outside | None

    @classmethod
    def of(cls, sequence: AxisSequence, description: Description) -> "Scatter":
        """Return that of a description's noise and filter."""
        bins, noise = sequence.bins, description.noise
        root = np.sqrt(noise.spread(bins))
        root[bins.last :] = np.inf
        return cls(sequence, root, Outside.of(noise, len(sequence.values), sequence.conditions.interval, root))

    def left(self, description: Description) -> np.ndarray:
        """Return the coefficients of what a description's terms leave, without what is from outside the log."""
        seen = _seen(self.sequence, description)
        return seen if self.outside is None else self.outside.without(seen)

    def whiten(self, columns: np.ndarray, description: Description) -> np.ndarray:
        """Return columns of the error, shape (n, m), as coefficients over their deviations, shape (n - 1, m)."""
        output = _passed(columns, self.sequence, description)
        if description.changes:
            output = output / scale(self.sequence, description.changes)[:, None]
        coefficients = cosine_coefficients(output)
        coefficients /= self.root[:, None]
        return coefficients


def offset(sequence: AxisSequence, description: Description) -> float:
    """Return the mean of the samples less the systematic terms, the noisier stretches of less weight."""
    return float(_level(_rest(sequence, description), sequence, description))


def _rest(sequence: AxisSequence, description: Description) -> np.ndarray:
    """Return the samples less the systematic terms, and less what a filter of the output takes from the input."""
    if not description.terms and description.noise.output_filter is None:
        return sequence.values
    ideal = sequence.conditions.error_free
    mean = sum((term.effect.sample(sequence.conditions, None) for term in description.terms), ideal)
    if np.ndim(mean) == 0:
        return sequence.values - mean
    return sequence.values - (_passed(mean, sequence, description) - ideal)


def _passed(values: np.ndarray, sequence: AxisSequence, description: Description) -> np.ndarray:
    """Return what the filter of the output lets through of errors, shape (n,) or (n, m)."""
    output_filter = description.noise.output_filter
    return values if output_filter is None else output_filter.passed(values, sequence.conditions.interval)


def _level(rest: np.ndarray, sequence: AxisSequence, description: Description) -> float:
    if not description.changes:
        return np.mean(rest)
    return np.average(rest, weights=scale(sequence, description.changes) ** -2.0)


def jacobian(terms: Sequence[Entry], sequence: AxisSequence) -> np.ndarray:
    """Return the derivatives of the mean in the free parameters, shape (n, parameters)."""
    columns = [column for term in terms for column in _slopes(term, sequence)]
    return np.array(columns).T if columns else np.empty((len(sequence.values), 0))


def _slopes(term: Entry, sequence: AxisSequence) -> list[np.ndarray]:
    slopes = term.effect.slopes(sequence.conditions)
    if not slopes.keys() >= set(term.free):
        expected, found = ", ".join(term.free), ", ".join(slopes) or "none"
        raise ValueError(f"{term.effect.name}: slopes: expected those of {expected}; found {found}")
    return [slopes[name] for name in term.free]


def _basis(columns: np.ndarray) -> np.ndarray:
    """Return an orthonormal basis of the span of columns, shape (n, rank)."""
    if not columns.shape[1]:
        return columns
    gram = columns.T @ columns
    norms = np.sqrt(np.diag(gram))
    values, vectors = _principal(gram)
    return columns @ (vectors / (np.where(norms > 0, norms, 1.0)[:, None] * np.sqrt(values)))


def _principal(gram: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return variances and directions that columns of a Gram matrix, of norm 1 each, span; (rank,) and (m, rank)."""
    norms = np.sqrt(np.diag(gram))
    norms[norms == 0] = 1.0
    values, vectors = np.linalg.eigh(gram / np.outer(norms, norms))
    kept = values > 1e-9 * len(values)
    return values[kept], vectors[:, kept]


def fit(sequence: AxisSequence, start: Description) -> AxisFit:
    """Fit a description to a sequence, from the values that it comes with.

    What a filter takes from a known input tells its cutoff, far better than the noise does: there it is adjusted by
    steps of Gauss and Newton of both together, ahead of all else.
    """
    if start.noise.output_filter is None or not sequence.in_motion:
        return _fitted(sequence, start)
    found = _surer(_fitted(sequence, start, held=True))
    for _ in range(MAX_ALTERNATIONS):
        moved = _cut_off_anew(found)
        if moved.log_likelihood < found.log_likelihood + MIN_GAIN:
            break
        found = moved
    return found


def _surer(found: AxisFit) -> AxisFit:
    """Return a fit whose noise knows what the mean tells of the log cutoff besides, the terms free to move."""
    sequence, interval = found.sequence, found.sequence.conditions.interval
    ends = (_seen(sequence, _cut_off(found.description, side, interval)) for side in (CUTOFF_STEP, -CUTOFF_STEP))
    slope = found.beyond(np.subtract(*ends)[:, None] / (2 * CUTOFF_STEP) / found.scatter.root[:, None])[:, 0]
    gradient, information = found.noise.gradient.copy(), found.noise.information.copy()
    gradient[-1] -= slope @ found.coefficients
    information[-1, -1] += slope @ slope
    return replace(found, noise=replace(found.noise, gradient=gradient, information=information))


def _cut_off_anew(found: AxisFit) -> AxisFit:
    """Return the fit after a step of the log cutoff, shortened until it is no worse, or the same fit."""
    step, sequence = found.noise.covariance[-1, -1] * found.noise.gradient[-1], found.sequence
    step = float(np.clip(step, -MAX_CUTOFF_STEP, MAX_CUTOFF_STEP))
    for _ in range(MAX_SHORTENINGS):
        moved = _fitted(sequence, _cut_off(found.description, step, sequence.conditions.interval), held=True)
        if moved.log_likelihood >= found.log_likelihood:
            return _surer(moved)
        step = step / 3
    return found


def _cut_off(description: Description, step: float, interval: float) -> Description:
    """Return a description with the cutoff of its filter moved by a step of its logarithm, as far as a fit can tell."""
    one = description.noise.output_filter
    moved = one.adjusted_to(min(one.adjusted * float(np.exp(step)), one.highest(interval)))
    return description.with_noise(replace(description.noise, output_filter=moved))


def _fitted(sequence: AxisSequence, start: Description, held: bool = False) -> AxisFit:
    """Return the fit of mean and noise in turn; the cutoff of a filter stays where it is ``held``."""
    description, last, scatter = start, -np.inf, Scatter.of(sequence, start)
    fixed = not start.terms and start.noise.output_filter is None
    for _ in range(MAX_ALTERNATIONS):
        left = scatter.left(description)
        noise = fit_noise(description.noise, sequence.bins, sequence.bins.sums(left**2), held)
        description = description.with_noise(noise.noise)
        value = noise.log_likelihood - _jacobian_of_scale(sequence, description)
        if value < last + MIN_GAIN or fixed:
            break
        last, scatter = value, Scatter.of(sequence, description)
        description = _mean_moved(scatter, description)
    return AxisFit(sequence, description, value, noise)


def log_score(sequence: AxisSequence, description: Description) -> float:
    """Return the log-density of a sequence, free of its offset, under a description with values from elsewhere."""
    bins = sequence.bins
    power = bins.sums(Scatter.of(sequence, description).left(description) ** 2)
    variance = description.noise.variance(bins)
    return log_likelihood(variance, power, bins.number) - _jacobian_of_scale(sequence, description)


def _jacobian_of_scale(sequence: AxisSequence, description: Description) -> float:
    """Return the logarithm of what the scale does to the density of the coefficients that are used."""
    bins = sequence.bins
    return bins.last * float(np.mean(np.log(scale(sequence, description.changes))))


def _mean_moved(scatter: Scatter, description: Description) -> Description:
    """Return the description after steps of Gauss and Newton of its terms under its spectrum."""
    rest = scatter.left(description) / scatter.root
    for _ in range(MAX_SHORTENINGS):
        columns = scatter.whiten(jacobian(description.terms, scatter.sequence), description)
        step = normal_equations.solution(columns.T @ columns, columns.T @ rest, OPEN)
        moved, after = _line_search(scatter, description, step, rest)
        gained = 0.5 * (rest @ rest - after @ after)
        if gained <= 0:
            break
        description, rest = moved, after
        if gained < MIN_GAIN:
            break
    return description


def _line_search(
    scatter: Scatter, description: Description, step: np.ndarray, rest: np.ndarray
) -> tuple[Description, np.ndarray]:
    for _ in range(MAX_SHORTENINGS):
        first, terms = 0, []
        for term in description.terms:
            terms.append(term.moved(step[first : first + len(term.free)]))
            first += len(term.free)
        moved = description.exchanging(Role.MEAN, terms)
        after = scatter.left(moved) / scatter.root
        if after @ after < rest @ rest:
            return moved, after
        step = step / 3
    return description, rest

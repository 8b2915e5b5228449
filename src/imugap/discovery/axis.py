"""A description of one axis and its fit: systematic terms, random processes, stretches of another variance.

The mean is fitted by generalised least squares under the spectrum, the spectrum by Whittle's likelihood to what the
mean leaves, in turn until neither moves; both in the basis of the cosine transform.
"""

from collections.abc import Sequence as Several
from dataclasses import dataclass, replace
from functools import cached_property
from math import exp

import numpy as np
from scipy.fft import dct, idct, irfft, rfft, rfftfreq

from imugap.discovery import scans
from imugap.discovery.cells import Cells
from imugap.discovery.noise import Noise, NoiseFit, log_likelihood
from imugap.discovery.noise import fit as fit_noise
from imugap.discovery.sequence import Sequence
from imugap.discovery.tails import Tails, tails
from imugap.effects import Outliers, OutputFilter, Quantization, VarianceChange
from imugap.effects.effect import TINY, Effect, StochasticEffect
from imugap.stream import stream

ROUNDS = 8
"""Turns between mean and spectrum."""
SETTLED = 0.02
"""Change of log-likelihood below which the turns end."""
HALVINGS = 6
UNSURE = 0.03
"""Standard deviation of the logarithm of a cutoff, as far as what a filter lets go of may say."""


@dataclass(frozen=True)
class Term:
    """A systematic effect and which of its parameters a fit adjusts."""

    effect: Effect
    free: tuple[str, ...]

    def moved(self, step: np.ndarray) -> "Term":
        """Return the term with its free parameters changed by ``step``, kept within their physical limits."""
        values = {item: self._moved(item, change) for item, change in zip(self.free, step.tolist(), strict=True)}
        return Term(replace(self.effect, **values), self.free)

    def _moved(self, name: str, change: float) -> float:
        """Return a parameter after a change; one that has to be positive changes by a factor, of e at most."""
        value, (low, high) = getattr(self.effect, name), self.effect.limits()[name]
        if low > 0:
            return min(value * exp(min(max(change / value, -1.0), 1.0)), high)
        return min(max(value + change, low), high)


@dataclass(frozen=True)
class Description:
    """What is said to be on an axis besides an offset."""

    terms: tuple[Term, ...]
    noise: Noise
    changes: tuple[VarianceChange, ...] = ()
    outliers: Outliers | None = None

    def effects(self) -> tuple[Effect, ...]:
        """Return all effects."""
        return (*(term.effect for term in self.terms), *self.noise, *self.changes, *filter(None, [self.outliers]))

    def size(self) -> int:
        """Return the number of adjusted parameters."""
        free = (*(term.free for term in self.terms), self.noise.parameters(), *(one.free() for one in self.changes))
        return sum(map(len, free))


@dataclass(frozen=True, eq=False)
class AxisFit:
    """A description at its maximum of likelihood on a sequence.

    Attributes
    ----------
    sequence, description
        The data and the fitted description.
    log_likelihood
        Log-density of the samples, free of their offset.
    noise
        Fit of the random part.
    """

    sequence: Sequence
    description: Description
    log_likelihood: float
    noise: NoiseFit

    @cached_property
    def scale(self) -> np.ndarray | float:
        """Return the factor of the standard deviation over time that the changes of variance make."""
        return scale(self.sequence, self.description.changes)

    @cached_property
    def variance(self) -> np.ndarray:
        """Return the variance of each cosine coefficient k = 1..n-1."""
        bins = self.sequence.bins
        return bins.spread(self.description.noise.variance(bins))

    @cached_property
    def _root(self) -> np.ndarray:
        """Return the standard deviation of each coefficient, infinite where it is not used."""
        return _roots(self.sequence, self.description)

    @cached_property
    def residual(self) -> np.ndarray:
        """Return what the systematic terms leave, of equal variance over time, shape (n,)."""
        return residual(self.sequence, self.description)

    @cached_property
    def power(self) -> np.ndarray:
        """Return the sums of the residual's squared cosine coefficients over the bins."""
        return self.sequence.bins.sums(cosines(self.residual) ** 2)

    @cached_property
    def coefficients(self) -> np.ndarray:
        """Return the residual's cosine coefficients over their standard deviations, k = 1..n-1; zero if not used."""
        return cosines(self.residual) / self._root

    @cached_property
    def whitened(self) -> np.ndarray:
        """Return the residual made white, shape (n,): of unit variance if the description is right."""
        full = np.sqrt(len(self.coefficients) / self.sequence.bins.last)
        return full * idct(np.r_[0.0, self.coefficients], norm="ortho")

    def whiten(self, columns: np.ndarray) -> np.ndarray:
        """Return columns of the error, (n, m), in basis and scale of :attr:`coefficients`, shape (n - 1, m)."""
        return _whitened(columns, self.sequence, self.description, self._root)

    def _directions(self) -> np.ndarray:
        """Return the derivatives of the mean by the terms' free parameters, whitened, shape (n - 1, parameters)."""
        return self.whiten(jacobian(self.description.terms, self.sequence))

    @cached_property
    def basis(self) -> np.ndarray:
        """Return an orthonormal basis of the directions that the terms can move the mean in, whitened."""
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

    def bare(self) -> "AxisFit":
        """Return the fit without what was derived from it, which is many times its size."""
        return replace(self)

    def has(self, kind: type[Effect]) -> bool:
        """Return whether an effect of a kind is described."""
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
    def steps(self) -> scans.Steps:
        """Return what a step of the mean gains at each sample, ahead of the filter of the output."""
        return self.steps_beside(np.empty((len(self.coefficients), 0)))

    def steps_beside(self, columns: np.ndarray) -> scans.Steps:
        """Return what a step gains at each sample beside whitened columns more, (n - 1, m), which are fitted too."""
        more, rest = self.beside(columns)
        even = self._unturned(np.column_stack([rest, self.basis, more]))
        return scans.steps(even[:, 0], self._root**2 / self._gain, even[:, 1:])

    @property
    def _gain(self) -> np.ndarray | float:
        """Return the gain of power of the filter of the output at each cosine coefficient k = 1..n-1, or 1."""
        output_filter, bins = self.description.noise.output_filter, self.sequence.bins
        return 1.0 if output_filter is None else bins.spread(output_filter.gain(bins.frequency, bins.interval))

    def _unturned(self, coefficients: np.ndarray) -> np.ndarray:
        """Return columns of cosine coefficients, shape (n - 1, m), without the phase of the filter of the output."""
        output_filter, interval = self.description.noise.output_filter, self.sequence.conditions.interval
        if output_filter is None:
            return coefficients
        values = idct(np.pad(coefficients, ((1, 0), (0, 0))), axis=0, norm="ortho")
        count = len(values)
        spectrum = output_filter.unturned(rfft(values, axis=0).T, rfftfreq(count, interval), interval)
        return cosines(irfft(spectrum.T, count, axis=0))

    def steps_without(self, index: int) -> scans.Steps:
        """Return what a step gains at each sample in the place of a term, the rest as it is."""
        terms = self.description.terms
        return replace(self, description=replace(self.description, terms=terms[:index] + terms[index + 1 :])).steps

    @cached_property
    def cells(self) -> Cells | None:
        """Return the cells in which the samples of a coarse lattice are known to be, if they say something."""
        return Cells.of(self) if self.sequence.coarse else None

    @cached_property
    def unrounded(self) -> np.ndarray:
        """Return the residual made white, ahead of a coarse lattice where its cells say something, shape (n,)."""
        if self.cells is None:
            return self.whitened
        return self.cells.drawn(stream(0, "cells", self.sequence.conditions.axis))

    @cached_property
    def tails(self) -> Tails:
        """Return the two normal laws in the residual made white, ahead of a coarse lattice if its cells tell them."""
        if self.cells is not None:
            return self.cells.tails()
        return tails(self.whitened, self.sequence.bins.last / len(self.whitened))

    @cached_property
    def stretch(self) -> tuple[float, int, int]:
        """Return gain, first sample and last sample + 1 of the stretch whose variance differs most."""
        return scans.stretches(self.unrounded)

    @cached_property
    def swing(self) -> tuple[float, float, float, float]:
        """Return frequency [Hz], depth, phase and gain of the swing of the variance that is most likely."""
        return scans.swing(self.unrounded, self.sequence.conditions.time)

    def beyond(self, columns: np.ndarray) -> np.ndarray:
        """Return what the terms leave of whitened columns, shape (n - 1, m)."""
        return columns - self.basis @ (self.basis.T @ columns)

    def beside(self, columns: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return a basis of what whitened columns say beside the terms, and the coefficients that are left of them."""
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
        norms = np.linalg.norm(columns, axis=0)
        kept = np.linalg.norm(rest, axis=0) > 1e-3 * norms
        basis = _basis(rest[:, kept] / norms[kept])
        return float(0.5 * np.sum((basis.T @ self.coefficients) ** 2)), basis.shape[1]


def cosines(values: np.ndarray) -> np.ndarray:
    """Return the orthonormal cosine coefficients k = 1..n-1 of columns."""
    return dct(values, axis=0, norm="ortho")[1:]


def scale(sequence: Sequence, changes: Several[VarianceChange]) -> np.ndarray | float:
    """Return the factor of the standard deviation at each sample, shape (n,), or 1."""
    if not changes:
        return 1.0
    return np.sqrt(np.prod([change.factor(sequence.conditions.time) for change in changes], axis=0))


def residual(sequence: Sequence, description: Description) -> np.ndarray:
    """Return the samples less the systematic terms and their mean, over the scale of the changes of variance."""
    rest = _rest(sequence, description)
    centred = (rest - _level(rest, sequence, description)) / scale(sequence, description.changes)
    return _without_outside(centred, sequence, description)


def _without_outside(values: np.ndarray, sequence: Sequence, description: Description) -> np.ndarray:
    """Return samples, shape (n,), without what comes from before the log or is cut off at its end.

    Differences of rounding errors, S ~ f^2, are as smooth at the ends as the cosines need but for those before the
    first and at the last; they are replaced by nothing where the log tells them (their posterior mean), and stay where
    other noise hides them. A filter has still to let go of what was there before the log, of which nothing is known.
    """
    columns, output_filter = _ends(sequence, description), description.noise.output_filter
    known = [1.0] * columns.shape[1]
    if output_filter is not None:
        columns, known = np.column_stack([columns, *_decay(sequence, output_filter)]), [*known, 0.0, 1.0]
    if not known:
        return values
    root = _roots(sequence, description)
    whitened, seen = cosines(columns) / root[:, None], cosines(values) / root
    if output_filter is not None:
        size = _sizes(whitened[:, :-1], seen, known[:-1])[-1]
        columns[:, -1], whitened[:, -1] = size * columns[:, -1], size * whitened[:, -1]
    return values - columns @ _sizes(whitened, seen, known)


def _ends(sequence: Sequence, description: Description) -> np.ndarray:
    """Return the rounding errors before the first sample and at the last, as the output has them, shape (n, 2 or 0)."""
    rounded = [effect.q for effect in description.noise.effects if isinstance(effect, Quantization)]
    ends = np.zeros((len(sequence.values), 2 * len(rounded)))
    if rounded:
        ends[[0, -1], [0, 1]] = rounded[0] / sequence.conditions.interval
    return _passed(ends, sequence, description)


def _decay(sequence: Sequence, output_filter: OutputFilter) -> tuple[np.ndarray, np.ndarray]:
    """Return how a filter lets go of what was before the log, and how else it would do so by a lower cutoff."""
    count, interval = len(sequence.values), sequence.conditions.interval
    lower = replace(output_filter, cutoff=output_filter.cutoff * (1 - UNSURE))
    decay = output_filter.decay(count, interval)
    return decay, lower.decay(count, interval) - decay


def _sizes(whitened: np.ndarray, seen: np.ndarray, known: Several[float]) -> np.ndarray:
    """Return the sizes of whitened columns, shape (n - 1, m); each is zero to 1/sqrt(``known``) a priori."""
    precision = whitened.T @ whitened + np.diag(known)
    units = np.sqrt(np.maximum(np.diag(precision), TINY))
    return np.linalg.lstsq(precision / np.outer(units, units), whitened.T @ seen / units)[0] / units


def offset(sequence: Sequence, description: Description) -> float:
    """Return the mean of the samples less the systematic terms, the noisier stretches of less weight."""
    return float(_level(_rest(sequence, description), sequence, description))


def _rest(sequence: Sequence, description: Description) -> np.ndarray:
    if not description.terms:
        return sequence.values
    mean = sum(term.effect.sample(sequence.conditions, None) for term in description.terms)
    return sequence.values - _passed(mean, sequence, description)


def _passed(values: np.ndarray, sequence: Sequence, description: Description) -> np.ndarray:
    """Return what the filter of the output lets through of errors, shape (n,) or (n, m)."""
    output_filter = description.noise.output_filter
    return values if output_filter is None else output_filter.passed(values, sequence.conditions.interval)


def _level(rest: np.ndarray, sequence: Sequence, description: Description) -> float:
    if not description.changes:
        return np.mean(rest)
    return np.average(rest, weights=scale(sequence, description.changes) ** -2.0)


def jacobian(terms: Several[Term], sequence: Sequence) -> np.ndarray:
    """Return the derivatives of the mean in the free parameters, shape (n, parameters)."""
    columns = [column for term in terms for column in _slopes(term, sequence)]
    return np.array(columns).T if columns else np.empty((len(sequence.values), 0))


def _slopes(term: Term, sequence: Sequence) -> list[np.ndarray]:
    slopes = term.effect.slopes(sequence.conditions)
    return [slopes[name] for name in term.free]


def _basis(columns: np.ndarray) -> np.ndarray:
    """Return an orthonormal basis of the span of columns, shape (n, rank)."""
    if not columns.shape[1]:
        return columns
    norms = np.linalg.norm(columns, axis=0)
    scaled = columns / np.where(norms > 0, norms, 1.0)
    values, vectors = np.linalg.eigh(scaled.T @ scaled)
    kept = values > 1e-9 * len(values)
    return scaled @ (vectors[:, kept] / np.sqrt(values[kept]))


def fit(sequence: Sequence, start: Description) -> AxisFit:
    """Fit a description to a sequence, from the values that it comes with."""
    description, last = start, -np.inf
    fixed = not start.terms and start.noise.output_filter is None
    for _ in range(ROUNDS):
        rest = residual(sequence, description)
        noise = fit_noise(description.noise, sequence.bins, sequence.bins.sums(cosines(rest) ** 2))
        description = replace(description, noise=noise.noise)
        value = noise.log_likelihood - _jacobian_of_scale(sequence, description)
        if value < last + SETTLED or fixed:
            break
        last = value
        description = _mean_moved(sequence, description)
    return AxisFit(sequence, description, value, noise)


def log_score(sequence: Sequence, description: Description) -> float:
    """Return the log-density of a sequence, free of its offset, under a description with values from elsewhere."""
    bins = sequence.bins
    power = bins.sums(cosines(residual(sequence, description)) ** 2)
    variance = description.noise.variance(bins)
    return log_likelihood(variance, power, bins.number) - _jacobian_of_scale(sequence, description)


def _jacobian_of_scale(sequence: Sequence, description: Description) -> float:
    """Return the logarithm of what the scale does to the density of the coefficients that are used."""
    bins = sequence.bins
    return bins.last * float(np.mean(np.log(scale(sequence, description.changes))))


def _mean_moved(sequence: Sequence, description: Description) -> Description:
    """Return the description after steps of Gauss and Newton of its terms under its spectrum."""
    root = _roots(sequence, description)
    rest = cosines(residual(sequence, description)) / root
    for _ in range(HALVINGS):
        columns = _whitened(jacobian(description.terms, sequence), sequence, description, root)
        precision = columns.T @ columns
        norms = np.sqrt(np.diag(precision))
        norms[norms == 0] = 1.0
        step = np.linalg.lstsq(precision / np.outer(norms, norms), columns.T @ rest / norms, rcond=1e-10)[0]
        moved, after = _line_search(sequence, description, step / norms, root, rest)
        gained = 0.5 * (rest @ rest - after @ after)
        if gained <= 0:
            break
        description, rest = moved, after
        if gained < SETTLED:
            break
    return description


def _whitened(columns: np.ndarray, sequence: Sequence, description: Description, root: np.ndarray) -> np.ndarray:
    """Return columns of the error, shape (n, m), as cosine coefficients over their deviations ``root``."""
    factor = np.reshape(scale(sequence, description.changes), (-1, 1))
    return cosines(_passed(columns, sequence, description) / factor) / root[:, None]


def _roots(sequence: Sequence, description: Description) -> np.ndarray:
    """Return the standard deviation of each coefficient, infinite where it is not used."""
    bins = sequence.bins
    root = np.sqrt(bins.spread(description.noise.variance(bins)))
    root[bins.last :] = np.inf
    return root


def _line_search(
    sequence: Sequence, description: Description, step: np.ndarray, root: np.ndarray, rest: np.ndarray
) -> tuple[Description, np.ndarray]:
    for _ in range(HALVINGS):
        first, terms = 0, []
        for term in description.terms:
            terms.append(term.moved(step[first : first + len(term.free)]))
            first += len(term.free)
        moved = replace(description, terms=tuple(terms))
        after = cosines(residual(sequence, moved)) / root
        if after @ after < rest @ rest:
            return moved, after
        step = step / 3
    return description, rest

"""Gaussian likelihood of an error sequence under an error model, its mean (and, on request, a ramp) unknown.

Two exact forms of the same number, the log-density of the n - 1 orthonormal contrasts that are free of the mean:

- :func:`innovations`: Kalman filter, for any model with a state space;
- :func:`log_likelihood`: cosine transform, for sums of white noise, random walk and Gauss-Markov processes.

In the basis of the DCT-II the contrasts are the coefficients k = 1..n-1, at frequencies k/(2 n dt), and (with
s = sin^2(pi k/(2n)), a_k = sqrt(2/n) cos(pi k/(2n)), phi = exp(-dt/T))

- white noise and random walk have diagonal covariances N^2/dt and K^2 dt/(4 s): the differences of the sequence have a
  tridiagonal Toeplitz covariance, which the DST-I diagonalises (Strang 1999, SIAM Review 41, 135-147);
- the inverse covariance of a Gauss-Markov sequence is [(1 - phi)^2 + 4 phi s + phi (1 - phi) (e_1 e_1' + e_n e_n')]
  /(std^2 (1 - phi^2)). The end points separate into even and odd k, so within each parity the Woodbury identity gives
  the covariance diag(c/g) - b u u', g = (1 - phi)^2 + 4 phi s, c = std^2 (1 - phi^2), u = a/g,
  b = 2 std^2 phi (1 - phi)^2 (1 - phi^n) for even and (1 + phi^n) for odd k.

The covariance of the sum is thus a diagonal, S(f_k)/dt with the PSD S of the sampled sequence, less one rank per
Gauss-Markov process and parity. A ramp is one more, diffuse, rank among the odd k. Where neighbouring coefficients
have nearly the same variance they are summed (:class:`Grid`), which makes an evaluation independent of the length.

A process that is given by one density and its ``sampled_psd`` alone (flicker) enters through its diagonal: for it the
likelihood is Whittle's in the cosine basis, whose leakage is that of a sequence without jumps at its ends.
"""

from dataclasses import dataclass, fields
from functools import cached_property, lru_cache

import numpy as np
from numba import njit
from scipy.fft import dct

from imugap.effects import GaussMarkov
from imugap.effects.effect import AxisModel
from imugap.numerics.small_matrix import invert

SMALLEST = 1e-150
"""Largest range of samples whose squares are no numbers."""
SINGLE = 64
"""Lowest coefficients of each parity that are kept one by one."""
WIDTH = 0.03
"""Relative width of the bins above."""


@dataclass(frozen=True, eq=False)
class Grid:
    """The cosine coefficients of a log, binned within each parity; even coefficients first.

    Attributes
    ----------
    count, interval
        Number of samples n and sampling interval [s].
    index
        Mean index k of the coefficients of a bin, shape (m,).
    number, leverage
        Number of coefficients and sum of a_k^2 in a bin, shape (m,).
    edges
        First coefficient of each bin, for even and for odd k.
    odd
        First bin of the odd coefficients.
    """

    count: int
    interval: float
    index: np.ndarray
    number: np.ndarray
    leverage: np.ndarray
    edges: tuple[np.ndarray, np.ndarray]
    odd: int

    @classmethod
    @lru_cache(maxsize=8)
    def of(cls, count: int, interval: float, highest: float = np.inf) -> "Grid":
        """Return the grid of ``count`` samples, without the coefficients above ``highest`` [Hz]."""
        last = int(min(count - 1, 2 * count * interval * highest))
        if last < 3:
            raise ValueError(f"likelihood: expected at least 4 samples below {highest} Hz; found {last + 1}")
        parities = [np.arange(first, last + 1, 2) for first in (2, 1)]
        edges = tuple(_edges(len(indices)) for indices in parities)
        number = [np.add.reduceat(np.ones(len(k)), edge) for k, edge in zip(parities, edges, strict=True)]
        index = [np.add.reduceat(k * 1.0, e) / m for k, e, m in zip(parities, edges, number, strict=True)]
        leverage = [np.add.reduceat(_end_point(k, count) ** 2, e) for k, e in zip(parities, edges, strict=True)]
        return cls(count, interval, *map(np.concatenate, (index, number, leverage)), edges, len(edges[0]))

    @property
    def frequency(self) -> np.ndarray:
        """Return the frequency of each bin [Hz]."""
        return self.index / (2 * self.count * self.interval)

    @cached_property
    def square(self) -> np.ndarray:
        """Return s = sin^2(pi k/(2n)) of each bin."""
        return np.sin(np.pi * self.index / (2 * self.count)) ** 2


def _edges(count: int) -> np.ndarray:
    if count <= SINGLE:
        return np.arange(count)
    bins = int(np.ceil(np.log(count / SINGLE) / WIDTH))
    wide = np.rint(np.geomspace(SINGLE, count, bins + 1)[:-1]).astype(int)
    return np.unique(np.concatenate([np.arange(SINGLE), wide]))


def _end_point(index: np.ndarray, count: int) -> np.ndarray:
    """Return a_k, the cosine coefficients of a unit first sample."""
    angle = np.pi * index
    angle /= 2 * count
    np.cos(angle, out=angle)
    angle *= np.sqrt(2 / count)
    return angle


@dataclass(frozen=True, eq=False)
class Cosines:
    """Sufficient statistics of a sequence: sums over bins of z_k^2 and a_k z_k, z its cosine coefficients.

    With ``ramp`` a ramp is unknown besides the mean; its least-squares estimate, of ``slope`` [unit/s], is subtracted
    first, because its coefficients alternate within a bin (the likelihood does not depend on it). ``share`` is that
    of the samples that were measured: the others are drawn given these, and add no information.
    """

    grid: Grid
    power: np.ndarray
    cross: np.ndarray
    ramp: bool
    slope: float = 0.0
    share: float = 1.0

    @classmethod
    def of(
        cls,
        sequence: np.ndarray,
        interval: float,
        highest: float = np.inf,
        ramp: bool = False,
        share: float = 1.0,
    ) -> "Cosines":
        """Transform ``sequence``, shape (n,), sampled every ``interval`` [s]; use frequencies to ``highest`` [Hz]."""
        sequence = np.asarray(sequence, float)
        if not np.ptp(sequence) > SMALLEST:
            raise ValueError("likelihood: expected finite samples that vary; found constant or missing ones")
        grid = Grid.of(len(sequence), interval, highest)
        centred = sequence - sequence.mean()
        slope = 0.0
        if ramp:
            time = interval * (np.arange(len(sequence)) - (len(sequence) - 1) / 2)
            slope = float((time @ centred) / (time @ time))
            centred -= slope * time
        coefficients = dct(centred, norm="ortho", overwrite_x=True)
        weighted = _end_point(np.arange(len(sequence)), len(sequence))
        weighted *= coefficients
        last = int(grid.number.sum())
        power, cross = [], []
        for first, edges in zip((2, 1), grid.edges, strict=True):
            power.append(np.add.reduceat(coefficients[first : last + 1 : 2] ** 2, edges))
            cross.append(np.add.reduceat(weighted[first : last + 1 : 2], edges))
        return cls(grid, np.concatenate(power), np.concatenate(cross), ramp, slope, share)

    def less(self, slope: float) -> "Cosines":
        """Return the statistics of the sequence less a ramp of known ``slope`` [unit/s], from those with ``ramp``.

        Beyond the single bins the coefficients of a ramp are negligible.
        """
        ramp = (self.slope - slope) * ramp_column(self.grid.square, self.grid.interval)
        ramp[: self.grid.odd] = 0.0
        cross = self.cross + ramp * self.grid.leverage
        return Cosines(self.grid, self.power + ramp * (self.cross + cross), cross, False, share=self.share)


@dataclass(frozen=True, eq=False)
class Quantity:
    """Parameter of a composition, or a derived quantity: log value = offset + direction' theta.

    Attributes
    ----------
    key
        Name of the effect, its number among effects of the same kind (from 1), name of the parameter.
    direction, offset
        Shape (parameters,) and a number.
    """

    key: tuple[str, int, str]
    direction: np.ndarray
    offset: float = 0.0


@dataclass(frozen=True)
class Composition:
    """Kinds of processes of a model: at most one of each one-density process, any number of Gauss-Markov processes.

    The parameter vector holds the natural logarithms of the densities, then of std and T of each Gauss-Markov process.
    """

    densities: tuple[type, ...]
    markov: int

    @classmethod
    def of(cls, *kinds: type) -> "Composition":
        """Return the sum of processes of the given types, e.g. ``of(WhiteNoise, GaussMarkov, GaussMarkov)``."""
        densities = tuple(kind for kind in kinds if kind is not GaussMarkov)
        for kind in densities:
            if len(fields(kind)) != 1 or densities.count(kind) > 1:
                raise ValueError(f"likelihood: expected one-density processes, each once; found {kind.__name__}")
        if not kinds:
            raise ValueError("likelihood: expected at least one stochastic effect; found none")
        return cls(densities, len(kinds) - len(densities))

    def shapes(self, grid: Grid) -> np.ndarray:
        """Return the variance of a coefficient per squared density, shape (densities, bins)."""
        rows = [kind(1.0).sampled_psd(grid.frequency, grid.interval) / grid.interval for kind in self.densities]
        return np.array(rows).reshape(len(self.densities), len(grid.index))

    def quantities(self) -> list[Quantity]:
        """Return every parameter, in the order of the vector; after std and T the driving PSD S_B = 2 std^2/T."""
        unit = np.eye(len(self.densities) + 2 * self.markov)
        rows = [
            Quantity((kind.name, 1, fields(kind)[0].name), row) for kind, row in zip(self.densities, unit, strict=False)
        ]
        for ordinal, (std, time) in enumerate(unit[len(self.densities) :].reshape(-1, 2, len(unit)), start=1):
            rows.append(Quantity((GaussMarkov.name, ordinal, "std"), std))
            rows.append(Quantity((GaussMarkov.name, ordinal, "correlation_time"), time))
            rows.append(Quantity((GaussMarkov.name, ordinal, "driving_psd"), 2 * std - time, np.log(2)))
        return rows

    def model(self, theta: np.ndarray) -> AxisModel:
        """Return the model with log parameters ``theta``."""
        values = np.exp(theta).tolist()
        first = len(self.densities)
        effects = [kind(value) for kind, value in zip(self.densities, values[:first], strict=True)]
        markov = [GaussMarkov(*values[i : i + 2]) for i in range(first, len(values), 2)]
        return AxisModel((*effects, *markov))


def parameters(model: AxisModel) -> tuple[Composition, np.ndarray]:
    """Return the composition of the stochastic effects of a model and its log parameters."""
    effects = model.stochastic()
    composition = Composition.of(*map(type, effects))
    ordered = sorted(effects, key=lambda effect: isinstance(effect, GaussMarkov))
    values = np.array([value for effect in ordered for value in effect.parameters().values()])
    with np.errstate(divide="ignore"):
        return composition, np.log(values)


def log_likelihood(model: AxisModel, sequence: np.ndarray, interval: float, ramp: bool = False) -> float:
    """Return the log-density of the contrasts of ``sequence``, shape (n,), free of its mean (and of a ramp)."""
    cosines = Cosines.of(sequence, interval, ramp=ramp)
    composition, theta = parameters(model)
    return value_and_gradient(theta, composition.shapes(cosines.grid), cosines)[0]


def value_and_gradient(theta: np.ndarray, shapes: np.ndarray, *logs: Cosines) -> tuple[float, np.ndarray, np.ndarray]:
    """Return the log-likelihood, its gradient in the log parameters and Whittle's approximation of its information.

    Parameters
    ----------
    theta, shapes
        Log parameters and spectral shapes (:class:`Composition`).
    logs
        Statistics of independent sequences on one grid, each with a mean (and a ramp) of its own.
    """
    value, gradient, information = density(theta, shapes, *statistics(*logs))
    return value + constant(*logs), gradient, information


def statistics(*logs: Cosines) -> tuple:
    """Return the arguments of :func:`density` of logs on one grid, from ``square`` on."""
    grid = logs[0].grid
    power, cross = sum(log.power for log in logs), np.array([log.cross for log in logs])
    return grid.square, grid.count, grid.interval, logs[0].ramp, grid.number, grid.leverage, grid.odd, power, cross


def constant(*logs: Cosines) -> float:
    """Return the part of the log-likelihood that does not depend on the parameters."""
    grid = logs[0].grid
    one = -0.5 * np.log(2 * np.pi) * grid.number.sum()
    if logs[0].ramp:
        one += 0.5 * np.log(2 * np.pi * _ramp_norm(grid))
    return len(logs) * float(one)


def _ramp_norm(grid: Grid) -> float:
    """Return the sum of the squared coefficients of the ramp of unit slope [s^2]."""
    return float(np.sum((grid.leverage * ramp_column(grid.square, grid.interval) ** 2)[grid.odd :]))


def slope(theta: np.ndarray, shapes: np.ndarray, cosines: Cosines) -> tuple[float, float]:
    """Return the generalised least-squares slope [unit/s] of a sequence with ``ramp``, and its variance.

    Both are those of the model with log parameters ``theta``: with the ramp x and the covariance V of the contrasts z,
    x'V^-1 z / x'V^-1 x and 1/x'V^-1 x.
    """
    grid = cosines.grid
    diagonal, _, columns, _, weights, _ = decompose(theta, shapes, grid.square, grid.count, grid.interval, True)
    last, ranks = len(diagonal), len(columns)
    cross = cosines.cross[None]
    core, seen = core_matrix(diagonal, columns, weights[1], grid.leverage, cross, grid.odd, last, ranks)
    inverse = np.linalg.inv(core)
    return cosines.slope - float(inverse[-1] @ seen[0]), -float(inverse[-1, -1])


def slope_density(value: float, variance: float, grid: Grid) -> float:
    """Return the log-density of the contrast along a ramp for an estimate ``value`` of the slope.

    The likelihood with ``ramp`` omits this contrast; added to it, it gives the log-density of all contrasts free of the
    mean, as without a ramp. The slope is normal of mean zero, with the variance that maximises the density: -log(2 pi e
    c^2)/2 for a contrast c beyond its standard deviation.
    """
    square = value**2 / variance
    return -0.5 * float(np.log(2 * np.pi * variance * max(square, 1.0) * _ramp_norm(grid)) + min(square, 1.0))


@njit(cache=True)
def ramp_column(square, interval):
    """Return the coefficients of the ramp of unit slope at odd k over a_k."""
    return -interval / (2 * square)


@njit(cache=True)
def decompose(theta, shapes, square, count, interval, ramp):
    """Return the covariance diag(d) - b u u' of the coefficients, u = a v, and its derivatives in the log parameters.

    Returns
    -------
    diagonal, diagonal_slopes
        d, shape (m,), and its derivatives, shape (parameters, m).
    columns, column_slopes
        v, shape (processes + ramp, m), and the derivatives of the Gauss-Markov columns in log T, shape (processes, m).
    weights, weight_slopes
        log b for even and odd k, shape (2, processes), and its derivatives in log T.
    """
    densities, bins = shapes.shape
    markov = (len(theta) - densities) // 2
    diagonal, diagonal_slopes = np.zeros(bins), np.empty((len(theta), bins))
    columns, column_slopes = np.empty((markov + ramp, bins)), np.empty((markov, bins))
    weights, weight_slopes = np.empty((2, markov)), np.empty((2, markov))
    for j in range(densities):
        squared = np.exp(2 * theta[j])
        for m in range(bins):
            diagonal_slopes[j, m] = 2 * squared * shapes[j, m]
            diagonal[m] += squared * shapes[j, m]
    for i in range(markov):
        j = densities + 2 * i
        variance, steps = np.exp(2 * theta[j]), interval * np.exp(-theta[j + 1])  # steps: dt/T
        decay, gap = np.exp(-steps), -np.expm1(-steps)
        driving = -variance * np.expm1(-2 * steps)
        driving_slope = -2 * variance * decay**2 * steps
        for m in range(bins):
            column = 1 / (gap**2 + 4 * decay * square[m])
            slope = -(column**2) * (4 * square[m] - 2 * gap) * decay * steps
            columns[i, m], column_slopes[i, m] = column, slope
            diagonal[m] += driving * column
            diagonal_slopes[j, m] = 2 * driving * column
            diagonal_slopes[j + 1, m] = driving_slope * column + driving * slope
        for parity in range(2):
            ends = -np.expm1(-count * steps) if parity == 0 else 1 + np.exp(-count * steps)
            sign = -1 if parity == 0 else 1
            weights[parity, i] = np.log(2 * variance * gap**2 * ends) - steps
            weight_slopes[parity, i] = steps * (1 - 2 * decay / gap + sign * count * np.exp(-count * steps) / ends)
    if ramp:
        for m in range(bins):
            columns[markov, m] = ramp_column(square[m], interval)
    return diagonal, diagonal_slopes, columns, column_slopes, weights, weight_slopes


@njit(cache=True)
def density(theta, shapes, square, count, interval, ramp, number, leverage, odd, power, cross):
    """Return log-density without its :func:`constant`, gradient, and sum_k dlog d_k dlog d_k'/2.

    ``power``, shape (m,), is the sum over logs, ``cross``, shape (logs, m), of each.
    """
    spectrum = decompose(theta, shapes, square, count, interval, ramp)
    diagonal, diagonal_slopes, columns, column_slopes, weights, weight_slopes = spectrum
    size, markov, logs = len(diagonal_slopes), len(column_slopes), len(cross)
    value, gradient, information = 0.0, np.zeros(size), np.zeros((size, size))
    for parity in range(2):
        first, last = (odd, len(diagonal)) if parity else (0, odd)
        ranks = len(columns) if parity else markov  # the ramp is odd
        core, seen = core_matrix(diagonal, columns, weights[parity], leverage, cross, first, last, ranks)
        inverse, log_determinant = invert(core)
        solved = np.zeros((logs, ranks))
        for log in range(logs):
            for i in range(ranks):
                for j in range(ranks):
                    solved[log, i] += inverse[i, j] * seen[log, j]
                value -= 0.5 * seen[log, i] * solved[log, i]
        for i in range(markov):
            log_determinant += weights[parity, i]
        value -= 0.5 * logs * log_determinant
        for m in range(first, last):
            d, freedom = diagonal[m], logs * number[m]
            value -= 0.5 * (freedom * np.log(d) + power[m] / d)
            spread, residual = 0.0, power[m]
            for i in range(ranks):
                for j in range(ranks):
                    spread += columns[i, m] * inverse[i, j] * columns[j, m]
            for log in range(logs if ranks else 0):
                pulled = 0.0
                for i in range(ranks):
                    pulled += solved[log, i] * columns[i, m]
                rest = cross[log, m] + pulled * leverage[m]
                residual += pulled * (cross[log, m] + rest)
                for i in range(markov):
                    gradient[size - 2 * markov + 2 * i + 1] -= rest * solved[log, i] / d * column_slopes[i, m]
            push = 0.5 * (residual / d - freedom - logs * leverage[m] * spread / d) / d
            for j in range(size):
                gradient[j] += push * diagonal_slopes[j, m]
                share = 0.5 * freedom * diagonal_slopes[j, m] / d**2
                for k in range(j + 1):
                    information[j, k] += share * diagonal_slopes[k, m]
            for i in range(markov):
                mixed = 0.0
                for j in range(ranks):
                    mixed += columns[j, m] * inverse[j, i]
                gradient[size - 2 * markov + 2 * i + 1] += logs * leverage[m] * mixed / d * column_slopes[i, m]
        for i in range(markov):
            squares = logs * inverse[i, i]
            for log in range(logs):
                squares -= solved[log, i] ** 2
            push = 0.5 * (squares * np.exp(-weights[parity, i]) - logs)
            gradient[size - 2 * markov + 2 * i] += 2 * push
            gradient[size - 2 * markov + 2 * i + 1] += push * weight_slopes[parity, i]
    for j in range(size):
        for k in range(j):
            information[k, j] = information[j, k]
    return value, gradient, information


@njit(cache=True)
def core_matrix(diagonal, columns, weights, leverage, cross, first, last, ranks):
    """Return 1/b - U' D^-1 U (1/b = 0 for the diffuse ramp) and U' D^-1 z of one parity: bins first to last.

    ``cross`` has shape (logs, m); so have the products, shape (logs, ranks).
    """
    core, seen = np.zeros((ranks, ranks)), np.zeros((len(cross), ranks))
    for i in range(len(weights)):
        core[i, i] = np.exp(-weights[i])
    for m in range(first, last):
        for i in range(ranks):
            scaled = columns[i, m] / diagonal[m]
            for log in range(len(cross)):
                seen[log, i] += scaled * cross[log, m]
            for j in range(ranks):
                core[i, j] -= leverage[m] * scaled * columns[j, m]
    return core, seen


def innovations(model: AxisModel, sequence: np.ndarray, interval: float) -> float:
    """Return the log-density of the contrasts of ``sequence`` from the innovations of a Kalman filter.

    The filter runs over the sequence and over a constant at once; generalised least squares takes the constant out
    (de Jong 1991, Annals of Statistics 19, 1073-1083). The states start as the state space says: a random walk at
    zero (its start is part of the constant), a Gauss-Markov process stationary.
    """
    system = model.state_space()
    transition, process = system.discretise(interval)
    sequence = np.asarray(sequence, float)
    start = np.ascontiguousarray(system.initial_covariance)
    log_determinant, squares, products, constant = _filter(
        sequence - sequence.mean(), transition, process, system.output, system.output_psd / interval, start
    )
    count = len(sequence)
    quadratic = squares - products**2 / constant
    return -0.5 * ((count - 1) * np.log(2 * np.pi) + log_determinant + np.log(constant / count) + quadratic)


STEADY = 1e-8
"""Relative change of the gain in one step below which the gain is kept fixed."""


@njit(cache=True)
def _filter(sequence, transition, process, output, white, covariance):
    """Return sums over the innovations of the sequence (e) and of a constant (h): log S, e^2/S, e h/S, h^2/S."""
    states = len(output)
    predicted = np.zeros((3, states))  # of the sequence and of the constant, and work space
    gain, work = np.zeros(states), np.empty((states, states))
    log_determinant, sums, steady, k, variance = 0.0, np.zeros(3), False, 0, 1.0
    while not steady and k < len(sequence):
        variance, change, size = _riccati(covariance, gain, work, transition, process, output, white)
        steady = change < STEADY * size or not states
        log_determinant += np.log(variance)
        sums += _advance(sequence[k : k + 1], transition, gain, output, predicted) / variance
        k += 1
    log_determinant += (len(sequence) - k) * np.log(variance)
    sums += _advance(sequence[k:], transition, gain, output, predicted) / variance
    return log_determinant, sums[0], sums[1], sums[2]


@njit(cache=True)
def _riccati(covariance, gain, work, transition, process, output, white):
    """Advance the covariance and the gain in place; return the innovation variance, the gain's change and size."""
    states = len(output)
    variance = white
    for i in range(states):
        for j in range(states):
            variance += output[i] * covariance[i, j] * output[j]
            work[i, j] = 0.0
            for k in range(states):
                work[i, j] += transition[i, k] * covariance[k, j]
    change, size = 0.0, 0.0
    for i in range(states):
        latest = 0.0
        for j in range(states):
            latest += work[i, j] * output[j] / variance
        change, size, gain[i] = change + abs(latest - gain[i]), size + abs(latest), latest
    for i in range(states):
        for j in range(states):
            covariance[i, j] = process[i, j] - gain[i] * variance * gain[j]
            for k in range(states):
                covariance[i, j] += work[i, k] * transition[j, k]
    return variance, change, size


@njit(cache=True)
def _advance(sequence, transition, gain, output, predicted):
    """Filter the sequence and a constant with a fixed gain, in place; return the sums of e^2, e h, h^2."""
    states = len(output)
    squares, products, constant = 0.0, 0.0, 0.0
    for value in sequence:
        error, reach = value, 1.0
        for i in range(states):
            error -= output[i] * predicted[0, i]
            reach -= output[i] * predicted[1, i]
        squares, products, constant = squares + error * error, products + error * reach, constant + reach * reach
        for row, innovation in ((0, error), (1, reach)):
            for i in range(states):
                predicted[2, i] = gain[i] * innovation
                for j in range(states):
                    predicted[2, i] += transition[i, j] * predicted[row, j]
            predicted[row] = predicted[2]
    return np.array([squares, products, constant])

"""Draw lost samples from an autoregressive model, given the samples around them."""

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.lib.stride_tricks import sliding_window_view
from scipy.linalg import cho_solve_banded, cholesky_banded, solve_banded, toeplitz

ORDER = 32
"""Order of the autoregression."""
MIN_ROWS_PER_COEFFICIENT = 100
"""Minimum number of complete rows per coefficient; with fewer, the order is halved."""
MAX_ROWS = 100_000
"""Maximum number of rows of the regression, spread over the log."""
RIDGE = 1e-12
"""Regularisation of the precision, as a share of the power of the filter."""


@dataclass(frozen=True, eq=False)
class Autoregression:
    """Autoregressive model of a sequence, valid in both directions of time.

    Attributes
    ----------
    level
        Its mean, in the unit of the sequence.
    whitening
        Filter that leaves the white noise, shape (order + 1,), its last coefficient, that of the sample itself, 1.
        Backwards in time it is the same, as for any stationary Gaussian sequence.
    std
        Robust standard deviation of the white noise, in the same unit.
    """

    level: float
    whitening: np.ndarray
    std: float

    @classmethod
    def of(cls, values: np.ndarray, good: np.ndarray) -> "Autoregression":
        """Fit the good samples by least squares; ``values`` and ``good`` of shape (n,)."""
        level, order = float(values[good].mean()), ORDER
        while len(at := _complete(good, order)) < MIN_ROWS_PER_COEFFICIENT * (order + 1) and order > 0:
            order //= 2
        rows = at[:: -(-len(at) // MAX_ROWS), None] + np.arange(order + 1)
        past = values[rows] - level
        triangle = np.linalg.qr(past, mode="r")
        weights = np.linalg.lstsq(triangle[:, :-1], triangle[:, -1])[0]
        whitening = np.r_[-weights, 1.0]
        return cls(level, whitening, float(np.median(np.abs(past @ whitening)) / 0.6745))

    def fill(self, values: np.ndarray, flawed: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        """Draw the flawed samples given all others; ``values`` and ``flawed`` of shape (n,).

        They are Gaussian with a banded precision, and are drawn by its Cholesky factor (Rue and Held 2005, Gaussian
        Markov Random Fields, section 2.4). The first part of the log is predicted backwards and the last part
        forwards, from a core of ``order`` samples between them.
        """
        reach, at = len(self.whitening) - 1, np.flatnonzero(flawed)
        known, turn = np.where(flawed, 0.0, values - self.level), self._turn(flawed)
        backward = np.correlate(known, self.whitening[::-1], "valid")
        forward = np.correlate(known, self.whitening, "valid")
        backward[turn:], forward[:turn] = 0.0, 0.0
        pull = np.convolve(backward, self.whitening[::-1]) + np.convolve(forward, self.whitening)
        core = self._core()
        pull[turn : turn + reach] += core @ known[turn : turn + reach]
        bands = _precision(at, self.whitening, len(values) - reach, turn, core)
        bands[-1] += RIDGE * np.sum(self.whitening**2)
        factor = cholesky_banded(bands)
        noise = solve_banded((0, reach), factor, self.std * rng.standard_normal(len(at)))
        known[at] = noise - cho_solve_banded((factor, False), pull[at])
        return np.where(flawed, self.level + known, values)

    def innovations(self, values: np.ndarray) -> np.ndarray:
        """Return each sample less its prediction, shape (n,): by those before it, at the start by those after it."""
        reach = len(self.whitening) - 1
        forward = np.correlate(values - self.level, self.whitening, "valid")
        if not reach:
            return forward
        backward = np.correlate(values[: 2 * reach] - self.level, self.whitening[::-1], "valid")[:reach]
        return np.r_[backward, forward[len(backward) - reach :]]

    def _core(self) -> np.ndarray:
        """Return the precision of ``order`` consecutive samples, over that of the white noise, shape (order, order).

        By the formula of Gohberg and Semencul (Brockwell and Davis 1991, Time Series, section 8.7, problem 8.5);
        negative eigenvalues of a nearly nonstationary model are set to zero.
        """
        ahead, behind = self.whitening[:0:-1], self.whitening[:-1]
        first, last = (
            toeplitz(column, np.zeros(len(column))) if len(column) else np.empty((0, 0)) for column in (ahead, behind)
        )
        values, vectors = np.linalg.eigh(first @ first.T - last @ last.T)
        return (vectors * np.maximum(values, 0.0)) @ vectors.T

    def _turn(self, flawed: np.ndarray) -> int:
        """Return the first row predicted forwards: near the middle, far from flawed samples if possible."""
        reach = len(self.whitening) - 1
        calm = _complete(~flawed, 3 * reach)
        middle = (len(flawed) - reach) // 2
        return int(calm[np.argmin(np.abs(calm - middle))]) + reach if len(calm) else middle


def _complete(good: np.ndarray, order: int) -> np.ndarray:
    """Return the first of each run of ``order`` + 1 good samples."""
    if len(good) <= order:
        return np.empty(0, int)
    return np.flatnonzero(sliding_window_view(good, order + 1).all(axis=1))


@njit(cache=True)
def _precision(at, whitening, count, turn, core):
    """Return the upper bands of the precision of the samples ``at``, over that of the white noise.

    The filter has ``count`` positions; those before ``turn`` predict backwards, and ``core`` is the precision of the
    samples from there on.
    """
    reach = len(whitening) - 1
    bands = np.zeros((reach + 1, len(at)))
    for a in range(len(at)):
        for b in range(a, min(a + reach + 1, len(at))):
            for k in range(max(0, at[b] - reach), min(at[a] + 1, count)):
                first, second = at[a] - k, at[b] - k
                if k < turn:
                    first, second = reach - first, reach - second
                bands[reach - (b - a), b] += whitening[first] * whitening[second]
            if at[a] >= turn and at[b] < turn + reach:
                bands[reach - (b - a), b] += core[at[a] - turn, at[b] - turn]
    return bands

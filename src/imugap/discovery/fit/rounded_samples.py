"""What rounded samples say of the values ahead of the rounding: each is known to lie in a cell of the lattice.

On a coarse lattice the rounding error is neither normal nor independent of the signal: the spread of rounded noise
goes with where between two levels its mean lies, and its squares scatter in another way than those of a normal law.
Whoever asks for the law of the white noise therefore has to ask the cells.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.fft import dct, idct
from scipy.optimize import minimize
from scipy.special import expit, logit, ndtr, ndtri

from imugap.discovery.fit.whittle import Noise
from imugap.discovery.preparation.sequence import AxisSequence
from imugap.numerics.samples.contaminated_normal import STARTS, Tails, ends

MIN_WHITE_SHARE = 0.5
"""Least share of white noise in the power, with which its samples can be told from what is slower."""
MAX_CELL_WIDTH = 4.0
"""Largest width of a cell, in standard deviations of the noise, across which its mean is still told."""
HARMONICS, CELL_POINTS = 3, 400
"""Harmonics of the mean rounding error over a cell, and points of a cell at which it is known."""
MEAN_ROUNDS = 3
"""Turns between the deviation ahead of the rounding and the mean there."""
PLACE_STEP = 0.01
"""Distance of places, in standard deviations of the noise, that are taken for one in the fit of a law."""
MAX_WIDE_SHARE = 0.5
"""Largest share of the wide law."""
MAX_DEVIATION = 37.0
"""Standard deviations beyond which a normal law has no mass in double precision."""
SIMPLEX_OPTIONS = {"xatol": 1e-5, "fatol": 1e-5, "maxiter": 2000, "maxfev": 2000}


@dataclass(frozen=True, eq=False)
class Cells:
    """Samples of white noise, each known to be within ``half`` of its centre; in the unit of the fitted white noise.

    Attributes
    ----------
    centres
        Rounded samples less the mean that is expected of each, shape (n,).
    half
        Half of the widths of the cells, shape (n,).
    unit
        Size, in the unit of the axis, of a single sample that is one off in them: what is slower takes up a share.
    """

    centres: np.ndarray
    half: np.ndarray
    unit: float

    @classmethod
    def of(
        cls, sequence: AxisSequence, noise: Noise, residual: np.ndarray, scale: np.ndarray | float
    ) -> "Cells | None":
        """Return the cells of the white noise of a fit, None where it is not distinguishable from the rest.

        Parameters
        ----------
        sequence
            The rounded samples.
        noise
            Fitted noise.
        residual
            Samples less the fitted mean, over ``scale``, shape (n,).
        scale
            Factor of the standard deviation of each sample, shape (n,), or 1.
        """
        step, bins = sequence.step, sequence.bins
        white = [effect for effect in noise.effects if effect.white]
        if not step or noise.output_filter is not None or not white:
            return None
        unit = white[0].density / np.sqrt(sequence.conditions.interval)
        share = np.minimum(unit**2 / bins.spread(noise.variance(bins)), 1.0)
        if share.mean() < MIN_WHITE_SHARE:
            return None
        share[bins.last :] = 1.0
        own = scale * idct(np.r_[0.0, share] * dct(residual, norm="ortho"), norm="ortho")
        output, deviation, std = sequence.values + sequence.conditions.error_free, scale * unit, unit
        half = np.broadcast_to(step / 2 / deviation, own.shape)
        for _ in range(MEAN_ROUNDS):
            cells = cls((output - ahead(output - own, step, std)) / deviation, half, unit / float(share.mean()))
            std = unit * float(np.exp(cells._normal[1]))
        return cells if step < MAX_CELL_WIDTH * std else None

    @cached_property
    def _places(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return centre, half and number of the cells at each place."""
        _, place, number = np.unique(np.rint(self.centres / PLACE_STEP), return_inverse=True, return_counts=True)
        centre, half = (np.bincount(place, values) / number for values in (self.centres, self.half))
        return centre, half, number

    @cached_property
    def _normal(self) -> np.ndarray:
        """Return mean and logarithm of the standard deviation of the normal law that is likeliest."""
        return minimize(self._cost, np.zeros(2), method="Nelder-Mead", options=SIMPLEX_OPTIONS).x

    def drawn(self, rng: np.random.Generator) -> np.ndarray:
        """Return values ahead of the rounding, shape (n,), over their standard deviation, as if they were normal.

        Where they are, what is drawn has exactly their law; where they are not, the cells hold it.
        """
        mean, std = self._normal[0], np.exp(self._normal[1])
        centre, half = (self.centres - mean) / std, self.half / std
        side = np.where(centre > 0, -1.0, 1.0)
        low, high = (np.maximum(side * centre + end * half, -MAX_DEVIATION) for end in (-1, 1))
        below, within = ndtr(low), ndtr(high) - ndtr(low)
        value = side * ndtri(below + within * rng.random(len(centre)))
        return np.where((within > 0) & np.isfinite(value), value, centre)

    def tails(self) -> Tails:
        """Return the mixture of two normal laws that is likeliest, in the unit of the cells."""
        mean, log_std = self._normal
        starts = (
            [mean, log_std - np.log1p(rare * wide), logit(rare / MAX_WIDE_SHARE), np.log(wide)] for rare, wide in STARTS
        )
        fits = [minimize(self._cost, start, method="Nelder-Mead", options=SIMPLEX_OPTIONS) for start in starts]
        best = min(fits, key=lambda fit: fit.fun)
        near, half, (share, narrow, wide) = self.centres - best.x[0], self.half, _laws(best.x)
        odds = logit(share) + np.log(_masses(near, half, wide) / _masses(near, half, narrow))
        (_, _, low_odds, low_excess), (_, _, high_odds, high_excess) = ends(self._cost, best.x)
        shares = MAX_WIDE_SHARE * float(expit(low_odds)), MAX_WIDE_SHARE * float(expit(high_odds))
        excess = narrow * float(np.exp(low_excess)), narrow * float(np.exp(high_excess))
        gain = self._cost(self._normal) - best.fun
        return Tails(share, narrow, wide, gain, expit(odds), (shares, excess))

    def _cost(self, theta: np.ndarray) -> float:
        """Return the negative log-likelihood of a normal law or a mixture of two.

        ``theta`` has the mean and the logarithm of the standard deviation; for a mixture also the logit of the share of
        the wide law over :data:`MAX_WIDE_SHARE` and the logarithm of sqrt(wide^2 - narrow^2)/narrow.
        """
        centre, half, number = self._places
        share, narrow, wide = _laws(theta)
        near = centre - theta[0]
        mass = (1 - share) * _masses(near, half, narrow) + share * _masses(near, half, wide)
        return -float(number @ np.log(mass))


def _laws(theta: np.ndarray) -> tuple[float, float, float]:
    """Return the share of the wide law, and the deviations of the narrow one and of it."""
    narrow = float(np.exp(theta[1]))
    if len(theta) == 2:
        return 0.0, narrow, narrow
    return MAX_WIDE_SHARE * float(expit(theta[2])), narrow, narrow * float(np.sqrt(1 + np.exp(2 * theta[3])))


def _masses(near: np.ndarray, half: np.ndarray, std: float) -> np.ndarray:
    """Return the probability of cells ``near`` the mean of a normal law."""
    far = -np.abs(near)
    return np.maximum(ndtr((far + half) / std) - ndtr((far - half) / std), np.finfo(float).tiny)


def ahead(level: np.ndarray, step: float, std: float) -> np.ndarray:
    """Return the means ahead of the rounding, shape (n,), of normal values of means ``level`` once they are rounded.

    The mean rounding error over a cell is a sum of sines (Widrow and Kollar 2008, Quantization noise, chapter 5).
    """
    place = np.linspace(-0.5, 0.5, CELL_POINTS + 1)
    order = np.arange(1, HARMONICS + 1)
    size = (-1.0) ** order / order / np.pi * np.exp(-2 * (np.pi * order * std / step) ** 2)
    rounded = place + size @ np.sin(2 * np.pi * order[:, None] * place)
    cell = np.rint(level / step)
    return step * (cell + np.interp(level / step - cell, np.maximum.accumulate(rounded), place))

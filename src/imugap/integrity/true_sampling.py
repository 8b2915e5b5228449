"""True sampling of a sensor slower than the rows of a log: held values, and values interpolated between samples."""

from dataclasses import dataclass

import numpy as np
from threadpoolctl import threadpool_limits

from imugap.integrity.lattice_clock import lattice_interval
from imugap.integrity.row_clock import every_row_is_a_sample

REPEATED = 1.05
"""Rows per new value from which slower sampling is possible."""
STUCK = 20
"""Rows of one value, over the usual number, from which the output was stuck and not sampled slowly."""
FEWEST = 256
"""Fewest new values."""
SEVERAL = 1.9
"""Rows per true sample from which random repeats may hide some of the new values."""
EXCERPT = 1 << 17
"""Values, in the middle of a log, on which interpolation is tested."""
KNOTS = 20
"""True samples over which interpolated values are averaged: fewer would see the interpolation."""
LINE = 30.0
"""Height of a spectral line of the squared bends over the mean power from which interpolation is tested."""
TONE, NEIGHBOURS = 0.02, 3
"""Share of the power of the bends in a tone that has a line in their squares, and its half width in ordinates."""
WINDOW, WINDOWS = 200, 25
"""Values of a window in which knots are fitted, and number of windows."""
PHASES = 50
"""Trial places of the knots."""
FREE = 10
"""Fewest values of a window above its knots: nearly as many knots as values would explain anything."""
ROUNDING, HUGE = 1e-12, 1e100
"""Size of bends that are rounding, relative to the values, and of values that are no readings."""
DISTINCT = 0.2
"""Share of different values below which equal bends are those of a lattice."""
EXPLAINED = 0.02
"""Variance about the lines between knots at the best place, over that at the median place, below which the values are
interpolated: recorded walks and drives leave 0.06 and more, interpolated ones 0.002."""


@dataclass(frozen=True)
class TrueSampling:
    """True sampling of a triad or an axis: rows per true sample, and whether the values between are interpolated."""

    rows: float
    interpolated: bool = False

    def samples(self, values: np.ndarray, interval: float) -> tuple[np.ndarray, float]:
        """Return the true samples of ``values``, shape (n,), NaN where lost, and their interval [s].

        Of interpolated values they are means over :data:`KNOTS` true samples.
        """
        if not self.interpolated:
            rows = np.arange(self.rows / 2, len(values), self.rows).astype(int)
            return values[rows], self.rows * interval
        width = int(np.ceil(KNOTS * self.rows))
        whole = values[: len(values) // width * width].reshape(-1, width)
        return whole.mean(axis=1), width * interval


def held(columns: np.ndarray) -> TrueSampling | None:
    """Return the true sampling of ``columns``, shape (n, axes), NaN where lost, whose rows repeat in a regular pattern.

    Random repeats, as of noise below one count, displace the rows of new values without bound; those of slower
    sampling stay near an even clock.
    """
    fresh = np.flatnonzero(np.r_[True, np.any(columns[1:] != columns[:-1], axis=1)])
    if len(fresh) < FEWEST:
        return None
    steps = np.diff(fresh)
    stuck = steps > STUCK * np.median(steps)
    if len(columns) - steps[stuck].sum() < REPEATED * (len(fresh) - np.count_nonzero(stuck)):
        return None
    position = fresh.astype(float)
    if every_row_is_a_sample(position, 0.0):
        rows = float(np.polyfit(np.arange(len(position)), position, 1)[0])
        return TrueSampling(rows)
    rows = lattice_interval(position, 0.0)
    return TrueSampling(rows) if rows is not None and rows > SEVERAL else None


def interpolated(values: np.ndarray) -> TrueSampling | None:
    """Return the true sampling of an axis, shape (n,), whose values lie on straight lines between slower true samples.

    The bends of such lines vary in size with the place between two true samples, so that their squares have a line at
    the true rate or its alias. Knots at that rate then explain the values exactly, more values than knots.
    """
    finite = values[np.isfinite(values)]
    finite = finite[max(len(finite) - EXCERPT, 0) // 2 :][:EXCERPT]
    if len(finite) < FEWEST:
        return None
    finite = finite[np.r_[True, finite[1:] != finite[:-1]]]  # a stuck stretch is a straight line too
    if len(finite) < FEWEST:
        return None
    bends = np.diff(finite, 2)
    if len(np.unique(finite)) < DISTINCT * len(finite):
        return None
    if not bends.any() or not np.sqrt(np.mean(bends**2)) > ROUNDING * np.abs(finite).max() < HUGE:
        return None
    power = np.abs(np.fft.rfft(bends**2 - np.mean(bends**2))) ** 2
    at = int(np.argmax(power[1:])) + 1
    if power[at] < LINE * power[1:].mean() or _has_tone(bends, at / 2):
        return None
    alias = at / len(bends)
    with threadpool_limits(1):  # hundreds of small factorisations, which several threads make slower
        knots = next((share for share in (alias, 1 - alias) if _is_explained(finite, share)), None)
    return None if knots is None else TrueSampling(1 / knots, interpolated=True)


def _has_tone(bends: np.ndarray, at: float) -> bool:
    """Return whether a vibration of ``at`` periods, or of its alias, has a share of the power of bends, shape (n,)."""
    power = np.abs(np.fft.rfft(bends)) ** 2
    places = (round(at), round(len(bends) / 2 - at))
    near = [power[max(place - NEIGHBOURS, 0) : place + NEIGHBOURS + 1].sum() for place in places]
    return max(near) > TONE * power.sum()


def _is_explained(values: np.ndarray, share: float) -> bool:
    """Return whether straight lines between knots, ``share`` of a knot for each value, explain values, shape (n,).

    Only with the knots where the true samples are: smooth values are near to the lines between any knots.
    """
    if (1 - share) * WINDOW < FREE:
        return False
    starts = np.linspace(0, len(values) - WINDOW, WINDOWS).astype(int)
    parts = np.array([values[start : start + WINDOW] for start in starts])
    parts = parts - parts.mean(axis=1, keepdims=True)
    left = np.empty((PHASES, len(parts)))
    for k in range(PHASES):
        place = k / PHASES + share * np.arange(WINDOW)
        design = np.maximum(1 - np.abs(place[:, None] - np.arange(np.ceil(place[-1]) + 1)), 0.0)
        basis = np.linalg.qr(design)[0]
        left[k] = np.mean((parts - (parts @ basis) @ basis.T) ** 2, axis=1)
    usual = np.median(left, axis=0)
    return bool(np.median(left.min(axis=0)[usual > 0] / usual[usual > 0]) < EXPLAINED) if usual.any() else False

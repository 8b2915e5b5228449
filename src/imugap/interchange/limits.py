"""Limits of the numbers of a tool: the 95 % intervals of the axes, carried through their reduction and combination."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import floor, inf, log10, sqrt

import numpy as np

from imugap.interchange.conventions import Parameter, Reduced, Rule, Triad

SIZES = ("white", "walk", "markov")
"""Numbers of a reduced model that have limits."""


@dataclass(frozen=True)
class Limits:
    """Reduced model of an axis or triad, with each size at the lower and at the upper end of its interval."""

    low: Reduced
    high: Reduced

    @classmethod
    def of(cls, value: Reduced, white: tuple[float, float], walk: tuple[float, float]) -> "Limits":
        """Return the limits of an axis from those of its N and K; the process that replaces K scales with it."""
        ends = (
            replace(value, white=one, walk=slow, markov=value.markov * (slow / value.walk if value.walk else 0.0))
            for one, slow in zip(white, walk, strict=True)
        )
        return cls(*ends)

    def interval(self, parameter: Parameter, rule: Rule) -> tuple[float, float] | None:
        """Return the interval of a number of a tool, SI; None for one that does not depend on the sizes."""
        low, high = (parameter.value(one, rule) for one in (self.low, self.high))
        return (low, high) if high > low else None


def combined(values: Sequence[Reduced], limits: Sequence[Limits], triad: Triad) -> Limits:
    """Return the limits of the number that stands for several axes, whose estimates are independent.

    The largest has the largest of the limits. The mean of squares has the limits that its terms give by the method of
    variance estimates recovery (Zou & Donner 2008, Statistics in Medicine 27, 1693-1702): with terms x in l to u, the
    sum is at least S - sqrt(sum (x - l)^2), and at most S + sqrt(sum (u - x)^2).
    """
    first = values[0]
    low, high = {}, {}
    for name in SIZES:
        value, least, most = (
            np.array([getattr(one, name) for one in some])
            for some in (values, [one.low for one in limits], [one.high for one in limits])
        )
        ends = (least.max(), most.max()) if triad is Triad.WORST else _of_mean_square(value**2, least**2, most**2)
        low[name], high[name] = map(float, ends)
    return Limits(replace(first, **low), replace(first, **high))


def _of_mean_square(terms: np.ndarray, low: np.ndarray, high: np.ndarray) -> tuple[float, float]:
    """Return the limits of the root of the mean of independent terms, shapes (axes,); a mere bound may be zero."""
    shown, count = (low > 0) | (high > terms), len(terms)
    least = terms[shown].sum() - np.linalg.norm((terms - low)[shown])
    most = terms.sum() + np.linalg.norm(high - terms)
    return sqrt(max(least, 0.0) / count), sqrt(most / count)


def ends_text(low: float, high: float) -> str:
    """Return an interval in words, with the digits that two digits of its half width need."""
    digits = 2
    if 0 < high - low < high < inf:
        digits = max(floor(log10(high)) - floor(log10((high - low) / 2)) + 1, digits)
    return f"{low:.{digits}e} to {high:.{digits}e}"

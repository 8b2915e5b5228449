"""Scale of an axis against the other axes of its sensor, and against other runs: by lattice and noise.

A converter gives the axes of a sensor one lattice; their noise differs. Integers of one axis that were scaled by
another constant have both another lattice and, by the same factor, another noise. A coarser word of the same scale
has another lattice alone, a noisier axis another noise alone.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np

from imugap.integrity.report import lattice

Name = TypeVar("Name")
ENOUGH = 200_000
"""Samples of an axis that show its scale, the first of a log."""
BLOCK = 50
"""Samples of a block, of whose noise the median is taken: a knock is in few of them."""
EQUAL = 0.01
"""Largest relative difference of two lattices that are one."""
LEAST = 8.0
"""Least factor of another scale; sensors of two ranges in one device differ by less."""
ALIKE = 3.0
"""Largest factor between the noise of two axes of a sensor, or between those of noise and lattice."""
LOUD = 12.0
"""Least factor of noise that alone tells of another scale; ordinary axes differ by less."""
POWER = 0.05
"""Largest relative difference from a power of two."""
WHITE = 1.5
"""Largest noise by first differences over that by second ones that is noise, and no motion."""
STEADY = 1.25
"""Largest factor between the noise of the other runs."""
SEEN = 0.35
"""Least noise over the lattice at which it is known."""


@dataclass(frozen=True)
class Scale:
    """Scale of an axis.

    Attributes
    ----------
    noise
        Noise by second differences, without that of the rounding; not a number where the lattice hides it.
    lattice
        Step of the lattice, or None.
    white
        Whether first and second differences show the same noise, as they do not in motion.
    """

    noise: float
    lattice: float | None
    white: bool = False

    @classmethod
    def of(cls, values: np.ndarray) -> "Scale":
        """Return the scale of samples, shape (n,), NaN where lost."""
        known = values[:ENOUGH][np.isfinite(values[:ENOUGH])]
        count = (len(known) - 2) // BLOCK
        if count < 1:
            return cls(np.nan, None)
        step = lattice(np.unique(known), len(known))
        by_order = {
            order: float(np.median(np.mean(np.diff(known, order)[: count * BLOCK].reshape(count, BLOCK) ** 2, axis=1)))
            for order in (1, 2)
        }
        variance = by_order[2] / 6 - (step or 0.0) ** 2 / 12
        noise = np.sqrt(variance) if variance > ((step or 0.0) * SEEN) ** 2 else np.nan
        return cls(noise, step, by_order[1] / 2 < WHITE**2 * by_order[2] / 6)


@dataclass(frozen=True)
class Odd(Generic[Name]):
    """Axis or run of another scale: its name, the factor to the others, and what shows it."""

    name: Name
    factor: float
    shown_by: str

    @property
    def times(self) -> str:
        """Return the factor in words."""
        return f"{self.factor:.6g} times" if self.factor > 1 else f"1/{1 / self.factor:.6g} of"


def odd_axis(scales: Mapping[str, Scale]) -> Odd[str] | None:
    """Return the axis of a sensor whose lattice and noise differ from those of both others by one factor, or None."""
    for axis, (one, other), of in _apart(scales):
        if None in (of.lattice, one.lattice, other.lattice) or abs(one.lattice / other.lattice - 1) > EQUAL:
            continue
        factor = of.lattice / one.lattice
        if _far(factor, LEAST) and all(_near(of.noise / each.noise / factor, ALIKE) for each in (one, other)):
            return Odd(axis, factor, "lattice step and noise")
    return None


def loud_axis(scales: Mapping[str, Scale]) -> Odd[str] | None:
    """Return the axis of a sensor whose noise is far from that of both others, which are alike, or None."""
    for axis, (one, other), of in _apart(scales):
        ratios = of.noise / one.noise, of.noise / other.noise
        if of.white and _near(one.noise / other.noise, ALIKE) and (min(ratios) > LOUD or max(ratios) < 1 / LOUD):
            return Odd(axis, float(np.sqrt(ratios[0] * ratios[1])), "noise")
    return None


def odd_run(scales: Mapping[int, Scale]) -> tuple[Odd[int], int] | None:
    """Return the run whose scale of an axis differs from that of the run of middle noise, and that run; or None.

    The noise of an axis hardly differs from run to run: without a lattice a power of two shows another scale, where
    that of the other runs is one.
    """
    known = sorted((name for name in scales if scales[name].noise > 0), key=lambda name: scales[name].noise)
    middle = known[(len(known) - 1) // 2] if known else None
    for name in known:
        factor = scales[name].noise / scales[middle].noise
        steps = scales[name].lattice, scales[middle].lattice
        by_step = steps[0] / steps[1] if None not in steps else 1.0
        if _far(by_step, LEAST) and _near(factor / by_step, ALIKE):
            return Odd(name, by_step, "lattice step and noise"), middle
        others = (scales[each].noise / scales[middle].noise for each in known if each != name)
        alike = scales[name].white and scales[middle].white and all(_near(each, STEADY) for each in others)
        if alike and _far(factor, LOUD) and abs(factor / 2.0 ** np.rint(np.log2(factor)) - 1) < POWER:
            return Odd(name, factor, "noise"), middle
    return None


def _apart(scales: Mapping[str, Scale]) -> Iterator[tuple[str, list[Scale], Scale]]:
    """Yield each axis with the scales of the two others of its sensor, and its own."""
    if len(scales) == 3 and all(one.noise > 0 for one in scales.values()):
        for axis in scales:
            yield axis, [one for name, one in scales.items() if name != axis], scales[axis]


def _far(factor: float, least: float) -> bool:
    return max(factor, 1 / factor) >= least * (1 - EQUAL)


def _near(factor: float, most: float) -> bool:
    return max(factor, 1 / factor) <= most

"""Effects that the axes of a device have by one physical value: their evidence is pooled, and the others are asked.

A delay is that of the whole device, a lever arm that of its accelerometers (``common`` of
:class:`imugap.effects.effect.Effect`). A search of one axis decides on its own data only. Here the axes that show such
an effect are pooled by the weights of their information; a chi-square test says whether they agree. The other axes are
then tested at an uncorrected level: they have the effect too unless their data contradict it. Where no axis shows it,
all of them together may.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import chi2

from imugap.discovery.axis import AxisFit, Term, fit
from imugap.discovery.search import Search, log_chance, with_effect
from imugap.effects.effect import Effect, SystematicEffect

LEVEL = 0.001
"""Probability below which axes disagree: at 0.01 one device in sixteen would lose one of its six axes by chance."""


@dataclass(frozen=True, eq=False)
class Estimate:
    """What one axis says of an effect.

    Attributes
    ----------
    axis, effect, free
        Name of the axis, the effect as fitted there, and its k fitted parameters.
    information
        Inverse of their covariance, the other parameters of the axis free, shape (k, k).
    """

    axis: str
    effect: SystematicEffect
    free: tuple[str, ...]
    information: np.ndarray

    @property
    def value(self) -> np.ndarray:
        """Return the fitted parameters, shape (k,)."""
        return np.array([getattr(self.effect, name) for name in self.free])


@dataclass(frozen=True, eq=False)
class Pool:
    """One value for several estimates, weighted by their information.

    Attributes
    ----------
    value, information
        Parameters, shape (k,), and the sum of the informations, shape (k, k).
    distance, freedom
        Sum of the squared distances of the estimates from it in units of their covariance, and the degrees of freedom
        of its chi-square law where they estimate the same.
    """

    value: np.ndarray
    information: np.ndarray
    distance: float
    freedom: int

    @property
    def covariance(self) -> np.ndarray:
        """Return the covariance of the value, shape (k, k)."""
        return np.linalg.pinv(self.information, hermitian=True)

    @property
    def agreement(self) -> float:
        """Return the probability of so large a distance where the axes agree; one for a single axis."""
        return float(chi2.sf(self.distance, self.freedom)) if self.freedom else 1.0

    @property
    def gain(self) -> float:
        """Return the gain of log-likelihood of the value over zero, to second order."""
        return float(0.5 * (self.value @ self.information @ self.value))


@dataclass(frozen=True, eq=False)
class Joint:
    """An effect with one value on several axes."""

    effect: SystematicEffect
    axes: tuple[str, ...]
    free: tuple[str, ...]
    pool: Pool


@dataclass(frozen=True, eq=False)
class Device:
    """The fits of the axes, and the effects that they have together.

    Attributes
    ----------
    fits, searches
        Fit and search of each axis; the effects of :attr:`joints` are held at their values.
    joints
        Effects with one value for several axes.
    """

    fits: dict[str, AxisFit]
    searches: dict[str, Search]
    joints: tuple[Joint, ...] = ()


def joined(fits: Mapping[str, AxisFit], searches: Mapping[str, Search], level: float = LEVEL) -> Device:
    """Return the device that the fits of its axes make, effects of one value joined."""
    device = Device(dict(fits), dict(searches))
    for kind in next(iter(searches.values())).catalogue:
        if kind.common:
            joint = _joint(kind, device, level)
            device = device if joint is None else _held(device, joint)
    return device


def pooled(estimates: Sequence[Estimate]) -> Pool:
    """Return the mean of estimates of the same parameters, weighted by their informations."""
    weights = [one.information for one in estimates]
    total = np.sum(weights, axis=0)
    value = np.linalg.pinv(total, hermitian=True) @ sum(one.information @ one.value for one in estimates)
    distance = sum((one.value - value) @ one.information @ (one.value - value) for one in estimates)
    ranks = [np.linalg.matrix_rank(weight, hermitian=True) for weight in weights]
    return Pool(value, total, float(distance), int(sum(ranks) - np.linalg.matrix_rank(total, hermitian=True)))


def agreeing(estimates: Sequence[Estimate], level: float = LEVEL) -> list[Estimate]:
    """Return the estimates that agree, after the removal, one by one, of that without which they agree best."""
    kept = list(estimates)
    while len(kept) > 1 and pooled(kept).agreement < level:
        rest = [[other for other in kept if other is not one] for one in kept]
        kept = min(rest, key=lambda others: (pooled(others).distance, -pooled(others).gain))
    return kept


def contradicts(one: Estimate, pool: Pool, level: float = LEVEL) -> bool:
    """Return whether an estimate that is not in a pool is too far from it."""
    covariance = np.linalg.pinv(one.information, hermitian=True) + pool.covariance
    gap = one.value - pool.value
    return bool(gap @ np.linalg.solve(covariance, gap) > chi2.isf(level, len(gap)))


def _joint(kind: type[Effect], device: Device, level: float) -> Joint | None:
    """Return the effect of a kind that axes of the device have together, if two of them or more do.

    Axes whose start model has it are not asked.
    """
    axes = [axis for axis in kind.common if axis in device.fits and not device.searches[axis].knows(kind)]
    showing = [_estimate(axis, device.fits[axis], kind) for axis in axes if device.fits[axis].has(kind)]
    asked = [_asked(axis, device.fits[axis], kind) for axis in axes if not device.fits[axis].has(kind)]
    silent = [one for one in asked if one is not None]
    if not showing and not _together(silent, device, level):
        return None
    anchor = agreeing(showing or silent, level)
    members = anchor + [one for one in silent if one not in anchor and not contradicts(one, pooled(anchor), level)]
    if len(members) < 2:
        return None
    pool, free = pooled(members), members[0].free
    effect = replace(members[0].effect, **dict(zip(free, pool.value.tolist(), strict=True)))
    return Joint(effect, tuple(axis for axis in axes if axis in {one.axis for one in members}), free, pool)


def _together(silent: Sequence[Estimate], device: Device, level: float) -> bool:
    """Return whether axes none of which shows an effect agree on one that chance does not explain."""
    if len(silent) < 2:
        return False
    pool, log_alpha = pooled(silent), device.searches[silent[0].axis].log_alpha
    return pool.agreement >= level and log_chance(pool.gain, len(pool.value)) < log_alpha


def _estimate(axis: str, found: AxisFit, kind: type[Effect]) -> Estimate:
    terms = found.description.terms
    index = next(i for i, term in enumerate(terms) if isinstance(term.effect, kind))
    first = sum(len(term.free) for term in terms[:index])
    block = slice(first, first + len(terms[index].free))
    information = np.linalg.pinv(found.covariance[block, block], hermitian=True)
    return Estimate(axis, terms[index].effect, terms[index].free, information)


def _asked(axis: str, found: AxisFit, kind: type[Effect]) -> Estimate | None:
    """Return what an axis that does not show an effect says of it; None where it cannot tell."""
    start = next(kind.starts(found), None)
    if start is None:
        return None
    return _estimate(axis, fit(found.sequence, with_effect(found.description, start)), kind)


def _held(device: Device, joint: Joint) -> Device:
    """Return the device with an effect held at its common value, and without what was there in its place."""
    fits, searches = dict(device.fits), dict(device.searches)
    for axis in joint.axes:
        search, term = searches[axis], Term(joint.effect, ())
        known = len(search.start.terms)
        terms = [one for one in fits[axis].description.terms if not isinstance(one.effect, type(joint.effect))]
        searches[axis] = replace(search, start=replace(search.start, terms=(*search.start.terms, term)), memory={})
        description = replace(fits[axis].description, terms=(*terms[:known], term, *terms[known:]))
        fits[axis] = searches[axis].pruned(fit(fits[axis].sequence, description))
    return Device(fits, searches, (*device.joints, joint))

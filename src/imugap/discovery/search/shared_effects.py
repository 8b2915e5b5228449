"""Effects that the axes of a device have by one physical value: their evidence is pooled, and the others are asked.

A delay is that of the whole device, a lever arm that of its accelerometers (``common`` of
:class:`imugap.effects.effect.Effect`). A search of one axis decides on its own data only. Here the axes that show such
an effect are pooled by the weights of their information; a chi-square test says whether they agree. The other axes are
then tested, those of a sensor together, at an uncorrected level: they have the effect too unless their data contradict
it. Where no axis shows it, all of them together may. As a delay and a lever arm may stand for each other, all such
effects are estimated together.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import chain

import numpy as np
from scipy.stats import chi2

from imugap.discovery.fit.axis_fit import AxisFit, fit
from imugap.discovery.fit.description import Entry
from imugap.discovery.search.search import Search, entry_of, log_p_of_gain
from imugap.effects.effect import Effect, SystematicEffect
from imugap.log import ACCEL, GYRO

MIN_AGREEMENT = 0.001
"""Probability below which axes disagree: at 0.01 one device in sixteen would lose one of its six axes."""


Label = tuple[type[Effect], str]
"""Kind of an effect and name of one of its parameters."""


@dataclass(frozen=True, eq=False)
class Estimate:
    """What one axis says of effects that it may have in common with others.

    Attributes
    ----------
    axis, terms
        Name of the axis, and the effects as fitted there, with k fitted parameters.
    information
        Inverse of their covariance, the other parameters of the axis free, shape (k, k).
    """

    axis: str
    terms: tuple[Entry, ...]
    information: np.ndarray

    @property
    def labels(self) -> tuple[Label, ...]:
        """Return what the k parameters are."""
        return tuple((type(term.effect), name) for term in self.terms for name in term.free)

    @property
    def value(self) -> np.ndarray:
        """Return the fitted parameters, shape (k,)."""
        return np.array([getattr(term.effect, name) for term in self.terms for name in term.free])

    def about(self, kinds: Collection[type[Effect]]) -> "Estimate":
        """Return what the axis says of effects of some kinds, the others free."""
        terms = tuple(term for term in self.terms if type(term.effect) in kinds)
        return Estimate(self.axis, terms, _marginal(self.information, [kind in kinds for kind, _ in self.labels]))


@dataclass(frozen=True, eq=False)
class Pool:
    """One value for several estimates, weighted by their information.

    Attributes
    ----------
    labels
        What the k parameters are.
    value, information
        Parameters, shape (k,), and the sum of the informations, shape (k, k).
    distance, freedom
        Sum of the squared distances of the estimates from it in units of their covariance, and the degrees of freedom
        of its chi-square law where they estimate the same.
    """

    labels: tuple[Label, ...]
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

    def about(self, kind: type[Effect]) -> "Pool":
        """Return the part of the pool that is about effects of one kind, the others free."""
        mine = [one is kind for one, _ in self.labels]
        labels = tuple(label for label in self.labels if label[0] is kind)
        return replace(self, labels=labels, value=self.value[mine], information=_marginal(self.information, mine))


@dataclass(frozen=True, eq=False)
class Joint:
    """An effect with one value on several axes, what each says of it, and the part of a pool that is about it."""

    effect: SystematicEffect
    axes: tuple[str, ...]
    free: tuple[str, ...]
    shares: tuple[Estimate, ...]
    pool: Pool

    def certain(self, axes: Collection[str], log_alpha: float) -> bool:
        """Return whether the effect is significant on some of the axes alone."""
        shares = [one for one in self.shares if one.axis in axes]
        return bool(shares) and log_p_of_gain(pooled(shares).gain, len(self.free)) < log_alpha


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


def joined(
    fits: Mapping[str, AxisFit],
    searches: Mapping[str, Search],
    apart: Collection[type[Effect]] = (),
    level: float = MIN_AGREEMENT,
) -> Device:
    """Return the device that the fits of its axes make, effects of one value joined but for kinds left ``apart``."""
    device = Device(dict(fits), dict(searches))
    kinds = [kind for kind in next(iter(searches.values())).catalogue if kind.common and kind not in apart]
    shown = [kind for kind in kinds if any(one.has(kind) for one in fits.values())]
    for kind in kinds:
        if kind not in shown and _together(kind, _estimates((*shown, kind), device), device, level):
            shown.append(kind)
    for joint in _joints(tuple(kind for kind in kinds if kind in shown), device, level):
        device = _held(device, joint)
    return device


def pooled(estimates: Sequence[Estimate]) -> Pool:
    """Return the mean of estimates, of the same parameters or some of them, weighted by their informations."""
    labels = tuple(dict.fromkeys(label for one in estimates for label in one.labels))
    total, weighted = np.zeros((len(labels), len(labels))), np.zeros(len(labels))
    places = [[labels.index(label) for label in one.labels] for one in estimates]
    for one, place in zip(estimates, places, strict=True):
        total[np.ix_(place, place)] += one.information
        weighted[place] += one.information @ one.value
    value = np.linalg.pinv(total, hermitian=True) @ weighted
    differences = [one.value - value[place] for one, place in zip(estimates, places, strict=True)]
    distance = sum(
        difference @ one.information @ difference for one, difference in zip(estimates, differences, strict=True)
    )
    ranks = [np.linalg.matrix_rank(one.information, hermitian=True) for one in estimates]
    return Pool(labels, value, total, float(distance), int(sum(ranks) - np.linalg.matrix_rank(total, hermitian=True)))


def agreeing(estimates: Sequence[Estimate], level: float = MIN_AGREEMENT) -> list[Estimate]:
    """Return the estimates that agree, after the removal, one by one, of that without which they agree best."""
    kept = list(estimates)
    while len(kept) > 1 and pooled(kept).agreement < level:
        rest = [[other for other in kept if other is not one] for one in kept]
        kept = min(rest, key=lambda others: (pooled(others).distance, -pooled(others).gain))
    return kept


def contradicts(one: Estimate | Pool, pool: Pool, level: float = MIN_AGREEMENT) -> bool:
    """Return whether an estimate, or several, that are not in a pool are too far from it."""
    covariance = np.linalg.pinv(one.information, hermitian=True) + pool.covariance
    difference = one.value - pool.value
    return bool(difference @ np.linalg.solve(covariance, difference) > chi2.isf(level, len(difference)))


def _marginal(information: np.ndarray, mine: Sequence[bool]) -> np.ndarray:
    """Return the information on some parameters, the others free."""
    covariance = np.linalg.pinv(information, hermitian=True)
    return np.linalg.pinv(covariance[np.ix_(mine, mine)], hermitian=True)


def _joints(kinds: tuple[type[Effect], ...], device: Device, level: float) -> tuple[Joint, ...]:
    """Return the effects of some kinds that axes of the device have together, if two of them or more do.

    All are estimated together, as each may stand for the others. One that is not significant beside them is left out.
    """
    if not kinds:
        return ()
    estimates = _estimates(kinds, device)
    members = {kind: _members(kind, estimates, device, level) for kind in kinds}
    several = tuple(kind for kind in kinds if len(members[kind]) > 1)
    if several != kinds:
        return _joints(several, device, level)
    shares = [one.about([kind for kind in kinds if one.axis in members[kind]]) for one in estimates]
    pool = pooled([one for one in shares if one.terms])
    log_ps = {kind: log_p_of_gain(pool.about(kind).gain, len(pool.about(kind).value)) for kind in kinds}
    weakest = max(kinds, key=lambda kind: log_ps[kind])
    if log_ps[weakest] > next(iter(device.searches.values())).log_alpha:
        return _joints(tuple(kind for kind in kinds if kind is not weakest), device, level)
    return tuple(_joint(kind, members[kind], estimates, pool.about(kind)) for kind in kinds)


def _joint(kind: type[Effect], members: Sequence[str], estimates: Sequence[Estimate], pool: Pool) -> Joint:
    term = next(term for one in estimates if one.axis in members for term in one.terms if type(term.effect) is kind)
    effect = replace(term.effect, **dict(zip(term.free, pool.value.tolist(), strict=True)))
    shares = tuple(one for one in _about(kind, estimates) if one.axis in members)
    return Joint(effect, tuple(axis for axis in kind.common if axis in members), term.free, shares, pool)


def _members(kind: type[Effect], estimates: Sequence[Estimate], device: Device, level: float) -> list[str]:
    """Return the axes that have an effect by one value: those that show it and agree, and those that allow of it.

    The others of a sensor are asked together: where some of them do without it, those that do not tell have none.
    """
    estimates = _about(kind, estimates)
    showing = [one for one in estimates if device.fits[one.axis].has(kind)]
    silent = [one for one in estimates if not device.fits[one.axis].has(kind)]
    anchor = agreeing(showing or silent, level)
    rest = [[one for one in silent if one.axis in sensor and one not in anchor] for sensor in (GYRO, ACCEL)]
    allowing = [group for group in rest if group and not contradicts(pooled(group), pooled(anchor), level)]
    return [one.axis for one in (*anchor, *chain.from_iterable(allowing))]


def _together(kind: type[Effect], estimates: Sequence[Estimate], device: Device, level: float) -> bool:
    """Return whether axes agree on a significant effect that none of them shows alone."""
    silent = _about(kind, estimates)
    if len(silent) < 2:
        return False
    pool, log_alpha = pooled(silent), device.searches[silent[0].axis].log_alpha
    return pool.agreement >= level and log_p_of_gain(pool.gain, len(pool.value)) < log_alpha


def _about(kind: type[Effect], estimates: Sequence[Estimate]) -> list[Estimate]:
    """Return what axes say of effects of one kind, those that say something."""
    return [part for one in estimates if (part := one.about([kind])).terms]


def _estimates(kinds: Sequence[type[Effect]], device: Device) -> list[Estimate]:
    """Return what the axes say of effects of some kinds, shown there or not, all of them free.

    Axes whose start model has one are not asked for it.
    """
    estimates = []
    for axis, found in device.fits.items():
        asked = [kind for kind in kinds if axis in kind.common and not device.searches[axis].start_has(kind)]
        for kind in asked:
            start = None if found.has(kind) else next(kind.starts(found), None)
            found = found if start is None else fit(found.sequence, found.description.adding(entry_of(start)))
        if any(found.has(kind) for kind in asked):
            estimates.append(_estimate(axis, found, asked))
    return estimates


def _estimate(axis: str, found: AxisFit, kinds: Sequence[type[Effect]]) -> Estimate:
    """Return what a fit says of its terms of some kinds, the other terms free."""
    terms = found.description.terms
    mine = [type(term.effect) in kinds for term in terms]
    places = np.repeat(mine, [len(term.free) for term in terms])
    information = np.linalg.pinv(found.covariance[np.ix_(places, places)], hermitian=True)
    return Estimate(axis, tuple(term for term, own in zip(terms, mine, strict=True) if own), information)


def _held(device: Device, joint: Joint) -> Device:
    """Return the device with an effect held at its common value, and without what was there in its place."""
    fits, searches = dict(device.fits), dict(device.searches)
    for axis in joint.axes:
        search, held = searches[axis], Entry(joint.effect, (), known=True)
        rest = fits[axis].description.keeping(lambda entry: not isinstance(entry.effect, type(joint.effect)))
        searches[axis] = replace(search, start=search.start.adding(held), memory={})
        fits[axis] = searches[axis].pruned(fit(fits[axis].sequence, rest.adding(held)))
    return Device(fits, searches, (*device.joints, joint))

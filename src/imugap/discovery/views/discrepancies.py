"""Test all views of all axes against refitted replicates of the fitted model, and locate the disagreements."""

from collections import defaultdict
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, partial
from itertools import combinations

import numpy as np
from threadpoolctl import threadpool_limits

from imugap.discovery import views
from imugap.discovery.finding import Discrepancy
from imugap.discovery.fit.axis_fit import AxisFit, fit
from imugap.discovery.preparation.rounding import level_before_rounding, mean_of_terms, unrounded
from imugap.discovery.preparation.sequence import AxisSequence
from imugap.discovery.views.envelope import Envelope
from imugap.effects.effect import AxisModel, Effect
from imugap.stream import stream

REPLICATES = 99
FIRST_REPLICATES, SMALL_P_VALUE = 40, 0.02
"""Number of replicates of every axis, and the p-value of a view below which its axes get all replicates."""
REPLICATES_PER_TASK = 10
"""Replicates per task of one process; consecutive ones serve as pairs of independent axes."""


@dataclass(frozen=True, eq=False)
class ViewTest:
    """Test of one view of one axis, or of two: the curve of the data and the envelope of its replicates."""

    curve: views.Curve
    envelope: Envelope

    @cached_property
    def p_value(self) -> float:
        """Return the probability, under the model, of as large a deviation anywhere in the view."""
        return float(self.envelope.p_value(self.envelope.deviation(self.curve.statistic).max()))

    @property
    def axes(self) -> set[str]:
        """Return the axes whose fits are tested: both for a coherence, else the axis of the residual."""
        axes = self.curve.axis.split(",")
        return set(axes) if self.curve.view == views.COHERENCE else {axes[0]}

    def places(self, level: float) -> list[Discrepancy]:
        """Return the places beyond the envelope at a level."""
        curve = self.curve
        return [
            Discrepancy(curve.view, curve.axis, low, high, curve.unit, p)
            for low, high, p in self.envelope.places(curve, level)
        ]


@dataclass(frozen=True, eq=False)
class ReplicateGroup:
    """Axes of one log whose views have the same distribution, so that they share replicates.

    Attributes
    ----------
    fits
        The fits of the axes.
    known
        Effects on the output, such as a resolution, that act after those of the description.
    binnings
        Cells of the views over conditions.
    """

    fits: tuple[AxisFit, ...]
    known: tuple[Effect, ...]
    binnings: tuple[views.Binning, ...]

    @property
    def axes(self) -> set[str]:
        """Return the names of the axes."""
        return {found.sequence.conditions.axis for found in self.fits}

    @property
    def last(self) -> int:
        """Return the number of cosine coefficients that their views use."""
        return self.fits[0].sequence.bins.last

    def replicate(self, seed: int, index: int) -> AxisFit:
        """Simulate the fitted description of the first axis, replace samples as in the data, and fit it again."""
        sequence, description = self.fits[0].sequence, self.fits[0].description
        conditions, labels = sequence.conditions, ("gaps", index)
        effects = unrounded(description.effects(), self.known, sequence)
        ideal = np.broadcast_to(conditions.error_free, len(conditions))
        error = AxisModel(effects).simulate(ideal, conditions, seed, *labels) - ideal
        if self.known:
            mean = float(np.mean(sequence.values))
            level = (
                mean
                if conditions.ideal is not None
                else level_before_rounding(mean, (*effects, *self.known), conditions.interval)
                - mean_of_terms(effects, conditions)
            )
            error = AxisModel(self.known).simulate(level + ideal + error, conditions, seed, *labels) - (mean + ideal)
        step = sequence.step if any(one.lattice for one in self.known) else 0.0
        clean = AxisSequence(error, conditions, share=sequence.share, step=step)
        rng = stream(seed, *labels, "mended")
        found = fit(clean.with_replaced(sequence.flawed, rng), description)
        if description.outliers is None:
            return found
        return fit(found.sequence.with_replaced(found.tails.flagged, rng), description)

    def binnings_of(self, axis: str) -> tuple[views.Binning, ...]:
        """Return the binnings that apply to the residual of an axis."""
        return tuple(item for item in self.binnings if item.applies_to(axis))


def replicate_groups(fits: Mapping[str, AxisFit], known: Mapping[str, tuple[Effect, ...]]) -> list[ReplicateGroup]:
    """Group the axes: those of mere normal white noise and the same flaws share a group, others have their own."""
    groups: dict[object, list[str]] = defaultdict(list)
    for axis, found in fits.items():
        plain = all(effect.white and effect.normal for effect in found.description.effects())
        shared = plain and not known.get(axis)
        groups[(found.sequence.flawed.tobytes(), found.sequence.share) if shared else axis].append(axis)
    over = views.binnings(next(iter(fits.values())).sequence)
    return [
        ReplicateGroup(
            tuple(fits[axis] for axis in group),
            tuple(effect for effect in known.get(group[0], ()) if not effect.replaced),
            tuple(item for item in over if any(item.applies_to(axis) for axis in group)),
        )
        for group in groups.values()
    ]


def view_tests(
    fits: Mapping[str, AxisFit],
    seed: int,
    replicates: int = REPLICATES,
    known: Mapping[str, tuple[Effect, ...]] | None = None,
    axes: Collection[str] | None = None,
    each: Callable = map,
) -> list[ViewTest]:
    """Test every view of every axis, and of every two axes, against replicates of the fitted model.

    All replicates are simulated only for axes with a small p-value among the first ones.

    Parameters
    ----------
    fits
        Axis to fit, all of one log.
    known
        Axis to effects on its output outside of the descriptions, such as a resolution.
    axes
        Axes to test, alone and in pairs with any other; default all.
    each
        Map function, possibly parallel.
    """
    tested = set(fits if axes is None else axes)
    if not tested:
        return []
    pairs = [pair for pair in combinations(fits, 2) if tested & set(pair)]
    sharing = {axis for axis, found in fits.items() if any(one.shared for one in found.description.effects())}
    common = [pair for pair in pairs if sharing >= set(pair)]
    doubtful = tested.union(*common)
    groups = replicate_groups({axis: replace(found) for axis, found in fits.items() if axis in doubtful}, known or {})
    lasts = {views.shared_last(*(fits[axis] for axis in pair)) for pair in pairs}
    curves = [*_axis_curves(groups, tested), *_pair_curves(pairs, common, fits)]
    tests, statistics = [], defaultdict(list)
    for first, last in ((0, min(FIRST_REPLICATES, replicates)), (FIRST_REPLICATES, replicates)):
        some = {number: group for number, group in enumerate(groups) if doubtful & group.axes}
        together = [pair for pair in common if set(pair) <= set().union(*(group.axes for group in some.values()))]
        parts = (
            [range(begin, min(begin + REPLICATES_PER_TASK, last)) for begin in range(first, last, REPLICATES_PER_TASK)]
            if some
            else []
        )
        for part in each(partial(_statistics, some, together, lasts, seed), parts):
            for key, rows in part.items():
                statistics[key] += rows
        tests = [ViewTest(curve, Envelope(np.array(statistics[key]), curve.signed)) for key, curve in curves]
        doubtful = set().union(*(one.axes for one in tests if one.p_value < SMALL_P_VALUE))
    return tests


def _statistics(
    groups: Mapping[int, ReplicateGroup], common: list[tuple[str, str]], lasts: set[int], seed: int, indices: range
) -> dict:
    """Return the statistics of replicates, by group and view, by pair of axes, and of independent pairs.

    Those of independent pairs use the coefficients up to each of ``lasts``.
    """
    statistics: dict[object, list[np.ndarray]] = defaultdict(list)
    widest = max(groups, key=lambda number: groups[number].last)
    paired, newest = {axis for pair in common for axis in pair}, None
    with threadpool_limits(1):
        for index in indices:
            last, drawn = newest, {}
            for number, group in groups.items():
                found = group.replicate(seed, index)
                for key, curve in views.curves(found, group.binnings).items():
                    statistics[number, *key].append(curve.statistic)
                drawn |= dict.fromkeys(group.axes & paired, found)
                newest = found if number == widest else newest
                del found
            if last is not None:
                for end in lasts:
                    statistics["independent", end].append(views.of_coherence(newest, last, end).statistic)
            for pair in common:
                statistics[pair].append(views.of_coherence(*(drawn[axis] for axis in pair)).statistic)
    return dict(statistics)


def _axis_curves(groups: list[ReplicateGroup], tested: Collection[str]) -> Iterator[tuple[object, views.Curve]]:
    """Yield the curves of the tested axes, each after the key of its statistics."""
    for number, group in enumerate(groups):
        for member in group.fits:
            axis = member.sequence.conditions.axis
            if axis in tested:
                for key, curve in views.curves(member.without_cache(), group.binnings_of(axis)).items():
                    yield (number, *key), curve


def _pair_curves(
    pairs: list[tuple[str, str]], common: list[tuple[str, str]], fits: Mapping[str, AxisFit]
) -> Iterator[tuple[object, views.Curve]]:
    """Yield the curves of pairs of axes, each after the key of its statistics; pairs without common noise share one."""
    bare = {axis: fit.without_cache() for axis, fit in fits.items()}
    for pair in pairs:
        members = [bare[axis] for axis in pair]
        yield pair if pair in common else ("independent", views.shared_last(*members)), views.of_coherence(*members)


def threshold(p_values: np.ndarray, alpha: float) -> float:
    """Return the threshold of p-values at a false discovery rate (Benjamini and Hochberg 1995), or 0 if none passes."""
    ordered = np.sort(p_values)
    passed = np.flatnonzero(ordered <= alpha * np.arange(1, len(ordered) + 1) / len(ordered))
    return float(alpha * (passed[-1] + 1) / len(ordered)) if len(passed) else 0.0


def find_discrepancies(
    fits: Mapping[str, AxisFit],
    alpha: float,
    seed: int,
    replicates: int = REPLICATES,
    known: Mapping[str, tuple[Effect, ...]] | None = None,
) -> tuple[Discrepancy, ...]:
    """Locate where data and model disagree, at a false discovery rate over views and axes, by increasing p-value.

    Parameters
    ----------
    fits
        Axis to fit, all of one log.
    alpha
        False discovery rate.
    known
        Axis to effects on its output outside of the descriptions, such as a resolution.
    """
    return significant_discrepancies(view_tests(fits, seed, replicates, known), alpha)


def place_level(tests: Collection[ViewTest], alpha: float) -> float:
    """Return the p-value down to which a view has places, at a false discovery rate over all of them.

    Where no view passes it is that of the first one that would.
    """
    return threshold(np.array([test.p_value for test in tests]), alpha) or alpha / max(len(tests), 1)


def significant_discrepancies(tests: Collection[ViewTest], alpha: float) -> tuple[Discrepancy, ...]:
    """Return the places of view tests at a false discovery rate over all of them, by p-value."""
    level = place_level(tests, alpha)
    found = [place for test in tests if test.p_value <= level for place in test.places(level)]
    return tuple(sorted(found, key=lambda place: place.p_value))

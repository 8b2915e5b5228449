"""Where measured data leave the model: all views of all axes against replicates of the fitted model, refitted."""

from collections import defaultdict
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, partial
from itertools import combinations

import numpy as np
from threadpoolctl import threadpool_limits

from imugap.discovery import views
from imugap.discovery.finding import Gap
from imugap.discovery.fit.axis_fit import AxisFit, fit
from imugap.discovery.preparation.rounding import level_ahead, unrounded
from imugap.discovery.preparation.sequence import AxisSequence
from imugap.discovery.views.envelope import Envelope
from imugap.effects import CommonMode, Resolution, SampleLoss, Saturation, StuckSamples, WhiteNoise
from imugap.effects.effect import AxisModel, Effect
from imugap.stream import stream

REPLICATES = 99
FIRST, DOUBT = 40, 0.02
"""Replicates that every axis has, and the probability by chance of a view below which an axis has the others too."""
TOGETHER = 10
"""Replicates that are made one after another, by one process; neighbours among them tell of independent axes."""
REPLACED = (SampleLoss, Saturation, StuckSamples)
"""Effects whose samples are replaced, all of them: a replicate has its replacements at the same places."""


@dataclass(frozen=True, eq=False)
class Verdict:
    """One view of one axis, or of two: its curve, the replicates', and the probability of the curve by chance."""

    curve: views.Curve
    envelope: Envelope

    @cached_property
    def p_value(self) -> float:
        """Return the probability of as large a deviation anywhere in the view if the model is right."""
        return float(self.envelope.p_value(self.envelope.deviation(self.curve.statistic).max()))

    @property
    def axes(self) -> set[str]:
        """Return the axes whose fits it is about: both of a coherence, else the first, that of the residual."""
        axes = self.curve.axis.split(",")
        return set(axes) if self.curve.view == views.COHERENCE else {axes[0]}

    def gaps(self, level: float) -> list[Gap]:
        """Return the places beyond the envelope of a level."""
        curve = self.curve
        return [
            Gap(curve.view, curve.axis, low, high, curve.unit, p) for low, high, p in self.envelope.places(curve, level)
        ]


@dataclass(frozen=True, eq=False)
class Twins:
    """Axes of one log whose views have the same law, so that they share replicates.

    Attributes
    ----------
    fits
        The fits of the axes.
    known
        Effects on the output, such as a resolution, that act after those of the description.
    over
        What the views of conditions are taken over.
    """

    fits: tuple[AxisFit, ...]
    known: tuple[Effect, ...]
    over: tuple[views.Binning, ...]

    @property
    def axes(self) -> set[str]:
        """Return the names of the axes."""
        return {found.sequence.conditions.axis for found in self.fits}

    @property
    def last(self) -> int:
        """Return the number of coefficients that their views use."""
        return self.fits[0].sequence.bins.last

    def replicate(self, seed: int, index: int) -> AxisFit:
        """Simulate the fitted description of the first axis, with its repairs, and fit it again."""
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
                else level_ahead(mean, (*effects, *self.known), conditions.interval)
            )
            error = AxisModel(self.known).simulate(level + ideal + error, conditions, seed, *labels) - (mean + ideal)
        step = sequence.step if any(isinstance(one, Resolution) for one in self.known) else 0.0
        clean = AxisSequence(error, conditions, np.zeros(len(conditions), bool), sequence.share, step=step)
        rng = stream(seed, *labels, "mended")
        found = fit(clean.mended(sequence.flawed, rng), description)
        if description.outliers is None:
            return found
        return fit(found.sequence.mended(found.tails.flagged, rng), description)

    def concern(self, axis: str) -> tuple[views.Binning, ...]:
        """Return what an axis' residual is looked at over."""
        return tuple(item for item in self.over if item.concerns(axis))


def twins(fits: Mapping[str, AxisFit], known: Mapping[str, tuple[Effect, ...]]) -> list[Twins]:
    """Return the axes grouped: those with nothing but white noise and the same flaws together, others alone."""
    groups: dict[object, list[str]] = defaultdict(list)
    for axis, found in fits.items():
        plain = all(isinstance(effect, WhiteNoise) for effect in found.description.effects())
        shared = plain and not known.get(axis)
        groups[(found.sequence.flawed.tobytes(), found.sequence.share) if shared else axis].append(axis)
    over = views.binnings(next(iter(fits.values())).sequence)
    return [
        Twins(
            tuple(fits[axis] for axis in group),
            tuple(effect for effect in known.get(group[0], ()) if not isinstance(effect, REPLACED)),
            tuple(item for item in over if any(item.concerns(axis) for axis in group)),
        )
        for group in groups.values()
    ]


def verdicts(
    fits: Mapping[str, AxisFit],
    seed: int,
    replicates: int = REPLICATES,
    known: Mapping[str, tuple[Effect, ...]] | None = None,
    asked: Collection[str] | None = None,
    each: Callable = map,
) -> list[Verdict]:
    """Return every view of every axis, and of every two axes, against replicates of the fitted model.

    The first replicates tell which axes are in doubt; only these have all of them.

    Parameters
    ----------
    fits
        Axis to fit, all of one log.
    known
        Axis to effects on its output that the descriptions leave out, such as a resolution.
    asked
        Axes that are asked for, alone and in pairs with any other; all of them unless given.
    each
        Applies a function to many arguments, several at a time perhaps.
    """
    asked = set(fits if asked is None else asked)
    if not asked:
        return []
    pairs = [pair for pair in combinations(fits, 2) if asked & set(pair)]
    common = [pair for pair in pairs if all(fits[axis].has(CommonMode) for axis in pair)]
    doubtful = asked.union(*common)
    groups = twins({axis: replace(found) for axis, found in fits.items() if axis in doubtful}, known or {})
    lasts = {views.shared_last(*(fits[axis] for axis in pair)) for pair in pairs}
    seen = [*_alone(groups, asked), *_pairs(pairs, common, fits)]
    judged, statistics = [], defaultdict(list)
    for first, last in ((0, min(FIRST, replicates)), (FIRST, replicates)):
        some = {number: group for number, group in enumerate(groups) if doubtful & group.axes}
        together = [pair for pair in common if set(pair) <= set().union(*(group.axes for group in some.values()))]
        parts = [range(begin, min(begin + TOGETHER, last)) for begin in range(first, last, TOGETHER)] if some else []
        for part in each(partial(_statistics, some, together, lasts, seed), parts):
            for key, rows in part.items():
                statistics[key] += rows
        judged = [Verdict(curve, Envelope(np.array(statistics[key]), curve.signed)) for key, curve in seen]
        doubtful = set().union(*(one.axes for one in judged if one.p_value < DOUBT))
    return judged


def _statistics(
    groups: Mapping[int, Twins], common: list[tuple[str, str]], lasts: set[int], seed: int, indices: range
) -> dict:
    """Return the statistics of replicates: by group and view, by pair of axes, and of independent pairs.

    Those of independent pairs are taken up to each of the coefficients ``lasts``.
    """
    statistics: dict[object, list[np.ndarray]] = defaultdict(list)
    widest = max(groups, key=lambda number: groups[number].last)
    paired, newest = {axis for pair in common for axis in pair}, None
    with threadpool_limits(1):
        for index in indices:
            last, drawn = newest, {}
            for number, group in groups.items():
                found = group.replicate(seed, index)
                for key, curve in views.curves(found, group.over).items():
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


def _alone(groups: list[Twins], asked: Collection[str]) -> Iterator[tuple[object, views.Curve]]:
    """Yield the curves of the axes that are asked for, each after the name of its statistics."""
    for number, group in enumerate(groups):
        for member in group.fits:
            axis = member.sequence.conditions.axis
            if axis in asked:
                for key, curve in views.curves(member.bare(), group.concern(axis)).items():
                    yield (number, *key), curve


def _pairs(
    pairs: list[tuple[str, str]], common: list[tuple[str, str]], fits: Mapping[str, AxisFit]
) -> Iterator[tuple[object, views.Curve]]:
    """Yield the curves of two axes each; where nothing is common, they go with pairs of independent replicates."""
    bare = {axis: fit.bare() for axis, fit in fits.items()}
    for pair in pairs:
        members = [bare[axis] for axis in pair]
        yield pair if pair in common else ("independent", views.shared_last(*members)), views.of_coherence(*members)


def threshold(p_values: np.ndarray, alpha: float) -> float:
    """Return the largest p-value that counts at a false discovery rate (Benjamini and Hochberg 1995), or 0."""
    ordered = np.sort(p_values)
    passed = np.flatnonzero(ordered <= alpha * np.arange(1, len(ordered) + 1) / len(ordered))
    return float(alpha * (passed[-1] + 1) / len(ordered)) if len(passed) else 0.0


def gaps(
    fits: Mapping[str, AxisFit],
    alpha: float,
    seed: int,
    replicates: int = REPLICATES,
    known: Mapping[str, tuple[Effect, ...]] | None = None,
) -> tuple[Gap, ...]:
    """Return the places where the data leave the model, at a false discovery rate over views and axes, surest first.

    Parameters
    ----------
    fits
        Axis to fit, all of one log.
    alpha
        Share of views that may be named by chance.
    known
        Axis to effects on its output that the descriptions leave out, such as a resolution.
    """
    return named(verdicts(fits, seed, replicates, known), alpha)


def named(judged: Collection[Verdict], alpha: float) -> tuple[Gap, ...]:
    """Return the places of verdicts at a false discovery rate over all of them, surest first."""
    level = threshold(np.array([verdict.p_value for verdict in judged]), alpha)
    found = [gap for verdict in judged if verdict.p_value <= level for gap in verdict.gaps(level)]
    return tuple(sorted(found, key=lambda gap: gap.p_value))

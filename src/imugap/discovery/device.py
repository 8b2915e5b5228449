"""Discovery on the logs of a device: where, which, add, show."""

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import partial
from types import MappingProxyType

import numpy as np
import pandas as pd
from threadpoolctl import threadpool_limits

from imugap.discovery.axis import Story, Tale, concluded, model_of, noise_of, part, told
from imugap.discovery.between_runs import as_first, clocks, turn_on
from imugap.discovery.checks.motion import ANOTHER
from imugap.discovery.common_noise import shared
from imugap.discovery.evaluation.distance import Distances, Drifts
from imugap.discovery.evaluation.held_out import HELD_IN, compare_held_out, compare_test_run, distances
from imugap.discovery.finding import CERTAIN, Finding, Gap, Interval
from imugap.discovery.fit.axis_fit import AxisFit
from imugap.discovery.fit.start_model import described, noisy, untold
from imugap.discovery.preparation.prepare import PreparedLog, prepare
from imugap.discovery.preparation.rounding import level_before_rounding, unrounded
from imugap.discovery.preparation.sequence import AxisSequence
from imugap.discovery.search.intervals import NORMAL, axis_unit
from imugap.discovery.search.noise_agreement import agreed
from imugap.discovery.search.search import log_chance
from imugap.discovery.search.shared_effects import Joint, joined
from imugap.discovery.views import COHERENCE, Curve
from imugap.discovery.views.gaps import REPLICATES, ViewTest, significant_gaps, view_tests
from imugap.effects import CATALOGUE
from imugap.effects.effect import AxisModel, Effect, Role, Stage
from imugap.log import TIME, axes
from imugap.model import ErrorModel, shifted

OTHER_STEPS = 4
"""Steps besides the two of each axis."""
Progress = Callable[[str, int, int], None]
"""Called with the name of a step as it begins, how many steps are done, and how many there are."""


@dataclass(frozen=True, eq=False)
class Discovery:
    """What was found on a device.

    Attributes
    ----------
    start, final
        Error models before and after.
    gaps
        Where the start model and the held-in part disagree.
    findings
        The effects that were added, surest first.
    unexplained
        Where the final model and the log still disagree.
    withheld
        (axis, name, reason) of what was seen but not named.
    described
        Noise that fits no name, which the final model has as noise of the slope that it has.
    untold
        (axis, name) of the effects of the start model that the log cannot tell, which stay as they were.
    distances
        Between measured and simulated held-out data, by name of the distance.
    drifts
        Navigation of the held-out data, measured and simulated, of each log that is compared; none for a device in
        motion or without all six axes.
    before, after
        Every view of the log against replicates of the start model (held-in part) and of the final one (whole log).
    record, stories
        The log and the discovery on each axis of it.
    """

    start: ErrorModel
    final: ErrorModel
    gaps: tuple[Gap, ...]
    findings: tuple[Finding, ...]
    unexplained: tuple[Gap, ...]
    withheld: tuple[tuple[str, str, str], ...]
    described: tuple[Finding, ...]
    untold: tuple[tuple[str, str], ...]
    distances: Mapping[str, Distances]
    drifts: tuple[Drifts, ...]
    before: tuple[ViewTest, ...]
    after: tuple[ViewTest, ...]
    record: PreparedLog
    stories: Mapping[str, Story]


@dataclass(frozen=True)
class Question:
    """How discovery is asked.

    Attributes
    ----------
    start
        Model that the simulator has now; None for a constant bias and white noise fitted to the log.
    alpha
        Probability that a log with nothing hidden gets any name.
    seed
        Of all simulations.
    catalogue
        Kinds of effects that may be missing.
    replicates, simulations
        Of the bootstrap of gaps, and of the distances.
    workers
        Processes that work at a time.
    """

    start: ErrorModel | None = None
    alpha: float = 0.01
    seed: int = 0
    catalogue: tuple[type[Effect], ...] = tuple(CATALOGUE.values())
    replicates: int = REPLICATES
    simulations: int = 60
    workers: int = 1

    def log_alpha(self, axes: int) -> float:
        """Return the logarithm of the probability that one proposal of one axis is taken by chance."""
        return float(np.log(self.alpha / axes / len(self.catalogue)))


def discover(
    logs: Sequence[pd.DataFrame],
    question: Question,
    tests: Sequence[pd.DataFrame] = (),
    reference: pd.DataFrame | None = None,
    progress: Progress = lambda step, done, steps: None,
) -> Discovery:
    """Find where a simulator and a device disagree, name what is missing and show that the gap shrinks.

    Parameters
    ----------
    logs
        Runs of one device, as :func:`imugap.io.readers.read_table` gives them. Effects within a run are discovered on
        the first; all are compared with each other.
    tests
        Further runs, on which distances are taken; without them it is the last part of the first log.
    reference
        Error-free log of the first run, for a device in motion.
    progress
        Told of each step.
    """
    known = ErrorModel({}) if question.start is None else question.start
    steps = _Steps(progress, OTHER_STEPS + 2 * len(axes(logs[0])))
    steps.begin("integrity")
    record = prepare(logs[0], reference, question.seed, question.start, question.catalogue)
    steps.count -= 2 * len(record.unusable)
    log_alpha = question.log_alpha(len(record.sequences))
    stories, joints = _stories(_alike(_tales(record, known, question, log_alpha, steps)), question, log_alpha, steps)
    befores = {axis: story.before for axis, story in stories.items()}
    wholes = {axis: story.whole for axis, story in stories.items()}
    steps.begin("gaps")
    outputs = {axis: _outputs(known, axis) for axis in stories}
    with _many(question.workers) as each:
        seen = view_tests(befores, question.seed, question.replicates, outputs, each=each)
    where = (*significant_gaps(seen, question.alpha), *_unsteady(stories))
    own = (*(one for story in stories.values() for one in story.findings), *map(_of_joint, joints))
    common = _news((one.finding(f"{axis_unit(one.axes[0])}/sqrt(Hz)") for one in shared(wholes, log_alpha)), known)
    between = _news(_between_runs(logs, wholes, known, question, log_alpha), known)
    outside = (*record.findings, *common, *between)
    findings = _ordered((*own, *_of_noise(wholes, question.start), *outside))
    steps.begin("gaps that remain")
    later, left = _left(seen, stories, record, common, question, outputs)
    left = (*_unsteady(stories), *left)
    steps.begin("distances")
    switching = {axis: (story.switching,) for axis, story in stories.items() if story.switching is not None}
    model = partial(_model, known=known, findings=outside, beside=switching)
    start, final = _model(befores, known), model(wholes)
    compared = [compare_test_run(test, stories, start, final, question.seed) for test in tests]
    with _many(question.workers) as each:
        asked = compared or [compare_held_out(record, stories, start, model)]
        apart, paths = distances(asked, question.seed, question.simulations, each)
    steps.begin("done")
    kept = _kept(known, record, wholes)
    return Discovery(
        start=_with_kept(start, kept),
        final=_with_kept(final, kept),
        gaps=(*record.gaps, *where, *nameless_places(stories, where, question.alpha)),
        findings=findings,
        unexplained=(*record.unusable, *left, *nameless_places(stories, left, question.alpha)),
        withheld=tuple((axis, *one) for axis, story in stories.items() for one in story.unnamed()),
        described=tuple(one.of_any_slope for one in stories.values() if one.of_any_slope is not None),
        untold=tuple((axis, one.name) for axis, some in kept.items() for one in some if axis in stories),
        distances=apart,
        drifts=paths,
        before=tuple(seen),
        after=later,
        record=record,
        stories=stories,
    )


@dataclass
class _Steps:
    """Counts the steps as they begin."""

    progress: Progress
    count: int
    done: int = 0

    def begin(self, name: str) -> None:
        self.progress(name, self.done, self.count)
        self.done += 1


def _ordered(findings: Sequence[Finding]) -> tuple[Finding, ...]:
    """Return the findings, those of integrity first, the others surest first."""
    return tuple(
        sorted(findings, key=lambda finding: (next(iter(finding.effects.values())).stage < Stage.RANGE, finding.log_p))
    )


def _each(
    task: Callable, arguments: Sequence[tuple], axes: Iterable[str], workers: int, steps: _Steps, step: str
) -> dict:
    """Return what a task makes of the arguments of each axis, several axes at a time."""
    found = {}
    with _many(workers) as each:
        results = iter(each(task, *zip(*arguments, strict=True)))
        for axis in axes:
            steps.begin(step)
            found[axis] = next(results)
    return found


@contextmanager
def _many(workers: int) -> Iterator[Callable]:
    """Yield what applies a function to many arguments, in so many processes."""
    if workers == 1:
        yield map
        return
    with ProcessPoolExecutor(workers) as pool:
        yield pool.map


def _stories(
    alone: dict[str, Tale],
    question: Question,
    log_alpha: float,
    steps: _Steps,
    apart: tuple[type[Effect], ...] = (),
) -> tuple[dict[str, Story], tuple[Joint, ...]]:
    """Return the story of each axis, and what axes have by one value, but for kinds left ``apart``.

    Apart is what is certain only with axes on which another function of the motion explains things better.
    """
    tales, joints = _together(alone, apart)
    stories = _each(concluded, [(tale,) for tale in tales.values()], tales, question.workers, steps, "names")
    moved = {axis for axis, story in stories.items() if any(one.reason == ANOTHER for one in story.withheld)}
    touched = [joint for joint in joints if moved & set(joint.axes)]
    doubtful = [type(joint.effect) for joint in touched if not joint.certain(set(joint.axes) - moved, log_alpha)]
    if not doubtful:
        return stories, joints
    steps.count += len(tales)
    return _stories(alone, question, log_alpha, steps, (*apart, *doubtful))


def _tales(
    record: PreparedLog, known: ErrorModel, question: Question, log_alpha: float, steps: _Steps
) -> dict[str, Tale]:
    arguments = [
        (sequence, _effects(known, axis), question.catalogue, log_alpha, int(HELD_IN * len(sequence.values)))
        for axis, sequence in record.sequences.items()
    ]
    return _each(told, arguments, record.sequences, question.workers, steps, "search")


def _alike(tales: dict[str, Tale]) -> dict[str, Tale]:
    """Return the tales with slow noise of one kind on the axes of a sensor, where they do not tell it."""
    with threadpool_limits(1):
        afters = agreed(*({axis: getattr(tale, part) for axis, tale in tales.items()} for part in ("after", "early")))
        wholes = agreed(*({axis: getattr(tale, part) for axis, tale in tales.items()} for part in ("whole", "late")))
    return {axis: replace(tale, after=afters[axis], whole=wholes[axis]) for axis, tale in tales.items()}


def _together(tales: dict[str, Tale], apart: Collection[type[Effect]]) -> tuple[dict[str, Tale], tuple[Joint, ...]]:
    """Return the tales with what axes have by one value joined, and what that is."""
    afters, earlies = ({axis: getattr(tale, part) for axis, tale in tales.items()} for part in ("after", "early"))
    wholes, lates = ({axis: getattr(tale, part) for axis, tale in tales.items()} for part in ("whole", "late"))
    early, late = joined(afters, earlies, apart), joined(wholes, lates, apart)
    changed = {
        axis: replace(
            tale, after=early.fits[axis], early=early.searches[axis], whole=late.fits[axis], late=late.searches[axis]
        )
        for axis, tale in tales.items()
    }
    return changed, late.joints


def _of_joint(joint: Joint) -> Finding:
    """Return an effect of one value on several axes as a finding."""
    errors = NORMAL * np.sqrt(np.diag(joint.pool.covariance))
    units = joint.effect.units(axis_unit(joint.axes[0]))
    parameters = {
        name: Interval(value, value - error, value + error, units[name])
        for name, value, error in zip(joint.free, joint.pool.value.tolist(), errors.tolist(), strict=True)
    }
    return Finding(dict.fromkeys(joint.axes, joint.effect), parameters, log_chance(joint.pool.gain, len(joint.free)))


def _outputs(model: ErrorModel, axis: str) -> tuple[Effect, ...]:
    """Return the effects of an axis that act on the output behind the filter."""
    return tuple(effect for effect in _effects(model, axis) if effect.stage > Stage.FILTER)


def _found_outputs(record: PreparedLog, axis: str, known: tuple[Effect, ...]) -> tuple[Effect, ...]:
    return known + tuple(finding.effects[axis] for finding in record.findings if axis in finding.effects)


def _between_runs(
    logs: Sequence[pd.DataFrame], wholes: Mapping[str, AxisFit], known: ErrorModel, question: Question, log_alpha: float
) -> tuple[Finding, ...]:
    """Return what differs between the runs."""
    if len(logs) < 2:
        return ()
    fits = [wholes]
    for log in logs[1:]:
        sequences = prepare(log, None, question.seed, question.start, question.catalogue).sequences
        whole = {axis: part(sequences[axis], 0, len(sequences[axis].values)) for axis in wholes if axis in sequences}
        starts = {axis: described(_effects(known, axis), one) for axis, one in whole.items()}
        fits.append({axis: as_first(one, starts[axis].terms, wholes[axis]) for axis, one in whole.items()})
    return (*turn_on(fits, log_alpha, question.catalogue), *clocks(fits, log_alpha, question.catalogue))


def _left(
    seen: Sequence[ViewTest],
    stories: Mapping[str, Story],
    record: PreparedLog,
    common: Sequence[Finding],
    question: Question,
    outputs: Mapping,
) -> tuple[tuple[ViewTest, ...], tuple[Gap, ...]]:
    """Return all views of the final model, and where it leaves the log.

    Axes on which nothing was seen are as they were; axes whose noise is shared are not held against each other.
    """
    fits = {axis: story.whole for axis, story in stories.items()}
    known = {axis: _found_outputs(record, axis, outputs[axis]) for axis in fits}
    changed = {axis for axis, story in stories.items() if story.seen or known[axis] != outputs[axis]}
    alike = {frozenset(pair) for finding in common for pair in _pairs(finding.axes)}
    with _many(question.workers) as each:
        judged = view_tests(fits, question.seed + 1, question.replicates, known, changed, each)
    judged += [one for one in seen if not changed & one.axes]
    left = tuple(gap for gap in significant_gaps(judged, question.alpha) if not _common(gap, alike))
    return tuple(one for one in judged if not _common(one.curve, alike)), left


def _common(one: Gap | Curve, alike: set[frozenset[str]]) -> bool:
    """Return whether a place or a curve is of what two axes have in common, which is known."""
    return one.view == COHERENCE and frozenset(one.axis.split(",")) in alike


def _unsteady(stories: Mapping[str, Story]) -> tuple[Gap, ...]:
    """Return the places of lines that are not steady; neither model has them."""
    return tuple(
        Gap("line", axis, band.low, band.high, "Hz", float(np.exp(max(band.log_p, CERTAIN))))
        for axis, story in stories.items()
        for band in story.bands
    )


def nameless_places(stories: Mapping[str, Story], places: Sequence[Gap], alpha: float) -> tuple[Gap, ...]:
    """Return where what has no name was seen for certain, of the axes on which no view shows it."""
    shown = {axis for place in places for axis in place.axis.split(",")}
    unseen = [one.place for axis, story in stories.items() if axis not in shown for one in story.withheld]
    return tuple(place for place in unseen if place.p_value < alpha)


def _effects(model: ErrorModel, axis: str) -> tuple[Effect, ...]:
    return tuple(model.axes.get(axis, AxisModel()))


def _news(findings: Iterable[Finding], known: ErrorModel) -> tuple[Finding, ...]:
    """Return the findings of which the start model does not have that kind on every axis of it."""

    def old(finding: Finding) -> bool:
        axes = finding.effects.items()
        return all(any(isinstance(one, type(effect)) for one in _effects(known, axis)) for axis, effect in axes)

    return tuple(finding for finding in findings if not old(finding))


def _of_noise(wholes: Mapping[str, AxisFit], start: ErrorModel | None) -> tuple[Finding, ...]:
    """Return the white noise of the axes of which a start model has no noise at all."""
    silent = [axis for axis in wholes if start is not None and not any(map(noisy, _effects(start, axis)))]
    return tuple(finding for axis in silent for finding in noise_of(wholes[axis]))


def _kept(known: ErrorModel, record: PreparedLog, wholes: Mapping[str, AxisFit]) -> dict[str, tuple[Effect, ...]]:
    """Return the effects that stay as the start model has them: what the log cannot tell, and those of the clock."""
    kept = {axis: tuple(effects) for axis, effects in known.axes.items()}
    for axis, found in wholes.items():
        effects = kept.get(axis, ())
        known = found.description.outliers is not None
        rare = () if known else tuple(one for one in effects if one.role is Role.OUTLIERS)
        kept[axis] = (*untold(effects, record.sequences[axis]), *rare)
    return kept


def _with_kept(model: ErrorModel, kept: Mapping[str, tuple[Effect, ...]]) -> ErrorModel:
    more = {axis: AxisModel((*effects, *_effects(model, axis))) for axis, effects in kept.items()}
    return ErrorModel({**model.axes, **more})


def _pairs(axes: Sequence[str]) -> list[tuple[str, str]]:
    return [(one, other) for one in axes for other in axes if one < other]


def _model(
    fits: Mapping[str, AxisFit],
    known: ErrorModel,
    findings: Sequence[Finding] = (),
    beside: Mapping[str, tuple[Effect, ...]] = MappingProxyType({}),
) -> ErrorModel:
    """Return the fits of all axes as a model, with what was found outside of them and what they are without.

    One device has one clock: of those of several other runs the first.
    """
    axes = {
        axis: AxisModel((*model_of(fit), *beside.get(axis, ()), *_outputs(known, axis))) for axis, fit in fits.items()
    }
    for finding in findings:
        for axis, effect in finding.effects.items():
            if not (axis == TIME and any(isinstance(one, type(effect)) for one in axes.get(axis, ()))):
                axes[axis] = _with(axes.get(axis, AxisModel()), effect)
    return ErrorModel(
        {axis: _ahead(model, fits[axis].sequence) if axis in fits else model for axis, model in axes.items()}
    )


def _ahead(model: AxisModel, sequence: AxisSequence) -> AxisModel:
    """Return the model whose rounded values are like those to which it was fitted."""
    effects = unrounded(model, model, sequence)
    if sequence.conditions.ideal is None:
        mean = float(sequence.values.mean())
        shift = level_before_rounding(mean, effects, sequence.conditions.interval) - mean
        return shifted(AxisModel(effects), shift)
    return AxisModel(effects)


def _with(model: AxisModel, effect: Effect) -> AxisModel:
    """Return the model with an effect more; noise that is shared is no longer the axis' own."""
    if effect.shared:
        own = [
            replace(one, density=float(np.sqrt(max(one.density**2 - (effect.density * effect.loading) ** 2, 0.0))))
            if one.white
            else one
            for one in model
        ]
        return AxisModel((*own, effect))
    return AxisModel((*model, effect))

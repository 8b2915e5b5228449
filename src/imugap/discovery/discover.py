"""Discovery on the logs of a device: where, which, add, show."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import pandas as pd
from threadpoolctl import threadpool_limits

from imugap import log as canonical
from imugap.discovery.axis import AxisFit
from imugap.discovery.common import shared
from imugap.discovery.device import Joint, joined
from imugap.discovery.distance import Apart, Distances, Drifts, distribution, drifts, together
from imugap.discovery.finding import CERTAIN, Finding, Gap, Interval
from imugap.discovery.gaps import REPLICATES, Verdict, named, verdicts
from imugap.discovery.parameters import NORMAL, axis_unit
from imugap.discovery.record import Record, prepare
from imugap.discovery.runs import as_first, clocks, turn_on
from imugap.discovery.search import log_chance
from imugap.discovery.story import Story, Tale, concluded, described, model_of, noise_of, part, told
from imugap.discovery.uncertain import Uncertain
from imugap.effects import CATALOGUE, CommonMode, SampleLoss, TurnOnBias, WhiteNoise
from imugap.effects.effect import Effect, Stage, StochasticEffect
from imugap.log import AXES, TEMPERATURE, from_samples
from imugap.model import AxisModel, ErrorModel

HELD_IN = 0.8
"""Share of a log that names and parameters come from, where no test log is given."""
LEVELLED = 0.2
"""Share of a test log that tells the level of a device at rest."""
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
    distances: Mapping[str, Distances]
    drifts: tuple[Drifts, ...]
    before: tuple[Verdict, ...]
    after: tuple[Verdict, ...]
    record: Record
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
        Runs of one device, as :func:`imugap.readers.read_table` gives them. Effects within a run are discovered on
        the first; all are compared with each other.
    tests
        Further runs, on which distances are taken; without them it is the last part of the first log.
    reference
        Error-free log of the first run, for a device in motion.
    progress
        Told of each step.
    """
    known = ErrorModel({}) if question.start is None else question.start
    steps = _Steps(progress, OTHER_STEPS + 2 * len(canonical.axes(logs[0])))
    steps.begin("integrity")
    record = prepare(logs[0], reference, question.seed, question.start)
    log_alpha = question.log_alpha(len(record.sequences))
    tales, joints = _together(_tales(record, known, question, log_alpha, steps))
    stories = _each(concluded, [(tale,) for tale in tales.values()], tales, question.workers, steps, "names")
    befores = {axis: story.before for axis, story in stories.items()}
    wholes = {axis: story.whole for axis, story in stories.items()}
    steps.begin("gaps")
    outputs = {axis: _outputs(known, axis) for axis in stories}
    with _many(question.workers) as each:
        seen = verdicts(befores, question.seed, question.replicates, outputs, each=each)
    where = named(seen, question.alpha)
    common = tuple(one.finding(f"{axis_unit(one.axes[0])}/sqrt(Hz)") for one in shared(wholes, log_alpha))
    own = tuple(finding for story in stories.values() for finding in story.findings)
    silent = [axis for axis in stories if question.start is not None and not _noisy(known.axes.get(axis, ()))]
    own += tuple(finding for axis in silent for finding in noise_of(wholes[axis]))
    outside = (*record.findings, *common, *_between_runs(logs, wholes, known, question, log_alpha))
    findings = _ordered((*own, *map(_of_joint, joints), *outside))
    steps.begin("gaps that remain")
    later, left = _left(seen, stories, record, common, question, outputs)
    start, final = _model(befores, known), _model(wholes, known, outside)
    steps.begin("distances")
    model = partial(_model, known=known, findings=outside)
    held_out = [_tested(test, stories, start, final, question) for test in tests]
    apart, paths = _distances(held_out or [_held_out(record, stories, start, model)], question)
    withheld = tuple((axis, *one) for axis, story in stories.items() for one in story.unnamed())
    unsteady = _unsteady(stories)
    where, left = (*where, *unsteady), (*unsteady, *left)
    places = (*record.gaps, *where, *_nameless(stories, where, question.alpha))
    left = (*left, *_nameless(stories, left, question.alpha))
    steps.begin("done")
    return Discovery(start, final, places, findings, left, withheld, apart, paths, tuple(seen), later, record, stories)


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


def _tales(record: Record, known: ErrorModel, question: Question, log_alpha: float, steps: _Steps) -> dict[str, Tale]:
    arguments = [
        (sequence, tuple(known.axes.get(axis, ())), question.catalogue, log_alpha, int(HELD_IN * len(sequence.values)))
        for axis, sequence in record.sequences.items()
    ]
    return _each(told, arguments, record.sequences, question.workers, steps, "search")


def _together(tales: dict[str, Tale]) -> tuple[dict[str, Tale], tuple[Joint, ...]]:
    """Return the tales with what axes have by one value joined, and what that is."""
    early = joined(
        {axis: tale.after for axis, tale in tales.items()}, {axis: tale.early for axis, tale in tales.items()}
    )
    late = joined({axis: tale.whole for axis, tale in tales.items()}, {axis: tale.late for axis, tale in tales.items()})
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
    return tuple(effect for effect in model.axes.get(axis, AxisModel()) if effect.stage > Stage.FILTER)


def _found_outputs(record: Record, axis: str, known: tuple[Effect, ...]) -> tuple[Effect, ...]:
    return known + tuple(finding.effects[axis] for finding in record.findings if axis in finding.effects)


def _between_runs(
    logs: Sequence[pd.DataFrame], wholes: Mapping[str, AxisFit], known: ErrorModel, question: Question, log_alpha: float
) -> tuple[Finding, ...]:
    """Return what differs between the runs."""
    if len(logs) < 2:
        return ()
    fits = [wholes]
    for log in logs[1:]:
        sequences = prepare(log, None, question.seed, question.start).sequences
        whole = {axis: part(sequences[axis], 0, len(sequences[axis].values)) for axis in wholes if axis in sequences}
        starts = {axis: described(tuple(known.axes.get(axis, AxisModel())), one) for axis, one in whole.items()}
        fits.append({axis: as_first(one, starts[axis].terms, wholes[axis]) for axis, one in whole.items()})
    return (*turn_on(fits, log_alpha), *clocks(fits, log_alpha))


def _left(
    seen: Sequence[Verdict],
    stories: Mapping[str, Story],
    record: Record,
    common: tuple[Finding, ...],
    question: Question,
    outputs: Mapping,
) -> tuple[tuple[Verdict, ...], tuple[Gap, ...]]:
    """Return all views of the final model, and where it leaves the log.

    Axes on which nothing was seen are as they were; axes whose noise is shared are not held against each other.
    """
    fits = {axis: story.whole for axis, story in stories.items()}
    known = {axis: _found_outputs(record, axis, outputs[axis]) for axis in fits}
    changed = {axis for axis, story in stories.items() if story.seen or known[axis] != outputs[axis]}
    alike = {frozenset(pair) for finding in common for pair in _pairs(finding.axes)}
    with _many(question.workers) as each:
        judged = verdicts(fits, question.seed + 1, question.replicates, known, changed, each)
    judged = [*judged, *(one for one in seen if not changed & set(one.curve.axis.split(",")))]
    left = tuple(gap for gap in named(judged, question.alpha) if frozenset(gap.axis.split(",")) not in alike)
    return tuple(one for one in judged if frozenset(one.curve.axis.split(",")) not in alike), left


def _unsteady(stories: Mapping[str, Story]) -> tuple[Gap, ...]:
    """Return the places of lines that are not steady; neither model has them."""
    return tuple(
        Gap("line", axis, band.low, band.high, "Hz", float(np.exp(max(band.log_p, CERTAIN))))
        for axis, story in stories.items()
        for band in story.bands
    )


def _nameless(stories: Mapping[str, Story], places: Sequence[Gap], alpha: float) -> tuple[Gap, ...]:
    """Return where what has no name was seen for certain, of the axes on which no view shows it."""
    shown = {axis for place in places for axis in place.axis.split(",")}
    unseen = [one.place for axis, story in stories.items() if axis not in shown for one in story.withheld]
    return tuple(place for place in unseen if place.p_value < alpha)


def _noisy(effects: Iterable[Effect]) -> bool:
    return any(isinstance(effect, StochasticEffect) for effect in effects)


def _pairs(axes: Sequence[str]) -> list[tuple[str, str]]:
    return [(one, other) for one in axes for other in axes if one < other]


def _model(fits: Mapping[str, AxisFit], known: ErrorModel, findings: Sequence[Finding] = ()) -> ErrorModel:
    """Return the fits of all axes as a model, with what was found outside of them."""
    axes = {axis: AxisModel((*model_of(fit), *_outputs(known, axis))) for axis, fit in fits.items()}
    for finding in findings:
        for axis, effect in finding.effects.items():
            axes[axis] = _with(axes.get(axis, AxisModel()), effect)
    return ErrorModel(axes)


def _with(model: AxisModel, effect: Effect) -> AxisModel:
    """Return the model with an effect more; noise that is shared is no longer the axis' own."""
    if isinstance(effect, CommonMode):
        own = [
            replace(one, density=float(np.sqrt(max(one.density**2 - (effect.density * effect.loading) ** 2, 0.0))))
            if isinstance(one, WhiteNoise)
            else one
            for one in model
        ]
        return AxisModel((*own, effect))
    return AxisModel((*model, effect))


@dataclass(frozen=True, eq=False)
class _Compared:
    """A log with the models that it is compared with: what is simulated counts from ``split`` [s] on.

    Before it, the mean of each axis would be ``level`` without a full scale.
    """

    measured: pd.DataFrame
    split: float
    level: Mapping[str, float]
    before: Uncertain
    after: Uncertain
    reference: pd.DataFrame | None

    def distribution(self, seed: int, count: int) -> Apart:
        asked = (self.measured, self.split, self.before, self.after, seed, count)
        return distribution(*asked, self.reference, self.level)

    def drifts(self, seed: int, count: int) -> Drifts:
        return drifts(self.measured, self.split, self.before, self.after, seed, count, self.level)

    @property
    def kinds(self) -> tuple[str, ...]:
        """Return the names of the distances that can be taken."""
        navigable = self.reference is None and all(axis in self.measured for axis in AXES)
        return ("distribution", "drifts") if navigable else ("distribution",)


def _held_out(record: Record, stories: Mapping[str, Story], start: ErrorModel, model: Callable) -> _Compared:
    """Return the last part of the log with models whose parameters come from the part before it.

    Where only the last part shows an effect, the parameters of its axis come from the whole log.
    """
    fits = {axis: story.after if story.settled else story.whole for axis, story in stories.items()}
    before = Uncertain(_in_run(start), {axis: story.before for axis, story in stories.items()})
    return _compared(record, HELD_IN, before, Uncertain(_in_run(model(fits)), fits))


def _tested(
    test: pd.DataFrame, stories: Mapping[str, Story], start: ErrorModel, final: ErrorModel, question: Question
) -> _Compared:
    """Return a further run with the models of the first one."""
    record = prepare(test[[name for name in test if name in stories or name == TEMPERATURE]], seed=question.seed)
    before = Uncertain(_in_run(start), {axis: story.before for axis, story in stories.items()})
    after = Uncertain(_in_run(final), {axis: story.whole for axis, story in stories.items()})
    return _compared(record, LEVELLED, before, after)


def _compared(record: Record, share: float, before: Uncertain, after: Uncertain) -> _Compared:
    conditions = next(iter(record.sequences.values())).conditions
    held_in = int(share * len(conditions))
    split = float(conditions.time[held_in])
    level = {axis: float(sequence.values[:held_in].mean()) for axis, sequence in record.sequences.items()}
    measured, reference = from_samples(record.outputs, conditions.interval), None
    if conditions.ideal is not None:
        reference = conditions.ideal[list(record.outputs)].set_axis(measured.index)
    if conditions.temperature is not None:
        measured = measured.assign(temperature=conditions.temperature)
    return _Compared(measured, split, level, before, after, reference)


def _distances(logs: Sequence[_Compared], question: Question) -> tuple[dict[str, Distances], tuple[Drifts, ...]]:
    """Return the distances over logs, and the drifts of those that can be navigated; each log has its own seed."""
    asked = [(one, question.seed + number, question.simulations) for number, one in enumerate(logs)]
    with _many(question.workers) as each:
        tasks = [(one, seed, count, kind) for one, seed, count in asked for kind in one.kinds]
        found = list(each(_one_distance, *zip(*tasks, strict=True)))
    apart = {"distribution": together([one for one in found if isinstance(one, Apart)])}
    paths = tuple(one for one in found if isinstance(one, Drifts))
    if paths:
        apart["navigation"] = together([path.apart() for path in paths])
    return apart, paths


def _one_distance(compared: _Compared, seed: int, count: int, kind: str) -> Apart | Drifts:
    """Return one distance of one log."""
    with threadpool_limits(1):
        return getattr(compared, kind)(seed, count)


def _in_run(model: ErrorModel) -> ErrorModel:
    """Return the model of one even run: without its clock and its gaps, and without what differs only between runs."""
    sensors, left_out = model.sensors.items(), (SampleLoss, TurnOnBias)
    kept = {axis: tuple(effect for effect in one if not isinstance(effect, left_out)) for axis, one in sensors}
    return ErrorModel({axis: AxisModel(effects) for axis, effects in kept.items()})

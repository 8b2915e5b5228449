"""Discovery on the logs of a device.

:func:`_prepare`, :func:`_search_axes`, :func:`_name_effects`, :func:`_compare_runs`, :func:`_assemble`,
:func:`_measure_distances`, :func:`_locate_discrepancies`, :func:`_test_final_model`, :func:`_describe_nameless` and
:func:`_conclude` are the stages in order, each a function of the one before. Where the final model turns out farther
from held-out data than the start model, the effects to blame are withdrawn, and the stages from :func:`_name_effects`
to :func:`_measure_distances` are repeated. :func:`name_missing` ends there.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import pandas as pd

from imugap.discovery.assembly import axis_effects, device_model, keep_undetermined, output_effects, with_effects
from imugap.discovery.axis import AxisResult, AxisSearch, part, white_noise_finding
from imugap.discovery.checks.distribution import NoiseShape, noise_shape
from imugap.discovery.evaluation.distance import Distances, Drifts, Evaluation, HeldOutComparison
from imugap.discovery.evaluation.held_out import HELD_IN_SHARE, compare_held_out, compare_test_run, evaluate
from imugap.discovery.finding import MIN_LOG_P, Discrepancy, Finding, Unnamed
from imugap.discovery.fit.axis_fit import AxisFit
from imugap.discovery.fit.start_model import described, noisy
from imugap.discovery.noise.common_noise import find_common_noise
from imugap.discovery.noise.nameless_noise import NamelessNoise, describe
from imugap.discovery.pooling import agree_on_noise, name_pooled, pooled_finding, search_each
from imugap.discovery.posterior import posterior
from imugap.discovery.preparation.gravity import SensedGravity
from imugap.discovery.preparation.prepare import PreparedLog, prepare
from imugap.discovery.preparation.reference_band import ReferenceBand, reference_band
from imugap.discovery.preparation.sequence import AxisSequence
from imugap.discovery.runs.between_runs import clock_findings, fit_like_first, turn_on_findings
from imugap.discovery.runs.over_runs import OverRuns, better_over_runs, not_needed, not_recurring, search_over_runs
from imugap.discovery.search.intervals import axis_unit, intervals
from imugap.discovery.search.shared_effects import Joint
from imugap.discovery.steps import Memory, Progress, StepCounter, each_in_processes, no_progress
from imugap.discovery.views import COHERENCE, Curve
from imugap.discovery.views.discrepancies import REPLICATES, ViewTest, significant_discrepancies, view_tests
from imugap.effects import CATALOGUE
from imugap.effects.effect import Effect, Role, Stage
from imugap.log import AXES, TEMPERATURE, axes
from imugap.model import ErrorModel
from imugap.units import STANDARD_GRAVITY

FARTHER = "the model with it is farther from data that no fit has seen"
OF_EITHER = "it may be of the reference"
NOT_SEARCHED = "it is not among the effects that are searched for"
NOT_RECURRING = "further runs are less likely with it"
BY_ALL_RUNS = "what only all runs together show explains it"
"""Reasons for withdrawing an effect."""
OTHER_STEPS = 4
"""Steps besides the two of each axis."""


@dataclass(frozen=True, eq=False)
class Names:
    """What was named on a device.

    Attributes
    ----------
    final
        Error model with all that was named.
    findings
        The effects that were added, surest first.
    withheld
        What was seen but not named.
    undetermined
        (axis, name) of the effects of the start model that the log does not determine; they stay as they were.
    record, results
        The first log, prepared, and the result of each axis of it.
    gravity
        Gravity in the level of the first log; None for a device in motion, or without accelerometers that sense it.
    """

    final: ErrorModel
    findings: tuple[Finding, ...]
    withheld: tuple[Unnamed, ...]
    undetermined: tuple[tuple[str, str], ...]
    record: PreparedLog
    results: Mapping[str, AxisResult]
    gravity: SensedGravity | None


@dataclass(frozen=True, eq=False)
class Discovery(Names):
    """What was found on a device.

    Attributes
    ----------
    start
        Error model before.
    discrepancies
        Where the start model and the training part disagree.
    unexplained
        Where the final model and the log still disagree.
    described
        Noise that fits no name, as the final model has it: a power law, or what only all runs together show.
    distances
        Between measured and simulated held-out data, by name of the distance.
    drifts
        Navigation of the held-out data, measured and simulated, of each log that is compared; none for a device in
        motion or without all six axes.
    before, after
        Every view of the log against replicates of the start model (training part) and of the final one (whole log).
    further
        Fits of the further runs of each axis, with the terms and the processes of the first.
    shapes
        Distributions of the noise of single samples that are not normal.
    band
        Band in which the reference follows the motion; None for all frequencies, or for a device at rest.
    runs
        Number of logs, to all of which the random processes are fitted.
    nameless
        Model with a description of noise that has no name, where that is nearer to held-out data; else None.
    """

    start: ErrorModel
    discrepancies: tuple[Discrepancy, ...]
    unexplained: tuple[Discrepancy, ...]
    described: tuple[Finding, ...]
    distances: Mapping[str, Distances]
    drifts: tuple[Drifts, ...]
    before: tuple[ViewTest, ...]
    after: tuple[ViewTest, ...]
    further: Mapping[str, tuple[AxisFit, ...]]
    shapes: tuple[NoiseShape, ...]
    band: ReferenceBand | None
    runs: int
    nameless: NamelessNoise | None


@dataclass(frozen=True)
class Settings:
    """Settings of discovery.

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
        Of the bootstrap of the views, and of the distances.
    workers
        Processes that work at a time.
    gravity
        Gravity of the site of a device at rest [m/s^2].
    """

    start: ErrorModel | None = None
    alpha: float = 0.01
    seed: int = 0
    catalogue: tuple[type[Effect], ...] = tuple(CATALOGUE.values())
    replicates: int = REPLICATES
    simulations: int = 60
    workers: int = 1
    gravity: float = STANDARD_GRAVITY

    def log_alpha(self, axes: int) -> float:
        """Return the logarithm of the false-alarm probability of one proposal on one axis."""
        return float(np.log(self.alpha / axes / len(self.catalogue)))

    def of_some_axes(self, count: int) -> "Settings":
        """Return the settings of a search of ``count`` axes, each proposal at the level that it has among all six."""
        return replace(self, alpha=self.alpha * count / len(AXES))


@dataclass(frozen=True, eq=False)
class _Prepared:
    """The prepared logs of a device.

    Attributes
    ----------
    settings
        Settings.
    record
        The first run, prepared.
    others, tests
        Further runs of the device, and runs for the distances, prepared.
    band
        Band in which the reference follows the motion; None for all frequencies, or for a device at rest.
    known
        Start model; empty where there is none.
    log_alpha
        Logarithm of the false-alarm probability of one proposal on one axis.
    steps
        Counter of the steps.
    """

    settings: Settings
    record: PreparedLog
    others: Sequence[PreparedLog]
    tests: Sequence[PreparedLog]
    band: ReferenceBand | None
    known: ErrorModel
    log_alpha: float
    steps: StepCounter


@dataclass(frozen=True, eq=False)
class _Searched(_Prepared):
    """With the search of each axis, and what was made of it before, with other effects withdrawn.

    Attributes
    ----------
    searches
        Search of each axis.
    named
        Results of axes (:func:`name_pooled`).
    memory
        Fits of the further runs, and noise of all runs.
    """

    searches: Mapping[str, AxisSearch]
    named: dict[tuple, AxisResult]
    memory: Memory

    @property
    def before(self) -> dict[str, AxisFit]:
        """Fit of the start model to the training part of each axis."""
        return {axis: one.start_fit for axis, one in self.searches.items()}

    @property
    def outputs(self) -> dict[str, tuple[Effect, ...]]:
        """Effects of the start model on the output of each axis."""
        return {axis: output_effects(self.known, axis) for axis in self.searches}


@dataclass(frozen=True, eq=False)
class _Named(_Searched):
    """With the result of each axis, and the effects that axes share by one value."""

    results: Mapping[str, AxisResult]
    joints: tuple[Joint, ...]

    @property
    def whole(self) -> dict[str, AxisFit]:
        """Fit of the named effects to the whole log of each axis."""
        return {axis: result.whole_fit for axis, result in self.results.items()}


@dataclass(frozen=True, eq=False)
class _Compared(_Named):
    """With the noise that axes share, what differs between the runs, and what all of them say together.

    Attributes
    ----------
    common, between
        Noise that axes share, and differences between runs.
    further
        Fits of the further runs of each axis, with the terms and the processes of the first run.
    over_runs
        Noise of each axis over all runs.
    """

    common: tuple[Finding, ...]
    between: tuple[Finding, ...]
    further: Mapping[str, tuple[AxisFit, ...]]
    over_runs: Mapping[str, OverRuns]

    @property
    def device(self) -> dict[str, AxisFit]:
        """Fit of the named effects of each axis, its noise that of all runs."""
        return {axis: one.fit for axis, one in self.over_runs.items()}

    @property
    def repeating(self) -> dict[str, AxisFit]:
        """Fit of the named effects to the whole first log of each axis, with what all runs repeat."""
        return {axis: self.over_runs[axis].beside(one) for axis, one in self.whole.items()}

    @property
    def beyond_axes(self) -> tuple[Finding, ...]:
        """Findings that are not those of one axis."""
        return (*self.record.findings, *self.common, *self.between)


@dataclass(frozen=True, eq=False)
class _Assembled(_Compared):
    """With all findings, and the models before and after."""

    findings: tuple[Finding, ...]
    start: ErrorModel
    model: Callable[[Mapping[str, AxisFit]], ErrorModel]


@dataclass(frozen=True, eq=False)
class _Measured(_Assembled):
    """With the held-out data, compared with both models, and the distances."""

    compared: Sequence[HeldOutComparison]
    evaluation: Evaluation


@dataclass(frozen=True, eq=False)
class _Located(_Measured):
    """With every view of the start model, and the discrepancies."""

    views: Sequence[ViewTest]
    discrepancies: tuple[Discrepancy, ...]


@dataclass(frozen=True, eq=False)
class _Tested(_Located):
    """With every view of the final model, and the remaining discrepancies."""

    views_after: tuple[ViewTest, ...]
    discrepancies_after: tuple[Discrepancy, ...]


@dataclass(frozen=True, eq=False)
class _Described(_Tested):
    """With a description of noise that has no name."""

    nameless: NamelessNoise | None


Withdrawn = Mapping[str, Mapping[type[Effect], str]]
"""Kinds of effects that are not named on an axis, with the reason."""


def discover(
    logs: Sequence[pd.DataFrame],
    settings: Settings,
    tests: Sequence[pd.DataFrame] = (),
    reference: pd.DataFrame | None = None,
    progress: Progress = no_progress,
) -> Discovery:
    """Find where a simulator and a device disagree, name what is missing and show that the discrepancy shrinks.

    Parameters
    ----------
    logs
        Runs of one device, as :func:`imugap.io.recording.read` gives them. Effects within a run are discovered on
        the first; all are compared with each other.
    tests
        Further runs, on which distances are taken; without them it is the last part of the first log.
    reference
        Error-free log of the first run, for a device in motion.
    progress
        Called as each step begins.
    """
    measured = _measured(_search_axes(_prepare(logs, settings, tests, reference, progress)))
    return _conclude(_describe_nameless(_test_final_model(_locate_discrepancies(measured))))


def name_missing(logs: Sequence[pd.DataFrame], settings: Settings) -> Names:
    """Name what is missing from the model of a device at rest, as :func:`discover` does, without testing any view."""
    return _names(_measured(_search_axes(_prepare(logs, settings, (), None, no_progress))))


def leave_one_out(
    logs: Sequence[pd.DataFrame],
    prepared: Sequence[PreparedLog],
    settings: Settings,
    starts: Sequence[ErrorModel | None],
) -> Iterator[HeldOutComparison]:
    """Yield, for each run of a device, its comparison with the models that discovery on the other runs has.

    Effects within a run are discovered on the first of the others, once for all folds that begin with it, from its
    model in ``starts``, which has one for each run. ``prepared`` are the same logs, prepared without a start model.
    """
    searched = {}
    for out, test in enumerate(prepared):
        first, *others = (number for number in range(len(logs)) if number != out)
        if first not in searched:
            own = _prepare([logs[first]], replace(settings, start=starts[first]), (), None, no_progress)
            searched[first] = _search_axes(own)
        runs = [prepared[number] for number in others]
        (compared,) = _measured(replace(searched[first], others=runs, tests=[test])).compared
        yield compared


def _measured(stage: _Searched) -> _Measured:
    """Name effects, and measure distances, until none is to be withdrawn."""
    withdrawn = _not_nameable(stage)
    measured = _modelled(stage, withdrawn)
    while (more := _to_withdraw(measured, withdrawn)) != withdrawn:
        withdrawn = more
        stage.steps.count += len(stage.searches) + 1
        measured = _modelled(stage, withdrawn)
    return measured


def _modelled(stage: _Searched, withdrawn: Withdrawn) -> _Measured:
    """Name effects but the withdrawn ones, assemble the final model, and measure its distance from held-out data."""
    return _measure_distances(_assemble(_compare_runs(_name_effects(stage, withdrawn))))


def _not_nameable(stage: _Prepared) -> Withdrawn:
    """Return the kinds that get no name on any axis.

    That is what is not searched for, and of a reference with errors of its own all but answers to motion and
    temperature.
    """
    searched = stage.settings.catalogue
    kinds = {kind: NOT_SEARCHED for kind in CATALOGUE.values() if kind not in searched}
    if stage.band is not None:
        kinds |= {kind: OF_EITHER for kind in searched if not (kind.of_motion or kind.of_temperature)}
    return dict.fromkeys(stage.record.sequences, kinds) if kinds else {}


def _to_withdraw(stage: _Measured, withdrawn: Withdrawn) -> Withdrawn:
    """Return the withdrawn effects, and further ones.

    On each axis the one that further runs do not have, or that noise of all runs explains; where there is none, and the
    axis is farther than before, the one of least held-out gain.
    """
    more = dict(withdrawn)
    for axis, apart in stage.evaluation.axes.items():
        found = stage.results[axis].findings
        kinds = {type(finding.effects[axis]) for finding in found}
        alone = type(not_recurring(stage.whole[axis], stage.further[axis]))
        replaced = type(_explained_over_runs(stage, axis))
        if alone in kinds:
            more[axis] = {**more.get(axis, {}), alone: NOT_RECURRING}
        elif replaced in kinds:
            more[axis] = {**more.get(axis, {}), replaced: BY_ALL_RUNS}
        elif apart.farther and found:
            worst = min(found, key=lambda finding: finding.log_score_gain)
            more[axis] = {**more.get(axis, {}), type(worst.effects[axis]): FARTHER}
    return more


def _explained_over_runs(stage: _Compared, axis: str) -> Effect | None:
    """Return an effect of the first run that what all runs together show explains, or None."""
    runs = (stage.whole[axis], *stage.further[axis])
    stands_in = better_over_runs(runs, stage.settings.catalogue, stage.log_alpha)
    return stands_in or not_needed(stage.over_runs[axis], stage.log_alpha)


def _prepare(
    logs: Sequence[pd.DataFrame],
    settings: Settings,
    tests: Sequence[pd.DataFrame],
    reference: pd.DataFrame | None,
    progress: Progress,
) -> _Prepared:
    """Take flawed samples and stamps out of the logs."""
    steps = StepCounter(progress, OTHER_STEPS + 2 * len(axes(logs[0])))
    steps.begin("integrity")
    record, band = _in_band(prepare(logs[0], reference, settings.seed, settings.start, settings.catalogue), settings)
    steps.count -= 2 * len(record.unusable)
    known = ErrorModel({}) if settings.start is None else settings.start
    others = [prepare(log, None, settings.seed, settings.start, settings.catalogue) for log in logs[1:]]
    compared = [_prepare_test(test, record, settings.seed) for test in tests]
    log_alpha = settings.log_alpha(len(record.sequences))
    return _Prepared(settings, record, others, compared, band, known, log_alpha, steps)


def _prepare_test(test: pd.DataFrame, record: PreparedLog, seed: int) -> PreparedLog:
    """Prepare the axes of a run for the distances that the first log has."""
    return prepare(test[[name for name in test if name in record.sequences or name == TEMPERATURE]], seed=seed)


def _in_band(record: PreparedLog, settings: Settings) -> tuple[PreparedLog, ReferenceBand | None]:
    """Return the means of a log in motion if its reference does not follow it at all frequencies, and the band.

    What acts on single samples and on stamps is found before, and cannot be seen in means.
    """
    conditions = next(iter(record.sequences.values())).conditions
    if conditions.motion is None:
        return record, None
    outputs = pd.DataFrame(record.outputs, index=conditions.ideal.index)
    band = reference_band(outputs, conditions.ideal, conditions.interval)
    if band is None:
        return record, None
    if conditions.temperature is not None:
        outputs = outputs.assign(**{TEMPERATURE: conditions.temperature})
    kinds = [kind for kind in settings.catalogue if kind.role not in (Role.OUTPUT, Role.CLOCK)]
    moving = band.moving_means(conditions.motion)
    means = prepare(band.means(outputs), moving, settings.seed, settings.start, kinds)
    return replace(
        means,
        findings=record.findings,
        discrepancies=(*record.discrepancies, *means.discrepancies),
        begin=record.begin + means.begin,
        unusable=record.unusable,
        confirmed=record.confirmed,
    ), band


def _search_axes(stage: _Prepared) -> _Searched:
    """Search each axis for missing effects, then let the axes of a sensor agree on their kind of slow noise."""
    settings = stage.settings
    arguments = [
        (sequence, axis_effects(stage.known, axis), settings.catalogue, stage.log_alpha, _split(sequence))
        for axis, sequence in stage.record.sequences.items()
    ]
    searches = search_each(arguments, stage.record.sequences, settings.workers, stage.steps)
    return _Searched(**vars(stage), searches=agree_on_noise(searches), named={}, memory=Memory())


def _name_effects(stage: _Searched, withdrawn: Withdrawn) -> _Named:
    """Pool effects that axes share by one value, check every name, and give intervals."""
    results, joints = name_pooled(
        stage.searches, stage.settings.workers, stage.log_alpha, stage.steps, withdrawn, stage.named
    )
    return _Named(**vars(stage), results=results, joints=joints)


def _compare_runs(stage: _Named) -> _Compared:
    """Find the noise that axes share, and the differences between runs, as far as the start model has neither."""
    common = (
        one.finding(f"{axis_unit(one.axes[0])}/sqrt(Hz)") for one in find_common_noise(stage.whole, stage.log_alpha)
    )
    others = _further_runs(stage)
    between = _between_runs(stage, others)
    by_axis = {axis: tuple(run[axis] for run in others if axis in run) for axis in stage.whole}
    levels = stage.settings.catalogue, stage.log_alpha
    return _Compared(
        **vars(stage),
        common=_news(common, stage.known),
        between=_news(between, stage.known),
        further=by_axis,
        over_runs={
            axis: stage.memory.once(search_over_runs, (one, *by_axis[axis]), *levels)
            for axis, one in stage.whole.items()
        },
    )


def _assemble(stage: _Compared) -> _Assembled:
    """Order all findings, and assemble the models of the device before and after."""
    own = (_of_device(one, stage) for result in stage.results.values() for one in result.findings)
    alone = (*own, *map(pooled_finding, stage.joints))
    of_all_runs = (term.finding(axis) for axis, one in stage.over_runs.items() for term in one.terms)
    noise = _noise_findings(stage.whole, stage.settings.start)
    findings = _ordered((*alone, *of_all_runs, *noise, *stage.beyond_axes))
    switching = {axis: (one.switching,) for axis, one in stage.results.items() if one.switching is not None}
    model = partial(device_model, known=stage.known, findings=stage.beyond_axes, beside=switching)
    start = device_model(stage.before, stage.known)
    return _Assembled(**vars(stage), findings=findings, start=start, model=model)


def _measure_distances(stage: _Assembled) -> _Measured:
    """Measure the distance of both models from the test runs, or from the held-out part where there are none."""
    settings = stage.settings
    stage.steps.begin("distances")
    models = stage.start, stage.model(stage.device)
    compared = [compare_test_run(test, stage.before, stage.device, *models) for test in stage.tests]
    with each_in_processes(settings.workers) as each:
        runs = compared or [compare_held_out(stage.record, stage.results, stage.start, stage.model)]
        evaluation = evaluate(runs, settings.seed, settings.simulations, each)
    return _Measured(**vars(stage), compared=runs, evaluation=evaluation)


def _locate_discrepancies(stage: _Measured) -> _Located:
    """Test every view of the training part against replicates of the start model."""
    settings = stage.settings
    stage.steps.begin("discrepancies")
    with each_in_processes(settings.workers) as each:
        views = view_tests(stage.before, settings.seed, settings.replicates, stage.outputs, each=each)
    return _Located(**vars(stage), views=views, discrepancies=significant_discrepancies(views, settings.alpha))


def _test_final_model(stage: _Located) -> _Tested:
    """Test every view of the whole log against replicates of the final model.

    Axes on which nothing was found are as they were; axes that share noise are not tested against each other.
    """
    settings, results = stage.settings, stage.results
    stage.steps.begin("remaining discrepancies")
    found = {axis: _with_found_outputs(stage, axis) for axis in results}
    repeating = stage.repeating
    changed = {
        axis
        for axis, result in results.items()
        if result.changed or found[axis] != stage.outputs[axis] or repeating[axis] is not stage.whole[axis]
    }
    with each_in_processes(settings.workers) as each:
        views = view_tests(repeating, settings.seed + 1, settings.replicates, found, changed, each)
    views += [one for one in stage.views if not changed & one.axes]
    sharing = {frozenset(pair) for finding in stage.common for pair in _pairs(finding.axes)}
    left = (place for place in significant_discrepancies(views, settings.alpha) if not _between_sharing(place, sharing))
    views = tuple(one for one in views if not _between_sharing(one.curve, sharing))
    return _Tested(**vars(stage), views_after=views, discrepancies_after=(*_line_discrepancies(results), *left))


def _describe_nameless(stage: _Tested) -> _Described:
    """Describe noise without a name where it remains, if a reference does not limit what is seen of it."""
    nameless = None
    if stage.band is None:
        with each_in_processes(stage.settings.workers) as each:
            nameless = describe(
                stage.discrepancies_after, stage.results, stage.record.sequences, stage.model, stage.compared,
                bool(stage.tests), lambda some: evaluate(some, stage.settings.seed, stage.settings.simulations, each),
            )  # fmt: skip
    return _Described(**vars(stage), nameless=nameless)


def _names(stage: _Measured) -> Names:
    """Put together what was named, and the final model."""
    proposals = len(stage.results) * len(stage.settings.catalogue)
    kept = _kept(stage)
    final = with_effects(stage.model(stage.device), kept)
    at_rest = all(fit.sequence.conditions.ideal is None for fit in stage.whole.values())
    gravity = SensedGravity.of(final, stage.known, stage.settings.gravity) if at_rest else None
    return Names(
        final=_without(gravity, final),
        findings=tuple(_with_probabilities(one, proposals) for one in stage.findings),
        withheld=tuple(one for axis, result in stage.results.items() for one in result.unnamed(axis, proposals)),
        undetermined=tuple((axis, one.name) for axis, some in kept.items() for one in some if axis in stage.results),
        record=stage.record,
        results=stage.results,
        gravity=gravity,
    )


def _conclude(stage: _Described) -> Discovery:
    """Put together the result."""
    stage.steps.begin("done")
    results, alpha = stage.results, stage.settings.alpha
    located = (*stage.discrepancies, *_line_discrepancies(results))
    names, kept = _names(stage), _kept(stage)
    nameless = stage.nameless
    if nameless is not None:
        nameless = replace(nameless, model=_without(names.gravity, with_effects(nameless.model, kept)))
    return Discovery(
        **vars(names),
        start=_without(names.gravity, with_effects(stage.start, kept)),
        discrepancies=(
            *stage.record.discrepancies,
            *located,
            *nameless_places(results, located, alpha),
        ),
        unexplained=(
            *stage.record.unusable,
            *stage.discrepancies_after,
            *nameless_places(results, stage.discrepancies_after, alpha),
        ),
        described=(
            *(_of_device(one.power_law, stage) for one in results.values() if one.power_law is not None),
            *(one for of_axis in stage.over_runs.values() for one in of_axis.findings()),
        ),
        distances=stage.evaluation.distances,
        drifts=stage.evaluation.drifts,
        before=tuple(stage.views),
        after=stage.views_after,
        further={axis: tuple(one.without_cache() for one in some) for axis, some in stage.further.items()},
        shapes=tuple(filter(None, (noise_shape(one, stage.log_alpha) for one in stage.whole.values()))),
        band=stage.band,
        runs=1 + len(stage.others),
        nameless=nameless,
    )


def _kept(stage: _Measured) -> dict[str, tuple[Effect, ...]]:
    """Return the effects of the start model that the log does not determine, of each axis."""
    return keep_undetermined(stage.known, stage.record, stage.whole)


def _without(gravity: SensedGravity | None, model: ErrorModel) -> ErrorModel:
    """Return a model of the error alone."""
    return model if gravity is None else gravity.taken_from(model)


def _with_probabilities(finding: Finding, proposals: int) -> Finding:
    """Return a finding with the probability of each explanation."""
    rivals = [(one.name, one.log_bayes_factor) for one in finding.rivals]
    shares = posterior(finding.name, finding.log_p, finding.misfit_log_p, rivals, proposals)
    return replace(finding, probabilities=shares)


def _split(sequence: AxisSequence) -> int:
    """Return the number of samples of the training part."""
    return int(HELD_IN_SHARE * len(sequence.values))


def _ordered(findings: Sequence[Finding]) -> tuple[Finding, ...]:
    """Return the findings, those of the output and the clock first, the others surest first."""
    return tuple(
        sorted(findings, key=lambda finding: (next(iter(finding.effects.values())).stage < Stage.RANGE, finding.log_p))
    )


def _with_found_outputs(stage: _Compared, axis: str) -> tuple[Effect, ...]:
    """Return the effects on the output of an axis: those of the start model, and those that were found."""
    found = (finding.effects[axis] for finding in stage.record.findings if axis in finding.effects)
    return (*stage.outputs[axis], *found)


def _further_runs(stage: _Named) -> list[dict[str, AxisFit]]:
    """Return the fits of the runs after the first, with the terms and the processes found in the first."""
    return [
        {
            axis: stage.memory.once(_like_first, one.sequences[axis], axis_effects(stage.known, axis), first)
            for axis, first in stage.whole.items()
            if axis in one.sequences
        }
        for one in stage.others
    ]


def _like_first(sequence: AxisSequence, known: tuple[Effect, ...], first: AxisFit) -> AxisFit:
    """Return the fit of an axis of another run, with the terms of a start model and what the first run has besides."""
    whole = part(sequence, 0, len(sequence.values))
    return fit_like_first(whole, described(known, whole).terms, first)


def _between_runs(stage: _Named, others: Sequence[Mapping[str, AxisFit]]) -> tuple[Finding, ...]:
    """Return what differs between the runs."""
    if not others:
        return ()
    fits, settings = [stage.whole, *others], stage.settings
    return (
        *turn_on_findings(fits, stage.log_alpha, settings.catalogue),
        *clock_findings(fits, stage.log_alpha, settings.catalogue),
    )


def _of_device(finding: Finding, stage: _Compared) -> Finding:
    """Return the finding of a random process with its values and intervals of all runs; any other as it is."""
    ((axis, effect),) = finding.effects.items()
    role, device = effect.role, stage.device[axis]
    alike = [entry.effect for entry in stage.whole[axis].description.of(role)]
    if not stage.further[axis] or effect not in alike or role not in (Role.NOISE, Role.FILTER):
        return finding
    entry = device.description.of(role)[alike.index(effect)]
    parameters = intervals(device, device.description.entries.index(entry))
    return replace(finding, effects={axis: entry.effect}, parameters=parameters)


def _between_sharing(one: Discrepancy | Curve, sharing: set[frozenset[str]]) -> bool:
    """Return whether a discrepancy or a curve is the coherence of two axes that share noise."""
    return one.view == COHERENCE and frozenset(one.axis.split(",")) in sharing


def _line_discrepancies(results: Mapping[str, AxisResult]) -> tuple[Discrepancy, ...]:
    """Return the places of lines that are not steady; neither model has them."""
    return tuple(
        Discrepancy("line", axis, band.low, band.high, "Hz", float(np.exp(max(band.log_p, MIN_LOG_P))))
        for axis, result in results.items()
        for band in result.bands
    )


def nameless_places(
    results: Mapping[str, AxisResult], places: Sequence[Discrepancy], alpha: float
) -> tuple[Discrepancy, ...]:
    """Return the places of withheld names on the axes of which no view shows a place."""
    shown = {axis for place in places for axis in place.axis.split(",")}
    unseen = [one.location for axis, result in results.items() if axis not in shown for one in result.withheld]
    return tuple(place for place in unseen if place.p_value < alpha)


def _news(findings: Iterable[Finding], known: ErrorModel) -> tuple[Finding, ...]:
    """Return the findings whose kind the start model does not have on every axis of it."""

    def old(finding: Finding) -> bool:
        effects = finding.effects.items()
        return all(any(isinstance(one, type(effect)) for one in axis_effects(known, axis)) for axis, effect in effects)

    return tuple(finding for finding in findings if not old(finding))


def _noise_findings(wholes: Mapping[str, AxisFit], start: ErrorModel | None) -> tuple[Finding, ...]:
    """Return the white noise of the axes for which a start model has no noise at all."""
    silent = [axis for axis in wholes if start is not None and not any(map(noisy, axis_effects(start, axis)))]
    return tuple(finding for axis in silent for finding in white_noise_finding(wholes[axis]))


def _pairs(axes: Sequence[str]) -> list[tuple[str, str]]:
    return [(one, other) for one in axes for other in axes if one < other]

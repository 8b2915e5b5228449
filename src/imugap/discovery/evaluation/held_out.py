"""Compare models with held-out data: the last part of a log, or further runs of the device."""

from collections.abc import Callable, Mapping, Sequence
from itertools import chain, islice

from threadpoolctl import threadpool_limits

from imugap.discovery.axis import AxisResult
from imugap.discovery.evaluation.distance import (
    SIDES,
    Evaluation,
    HeldOutComparison,
    LogStatistics,
    combined,
    distribution,
)
from imugap.discovery.evaluation.parameter_ensemble import UncertainModel
from imugap.discovery.fit.axis_fit import AxisFit, log_score
from imugap.discovery.preparation.prepare import PreparedLog
from imugap.discovery.preparation.sequence import AxisSequence
from imugap.effects.effect import AxisModel, Effect, Role
from imugap.log import from_samples
from imugap.model import ErrorModel

SIMULATIONS_PER_TASK = 15
"""Simulations of one model of one log per task of one process."""
HELD_IN_SHARE = 0.8
"""Share of a log that is fitted, where no test log is given."""
LEVEL_SHARE = 0.2
"""Share of a test log from which the level of a device at rest is estimated."""


def compare_held_out(
    record: PreparedLog, results: Mapping[str, AxisResult], start: ErrorModel, model: Callable
) -> HeldOutComparison:
    """Compare the last part of the log with models fitted to the part before it.

    Where an effect is found in the last part only, the parameters of its axis come from the whole log.
    """
    fits = {axis: result.training_fit if result.same_names else result.whole_fit for axis, result in results.items()}
    before = UncertainModel.of(of_one_run(start), {axis: result.start_fit for axis, result in results.items()})
    return _compared(record, HELD_IN_SHARE, before, UncertainModel.of(of_one_run(model(fits)), fits))


def compare_test_run(
    record: PreparedLog,
    befores: Mapping[str, AxisFit],
    afters: Mapping[str, AxisFit],
    start: ErrorModel,
    final: ErrorModel,
) -> HeldOutComparison:
    """Compare a further run with the start and the final model of a device, without events of the first run alone.

    ``befores`` and ``afters`` are the fits of the models, by axis.
    """
    before = UncertainModel.of(_in_another(start, befores, record.sequences), befores)
    after = UncertainModel.of(_in_another(final, afters, record.sequences), afters)
    return _compared(record, LEVEL_SHARE, before, after)


def _compared(record: PreparedLog, share: float, before: UncertainModel, after: UncertainModel) -> HeldOutComparison:
    conditions = next(iter(record.sequences.values())).conditions
    training = int(share * len(conditions))
    split = float(conditions.time[training])
    level = {axis: float(sequence.values[:training].mean()) for axis, sequence in record.sequences.items()}
    measured, reference = from_samples(record.outputs, conditions.interval), None
    if conditions.ideal is not None:
        reference = conditions.ideal.set_axis(measured.index)
    if conditions.temperature is not None:
        measured = measured.assign(temperature=conditions.temperature)
    return HeldOutComparison(measured, split, before, after, reference, level, conditions.motion)


def evaluate(logs: Sequence[HeldOutComparison], seed: int, count: int, each: Callable = map) -> Evaluation:
    """Return the distances over logs, together and of each axis, and the drifts of those that can be navigated.

    Log number k uses the seed ``seed`` + k; ``count`` is the number of simulations of each model, and ``each`` a map
    function, possibly parallel.
    """
    parts = [range(first, min(first + SIMULATIONS_PER_TASK, count)) for first in range(0, count, SIMULATIONS_PER_TASK)]
    tasks = [(one, name, seed + k, part) for name in SIDES for k, one in enumerate(logs) for part in parts]
    made = iter(each(_ensemble, *zip(*tasks, strict=True)))
    befores, afters = ([list(chain.from_iterable(islice(made, len(parts)))) for _ in logs] for _ in SIDES)
    seen = [(one, one.statistics(), *pair) for one, *pair in zip(logs, befores, afters, strict=True)]
    apart = {"distribution": combined([distribution(*summaries) for _, *summaries in seen])}
    shared = [axis for axis in seen[0][1].views if all(axis in own.views for _, own, *_ in seen)]
    axes = {axis: combined([distribution(*summaries, [axis]) for _, *summaries in seen]) for axis in shared}
    paths = tuple(one.drifts_of(*summaries) for one, *summaries in seen if one.course is not None)
    if paths:
        apart["navigation"] = combined([path.distances() for path in paths])
    return Evaluation(apart, axes, paths)


def _ensemble(compared: HeldOutComparison, name: str, seed: int, numbers: range) -> list[LogStatistics]:
    """Return the statistics of some simulations of one model."""
    with threadpool_limits(1):
        return compared.simulate(name, seed, numbers)


def of_one_run(model: ErrorModel) -> ErrorModel:
    """Return a model of one evenly sampled run: without effects of the clock and of those that differ between runs."""
    return _without(model, lambda _, effect: effect.role in (Role.CLOCK, Role.RUN))


def _in_another(model: ErrorModel, fits: Mapping[str, AxisFit], sequences: Mapping[str, AxisSequence]) -> ErrorModel:
    """Return the model of another run, with those events of the first run that recur at the same time."""
    once = {
        axis: [one for one in model[axis] if one.once and not _recurs(one, fits[axis], run)]
        for axis, run in sequences.items()
    }
    return _without(of_one_run(model), lambda axis, effect: effect in once.get(axis, []))


def _recurs(event: Effect, fit: AxisFit, run: AxisSequence) -> bool:
    """Return whether the likelihood of a further run is larger with an event of the first run than without it."""
    without = fit.description.keeping(lambda entry: entry.effect != event)
    return log_score(run, fit.description) > log_score(run, without)


def _without(model: ErrorModel, excluded: Callable[[str, Effect], bool]) -> ErrorModel:
    """Return the models of the sensor axes without the excluded effects."""
    kept = {axis: [one for one in effects if not excluded(axis, one)] for axis, effects in model.sensors.items()}
    return ErrorModel({axis: AxisModel(tuple(effects)) for axis, effects in kept.items()})

"""Logs beside the models that they are compared with: the last part of a log, or further runs of the device."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from itertools import chain, islice

import pandas as pd
from threadpoolctl import threadpool_limits

from imugap.discovery.axis import AxisResult
from imugap.discovery.evaluation.distance import (
    SIDES,
    Distances,
    Drifts,
    HeldOutComparison,
    LogStatistics,
    combined,
    distribution,
)
from imugap.discovery.evaluation.parameter_ensemble import UncertainModel
from imugap.discovery.fit.axis_fit import AxisFit, log_score
from imugap.discovery.preparation.prepare import PreparedLog, prepare
from imugap.discovery.preparation.sequence import AxisSequence
from imugap.effects.effect import AxisModel, Effect, Role
from imugap.log import TEMPERATURE, from_samples
from imugap.model import ErrorModel

TOGETHER = 15
"""Simulations of one model of one log that are made one after another, by one process."""
HELD_IN = 0.8
"""Share of a log that names and parameters come from, where no test log is given."""
LEVELLED = 0.2
"""Share of a test log that tells the level of a device at rest."""


def compare_held_out(
    record: PreparedLog, results: Mapping[str, AxisResult], start: ErrorModel, model: Callable
) -> HeldOutComparison:
    """Return the last part of the log with models whose parameters come from the part before it.

    Where only the last part shows an effect, the parameters of its axis come from the whole log.
    """
    fits = {axis: result.after if result.settled else result.whole for axis, result in results.items()}
    before = UncertainModel.of(_in_run(start), {axis: result.before for axis, result in results.items()})
    return _compared(record, HELD_IN, before, UncertainModel.of(_in_run(model(fits)), fits))


def compare_test_run(
    test: pd.DataFrame, results: Mapping[str, AxisResult], start: ErrorModel, final: ErrorModel, seed: int
) -> HeldOutComparison:
    """Return a further run with the models of the first one, without what happened in that one alone."""
    record = prepare(test[[name for name in test if name in results or name == TEMPERATURE]], seed=seed)
    befores, afters = (
        {axis: getattr(result, name) for axis, result in results.items()} for name in ("before", "whole")
    )
    before = UncertainModel.of(_in_another(start, befores, record.sequences), befores)
    after = UncertainModel.of(_in_another(final, afters, record.sequences), afters)
    return _compared(record, LEVELLED, before, after)


def _compared(record: PreparedLog, share: float, before: UncertainModel, after: UncertainModel) -> HeldOutComparison:
    conditions = next(iter(record.sequences.values())).conditions
    held_in = int(share * len(conditions))
    split = float(conditions.time[held_in])
    level = {axis: float(sequence.values[:held_in].mean()) for axis, sequence in record.sequences.items()}
    measured, reference = from_samples(record.outputs, conditions.interval), None
    if conditions.ideal is not None:
        reference = conditions.ideal.set_axis(measured.index)
    if conditions.temperature is not None:
        measured = measured.assign(temperature=conditions.temperature)
    return HeldOutComparison(measured, split, before, after, reference, level)


def distances(
    logs: Sequence[HeldOutComparison], seed: int, count: int, each: Callable = map
) -> tuple[dict[str, Distances], tuple[Drifts, ...]]:
    """Return the distances over logs, and the drifts of those that can be navigated.

    Each log has a seed of its own, counted from ``seed``; ``count`` simulations are made of each model, and ``each``
    applies a function to many arguments, several at a time perhaps.
    """
    parts = [range(first, min(first + TOGETHER, count)) for first in range(0, count, TOGETHER)]
    tasks = [(one, name, seed + k, part) for name in SIDES for k, one in enumerate(logs) for part in parts]
    made = iter(each(_ensemble, *zip(*tasks, strict=True)))
    befores, afters = ([list(chain.from_iterable(islice(made, len(parts)))) for _ in logs] for _ in SIDES)
    seen = [(one, one.statistics(), *pair) for one, *pair in zip(logs, befores, afters, strict=True)]
    apart = {"distribution": combined([distribution(*summaries) for _, *summaries in seen])}
    paths = tuple(one.drifts_of(*summaries) for one, *summaries in seen if one.course is not None)
    if paths:
        apart["navigation"] = combined([path.distances() for path in paths])
    return apart, paths


def _ensemble(compared: HeldOutComparison, name: str, seed: int, numbers: range) -> list[LogStatistics]:
    """Return the summaries of some simulations of one model."""
    with threadpool_limits(1):
        return compared.simulate(name, seed, numbers)


def _in_run(model: ErrorModel) -> ErrorModel:
    """Return the model of one even run: without its clock and its gaps, and without what differs only between runs."""
    return _but_for(model, lambda _, effect: effect.role in (Role.CLOCK, Role.RUN))


def _in_another(model: ErrorModel, fits: Mapping[str, AxisFit], sequences: Mapping[str, AxisSequence]) -> ErrorModel:
    """Return the model of another even run, in which a step or a change of variance may happen at the same time."""
    once = {
        axis: [one for one in model[axis] if one.once and not _recurs(one, fits[axis], run)]
        for axis, run in sequences.items()
    }
    return _but_for(_in_run(model), lambda axis, effect: effect in once.get(axis, []))


def _recurs(event: Effect, fit: AxisFit, run: AxisSequence) -> bool:
    """Return whether a further run is likelier with an event of the first one at the same time than without it."""
    found = fit.description
    terms = tuple(term for term in found.terms if term.effect != event)
    without = replace(found, terms=terms, changes=tuple(one for one in found.changes if one != event))
    return log_score(run, found) > log_score(run, without)


def _but_for(model: ErrorModel, left_out: Callable[[str, Effect], bool]) -> ErrorModel:
    """Return the models of the sensor axes without some effects."""
    kept = {axis: [one for one in effects if not left_out(axis, one)] for axis, effects in model.sensors.items()}
    return ErrorModel({axis: AxisModel(tuple(effects)) for axis, effects in kept.items()})

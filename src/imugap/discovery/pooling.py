"""Stages that pool the axes of a device: one kind of slow noise for a sensor, and effects of one value."""

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import replace

import numpy as np
from threadpoolctl import threadpool_limits

from imugap.discovery.axis import AxisResult, AxisSearch, conclude, search_axis
from imugap.discovery.checks.motion import OTHER_FUNCTION
from imugap.discovery.finding import Finding, Interval
from imugap.discovery.search.intervals import axis_unit
from imugap.discovery.search.noise_agreement import agreed
from imugap.discovery.search.search import log_p_of_gain
from imugap.discovery.search.shared_effects import Joint, joined
from imugap.discovery.steps import StepCounter, of_each_axis
from imugap.effects.effect import Effect
from imugap.numerics.normal_quantile import NORMAL_QUANTILE


def search_each(
    arguments: Sequence[tuple], axes: Iterable[str], workers: int, steps: StepCounter
) -> dict[str, AxisSearch]:
    """Search each axis; ``arguments`` are those of :func:`imugap.discovery.axis.search_axis`."""
    return of_each_axis(search_axis, arguments, axes, workers, steps, "search")


def agree_on_noise(searches: dict[str, AxisSearch]) -> dict[str, AxisSearch]:
    """Give the axes of a sensor one kind of slow noise where their samples do not contradict it."""
    with threadpool_limits(1):
        training = agreed(_each(searches, "training_fit"), _each(searches, "training_search"))
        whole = agreed(_each(searches, "whole_fit"), _each(searches, "whole_search"))
    return {axis: replace(one, training_fit=training[axis], whole_fit=whole[axis]) for axis, one in searches.items()}


def name_pooled(
    searches: dict[str, AxisSearch],
    workers: int,
    log_alpha: float,
    steps: StepCounter,
    withdrawn: Mapping[str, Mapping[type[Effect], str]],
    known: dict[tuple, AxisResult],
    apart: tuple[type[Effect], ...] = (),
) -> tuple[dict[str, AxisResult], tuple[Joint, ...]]:
    """Pool effects shared by several axes, and name those of each axis.

    Kinds ``apart`` are not pooled, kinds ``withdrawn`` on an axis are not named, each for its reason. Not pooled is
    what is certain only together with axes on which another function of the motion explains more. Results are put to
    those ``known`` of the same searches, and taken from there.
    """
    pooled, joints = _pool(searches, apart)
    keys = {axis: (axis, apart, frozenset(withdrawn.get(axis, {}).items())) for axis in pooled}
    new = {axis: (pooled[axis], withdrawn.get(axis, {})) for axis, key in keys.items() if key not in known}
    steps.count -= len(pooled) - len(new)
    found = of_each_axis(conclude, list(new.values()), new, workers, steps, "names")
    known.update({keys[axis]: result for axis, result in found.items()})
    results = {axis: known[key] for axis, key in keys.items()}
    moved = {axis for axis, result in results.items() if any(one.reason == OTHER_FUNCTION for one in result.withheld)}
    touched = [joint for joint in joints if moved & set(joint.axes)]
    uncertain = [type(joint.effect) for joint in touched if not joint.certain(set(joint.axes) - moved, log_alpha)]
    if not uncertain:
        return results, joints
    steps.count += len(searches)
    return name_pooled(searches, workers, log_alpha, steps, withdrawn, known, (*apart, *uncertain))


def pooled_finding(joint: Joint) -> Finding:
    """Return an effect of one value on several axes as a finding."""
    errors = NORMAL_QUANTILE * np.sqrt(np.diag(joint.pool.covariance))
    units = joint.effect.units(axis_unit(joint.axes[0]))
    parameters = {
        name: Interval(value, value - error, value + error, units[name])
        for name, value, error in zip(joint.free, joint.pool.value.tolist(), errors.tolist(), strict=True)
    }
    return Finding(dict.fromkeys(joint.axes, joint.effect), parameters, log_p_of_gain(joint.pool.gain, len(joint.free)))


def _pool(
    searches: dict[str, AxisSearch], apart: Collection[type[Effect]]
) -> tuple[dict[str, AxisSearch], tuple[Joint, ...]]:
    """Return the searches with the effects of one value held, and these effects."""
    training = joined(_each(searches, "training_fit"), _each(searches, "training_search"), apart)
    whole = joined(_each(searches, "whole_fit"), _each(searches, "whole_search"), apart)
    held = {
        axis: replace(
            one,
            training_fit=training.fits[axis],
            training_search=training.searches[axis],
            whole_fit=whole.fits[axis],
            whole_search=whole.searches[axis],
        )
        for axis, one in searches.items()
    }
    return held, whole.joints


def _each(searches: dict[str, AxisSearch], name: str) -> dict:
    """Return one attribute of the search of each axis."""
    return {axis: getattr(one, name) for axis, one in searches.items()}

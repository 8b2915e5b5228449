"""Error model of a device, assembled from the fits of its axes and the findings of the device."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType

import numpy as np

from imugap.discovery.axis import model_of
from imugap.discovery.finding import Finding
from imugap.discovery.fit.axis_fit import AxisFit
from imugap.discovery.fit.start_model import undetermined
from imugap.discovery.preparation.prepare import PreparedLog
from imugap.discovery.preparation.rounding import level_before_rounding, unrounded
from imugap.discovery.preparation.sequence import AxisSequence
from imugap.effects.effect import AxisModel, Effect, Role, Stage
from imugap.log import TIME
from imugap.model import ErrorModel, shifted


def axis_effects(model: ErrorModel, axis: str) -> tuple[Effect, ...]:
    """Return the effects of a model on an axis, none where it does not have the axis."""
    return tuple(model.axes.get(axis, AxisModel()))


def output_effects(model: ErrorModel, axis: str) -> tuple[Effect, ...]:
    """Return the effects of an axis that act on the output behind the filter."""
    return tuple(effect for effect in axis_effects(model, axis) if effect.stage > Stage.FILTER)


def device_model(
    fits: Mapping[str, AxisFit],
    known: ErrorModel,
    findings: Sequence[Finding] = (),
    beside: Mapping[str, tuple[Effect, ...]] = MappingProxyType({}),
) -> ErrorModel:
    """Assemble the device's error model.

    One device has one clock: of the clocks of several other runs it is the first.

    Parameters
    ----------
    fits
        Fit of each axis.
    known
        Start model; its effects on the output are kept.
    findings
        Findings of preparation, of noise that axes share, and between runs.
    beside
        Effects of each axis that were removed before its fit.
    """
    models = {
        axis: AxisModel((*model_of(fit), *beside.get(axis, ()), *output_effects(known, axis)))
        for axis, fit in fits.items()
    }
    for finding in findings:
        for axis, effect in finding.effects.items():
            if not (axis == TIME and any(isinstance(one, type(effect)) for one in models.get(axis, ()))):
                models[axis] = _with(models.get(axis, AxisModel()), effect)
    return ErrorModel(
        {axis: _before_rounding(one, fits[axis].sequence) if axis in fits else one for axis, one in models.items()}
    )


def keep_undetermined(
    known: ErrorModel, record: PreparedLog, fits: Mapping[str, AxisFit]
) -> dict[str, tuple[Effect, ...]]:
    """Return the effects that stay as the start model has them: undetermined by the log, and those of the clock."""
    kept = {axis: tuple(effects) for axis, effects in known.axes.items()}
    for axis, found in fits.items():
        effects = kept.get(axis, ())
        fitted = found.description.outliers is not None
        rare = () if fitted else tuple(one for one in effects if one.role is Role.OUTLIERS)
        kept[axis] = (*undetermined(effects, record.sequences[axis]), *rare)
    return kept


def with_effects(model: ErrorModel, effects: Mapping[str, tuple[Effect, ...]]) -> ErrorModel:
    """Return a model with further effects on some axes."""
    more = {axis: AxisModel((*some, *axis_effects(model, axis))) for axis, some in effects.items()}
    return ErrorModel({**model.axes, **more})


def _before_rounding(model: AxisModel, sequence: AxisSequence) -> AxisModel:
    """Return the model whose rounded values have the mean and the noise of those to which it was fitted."""
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

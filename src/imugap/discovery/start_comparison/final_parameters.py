"""Parameters of the final model, each with an interval of its own where the log gives one."""

from collections.abc import Mapping
from math import sqrt

import pandas as pd

from imugap.discovery.device import Discovery
from imugap.discovery.finding import Finding
from imugap.discovery.search.intervals import axis_unit
from imugap.discovery.start_comparison.parameters import StartParameter, kept_parameters
from imugap.effects.effect import Effect

LEVEL = 0.05
"""Probability that an interval misses its parameter."""
COLUMNS = ["axis", "effect", "number", "parameter", "unit", "value", "low", "high", "remark"]


def table(found: Discovery) -> pd.DataFrame:
    """Return a row for each parameter of the final model, SI.

    Columns: axis, effect, number (of the effects of one name on the axis, from 1), parameter, unit, value, low, high
    (95 %; none where the log gives no interval) and remark.
    """
    kept = {(row.axis, row.name): row for row in kept_parameters(found, LEVEL)}
    added = [*found.findings, *found.described]
    rows = []
    for axis, model in found.final.axes.items():
        counts: dict[str, int] = {}
        for effect in model:
            counts[effect.name] = counts.get(effect.name, 0) + 1
            own = next((one for one in added if one.effects.get(axis) == effect), None)
            for name, unit in effect.units(axis_unit(axis)).items():
                place = (axis, effect.name, counts[effect.name], name, unit, getattr(effect, name))
                rows.append((*place, *_interval(axis, effect, name, own, kept)))
    return pd.DataFrame(rows, columns=COLUMNS)


def _interval(
    axis: str, effect: Effect, name: str, own: Finding | None, kept: Mapping[tuple[str, str], StartParameter]
) -> tuple[float | None, float | None, str]:
    """Return lower and upper end of a parameter, and a remark."""
    if own is not None:
        found = own.parameters.get(name) or own.parameters.get(f"{name}_{axis}")
        return (None, None, "") if found is None else (found.low, found.high, "")
    row = kept.get((axis, f"{effect.name}.{name}"))
    if row is None or row.log is None:
        return None, None, "" if row is None else row.remark
    if not effect.white:
        return row.log.low, row.log.high, row.remark
    shared = row.log.value**2 - getattr(effect, name) ** 2  # what other axes have in common with this one
    low, high = (sqrt(max(end**2 - shared, 0.0)) for end in (row.log.low, row.log.high))
    return low, high, row.remark

"""The comparison of the start model with the log as a table and in words."""

from collections.abc import Iterable, Sequence
from math import isfinite

import pandas as pd

from imugap.discovery.start_comparison.parameters import Comparison, StartParameter


def table(rows: Iterable[StartParameter]) -> pd.DataFrame:
    """Return the comparison as a table, a row for each parameter and axis."""
    columns = ["axis", "effect", "parameter", "unit", "start", "log", "low", "high", "within", "p_value", "verdict",
               "remark"]  # fmt: skip
    return pd.DataFrame([_cells(one) for one in rows], columns=columns)


def _cells(row: StartParameter) -> tuple:
    value, low, high = (None, None, None) if row.log is None else (row.log.value, row.log.low, row.log.high)
    within = {Comparison.AGREES: "yes", Comparison.DIFFERS: "no"}.get(row.agreement, "")
    return (
        row.axis, row.effect, row.name, row.unit, row.start, value, low, high, within, row.p_value,
        str(row.agreement), row.remark,
    )  # fmt: skip


def sentences(rows: Sequence[StartParameter]) -> tuple[str, ...]:
    """Return in words which parameters differ, axes of a kind together, and how many agree."""
    groups: dict[tuple, list[StartParameter]] = {}
    for row in rows:
        keyed = row.agreement is Comparison.MISSING and not row.name.startswith(f"{row.effect}.")
        if (
            row.agreement is Comparison.DIFFERS
            or keyed
            or (row.agreement is Comparison.MISSING and row.effect == "bias")
        ):
            groups.setdefault((row.name, row.agreement, row.remark, _none(row)), []).append(row)
    said = [_sentence(some) for some in groups.values()]
    if any(row.agreement is Comparison.DIFFERS for row in rows):
        said.append("The distances before are those of the start model with its parameters fitted to the log.")
    own = [row for row in rows if row.agreement is not Comparison.MISSING]
    agreeing, open_ = (sum(row.agreement is one for row in own) for one in (Comparison.AGREES, Comparison.OPEN))
    if own:
        text = f"Of {len(own)} parameters of the start model {agreeing} agree with the log"
        said.append(text + (f"; the log cannot tell {open_}." if open_ else "."))
    return tuple(said)


def _none(row: StartParameter) -> bool:
    """Return whether the log shows none of what the start model has."""
    return row.log is not None and row.log.value == 0


def _sentence(rows: Sequence[StartParameter]) -> str:
    first = rows[0]
    axes, unit = ", ".join(row.axis for row in rows), f" {first.unit}".rstrip("1").rstrip()
    logs = [row.log for row in rows if row.log is not None]
    if first.agreement is Comparison.MISSING:
        return f"{axes}: {first.name} is missing; the log has {_range([one.value for one in logs])}{unit}."
    yours = f"{axes}: {first.name} is {_range([row.start for row in rows])}{unit} in the start model"
    if not logs:
        return f"{yours}; {first.remark}."
    most = f"at most {max(one.high for one in logs):.3g}{unit}"
    if _none(first):
        return f"{yours}; the log shows none ({most})."
    span = _span(min(one.low for one in logs), max(one.high for one in logs))
    remark = f" ({first.remark})" if first.remark else ""
    return f"{yours}; the log has {_range([one.value for one in logs])}{unit} (with its interval {span}){remark}."


def _span(low: float, high: float) -> str:
    return f"{low:.3g} to {high:.3g}" if isfinite(high) else f"at least {low:.3g}"


def _range(values: Sequence[float]) -> str:
    low, high = f"{min(values):.4g}", f"{max(values):.4g}"
    return low if low == high else f"{low} to {high}"

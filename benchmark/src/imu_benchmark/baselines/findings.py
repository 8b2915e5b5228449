"""Reports of baselines: effects that are found, with estimates where there are any."""

from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple


class Estimate(NamedTuple):
    """An estimate with its 95 % interval, where there is one."""

    value: float
    low: float | None = None
    high: float | None = None


def effect(
    name: str,
    axes: Sequence[str],
    parameters: Mapping[str, Estimate] | None = None,
    probabilities: Mapping[str, float] | None = None,
) -> dict:
    """Return an effect of a report on ``axes``."""
    estimates = {key: one._asdict() for key, one in (parameters or {}).items()}
    found = {"name": name, "axes": list(axes), "parameters": estimates, "alternatives": []}
    return found | ({"probabilities": dict(probabilities)} if probabilities else {})


def answer(effects: Iterable[Mapping], unexplained: Iterable[Mapping] = ()) -> dict:
    """Return a report."""
    return {"schema": "imugap/discovery/2", "effects": list(effects), "unexplained": list(unexplained)}

"""Report of a discovery as plain data and as tables."""

from collections.abc import Iterable, Sequence
from dataclasses import asdict
from math import exp, isfinite

import pandas as pd

from imugap.discovery.device import Discovery
from imugap.discovery.evaluation.distance import Distances
from imugap.discovery.finding import MIN_LOG_P, Discrepancy, Finding, Interval, Unnamed
from imugap.discovery.noise.nameless_noise import NamelessNoise
from imugap.discovery.posterior import NOT_SEEN, ambiguity_set

SCHEMA = "imugap/discovery/2"


def to_mapping(found: Discovery, logs: Sequence[dict], tests: Sequence[dict] = ()) -> dict:
    """Return the report as plain data; ``logs`` and ``tests`` are the properties of each log and test log."""
    report = {
        "schema": SCHEMA,
        "log": list(logs),
        "test": list(tests),
        "start_model": found.start.to_mapping(),
        "final_model": found.final.to_mapping(),
        "gaps": [_place(place) for place in found.discrepancies],
        "effects": [_effect(finding) for finding in found.findings],
        "unexplained": [_place(place) for place in found.unexplained],
        "probabilities": dict(NOT_SEEN),
        "withheld": [
            {"axis": one.axis, "name": one.name, "reason": one.reason} | _explanations(one) for one in found.withheld
        ],
        "described": [
            {"axis": one.axes[0], "name": one.name, "parameters": _parameters(one)} for one in found.described
        ],
    }
    for key, name in (("distance", "distribution"), ("navigation_distance", "navigation")):
        apart = found.distances.get(name)
        report[key] = None if apart is None else _distances(apart)
    report["nameless_noise"] = None if found.nameless is None else _nameless(found.nameless)
    return report


def _nameless(nameless: NamelessNoise) -> dict:
    return {
        "model": nameless.model.to_mapping(),
        "axes": list(nameless.effects),
        "distance": _distances(nameless.distances),
    }


def _distances(apart: Distances) -> dict[str, dict]:
    return {one: _ends(getattr(apart, one)) for one in ("before", "after", "floor")}


def _effect(finding: Finding) -> dict:
    return {
        "name": finding.name,
        "axes": list(finding.axes),
        "parameters": _parameters(finding),
        "p_value": exp(max(finding.log_p, MIN_LOG_P)),
        "log_score_gain": _number(finding.log_score_gain),
        "alternatives": [{"name": name, "log_score_gain": _number(gain)} for name, gain in finding.alternatives],
    } | _explanations(finding)


def _explanations(one: Finding | Unnamed) -> dict:
    return {"probabilities": dict(one.probabilities), "ambiguity_set": list(ambiguity_set(one.probabilities))}


def _parameters(finding: Finding) -> dict[str, dict]:
    return {name: _ends(one) | {"unit": one.unit} for name, one in finding.parameters.items()}


def _ends(interval: Interval) -> dict[str, float | None]:
    """Return value and ends; an end at infinity is null."""
    ends = {"value": interval.value, "low": interval.low, "high": interval.high}
    return {key: _number(value) for key, value in ends.items()}


def _place(place: Discrepancy) -> dict:
    return asdict(place) | {"low": _number(place.low), "high": _number(place.high)}


def _number(value: float) -> float | None:
    """Return a number as JSON has it: null where it is not finite."""
    return float(value) if isfinite(value) else None


def discrepancy_table(discrepancies: Iterable[Discrepancy], left: Iterable[Discrepancy]) -> pd.DataFrame:
    """Return the places, found with the start model and left by the final one."""
    columns = ["view", "axis", "low", "high", "unit", "p_value", "model"]
    rows = [
        asdict(place) | {"model": model}
        for model, some in (("start", discrepancies), ("final", left))
        for place in some
    ]
    return pd.DataFrame(rows, columns=columns)


def view_table(found: Discovery) -> pd.DataFrame:
    """Return the p-value of each view under the start and the final model; none where a model has no such view."""
    start, final = (
        pd.Series({(one.curve.view, one.curve.axis): one.p_value for one in some}, dtype=float)
        for some in (found.before, found.after)
    )
    return pd.DataFrame({"start": start, "final": final}).rename_axis(["view", "axis"]).reset_index()


def candidate_table(found: Discovery) -> pd.DataFrame:
    """Return named effects, their alternatives that the data cannot distinguish, and withheld ones with the reason."""
    columns = ["axes", "name", "status", "probability", "log_p", "log_score_gain", "reason"]
    rows = []
    for one in found.findings:
        axes, share = " ".join(one.axes), one.probabilities
        rows.append((axes, one.name, "named", share.get(one.name), one.log_p, one.log_score_gain, ""))
        rows += [
            (axes, name, f"alternative to {one.name}", share.get(name), None, gain, "")
            for name, gain in one.alternatives
        ]
    rows += [
        (one.axis, one.name, "withheld", one.probabilities.get(one.name), None, None, one.reason)
        for one in found.withheld
    ]
    return pd.DataFrame(rows, columns=columns)

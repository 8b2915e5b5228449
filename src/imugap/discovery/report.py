"""Report of a discovery as plain data, as tables, and as text."""

from collections.abc import Iterable, Sequence
from dataclasses import asdict, replace
from math import exp, isfinite

import pandas as pd

from imugap.discovery.device import Discovery
from imugap.discovery.evaluation.distance import Distances
from imugap.discovery.finding import MIN_LOG_P, Discrepancy, Finding, Interval, Unnamed, unnamed_sentences
from imugap.discovery.noise.nameless_noise import NamelessNoise
from imugap.discovery.posterior import IN_WORDS, MIN_SHARE, NOT_SEEN, ambiguity_set, percent
from imugap.effects import title_of
from imugap.integrity.regular import counted

MAX_LOCATIONS = 12
"""Largest number of groups of locations in one sentence."""
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


def verdict(found: Discovery) -> str:
    """Return the verdict as text; that the final model does not fit comes ahead of any name and number."""
    known = "has a name" if found.withheld or found.unexplained or found.shapes else "the log can show"
    far = [name for name, one in found.distances.items() if not one.reached]
    lines = [f"The model does not yet describe the device in {' and '.join(far)}."] if far else []
    lines += [] if found.band is None else [found.band.sentence()]
    if found.record.shocks:
        times = ", ".join(f"{begin:.4g} to {end:.4g} s" for begin, end in found.record.shocks[:MAX_LOCATIONS])
        number = counted(len(found.record.shocks), "shock")
        lines.append(f"Left out: {number} of the device, on several axes at once, {times}; no error of a sensor.")
    lines += [_sentence(finding) for finding in found.findings] or [f"Nothing is missing that {known}."]
    lines += unnamed_sentences(found.withheld)
    lines += described_sentences(found)
    lines += [one.sentence() for one in found.shapes]
    if found.undetermined:
        kept = ", ".join(f"{name} of {axis}" for axis, name in found.undetermined)
        lines.append(f"The log cannot tell {kept}; kept as the start model has it.")
    if found.runs > 1:
        lines.append(f"Random processes have the values and intervals of all {found.runs} runs together.")
    if found.gravity is not None:
        lines.append(found.gravity.sentence())
    if found.unexplained:
        lines.append(f"Still unexplained: {describe_locations(found.unexplained)}.")
    for name, apart in found.distances.items():
        numbers = f"{apart.before.value:.3g} before, {apart.after.value:.3g} after"
        text = f"Distance in {name}: {numbers}; floor {apart.floor.low:.3g} to {apart.floor.high:.3g}"
        lines.append(f"{text}: {apart.judgement}.")
    if found.nameless is not None:
        lines.append(found.nameless.sentence())
    return "\n".join(lines)


def _sentence(finding: Finding) -> str:
    values = (f"{name} {one.value:.4g} {one.unit}".removesuffix(" 1") for name, one in finding.parameters.items())
    text = f"{', '.join(finding.axes)}: {finding.name} ({', '.join(values)})"
    return f"{text}; {certainty(finding)}."


def certainty(finding: Finding) -> str:
    """Return how probable the name is, what else is likely, and which names the log cannot tell from it."""
    share = finding.probabilities
    others = [name for name in ambiguity_set(share) if name != finding.name]
    likely = (name for name, _ in finding.alternatives if share.get(name, 1.0) >= MIN_SHARE)
    names = dict.fromkeys((*likely, *(one for one in others if one not in IN_WORDS)))
    parts = [f"of the name {percent(share[finding.name])}"]
    parts += [f"of {IN_WORDS[one]} {percent(share[one])}" for one in others if one in IN_WORDS]
    text = f"probability {', '.join(parts)}"
    return f"{text}; the log cannot tell it from {', '.join(title_of(one) for one in names)}" if names else text


def described_sentences(found: Discovery) -> list[str]:
    """Return how the final model describes noise without a name, a sentence for each axis."""
    axes = dict.fromkeys(one.axes[0] for one in found.described)
    return [_described(axis, [one for one in found.described if one.axes[0] == axis]) for axis in axes]


def _described(axis: str, processes: Sequence[Finding]) -> str:
    parts = []
    for one in processes:
        values = (
            f"{name} {of.value:.3g} ({of.low:.3g} to {of.high:.3g}) {of.unit}".removesuffix(" 1")
            for name, of in one.parameters.items()
        )
        parts.append(f"{one.name} ({', '.join(values)})")
    return f"{axis}: noise without a name is in the model as {' and '.join(parts)}."


def describe_locations(places: Sequence[Discrepancy]) -> str:
    """Return locations as text, those of one axis and view together, :data:`MAX_LOCATIONS` of them at most."""
    groups: dict[tuple[str, str, str], list[Discrepancy]] = {}
    for place in places:
        groups.setdefault((place.axis, place.view, place.unit), []).append(place)
    shown = [_describe_group(some) for some in list(groups.values())[:MAX_LOCATIONS]]
    more = len(groups) - len(shown)
    return "; ".join(shown) + (f"; and {more} more views, all of them in the table of places" if more else "")


def _describe_group(places: Sequence[Discrepancy]) -> str:
    first = places[0]
    if len({(place.low, place.high) for place in places}) == 1:
        return describe_location(first)
    low, high = min(place.low for place in places), max(place.high for place in places)
    return f"{describe_location(replace(first, low=low, high=high))} ({len(places)} places)"


def describe_location(place: Discrepancy) -> str:
    """Return a location as text, e.g. "gyro_y, line, 49.98 Hz"."""
    return f"{place.axis}, {place.view}, {describe_range(place)}"


def describe_range(place: Discrepancy) -> str:
    """Return the range of a location in its view as text."""
    where = f"{place.low:.4g}" if place.low == place.high else f"{place.low:.4g} to {place.high:.4g}"
    return f"{where} {place.unit}".removesuffix(" 1")

"""Verdict of a discovery in words: what is missing, what else the log shows, and how far the model is from the log."""

from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

from imugap.discovery.device import Discovery
from imugap.discovery.evaluation.distance import Distances
from imugap.discovery.finding import Discrepancy, Finding, Unnamed
from imugap.discovery.posterior import IN_WORDS, MIN_SHARE, ambiguity_set, percent
from imugap.effects import title_of
from imugap.integrity.regular import counted
from imugap.units import with_unit

MAX_LOCATIONS = 12
"""Largest number of groups of locations in one sentence."""


def verdict(found: Discovery) -> str:
    """Return the verdict as text; that the final model does not fit comes ahead of any name and number."""
    lines = [*far_from_the_log(found), *left_out(found)]
    lines += [_sentence(finding) for finding in found.findings] or [nothing_named(found)]
    lines += remarks(found)
    lines += gap(found)
    lines += [] if found.nameless is None else [found.nameless.sentence()]
    return "\n".join(lines)


def far_from_the_log(found: Discovery) -> Iterator[str]:
    """Yield that the final model does not describe the device, a sentence, where a distance is beyond its floor."""
    far = [name for name, one in found.distances.items() if not one.reached]
    if far:
        yield (
            "The final model does not yet describe the device: the log is farther from simulations with it than these "
            f"are from each other, in {' and '.join(far)}."
        )


def agrees(found: Discovery) -> bool:
    """Return whether the log shows nothing that the start model lacks, with a name or without."""
    return not (found.findings or found.withheld or found.unexplained or found.shapes)


def nothing_named(found: Discovery) -> str:
    """Return what it means that no effect is named."""
    if agrees(found):
        return "Nothing is missing that the log can show."
    return "The log disagrees with the model, but nothing that is missing has a name."


def left_out(found: Discovery) -> Iterator[str]:
    """Yield what of the log was not compared, as sentences."""
    if found.band is not None:
        yield found.band.sentence()
    if found.record.shocks:
        times = ", ".join(f"{begin:.4g} to {end:.4g} s" for begin, end in found.record.shocks[:MAX_LOCATIONS])
        number = counted(len(found.record.shocks), "shock")
        yield f"Left out: {number} of the device, on several axes at once, {times}; no error of a sensor."


def remarks(found: Discovery) -> Iterator[str]:
    """Yield what was seen but not named, and what the log does not show, as sentences."""
    yield from unnamed_sentences(found.withheld)
    yield from described_sentences(found)
    yield from (one.sentence() for one in found.shapes)
    if found.undetermined:
        kept = ", ".join(f"{title_of(name)} of {axis}" for axis, name in found.undetermined)
        yield f"The log cannot tell {kept}; kept as the start model has it."
    if found.runs > 1:
        yield f"Random processes have the values and intervals of all {found.runs} runs together."
    if found.gravity is not None:
        yield found.gravity.sentence()


def gap(found: Discovery) -> Iterator[str]:
    """Yield where log and final model still disagree, and how far apart they are, as sentences."""
    if found.unexplained:
        yield f"Still unexplained: {describe_locations(found.unexplained)}."
    yield from (distance_sentence(name, apart) for name, apart in found.distances.items())


def distance_sentence(name: str, apart: Distances) -> str:
    """Return in words what the distance of this name was, is, and could be."""
    numbers = f"{apart.before.value:.3g} before, {apart.after.value:.3g} after"
    floor = f"{apart.floor.low:.3g} to {apart.floor.high:.3g}"
    return f"Distance in {name}: {numbers}; floor {floor}: {apart.judgement}."


def _sentence(finding: Finding) -> str:
    values = (with_unit(f"{name} {one.value:.4g}", one.unit) for name, one in finding.parameters.items())
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


def unnamed_sentences(found: Iterable[Unnamed]) -> Iterator[str]:
    """Yield what is not named as sentences, one for all of an axis that have the same reason."""
    names: dict[tuple[str, str], Counter[str]] = defaultdict(Counter)
    for one in found:
        names[one.axis, one.reason][title_of(one.name)] += 1
    for (axis, reason), counts in names.items():
        alike = ", ".join(name if count == 1 else f"{name} ({count})" for name, count in counts.items())
        yield f"{axis}: something like {alike}, but {reason}; not named."


def described_sentences(found: Discovery) -> list[str]:
    """Return how the final model describes noise without a name, a sentence for each axis."""
    axes = dict.fromkeys(one.axes[0] for one in found.described)
    return [_described(axis, [one for one in found.described if one.axes[0] == axis]) for axis in axes]


def _described(axis: str, processes: Sequence[Finding]) -> str:
    parts = []
    for one in processes:
        values = (
            with_unit(f"{name} {of.value:.3g} ({of.low:.3g} to {of.high:.3g})", of.unit)
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
    return with_unit(where, place.unit)

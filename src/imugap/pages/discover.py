"""Page of a discovery: what the error model lacks, where that shows, what it changes, and how to add it."""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from imugap.discovery.finding import Discrepancy, Finding, Interval
from imugap.discovery.inputs import FileDiscovery
from imugap.discovery.noise.nameless_noise import NamelessNoise
from imugap.discovery.start_comparison.parameters import StartParameter
from imugap.discovery.start_comparison.wording import sentences
from imugap.discovery.verdict import (
    agrees,
    certainty,
    describe_range,
    distance_sentence,
    gap,
    left_out,
    nothing_named,
    remarks,
)
from imugap.effects import title_of
from imugap.effects.effect import AxisModel, Effect, Role
from imugap.figures import discovery as figures
from imugap.figures.log import quantities
from imugap.figures.style import AXIS_TITLES
from imugap.figures.views import VIEWS, title
from imugap.interchange.conventions import Rule
from imugap.interchange.export import export
from imugap.log import AXES, TIME
from imugap.model import ErrorModel
from imugap.pages.estimate import HORIZON
from imugap.pages.model import filter_part, simulator_part, text
from imugap.pages.page import Block, DataTable, Fold, Gallery, Page, Part, Picture, Points, Snippet, Text, Topic
from imugap.units import with_unit
from imugap.workflow.tables import number, unit, with_interval

SHOWN = 6
"""Pictures of places that are shown; the others are in a fold."""
FEW = 3
"""Places of one view and axis that are listed; of more, the span."""
FILTER_SIDE: Mapping[Role, str] = {
    Role.MEAN: "correct it before the filter, or give the filter a state for its size; it is no noise.",
    Role.NOISE: "it is process noise; white noise enters the density of the filter, slow noise a state of its own.",
    Role.FILTER: "set the noise of the filter by the density at low frequencies, and take its delay off the stamps.",
    Role.OUTLIERS: "reject or weigh down single samples.",
    Role.VARIANCE: "let the noise of the filter follow it, or take the larger level.",
    Role.BIAS: "give the filter a bias state.",
    Role.RUN: "it is the initial standard deviation of the bias state.",
    Role.OUTPUT: "leave out the samples that it spoils, or weigh them down.",
    Role.CLOCK: "correct the stamps before the filter.",
}
"""What an effect of each role means to a filter."""
ROUNDED = (
    "keep all samples. Where the noise is half a step or more, rounding is white noise of the variance step squared / "
    "12, which `estimate` has in its white noise already: add nothing. Where it is less, the mean is known to half a "
    "step: give the bias state this as its standard deviation, and take a finer range of the sensor if there is one."
)
"""What rounding means to a filter."""
DISTANCE = (
    "A distance compares the held-out data with simulations of a model, in units of the scatter of these simulations: "
    "1 is as like as two runs of the same model. The grey floor is where two runs of the final model lie; the final "
    "model is good where its distance is within the floor."
)
NAMES = {"distribution": "Distribution of the values, Allan variance and spectrum", "navigation": "Navigation drift"}


def page(result: FileDiscovery) -> Page:
    """Compose the page of a discovery."""
    found = result.found
    rule = Rule(float(f"{result.logs[0]['rate_hz']:.9g}"), HORIZON)
    further = (*left_out(found), *remarks(found))
    return Page(
        "What does the error model lack?",
        tuple(_verdict(result)),
        agrees(found),
        (
            Part("What is missing, and what to do", tuple(_missing(found.findings))),
            Part(
                "What to record next",
                (Points(tuple(one.sentence() for one in result.advice)),) if result.advice else (),
            ),
            Part("Your start model, parameter by parameter", tuple(_against(result.against))),
            Part("What else the log shows", (Points(further),) if further else ()),
            Part("Where log and simulator disagree", tuple(_places(result))),
            Part("How far the model is from data that it has not seen", tuple(_distances(result))),
            Part("Noise without a name, described", tuple(_nameless(found.nameless, rule))),
            simulator_part(found.final, rule, (_compared(found.start, found.final),)),
            filter_part(lambda target: export(found.final, target, rule)),
            Part("The log", tuple(_log(result))),
        ),
    )


def _verdict(result: FileDiscovery) -> Iterable[str]:
    """Yield how much is missing, what is left, and the gain."""
    found = result.found
    if found.findings:
        shared = list(_shared(found.findings))
        names = "; ".join(f"{title_of(some[0].name)} on {_axes_of(some)}" for some in shared)
        count = len(shared)
        yield f"{count} effect{'s are' if count > 1 else ' is'} missing from the error model: {names}."
    else:
        yield nothing_named(found)
    yield from gap(found)


def _missing(findings: Sequence[Finding]) -> Iterable[Block]:
    for some in _shared(findings):
        heading = f"{title_of(some[0].name)} on {_axes_of(some)}"
        yield Topic(heading[0].upper() + heading[1:], tuple(_effect(some)))


def _shared(findings: Sequence[Finding]) -> Iterable[list[Finding]]:
    """Yield findings of the same effect on several axes together: those whose frequencies and times may be equal."""
    groups: list[list[Finding]] = []
    for one in findings:
        group = next((some for some in groups if all(_may_be_one(one, other) for other in some)), None)
        if group is None:
            groups.append([one])
        else:
            group.append(one)
    return [sorted(some, key=lambda one: (TIME, *AXES).index(one.axes[0])) for some in groups]


def _may_be_one(one: Finding, other: Finding) -> bool:
    """Return whether findings are the same effect on different axes, with intervals that overlap in time and rate."""
    both = ((one.parameters[name], other.parameters[name]) for name in one.parameters.keys() & other.parameters.keys())
    return (
        one.name == other.name
        and not set(one.axes) & set(other.axes)
        and all(a.low <= b.high and b.low <= a.high for a, b in both if a.unit in ("Hz", "s"))
    )


def _axes_of(some: Sequence[Finding]) -> str:
    return ", ".join(axis for one in some for axis in one.axes)


def _effect(some: Sequence[Finding]) -> Iterable[Block]:
    """Yield what an effect is, its parameters on its axes, and what simulator and filter do with it."""
    effects = {axis: own for one in some for axis, own in one.effects.items()}
    effect = next(iter(effects.values()))
    yield Text(_meaning(effect))
    several = len(some) > 1
    rows = tuple(
        (*((", ".join(one.axes),) if several else ()), *_parameter(name, interval))
        for one in some for name, interval in one.parameters.items() if not _is_unused(interval)
    )  # fmt: skip
    titles = (*(("axis",) if several else ()), "parameter", "value", "95 % interval", "unit")
    yield DataTable("Parameters with 95 % intervals, SI.", titles, rows)
    alike: dict[str, list[Finding]] = {}
    for one in some:
        alike.setdefault(certainty(one), []).append(one)
    if len(alike) > 1:
        yield Points(tuple(f"{_axes_of(those)}: {sentence}." for sentence, those in alike.items()))
    else:
        yield Text(f"{certainty(some[0]).capitalize()}.")
    yield Text(f"In the simulator: {'add to the model' if effect.normal else 'in place of the white noise'}")
    yield Snippet(text(ErrorModel({axis: AxisModel((own,)) for axis, own in effects.items()})))
    meaning = in_filter(effect)
    if meaning is not None:
        yield Text(f"In the filter: {meaning}")


def in_filter(effect: Effect) -> str | None:
    """Return what an effect means to a filter, None where nothing is said."""
    return ROUNDED if effect.rounds else FILTER_SIDE.get(effect.role)


def _nameless(nameless: NamelessNoise | None, rule: Rule) -> Iterable[Block]:
    """Yield how noise without a name is described, and what a simulation with it is like."""
    if nameless is None:
        return
    yield Text(
        "The log has noise whose cause is not known. It can be simulated all the same: a spectrum as bands of noise, a "
        "distribution by its quantiles. This is no explanation, and another log of the device need not have it."
    )
    yield Text(nameless.sentence())
    rows = tuple(
        (axis, title_of(of_name), str(count))
        for axis, effects in nameless.effects.items()
        for of_name, count in Counter(one.name for one in effects).items()
    )
    yield DataTable("Descriptions beside the named effects.", ("axis", "description", "number"), rows)
    yield Text("The file described.yaml beside this page is the model with them:")
    yield Snippet(f"imugap simulate described.yaml --duration 600 --rate {rule.rate:g} --out simulated.csv")


def _against(rows: Sequence[StartParameter]) -> Iterable[Block]:
    """Yield which parameters of the start model differ, and all of them in a fold."""
    if not rows:
        return
    yield Points(sentences(rows))
    titles = ("axis", "parameter", "start", "log", "interval", "unit", "verdict")
    cells = tuple(
        (one.axis, one.name, _or_dash(one.start), *_of_log(one.log), _unit(one.unit),
         f"{one.agreement}: {one.remark}" if one.remark else str(one.agreement))
        for one in rows if not (one.start is None and one.log is not None and _is_unused(one.log))
    )  # fmt: skip
    caption = "All intervals hold together with the probability one minus the level of the tests."
    yield Fold("Each parameter on each axis", (DataTable(caption, titles, cells),))


def _or_dash(value: float | None) -> str:
    return "–" if value is None else number(value)


def _of_log(one: Interval | None) -> tuple[str, str]:
    return ("–", "–") if one is None else with_interval(one.value, one.low, one.high)


def _meaning(effect: Effect) -> str:
    """Return the first sentence of the documentation of an effect."""
    first = (type(effect).__doc__ or "").strip().split("\n\n")[0]
    return " ".join(first.split())


def _is_unused(one: Interval) -> bool:
    """Return whether a parameter is that of a term which the effect does not have here: zero, and not estimated."""
    return one.value == one.low == one.high == 0


def _parameter(name: str, one: Interval) -> tuple[str, ...]:
    return (
        name.replace("_", " "),
        *with_interval(one.value, one.low, one.high),
        _unit(one.unit),
    )


def _unit(name: str) -> str:
    """Return the unit as a cell shows it; an empty cell where there is none."""
    return "" if name == "1" else unit(name)


def _compared(start: ErrorModel, final: ErrorModel) -> DataTable:
    """Return the parameters of both models side by side; an effect that one of them has several times is numbered."""
    before, after = (_parameters(model) for model in (start, final))
    rows = tuple(
        (*key, *(number(some[key]) if key in some else "–" for some in (before, after)))
        for key in dict.fromkeys((*before, *after))
    )
    titles = ("axis", "effect", "parameter", "before", "now")
    return DataTable("Parameters of the model before and now, SI.", titles, rows)


def _parameters(model: ErrorModel) -> dict[tuple[str, str, str], float]:
    """Return the parameters of a model by axis, effect and name."""
    found = {}
    for axis, effects in model.axes.items():
        seen: Counter[str] = Counter()
        for effect in effects:
            seen[effect.name] += 1
            title = title_of(effect.name) + (f" {seen[effect.name]}" if seen[effect.name] > 1 else "")
            found |= {(axis, title, name.replace("_", " ")): value for name, value in effect.parameters().items()}
    return found


def _places(result: FileDiscovery) -> Iterable[Block]:
    """Yield the places by view, in a table and as pictures."""
    found = result.found
    if not (found.discrepancies or found.unexplained):
        yield Text("No view of the log leaves the start model.")
        return
    yield Text(
        "Each picture compares the log (black) with simulations of the model before and after (band). Bars at the top "
        f"mark the places where the log leaves the band; of all places, at most {result.alpha:.0%} are chance. The "
        "fewer views disagree, the wider is the band of such a test. A curve that has not changed can therefore leave "
        "the band before and lie within it after. Of each view the surest axis is shown, and every "
        "axis that is still unexplained; the figure called places beside this page has all."
    )
    drawn = figures.drawn_places(found)
    pictures = [
        Picture(
            figures.place(found, result.alpha, key),
            f"{_axes(key[1])}. {VIEWS[key[0]].caption}",
            f"View {key[0]} of {key[1]} with the start model and with the final model",
        )
        for key in drawn
    ]
    if pictures:
        yield Gallery(tuple(pictures[:SHOWN]))
    if pictures[SHOWN:]:
        yield Fold(f"{len(pictures) - SHOWN} more pictures", (Gallery(tuple(pictures[SHOWN:])),))
    yield DataTable("Places by view.", ("view", "axis", "before", "after"), tuple(_grouped(result)))


def _grouped(result: FileDiscovery) -> Iterable[tuple[str, ...]]:
    """Yield view and axis with their places under the start and the final model."""
    found = result.found
    keys = dict.fromkeys((one.view, one.axis) for one in (*found.discrepancies, *found.unexplained))
    for view, axis in sorted(keys, key=lambda key: list(VIEWS).index(key[0]) if key[0] in VIEWS else len(VIEWS)):
        before, after = (
            [one for one in some if (one.view, one.axis) == (view, axis)]
            for some in (found.discrepancies, found.unexplained)
        )
        yield title(view), axis, _ranges(before), _ranges(after)


def _ranges(places: Sequence[Discrepancy]) -> str:
    if not places:
        return "–"
    spans = list(dict.fromkeys(describe_range(one) for one in places))
    if len(spans) <= FEW:
        return "; ".join(spans)
    low, high = min(one.low for one in places), max(one.high for one in places)
    return with_unit(f"{len(spans)} places, {low:.4g} to {high:.4g}", places[0].unit)


def _axes(names: str) -> str:
    return " and ".join(AXIS_TITLES.get(one, one) for one in names.split(","))


def _distances(result: FileDiscovery) -> Iterable[Block]:
    found = result.found
    if not found.distances:
        return
    yield Text(DISTANCE)
    yield Text(f"Held-out data: {'the test logs' if result.tests else 'the last part of the log'}.")
    pictures = [
        Picture(figures.distance_of(found, name), f"{NAMES[name]}.", distance_sentence(name, apart))
        for name, apart in found.distances.items()
    ]
    drifts = [
        Picture(
            figures.drift_of(path, direction),
            f"Drift {direction} of free-inertial navigation of the held-out data (black), and of simulations.",
            f"Drift {direction} over time, with the start model and with the final model",
        )
        for path in found.drifts for direction in figures.DIRECTIONS
    ]  # fmt: skip
    yield Gallery(tuple(pictures + drifts[: len(figures.DIRECTIONS)]))


def _log(result: FileDiscovery) -> Iterable[Block]:
    table = result.inputs.logs[0].table
    table = table[np.isfinite(table.index.to_numpy(float))]
    pictures = tuple(
        Picture(figure, f"{name.capitalize()} over time.", f"Curves of the {name} of each axis over time")
        for name, figure in quantities(table)
    )
    yield Gallery(pictures)
    rows = tuple(
        (role, one["path"], f"{one['duration_s']:.6g}", f"{one['rate_hz']:.6g}", f"{one['begin_s']:.10g}")
        for role, some in (("log", result.logs), ("test", result.tests)) for one in some
    )  # fmt: skip
    titles = ("", "path", "duration [s]", "rate [Hz]", "first stamp [s]")
    yield DataTable("Logs. Times on this page count from the first stamp.", titles, rows)

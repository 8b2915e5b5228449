"""Show the models of devices that are shipped: what each was found on, its effects with intervals, what is not known.

Stages: find the model; print its card; write the model alone, to change it.
"""

import argparse
from collections.abc import Iterable, Iterator, Mapping
from textwrap import wrap
from typing import Any

from imugap.atomic import atomic
from imugap.commands.arguments import add_examples
from imugap.commands.outputs import require_files
from imugap.interchange.devices import catalogue
from imugap.interchange.devices.card import DeviceCard
from imugap.pages.shown import interval_text, number, table_text
from imugap.units import habit

WIDTH = 100
"""Columns of a line."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    add_examples(
        parser,
        "imugap models",
        "imugap models xsens_dot",
        "imugap simulate xsens_dot --duration 60 --rate 120 --out simulated.csv",
    )
    parser.description = (
        "Show the models of real devices that are shipped, found on public recordings. Every command takes the name of "
        "one in the place of a model. Of one: the recording and its licence, the effects with 95 % intervals, what is "
        "not known, and how far simulations of the model are from the recording."
    )
    name = parser.add_argument("name", nargs="?", help="device (default: a list of all)")
    name.completer = lambda **_: catalogue.names()
    parser.add_argument("--out", help="YAML file for the model alone")


def run(options: argparse.Namespace) -> None:
    """Print the list of all models, or the card of one, and write the model to ``--out``."""
    if options.name is None:
        if options.out:
            raise ValueError("--out: expected the name of a device before it; found none")
        print(listed(catalogue.names()))
        return
    card = catalogue.read(options.name)
    if options.out:
        require_files({"--out": options.out}, [])
        with atomic(options.out) as partial:
            card.model.write(partial)
    print(shown(options.name, card))


def listed(names: Iterable[str]) -> str:
    """Return a table of device models."""
    cards = {name: catalogue.read(name) for name in names}
    rows = [
        [name, card.title, _logs(card.content["data"]), _licence(card), _verdict(card.content["distances"])]
        for name, card in cards.items()
    ]
    return table_text(["name", "device", "found on", "licence of the data", "distance from the recording"], rows)


def shown(name: str, card: DeviceCard) -> str:
    """Return the card of a device model as text."""
    content, data = card.content, card.content["data"]
    made = ", ".join(f"{key} {value}" for key, value in content["made_by"].items() if key != "command")
    parts = [
        [f"{name}: {card.title}"],
        _paragraph("data", f"{data['title']}; {_runs(data)}, {_logs(data)}"),
        _paragraph("licence of the data", data["licence"]),
        _paragraph("source", data["source"]),
        _paragraph("axes", data["frame"]),
        _paragraph("found by", f"{content['made_by']['command']} ({made})"),
        *(_paragraph("note", one) for one in (*content["remarks"], data["remarks"])),
        ["", *_parameters(content["parameters"])],
        ["", *_ambiguous(content["not_told_apart"])] if content["not_told_apart"] else [],
        *(_paragraph("of that log alone, not in the model", _effect(one)) for one in content["once"]),
        ["", "not known:", *(line for one in content["not_known"] for line in _item(one))],
        ["", *_paragraph("where the log still differs from the model", content["unexplained"])],
        *(_paragraph(f"distance in {kind}", _distance(one)) for kind, one in content["distances"].items()),
    ]
    return "\n".join(line for part in parts for line in part)


def _paragraph(title: str, text: str) -> list[str]:
    return wrap(f"{title}: {text}", WIDTH, subsequent_indent="  ", break_long_words=False, break_on_hyphens=False)


def _item(text: str) -> list[str]:
    return wrap(text, WIDTH, initial_indent="- ", subsequent_indent="  ")


def _runs(data: Mapping[str, Any]) -> str:
    runs = data["runs"]
    return f"run {runs[0]}" if len(runs) == 1 else f"{len(runs)} runs"


def _logs(data: Mapping[str, Any]) -> str:
    first, several = data["logs"][0], len(data["logs"])
    times = f"{several} x " if several > 1 else ""
    state = "in motion" if data["in_motion"] else "at rest"
    return f"{times}{first['duration_s']:.3g} s at {first['rate_hz']:.4g} Hz, {state}"


def _licence(card: DeviceCard) -> str:
    return card.content["data"]["licence"]


def _parameters(rows: Iterable[Mapping[str, Any]]) -> list[str]:
    cells = [
        [one["axis"], one["effect"], one["parameter"], number(one["value"]), _interval(one),
         one["unit"], habit(one["value"], one["unit"])]
        for one in rows
    ]  # fmt: skip
    titles = ["axis", "effect", "parameter", "value", "95 % interval", "unit", "in use"]
    return table_text(titles, cells).splitlines()


def _interval(one: Mapping[str, Any]) -> str:
    low, high = one["low"], one["high"]
    if low is None and high is None:
        return "not known"
    if low == high:
        return "fixed"
    ends = (-float("inf") if low is None else low, float("inf") if high is None else high)
    return interval_text(*ends)


def _ambiguous(rows: Iterable[Mapping[str, Any]]) -> Iterator[str]:
    for one in rows:
        rivals = ", ".join(one["from"])
        yield from _paragraph("the log cannot tell", f"{one['effect']} of {', '.join(one['axes'])} from {rivals}")


def _effect(one: Mapping[str, Any]) -> str:
    size = ", ".join(f"{name} {number(value)}" for name, value in one.items() if name not in ("axis", "effect"))
    return f"{one['effect']} of {one['axis']} ({size})"


def _distance(one: Mapping[str, Any]) -> str:
    before, after = (one[state]["value"] for state in ("before", "after"))
    low, high = (number(one["floor"][end], 3) for end in ("low", "high"))
    return (
        f"{number(after, 3)}, of white noise alone {number(before, 3)}; simulations of the model are {low} to {high} "
        f"from each other: {_judged(one)}"
    )


def _judged(one: Mapping[str, Any]) -> str:
    return "within this floor" if one["after"]["value"] <= one["floor"]["high"] else "ABOVE this floor"


def _verdict(distances: Mapping[str, Mapping]) -> str:
    return ", ".join(f"{kind} {_judged(one)}" for kind, one in distances.items()).replace("this floor", "the floor")

"""Models of devices that are shipped, each with its card."""

from collections.abc import Mapping
from typing import Any

from imugap.interchange.devices import catalogue
from imugap.interchange.devices.card import DeviceCard
from imugap.site.markdown import code, plain, table


def page() -> str:
    """Return a section for each device model."""
    return "\n\n".join(_section(name, catalogue.read(name)) for name in catalogue.names()) + "\n"


def _section(name: str, card: DeviceCard) -> str:
    content, data = card.content, card.content["data"]
    state = "in motion" if data["in_motion"] else "at rest"
    first = data["logs"][0]
    log = f"{len(data['logs'])} × {first['duration_s']:.3g} s at {first['rate_hz']:.4g} Hz, {state}"
    rows = [
        (code(one["axis"]), code(one["effect"]), code(one["parameter"]), f"{one['value']:.4g}", _interval(one),
         plain(one["unit"]))
        for one in content["parameters"]
    ]  # fmt: skip
    points = [
        f"Data: {plain(data['title'])}; {log}. Licence: {plain(data['licence'])}. [Source]({data['source']}).",
        *(plain(one) for one in content["remarks"]),
        *(f"Not known: {plain(one)}." for one in content["not_known"]),
        f"Where the log still differs from the model: {plain(content['unexplained'])}.",
        *(_distance(kind, one) for kind, one in content["distances"].items()),
    ]
    heads = ("axis", "effect", "parameter", "value", "95 % interval", "unit")
    return "\n\n".join(
        (f"## {plain(name)}", f"{plain(card.title)}.", "\n".join(f"- {one}" for one in points), table(heads, rows))
    )


def _interval(one: Mapping[str, Any]) -> str:
    low, high = one["low"], one["high"]
    if low is None or high is None:
        return "not known" if low is high else f"from {low:.3g}" if high is None else f"to {high:.3g}"
    return "fixed" if low == high else f"{low:.3g} to {high:.3g}"


def _distance(kind: str, one: Mapping[str, Any]) -> str:
    after, floor = one["after"]["value"], one["floor"]
    verdict = "within the floor" if after <= floor["high"] else "above the floor"
    return f"Distance in {kind}: {after:.3g}; floor {floor['low']:.3g} to {floor['high']:.3g}: {verdict}."

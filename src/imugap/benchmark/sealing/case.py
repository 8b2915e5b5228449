"""Seal a case: draw its device and its hidden effects, make its logs, and lock what is true into a key."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
import yaml

from imugap import log
from imugap.atomic import atomic
from imugap.benchmark.sealing.catalogue import EVERY
from imugap.benchmark.sealing.device import Device, temperature
from imugap.benchmark.sealing.hidden_effect import Additive, Kind, Modulation, Output, Scene, Stamp
from imugap.benchmark.sealing.output import ClockScale
from imugap.benchmark.sealing.plan import Case
from imugap.stream import stream

OFF_RUN = 1
"""Run (from zero) whose sampling clock a ClockScale puts off."""


@dataclass(frozen=True, eq=False)
class Hidden:
    """An effect in its place: its number in the case, its axes, its size in multiples of the limit."""

    number: int
    effect: Kind
    axes: tuple[str, ...]
    size: float


@dataclass(frozen=True, eq=False)
class Sealed:
    """A sealed case: its logs, the error-free log of a motion, the start model as plain data, and the key."""

    logs: tuple[pd.DataFrame, ...]
    reference: pd.DataFrame | None
    model: Mapping | None
    key: Mapping


def seal(case: Case, recipe: Mapping) -> Sealed:
    """Return the logs and the key of ``case``; ``recipe`` holds the ranges from which all is drawn."""
    interval = 1 / case.rate_hz
    device = Device.draw(case.base, case.motion, interval, case.duration_s, recipe["device"], _stream(case, "device"))
    hidden = _hide(case, device, recipe["effects"], _scenes(case, device, recipe, run=0, ratio=1.0))
    logs = tuple(_record(case, device, hidden, recipe, run) for run in range(case.runs))
    moving = device.motion is not None
    reference = device.ideal(interval * np.arange(round(case.duration_s * case.rate_hz))) if moving else None
    return Sealed(logs, reference, device.model(), _key(case, hidden))


def write(sealed: Sealed, cases: str | Path, keys: str | Path) -> None:
    """Write the logs to ``cases``/CASE and the key, which nobody but the scorer may read, to ``keys``/CASE.json."""
    name = sealed.key["case"]
    folder = Path(cases) / name
    several = len(sealed.logs) > 1
    for run, table in enumerate(sealed.logs, start=1):
        log.write(table, folder / (f"run{run}.parquet" if several else "log.parquet"))
    if sealed.reference is not None:
        log.write(sealed.reference, folder / "reference.parquet")
    if sealed.model is not None:
        with atomic(folder / "model.yaml") as partial:
            partial.write_text(yaml.safe_dump(sealed.model, sort_keys=False))
    with atomic(Path(keys) / f"{name}.json") as partial:
        partial.write_text(json.dumps(sealed.key, indent=1) + "\n")


def _stream(case: Case, *labels: object) -> np.random.Generator:
    return stream(case.seed, "seal", case.name, *labels)


def _scenes(case: Case, device: Device, recipe: Mapping, run: int, ratio: float) -> dict[str, Scene]:
    """Return what effects meet on each axis of a run whose stamps are ``ratio`` times the true time."""
    interval = 1 / case.rate_hz
    time = interval * np.arange(round(case.duration_s * case.rate_hz)) / ratio
    warmth = temperature(time, recipe["temperature"], _stream(case, "temperature", run))
    ideal = device.ideal(time)
    return {
        axis: Scene(axis, time, interval, device.noise[axis], warmth, device.motion, ideal, device.bias[axis])
        for axis in log.AXES
    }


def _hide(case: Case, device: Device, ranges: Mapping, scenes: Mapping[str, Scene]) -> list[Hidden]:
    """Draw place and parameters of the effects of a case."""
    hidden: list[Hidden] = []
    for number, planned in enumerate(case.effects):
        rng, kind = _stream(case, "effect", number), EVERY[planned.name]
        axes = kind.choose(rng)
        if case.same_axis and hidden and len(axes) == len(hidden[0].axes) == 1 and "time" not in axes:
            axes = hidden[0].axes
        places = [scenes[axis] for axis in (log.AXES if axes == ("time",) else axes)]
        drawn = kind.draw(places, ranges.get(planned.name, {}), rng)
        hidden.append(Hidden(number, drawn.of_size(planned.size, places), axes, planned.size))
    return hidden


def _record(case: Case, device: Device, hidden: Sequence[Hidden], recipe: Mapping, run: int) -> pd.DataFrame:
    """Return the log of a run."""
    ratios = [item.effect.ratio for item in hidden if isinstance(item.effect, ClockScale) and run == OFF_RUN]
    scenes = _scenes(case, device, recipe, run, float(np.prod(ratios)))
    samples = {axis: _axis(case, hidden, scenes[axis], run) for axis in log.AXES}
    if case.temperature:
        samples[log.TEMPERATURE] = scenes[log.AXES[0]].temperature.round(2)
    table = log.from_samples(samples, 1 / case.rate_hz)
    for item in hidden:
        if isinstance(item.effect, Stamp):
            table = item.effect.act(table, _stream(case, "stamp", item.number, run))
    return log.check(table, case.name)


def _axis(case: Case, hidden: Sequence[Hidden], scene: Scene, run: int) -> np.ndarray:
    """Return the samples of an axis: noise, biases and signals added up, then what acts on the output."""
    here = [item for item in hidden if scene.axis in item.axes]
    rng = _stream(case, "noise", run, scene.axis)
    white = scene.noise.white(scene.count, scene.interval, rng)
    for item in here:
        if isinstance(item.effect, Modulation):
            white *= np.sqrt(item.effect.variance(scene))
    values = scene.ideal[scene.axis].to_numpy() + scene.bias + white
    values += scene.noise.coloured(scene.count, scene.interval, rng) + scene.noise.line(scene.time, rng)
    for item in here:
        if isinstance(item.effect, Additive):
            labels = () if item.effect.shared else (scene.axis,)
            values += item.effect.sample(scene, _stream(case, "signal", item.number, run, *labels))
    for item in sorted((item for item in here if isinstance(item.effect, Output)), key=lambda item: item.effect.rank):
        values = item.effect.act(values, scene, _stream(case, "output", item.number, run, scene.axis))
    return values


def _key(case: Case, hidden: Sequence[Hidden]) -> dict:
    """Return what is true of a case."""
    return {
        "case": case.name,
        "kind": str(case.kind),
        "motion": case.motion != "rest",
        "base": case.base,
        "rate_hz": case.rate_hz,
        "duration_s": case.duration_s,
        "effects": [
            {
                "name": item.effect.name,
                "axes": list(item.axes),
                "parameters": item.effect.parameters(),
                "size": item.size,
            }
            for item in hidden
        ],
    }

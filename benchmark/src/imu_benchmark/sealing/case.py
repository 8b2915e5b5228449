"""Seal a case: draw its device and hidden effects, generate its logs, and write the truth into a key."""

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from imu_benchmark import log, start_model
from imu_benchmark.sealing.device import BaseDevice, temperature
from imu_benchmark.sealing.hidden_effect import (
    AxisRun,
    HiddenEffect,
    HiddenSignal,
    OutputEffect,
    ParameterSource,
    TimestampEffect,
)
from imu_benchmark.sealing.output import HiddenClockScale, HiddenVarianceChange
from imu_benchmark.sealing.plan import BlindCase
from imu_benchmark.sealing.vocabulary import ALL
from imu_benchmark.stream import stream

SCALED_RUN = 1
"""Run (from zero) with the scaled sampling clock."""


@dataclass(frozen=True, eq=False)
class PlacedEffect:
    """A hidden effect with its number in the case, its axes, and its size in detection limits."""

    number: int
    effect: HiddenEffect
    axes: tuple[str, ...]
    size: float


@dataclass(frozen=True, eq=False)
class SealedCase:
    """A sealed case: its logs, the error-free log if it moves, the start model as plain data, and the key."""

    logs: tuple[pd.DataFrame, ...]
    reference: pd.DataFrame | None
    model: Mapping | None
    key: Mapping


def seal(case: BlindCase, recipe: Mapping) -> SealedCase:
    """Generate the logs and the key of ``case``; ``recipe`` holds the ranges of all random parameters."""
    interval = 1 / case.rate_hz
    device = BaseDevice.draw(
        case.base, case.motion, interval, case.duration_s, recipe["device"], _stream(case, "device")
    )
    hidden = _hide(case, device, recipe["effects"], _axis_runs(case, device, recipe, run=0, ratio=1.0))
    logs = tuple(_record(case, device, hidden, recipe, run) for run in range(case.runs))
    moving = device.motion is not None
    reference = device.ideal(interval * np.arange(round(case.duration_s * case.rate_hz))) if moving else None
    return SealedCase(logs, reference, device.model(), _key(case, hidden))


def write(
    sealed: SealedCase,
    cases: str | Path,
    keys: str | Path,
    write_log: Callable[[pd.DataFrame, Path], None] = log.write,
    suffix: str = ".csv",
) -> None:
    """Write the logs to ``cases``/CASE and the key, for the scorer only, to ``keys``/CASE.json.

    ``write_log`` writes a log in the format of ``suffix``.
    """
    name = sealed.key["case"]
    folder = Path(cases) / name
    for place in (folder, Path(keys)):
        place.mkdir(parents=True, exist_ok=True)
    several = len(sealed.logs) > 1
    for run, table in enumerate(sealed.logs, start=1):
        write_log(table, folder / (f"run{run}{suffix}" if several else f"log{suffix}"))
    if sealed.reference is not None:
        write_log(sealed.reference, folder / f"reference{suffix}")
    if sealed.model is not None:
        (folder / "model.yaml").write_text(start_model.text(sealed.model))
    (Path(keys) / f"{name}.json").write_text(json.dumps(sealed.key, indent=1) + "\n")


def _stream(case: BlindCase, *labels: object) -> np.random.Generator:
    return stream(case.seed, "seal", case.name, *labels)


def _axis_runs(case: BlindCase, device: BaseDevice, recipe: Mapping, run: int, ratio: float) -> dict[str, AxisRun]:
    """Return each axis of the base device in a run whose stamps are ``ratio`` times the true time."""
    interval = 1 / case.rate_hz
    time = interval * np.arange(round(case.duration_s * case.rate_hz)) / ratio
    degrees = temperature(time, recipe["temperature"], _stream(case, "temperature", run))
    ideal = device.ideal(time)
    return {
        axis: AxisRun(axis, time, interval, device.noise[axis], degrees, device.motion, ideal, device.bias[axis])
        for axis in log.AXES
    }


def _hide(case: BlindCase, device: BaseDevice, ranges: Mapping, axis_runs: Mapping[str, AxisRun]) -> list[PlacedEffect]:
    """Draw axes and parameters of the effects of a case."""
    hidden: list[PlacedEffect] = []
    for number, planned in enumerate(case.effects):
        rng, kind = _stream(case, "effect", number), ALL[planned.name]
        axes = kind.choose(rng)
        if case.same_axis and hidden and len(axes) == len(hidden[0].axes) == 1 and "time" not in axes:
            axes = hidden[0].axes
        runs = [axis_runs[axis] for axis in (log.AXES if axes == ("time",) else axes)]
        drawn = kind.draw(ParameterSource(runs[0], ranges.get(planned.name, {}), rng))
        hidden.append(PlacedEffect(number, drawn.of_size(planned.size, runs), axes, planned.size))
    return hidden


def _record(
    case: BlindCase, device: BaseDevice, hidden: Sequence[PlacedEffect], recipe: Mapping, run: int
) -> pd.DataFrame:
    """Return the log of a run."""
    ratios = [item.effect.ratio for item in hidden if isinstance(item.effect, HiddenClockScale) and run == SCALED_RUN]
    axis_runs = _axis_runs(case, device, recipe, run, float(np.prod(ratios)))
    samples = {axis: _axis(case, hidden, axis_runs[axis], run) for axis in log.AXES}
    if case.temperature:
        samples[log.TEMPERATURE] = axis_runs[log.AXES[0]].temperature.round(2)
    table = log.from_samples(samples, 1 / case.rate_hz)
    for item in hidden:
        if isinstance(item.effect, TimestampEffect):
            table = item.effect.act(table, _stream(case, "stamp", item.number, run))
    return table


def _axis(case: BlindCase, hidden: Sequence[PlacedEffect], axis_run: AxisRun, run: int) -> np.ndarray:
    """Return the samples of an axis: the sum of noise, bias and signals, with the effects on the output."""
    here = [item for item in hidden if axis_run.axis in item.axes]
    rng = _stream(case, "noise", run, axis_run.axis)
    white = axis_run.noise.white(axis_run.count, axis_run.interval, rng)
    for item in here:
        if isinstance(item.effect, HiddenVarianceChange):
            white *= np.sqrt(item.effect.variance(axis_run))
    values = axis_run.ideal[axis_run.axis].to_numpy() + axis_run.bias + white
    values += axis_run.noise.coloured(axis_run.count, axis_run.interval, rng) + axis_run.noise.line(axis_run.time, rng)
    for item in here:
        if isinstance(item.effect, HiddenSignal):
            labels = () if item.effect.shared else (axis_run.axis,)
            values += item.effect.sample(axis_run, _stream(case, "signal", item.number, run, *labels))
    for item in sorted(
        (item for item in here if isinstance(item.effect, OutputEffect)), key=lambda item: item.effect.rank
    ):
        values = item.effect.act(values, axis_run, _stream(case, "output", item.number, run, axis_run.axis))
    return values


def _key(case: BlindCase, hidden: Sequence[PlacedEffect]) -> dict:
    """Return the key of a case."""
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

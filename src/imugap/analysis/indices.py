"""Performance indices of static runs of one device.

Stages: leave out knocks, outliers, stuck samples and gaps; compute the indices of each run; combine the runs.
"""

from collections.abc import Iterable
from dataclasses import dataclass

import pandas as pd

from imugap.estimation.gap_draws import with_gaps_drawn
from imugap.estimation.indices import INDICES, ROUND_OFF, IndexSamples, of_samples, over_runs, shortest
from imugap.estimation.screening import screen
from imugap.io.recording import Recording
from imugap.io.scales import require_same_scale
from imugap.log import AXES
from imugap.stream import stream
from imugap.units import STANDARD_GRAVITY

SEED = 0
"""Seed of the samples that are drawn where the log has none that is undisturbed."""


@dataclass(frozen=True, eq=False)
class DeviceIndices:
    """Indices of a device.

    Attributes
    ----------
    table
        Columns of :func:`imugap.estimation.indices.over_runs`, SI.
    remarks
        Sentences on what was left out of the runs.
    """

    table: pd.DataFrame
    remarks: tuple[str, ...]


def indices(runs: Iterable[Recording], period: float = 1.0, gravity: float = STANDARD_GRAVITY) -> DeviceIndices:
    """Compute the indices over static runs.

    Parameters
    ----------
    period
        Averaging period of the bias stability [s].
    gravity
        Gravity of the site [m/s^2], which accel_z reads with the opposite sign.
    """
    ideal = pd.Series(0.0, index=list(AXES))
    ideal["accel_z"] = -gravity
    parts, remarks, runs = {}, [], list(runs)
    require_same_scale([one.source for one in runs], [one.table for one in runs])
    for number, one in enumerate(runs, start=1):
        parts[number], sentences = _of_run(one.require_gravity(), ideal, period)
        remarks += sentences
    table = over_runs(pd.concat(parts, names=["run"]).reset_index("run").reset_index(drop=True))
    return DeviceIndices(table, tuple(remarks))


def _of_run(recording: Recording, ideal: pd.Series, period: float) -> tuple[pd.DataFrame, list[str]]:
    """Return the indices of one run, its disturbed samples left out, with a sentence for each."""
    path, found = recording.source, recording.regular
    if not found.samples:
        raise ValueError(f"{path}: columns: expected an axis that varies; found {'; '.join(found.unusable.values())}")
    duration = min(len(one.values) * one.interval for one in found.samples.values())
    symbols, short = _computable(duration, period, max(one.interval for one in found.samples.values()))
    parts, remarks = [], [*(f"{path}: {remark}" for remark in found.remarks), *short]
    for axis, one in found.samples.items():
        screened = screen(one.values, stream(SEED, "indices", axis))
        remarks += [f"{path}: {axis}: {sentence}" for sentence in screened.sentences(one.interval, one.begin)]
        values = with_gaps_drawn(screened, one.interval, stream(SEED, "gaps", axis))
        drawn = IndexSamples(axis, values, screened.replaced, one.interval)
        parts.append(of_samples(drawn, ideal[axis], period, symbols))
    return pd.concat(parts, ignore_index=True), remarks


def _computable(duration: float, period: float, interval: float) -> tuple[tuple[str, ...], list[str]]:
    """Return the indices for which a log of a duration [s] is long enough, and a sentence on each other."""
    needed = {symbol: shortest(symbol, period, interval) for symbol in INDICES if symbol != "repeatability"}
    missing = {symbol: least for symbol, least in needed.items() if duration < least * (1 - ROUND_OFF)}
    if len(missing) == len(needed):
        raise ValueError(f"log: expected at least {min(needed.values()):g} s; found {duration:g} s")
    short = [
        f"{INDICES[one].title}: expected at least {least:g} s; found {duration:g} s" for one, least in missing.items()
    ]
    return tuple(symbol for symbol in needed if symbol not in missing), short

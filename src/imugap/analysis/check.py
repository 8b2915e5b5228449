"""Check a recording: a verdict in words, and each finding with its place and its consequence for each command."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from itertools import product

import numpy as np

from imugap.discovery.inputs import MIN_SAMPLES
from imugap.discovery.preparation.shocks import common_shocks
from imugap.effects.timestamp_jitter import TimestampJitter
from imugap.estimation.indices import INDICES, shortest
from imugap.estimation.model_selection import SHORTEST
from imugap.integrity import rest
from imugap.integrity.regular import Fault, Regular, Remark, powered, without_power
from imugap.integrity.report import Axis, Report, Shock, report
from imugap.integrity.timestamps import stamps
from imugap.io.recording import Recording
from imugap.log import ACCEL, axes
from imugap.numerics.normal_quantile import NORMAL_QUANTILE
from imugap.numerics.samples.runs import runs_of
from imugap.units import STANDARD_GRAVITY

COMMANDS = ("indices", "estimate", "discover", "walk", "drive")
STATIC, MOVING = COMMANDS[:3], COMMANDS[3:]
"""Commands for a device at rest, and for one in motion."""
FINE, NOTED, LESS, NEVER = "", "left out", "wider", "no"
"""Consequences of a finding: none, what is found is left out, wider intervals, not usable."""
CONSEQUENCES: dict[Fault, tuple[str, ...]] = {
    Fault.TWICE: (NOTED, NOTED, NOTED, NOTED, NOTED),
    Fault.LOST_VALUES: (NOTED, NOTED, NOTED, NOTED, NOTED),
    Fault.DEAD: (NOTED, NOTED, NOTED, NEVER, NEVER),
    Fault.STREAMS: (FINE, FINE, NEVER, "joined", "joined"),
    Fault.RESET: (FINE, FINE, FINE, FINE, FINE),
    Fault.UNEVEN: (FINE, FINE, FINE, FINE, FINE),
    Fault.LOST: (LESS, LESS, LESS, "filled", "filled"),
    Fault.HELD: (FINE, FINE, NEVER, FINE, FINE),
    Fault.INTERPOLATED: (LESS, LESS, NOTED, FINE, FINE),
    Fault.LOUD: ("kept", "kept", "kept", "kept", "kept"),
}
ROUNDED = ("rounded", "rounded", "an effect", FINE, FINE)
"""What rounding means: the noise and the mean of rounded values, an effect of its own, nothing to motion."""
LONGEST_GAP_S = {"walk": 0.1, "drive": 0.5}
"""Longest gap that a command fills [s]."""
NEXT = {
    Fault.DEAD: "record all axes for navigation",
    Fault.STREAMS: "for discover record all axes on one clock",
    Fault.LOST: "for navigation record without gaps",
    Fault.HELD: "poll the sensor at its own rate",
}
"""Next step where a finding makes a command useless."""
GRAVITY_TOLERANCE = 0.03
"""Relative difference of the mean specific force at rest from gravity that scale-factor errors do not reach."""
COARSE = 2.0
"""Step of the lattice over the noise from which it says little of it."""
SHIFTS = range(3, 17)
"""Bits that the counts of an axis may lack."""
WIDTHS = (0.1, 0.5)
"""Half widths of 95 % intervals, relative, for which a verdict says what a log determines."""
LISTED = 3
"""Number of shocks that are listed."""


@dataclass(frozen=True)
class CheckedFault:
    """What is wrong with a recording: name in a verdict, text, consequence for each of :data:`COMMANDS`, next step."""

    name: str
    text: str
    consequences: tuple[str, ...] = (FINE,) * len(COMMANDS)
    step: str = ""


@dataclass(frozen=True, eq=False)
class RecordingCheck:
    """Result of a check.

    Attributes
    ----------
    source
        File.
    findings
        What is wrong, or restricts the use.
    summary
        Sentence on rest, length, rate and gravity.
    commands
        Commands for which the recording is meant: of a device at rest, or of one in motion.
    facts
        All properties, as plain data.
    """

    source: str
    findings: tuple[CheckedFault, ...]
    summary: str
    commands: tuple[str, ...]
    facts: dict

    @property
    def never(self) -> tuple[str, ...]:
        """Return the commands of the recording for which it is not usable."""
        columns = zip(*(one.consequences for one in self.findings), strict=True) if self.findings else ()
        useless = {name for name, column in zip(COMMANDS, columns, strict=False) if NEVER in column}
        return tuple(name for name in self.commands if name in useless)

    @property
    def verdict(self) -> str:
        """Return in words for which commands the recording is usable, and the next step for the others."""
        usable = [name for name in self.commands if name not in self.never]
        able = f"usable for {', '.join(usable)}"
        if not self.never:
            names = ", ".join(dict.fromkeys(one.name for one in self.findings))
            return f"{able}{f' with {names}' if names else ''}: {self.summary}"
        steps = "; ".join(dict.fromkeys(one.step for one in self.findings if one.step and NEVER in one.consequences))
        able = f"{able}, not for" if usable else "not usable for"
        return f"{able} {', '.join(self.never)}: {self.summary}" + (f"; next: {steps}" if steps else "")


def check(recording: Recording) -> RecordingCheck:
    """Check a recording; a LogError where no rate or no value is right."""
    regular, raw = recording.regular, report(powered(recording.table, without_power(recording.table)))
    motion = rest.motion(regular.log, regular.interval)
    found = (
        *(_of_remark(remark, regular) for remark in regular.remarks),
        *_of_motion(motion),
        *_of_gravity(regular, motion),
        *_of_samples(regular, raw, motion),
        *_of_length(regular, motion),
    )
    commands = MOVING if motion.mostly else STATIC
    facts = raw.facts() | {
        "axes": [asdict(axis) for axis in raw.axes],
        "rate_hz": 1 / regular.interval,
        "lost": int(regular.lost.sum()),
        "moving": [list(one) for one in motion.stretches],
        "findings": [{"text": one.text} | dict(zip(COMMANDS, one.consequences, strict=True)) for one in found],
    }
    return RecordingCheck(str(recording.source), found, _summary(regular, motion), commands, facts)


def _of_remark(remark: Remark, regular: Regular) -> CheckedFault:
    consequences, step = CONSEQUENCES[remark.fault], NEXT.get(remark.fault, "")
    if remark.fault is Fault.LOST:
        gap = _longest_gap(regular)
        consequences = tuple(
            NEVER if gap > LONGEST_GAP_S.get(name, np.inf) else one
            for name, one in zip(COMMANDS, consequences, strict=True)
        )
    return CheckedFault(remark.fault.value, str(remark), consequences, step)


def _longest_gap(regular: Regular) -> float:
    return float(np.max(np.diff(runs_of(regular.lost)), initial=0) * regular.interval)


def _of_motion(motion: rest.Motion) -> Iterable[CheckedFault]:
    """Yield that a device at rest was moved."""
    if motion.at_rest or motion.mostly:
        return
    begin, end = max(motion.stretches, key=lambda one: one[1] - one[0])
    count = len(motion.stretches)
    where = (
        f"from {begin:.6g} to {end:.6g} s" if count == 1 else f"{count} times, longest from {begin:.6g} to {end:.6g} s"
    )
    low, high = motion.longest_rest
    step = f"cut the log to its rest from {low:.6g} to {high:.6g} s"
    yield CheckedFault("motion", f"at rest, but moved {where}", (NEVER, NEVER, NEVER, FINE, FINE), step)


def _of_gravity(regular: Regular, motion: rest.Motion) -> Iterable[CheckedFault]:
    """Yield that the specific force of a device at rest is not gravity."""
    if not set(ACCEL) <= set(regular.samples):
        return
    mean = {name: float(np.nanmedian(regular.samples[name].values)) for name in ACCEL}
    norm = float(np.linalg.norm(list(mean.values())))
    if norm < rest.GRAVITY_LEAST * STANDARD_GRAVITY:
        shifted = (f"or has {name} 1/{2**bits} of its scale?" for name, bits in _shifted(mean))
        why = " ".join(["removed by the driver?", *shifted])
        text = f"the specific force, {norm:.3g} m/s^2, is without gravity: {why}"
        step = "record the specific force with gravity"
        yield CheckedFault("no gravity", text, (FINE, FINE, FINE, NEVER, NEVER), step)
    elif motion.at_rest and abs(norm / STANDARD_GRAVITY - 1) > GRAVITY_TOLERANCE:
        text = (
            f"the specific force at rest is {norm:.4g} m/s^2, {100 * (norm / STANDARD_GRAVITY - 1):+.2g} % off gravity"
        )
        yield CheckedFault("another gravity", text)


def _of_samples(regular: Regular, raw: Report, motion: rest.Motion) -> Iterable[CheckedFault]:
    """Yield shocks of a device at rest, stuck and clipped axes, and noise below the resolution."""
    held = {name for name, one in regular.samples.items() if one.interval > regular.interval}
    coarse = {axis.axis for axis in raw.axes if axis.axis in regular.samples and _is_coarse(axis, regular)}
    yield from _of_shocks([event for event in raw.events if not motion.mostly and event.axis not in coarse], regular)
    for axis in (axis for axis in raw.axes if axis.axis in regular.samples and axis.axis not in held):
        if axis.stuck:
            text = f"{axis.axis}: {axis.longest_repeat} equal values in a row at {axis.repeat_s:.6g} s"
            yield CheckedFault("stuck values", text, (NOTED, NOTED, NOTED, FINE, FINE))
        if axis.saturated and axis.axis not in coarse:
            text = f"{axis.axis}: clipped at {axis.minimum:.6g} or {axis.maximum:.6g}"
            yield CheckedFault("clipped values", text, ("kept", "kept", NOTED, FINE, FINE))
        if axis.axis in coarse and not motion.mostly:
            text = (
                f"{axis.axis}: noise below one count, {axis.lattice:.4g}; keep all samples: N is that of the rounded "
                f"values, the mean is known to half a count"
            )
            yield CheckedFault("coarse values", text, ROUNDED)


def _shifted(mean: Mapping[str, float]) -> Iterator[tuple[str, int]]:
    """Yield each axis and the bits by which a shift of its mean [m/s^2] makes the norm that of gravity."""
    for name, bits in product(ACCEL, SHIFTS):
        norm = np.linalg.norm([*(mean | {name: mean[name] * 2**bits}).values()])
        if abs(norm / STANDARD_GRAVITY - 1) < GRAVITY_TOLERANCE:
            yield name, bits


def _of_length(regular: Regular, motion: rest.Motion) -> Iterable[CheckedFault]:
    """Yield that a log of a device at rest is too short for a command."""
    duration, count = len(regular.log) * regular.interval, len(regular.log)
    least = {"indices": min(_shortest(regular).values()) * (1 - 1e-9) / regular.interval}
    least |= {"estimate": SHORTEST, "discover": MIN_SAMPLES}
    short = {name: samples for name, samples in least.items() if count < samples}
    if short and not motion.mostly:
        consequences = tuple(NEVER if name in short else FINE for name in COMMANDS)
        needed = max(short.values()) * regular.interval
        text = f"{count} samples in {duration:.3g} s are too few for {', '.join(short)}"
        yield CheckedFault("a short log", text, consequences, f"record at least {needed:.3g} s")


def _shortest(regular: Regular) -> dict[str, float]:
    """Return the shortest log of each index of a single run [s]."""
    return {s: shortest(s, 1.0, regular.interval) for s in INDICES if s != "repeatability"}


def _of_shocks(shocks: Sequence[Shock], regular: Regular) -> Iterable[CheckedFault]:
    """Yield the largest shocks; discovery leaves out those of several axes at once, and takes others for an effect."""
    common = _common_shocks(regular) if shocks else np.array([])
    for event in sorted(shocks, key=lambda one: -one.size)[:LISTED]:
        more = f" ({len(shocks)} in all)" if len(shocks) > LISTED else ""
        text = f"shock at {event.start_s:.6g} s, {event.size:.3g} standard deviations on {event.axis}{more}"
        together = np.any((event.start_s - regular.interval < common) & (common < event.end_s + regular.interval))
        yield CheckedFault("shocks", text, (NOTED, NOTED, NOTED if together else "an effect", FINE, FINE))


def _common_shocks(regular: Regular) -> np.ndarray:
    """Return the times [s] of the samples of shocks of several axes at once."""
    outputs = {axis: regular.log[axis].to_numpy(float) for axis in axes(regular.log) if axis not in regular.unusable}
    return regular.log.index.to_numpy(float)[common_shocks(outputs, regular.interval)]


def _is_coarse(axis: Axis, regular: Regular) -> bool:
    """Return whether the noise of an axis is below its lattice."""
    noise = float(np.nanstd(np.diff(regular.samples[axis.axis].values)) / np.sqrt(2))
    return axis.lattice is not None and axis.lattice > COARSE * noise


def _summary(regular: Regular, motion: rest.Motion) -> str:
    """Return rest or motion, length, rate, direction of gravity, and the indices that need a longer log."""
    duration = len(regular.log) * regular.interval
    state = "in motion" if motion.mostly else "at rest" if motion.at_rest else "moved"
    parts = [f"{state}, {duration:.4g} s at {1 / regular.interval:.4g} Hz"]
    up = rest.vertical(regular.log)
    if up is not None and not motion.mostly:
        direction, angle = up
        parts.append(
            f"gravity along {direction}" + (f", {np.degrees(angle):.2g} deg off" if angle > np.radians(0.5) else "")
        )
    if not motion.mostly:
        missing = {s: least for s, least in _shortest(regular).items() if duration < least * (1 - 1e-9)}
        if missing:
            parts.append(f"too short for {', '.join(missing)} ({max(missing.values()):g} s)")
    jitter = TimestampJitter.found(stamps(regular.log.index.to_numpy(float)))
    if jitter is not None:
        size = f"{1e3 * jitter.effect.std:.2g} ms, {100 * jitter.effect.std / regular.interval:.2g} % of an interval"
        turned = np.degrees(jitter.effect.std)
        moving = f"turned by the rate over so long, {turned:.2g} deg at 1 rad/s, which does not add up"
        parts.append(f"stamps scatter by {size}: {moving if motion.mostly else 'harmless at rest'}")
    if not motion.mostly:
        parts.append(_determined(duration, regular.interval))
    return ", ".join(parts)


def _determined(duration: float, interval: float) -> str:
    """Return how well a log at rest, both [s], determines its noise: by the independent values that it has.

    Of n values a deviation is known to 1/sqrt(2 n). White noise has one for each sample, and a process with the
    correlation exp(-t/T) one for each T, as far as its variance goes.
    """
    white = NORMAL_QUANTILE / np.sqrt(2 * duration / interval)
    longest = [2 * duration * (width / NORMAL_QUANTILE) ** 2 for width in WIDTHS]
    slow = (f"{100 * width:g} % up to {float(f'{time:.2g}'):g} s" for width, time in zip(WIDTHS, longest, strict=True))
    return f"gives white noise to {100 * white:.2g} %, slow processes to {' and '.join(slow)} of correlation time"

"""Conversion of the columns of a file to the canonical log: stamps to seconds, samples to SI, axes to z down.

It is recognised on an excerpt, and applied to any rows.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from imugap.io.recognition import column_names, frame, samples, stamps, units
from imugap.io.recognition.column_names import Assignment
from imugap.io.recognition.settings import RecordingSettings
from imugap.log import ACCEL, GYRO, TEMPERATURE, TIME, TRIADS, LogError
from imugap.units import factor

COLDEST, HOTTEST = -60.0, 150.0
"""Temperatures between which electronics work [degC]."""


@dataclass(frozen=True, eq=False)
class Conversion:
    """Conversion of the columns of a file.

    Attributes
    ----------
    rate_hz
        Sampling rate, approximately.
    time_unit
        Unit of the stamps; None where there are none, and the rate is exact.
    factors
        Factor to SI of each column.
    offsets
        What is added to a column afterwards.
    frame
        Where the axes of the file point; ``as-is`` where they are not turned.
    recognised
        Sentences on what was recognised.
    weightless
        Whether gravity was removed from the specific force.
    without
        Columns that are left out.
    """

    rate_hz: float
    time_unit: str | None
    factors: Mapping[str, float]
    frame: str
    recognised: tuple[str, ...]
    weightless: bool
    offsets: Mapping[str, float] = field(default_factory=dict)
    without: tuple[str, ...] = ()

    def apply(self, values: Mapping[str, np.ndarray], raw: np.ndarray | None, first: int = 0) -> np.ndarray:
        """Convert columns in place, and return the time of their rows [s]; the first is row ``first``."""
        for name, column in values.items():
            if self.factors.get(name, 1.0) != 1.0:
                column *= self.factors[name]
            if self.offsets.get(name, 0.0) != 0.0:
                column += self.offsets[name]
        if self.frame not in (frame.AS_IS, frame.CANONICAL):
            _turn(values, frame.rotation_of(self.frame))
        if self.time_unit is None:
            return (first + np.arange(len(next(iter(values.values()))))) / self.rate_hz
        return stamps.seconds(raw, factor(self.time_unit))


def conversion(
    values: Mapping[str, np.ndarray],
    raw: np.ndarray | None,
    clock: str | tuple[float, str],
    assignment: Assignment,
    settings: RecordingSettings,
    texts: bool = False,
) -> Conversion:
    """Recognise the conversion of columns; LogError where nothing decides.

    Parameters
    ----------
    values
        Excerpt of each column, shape (n,), in the unit of the file; not changed.
    raw
        Stamps, shape (m,); None where there are none.
    clock
        Name of the column of stamps; where there is none, the rate [Hz] and what states it.
    texts
        Whether the stamps are times as texts, in nanoseconds.
    """
    contract = assignment.contract and not settings.columns
    scales, mixed = _in_one_unit(assignment, settings)
    values = {name: column * scales.get(name, 1.0) for name, column in values.items()}
    time_unit, said = _time_unit(values, raw, clock, assignment, settings, texts)
    if time_unit is not None:
        asked(stamps.require_possible, f"column {clock}", raw, time_unit)
    rate = clock[0] if time_unit is None else 1 / (stamps.step_of(raw) * factor(time_unit))
    accel, gyro = (_triad(values, axes) for axes in (ACCEL, GYRO))
    sizes, sentences, weightless = {}, [], False
    both = all(one is not None and one.shape[1] == len(ACCEL) for one in (accel, gyro))
    if both and not settings.columns:
        units.require_own_names(gyro, accel, rate)
    if accel is not None:
        unit = units.accel_unit(accel, rate, settings.units.get("accel"), assignment.units.get("accel"), contract)
        unit = units.downward(unit) if assignment.downward and not settings.units.get("accel") else unit
        unit = units.signed(unit) if assignment.unsigned else unit
        sizes |= dict.fromkeys(ACCEL, unit.to_si(rate))
        sentences += [] if unit.evidence is None else [unit.sentence("accel")]
        accel = accel * unit.to_si(rate) if accel.shape[1] == len(ACCEL) else None
    force = None if accel is None else samples.force_of(accel)
    if both and not settings.columns:
        _require_turns(gyro, accel, rate)
    if gyro is not None:
        promised = all(name == of for name, of in assignment.columns.items() if name in GYRO) and not settings.columns
        given, stated = settings.units.get("gyro"), assignment.units.get("gyro")
        unit = units.gyro_unit(gyro, accel, rate, given, stated, contract, promised)
        sizes |= dict.fromkeys(GYRO, unit.to_si(rate))
        sentences = [*([] if unit.evidence is None else [unit.sentence("gyro")]), *sentences]
    if assignment.free or (force is not None and units.without_gravity(force, 1.0)):
        weightless = True
        sentences += ["no gravity in the specific force: it was removed"]
    offsets, without = {}, ()
    if TEMPERATURE in values:
        stated = assignment.units.get(TEMPERATURE)
        unit = units.temperature_unit(values[TEMPERATURE], settings.units.get(TEMPERATURE), stated)
        sizes[TEMPERATURE], offsets[TEMPERATURE] = units.to_celsius(unit)
        celsius = _median(values[TEMPERATURE]) * sizes[TEMPERATURE] + offsets[TEMPERATURE]
        if not COLDEST < celsius < HOTTEST:
            without = (TEMPERATURE,)
            sentences.append(
                f"temperature left out: a median of {celsius:.4g} degC is of no device "
                "(--units temperature=degC/100, or another unit, decides)"
            )
        elif unit.name != units.SI[TEMPERATURE]:
            sentences.append(unit.sentence(TEMPERATURE))
        elif unit.evidence is None and not contract:
            sentences.append("temperature taken as degC")
    axes, words = _frame(None if weightless else force, settings)
    sizes = {name: size * scales.get(name, 1.0) for name, size in sizes.items()}
    return Conversion(rate, time_unit, sizes, axes, (*said, *sentences, *mixed, *words), weightless, offsets, without)


def _in_one_unit(assignment: Assignment, settings: RecordingSettings) -> tuple[dict[str, float], tuple[str, ...]]:
    """Return the factor of each axis to the unit of its triad, where the header gives several, and what was done."""
    scales: dict[str, float] = {}
    sentences = []
    for quantity, axes in TRIADS.items():
        stated = {name: assignment.mixed[name] for name in axes if name in assignment.mixed}
        if stated and not settings.units.get(quantity):
            unit = assignment.units[quantity]
            scales |= units.in_one_unit(quantity, unit, stated)
            others = ", ".join(f"{name} {one}" for name, one in stated.items() if one != unit)
            sentences += [f"{others} from the header"]
    return scales, tuple(sentences)


def asked(function, place: str, *arguments):
    """Call a function of recognition; its ValueError, ``expectation; found ...``, becomes a LogError at a place."""
    try:
        return function(*arguments)
    except LogError:
        raise
    except ValueError as error:
        raise LogError.at("log", place, error) from error


def _time_unit(
    values: Mapping[str, np.ndarray],
    raw: np.ndarray | None,
    clock: str | tuple[float, str],
    assignment: Assignment,
    settings: RecordingSettings,
    texts: bool,
) -> tuple[str | None, tuple[str, ...]]:
    """Return the unit of the stamps, None where there are none, and what was recognised."""
    if raw is None:
        rate, source = clock
        return None, (f"no stamps, {rate:g} Hz from {source}",)
    if texts:
        said = "stamps are times as texts"
        return "ns", (f"{said}: --time-unit does not apply" if settings.time_unit else said,)
    if settings.time_unit:
        unit, why = settings.time_unit, "the option"
    elif stated := column_names.stated_unit(clock):
        asked(stamps.require_rate, f"column {clock}", raw, stated)
        unit, why = stated, "the header"
    elif stamps.FINE in clock.lower():
        unit, why = stamps.unit_of_fine(raw)
    else:
        if stamps.are_clock_numbers(raw):
            raise LogError("log", f"column {clock}", "seconds, or times of day as HH:MM:SS", "numbers HHMMSS")
        unit, why = asked(stamps.unit_of_stamps, f"column {clock}", raw, clock == TIME)
        if (unit, why) == ("s", "the rate") and _may_be_counted(raw):
            unit, why = _counted_unit(values, raw, clock, assignment, settings)
    return unit, () if unit == "s" else (f"stamps {unit} -> s from {why}",)


def _may_be_counted(raw: np.ndarray) -> bool:
    """Return whether stamps have a rate that few sensors have in seconds, but many in milliseconds.

    Whole numbers with a decimal point are seconds: a counter has none.
    """
    if len(raw) < stamps.FEWEST or 1 / stamps.step_of(raw) >= stamps.SLOWEST_HZ:
        return False
    finite = raw[np.isfinite(raw)]
    return raw.dtype.kind == "i" or bool((finite != np.rint(finite)).any())


def _counted_unit(
    values: Mapping[str, np.ndarray], raw: np.ndarray, stamp: str, assignment: Assignment, settings: RecordingSettings
) -> tuple[str, str]:
    """Return whether stamps are seconds or milliseconds, and what shows it; LogError where nothing does."""
    step = stamps.step_of(raw)
    rates = {"s": 1 / step, "ms": 1e3 / step}
    unit = settings.units.get("gyro") or assignment.units.get("gyro") or units.SI["gyro"]
    found = samples.time_unit(_triad(values, GYRO), _triad(values, ACCEL), unit, rates, len(raw))
    if found is None:
        readings = " or ".join(f"{rate:.4g} Hz in {name}" for name, rate in rates.items())
        expected = "the unit of the stamps (--time-unit decides)"
        raise LogError("log", f"column {stamp}", expected, f"a step of {step:.6g}: {readings}")
    return found.unit, found.reason


def _require_turns(gyro: np.ndarray, accel: np.ndarray, rate_hz: float) -> None:
    """Raise a LogError where gravity turns as with other signs or another order of the gyroscopes."""
    signs = samples.opposed(gyro, accel, rate_hz)
    if signs is not None:
        right = ", ".join(("-" if sign < 0 else "") + GYRO[axis] for axis, sign in signs)
        expected = (
            "angular rates by the right-hand rule, in the axes of the accelerometers "
            "(change signs or order in the file, or name the columns by --columns to take them as they are)"
        )
        raise LogError("log", units.PLACES["gyro"], expected, f"gravity turns as with {right} as the rates of x, y, z")


def _median(values: np.ndarray) -> float:
    """Return the median of the finite values; zero where there are none."""
    finite = values[np.isfinite(values)]
    return float(np.median(finite)) if len(finite) else 0.0


def _triad(values: Mapping[str, np.ndarray], axes: tuple[str, ...]) -> np.ndarray | None:
    """Return the columns of a triad that there are, shape (n, axes); None where there is none, or all are zero."""
    found = [values[name] for name in axes if name in values]
    return np.column_stack(found) if any(one.any() for one in found) else None


def _frame(force: samples.Force | None, settings: RecordingSettings) -> tuple[str, tuple[str, ...]]:
    """Return where the axes of the file point, and what was recognised."""
    if settings.frame:
        if settings.frame != frame.AS_IS:
            asked(frame.rotation_of, "frame", settings.frame)
        axes, why = settings.frame, f"{settings.frame} from the option"
    else:
        axes = (None if force is None else frame.upright(force.direction)) or frame.AS_IS
        why = "" if axes == frame.AS_IS else f"{frame.vertical(axes)} ({axes})"
    return axes, () if axes in (frame.AS_IS, frame.CANONICAL) else (f"{why} -> turned, z down",)


def _turn(values: Mapping[str, np.ndarray], matrix: np.ndarray) -> None:
    """Turn the triads in place; a triad that lacks an axis stays as it is."""
    for triad in (GYRO, ACCEL):
        if set(triad) <= set(values):
            turned = [_combined(row, [values[name] for name in triad]) for row in matrix]
            for name, column in zip(triad, turned, strict=True):
                values[name][:] = column


def _combined(row: np.ndarray, columns: list[np.ndarray]) -> np.ndarray:
    """Return the sum of columns with weights, without round-off for a single one of weight 1 or -1."""
    used = [(weight, column) for weight, column in zip(row, columns, strict=True) if weight]
    total = used[0][0] * used[0][1]
    for weight, column in used[1:]:
        total += weight * column
    return total

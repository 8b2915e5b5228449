"""Units of the samples of a recording: by option, header, contract of the package, or physics, in this order.

A header or the contract that physics contradicts is refused; so is what nothing decides.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from imugap.integrity.scales import Scale, loud_axis
from imugap.io.recognition import samples
from imugap.io.recognition.unit_text import COUNTS, INCREMENTS, QUANTITIES, quantity_of, unit_of
from imugap.log import ACCEL, TRIADS, LogError
from imugap.units import STANDARD_GRAVITY, factor

TEMPERATURES = {"degC": (1.0, 0.0), "degF": (5 / 9, -160 / 9), "K": (1.0, -273.15)}
"""Factor and offset to degC of each unit."""
KELVINS = 200.0, 400.0
"""Temperatures of devices [K]; those of none in degC."""
SI = {"gyro": "rad/s", "accel": "m/s^2", "temperature": "degC"}
PLACES = {"gyro": "columns gyro_x to gyro_z", "accel": "columns accel_x to accel_z"}
OPPOSITE = "-"
"""Before the unit of a quantity of the other sign, such as accelerations in which gravity points down."""
OPTION = "the option"
COUNTED_RATES = "counts of a converter (--units gyro=deg/s/131 for 131 counts per deg/s)"


@dataclass(frozen=True)
class Unit:
    """Unit of a quantity in a file.

    Attributes
    ----------
    name
        Unit; ``g/16384`` for counts, 16384 to 1 g.
    evidence
        What shows it; None where the contract of the package does.
    """

    name: str
    evidence: str | None = None

    def to_si(self, rate_hz: float) -> float:
        """Return the factor to SI; increments over the sampling interval become means over it."""
        base, _, counts = self.name.removeprefix(OPPOSITE).partition("//")
        size = factor(base) / (float(counts) if counts else 1.0) * (-1.0 if self.name.startswith(OPPOSITE) else 1.0)
        return size * rate_hz if base in INCREMENTS else size

    def sentence(self, quantity: str) -> str:
        """Return what is done, in words."""
        change = (
            self.name.replace("//", "/")
            if self.name == SI[quantity]
            else f"{self.name.replace('//', '/')} -> {SI[quantity]}"
        )
        return f"{quantity} {change} from {self.evidence}"


def given_units(texts) -> dict[str, str]:
    """Return units by quantity from ``gyro=deg/s`` or plain ``deg/s``.

    ``accel=g/16384`` is counts per g, ``accel=-g`` accelerations in which gravity points down.
    """
    units = {}
    for text in texts:
        quantity, _, whole = text.rpartition("=")
        unit = whole.removeprefix(OPPOSITE)
        counts = re.fullmatch(r"(.*[a-z^)\]²°].*)/(\d+\.?\d*)", unit)
        known = unit_of(counts[1] if counts else unit)
        found = None if known is None else quantity_of(known)
        if found not in SI or (quantity and quantity != found):
            expected = "; ".join(f"{name}: {', '.join(QUANTITIES[name])}" for name in SI)
            raise ValueError(f"--units: expected units such as gyro=deg/s accel=g ({expected}); found {text!r}")
        sign = OPPOSITE if whole != unit and found in TRIADS else ""
        units[found] = f"{sign}{known}//{counts[2]}" if counts else f"{sign}{known}"
    return units


def downward(unit: Unit) -> Unit:
    """Return a unit of accelerations of Core Motion as that of the specific force; LogError where it is not g."""
    if unit.name == "g":
        return Unit(f"{OPPOSITE}g", f"{unit.evidence}, the sign from the names of Core Motion: gravity points down")
    expected = "g by the names of Core Motion (--units accel=m/s^2, or accel=-m/s^2 where gravity points down, decides)"
    raise LogError("log", PLACES["accel"], expected, unit.name)


def signed(unit: Unit) -> Unit:
    """Return a unit of accelerations of W3C DeviceMotion if an option gives it; LogError where their sign is open."""
    if unit.evidence == OPTION:
        return unit
    expected = f"the sign of the accelerations (--units accel={unit.name}, or accel=-{unit.name} of iOS, decides)"
    found = "those of a browser: at rest +1 g along the axis that points up on Android, -1 g on iOS"
    raise LogError("log", PLACES["accel"], expected, found)


def accel_unit(accel: np.ndarray, rate_hz: float, given: str | None, stated: str | None, contract: bool) -> Unit:
    """Return the unit of specific force, shape (n, axes); LogError where nothing decides or gravity contradicts."""
    if given:
        return Unit(given, OPTION)
    force = samples.force_of(accel) if accel.shape[1] == 3 else None
    if stated and quantity_of(stated) is None:
        counts = samples.counts_of(force) if stated == COUNTS and force is not None else None
        raise _unknown("accel", stated, counts)
    named = Unit(stated, "the header") if stated else Unit(SI["accel"]) if contract else None
    if force is None:
        if named is None:
            raise _undecided("accel", "fewer than three axes, which show no gravity")
        return named
    gravity = None if named is None else _is_gravity(force, named.to_si(rate_hz), rate_hz)
    if named is not None and (gravity or (gravity is None and named.name not in INCREMENTS)):
        return named
    units = samples.gravity_units(force)
    whole = samples.are_whole(accel)
    counted = whole and not samples.is_precise(force, units)
    if named is None and len(units) == 1 and not counted:
        return Unit(units[0], "gravity")
    readings = [f"gravity in {' or in '.join(units)}"] if units else []
    if not units or (named is None and counted):
        readings.append(samples.counts_of(force) if whole else samples.other_reading(force, rate_hz))
    loud = loud_axis({name: Scale.of(column) for name, column in zip(ACCEL, accel.T, strict=True)})
    if loud is not None:
        readings = [f"one of several scales: {loud.name} has {loud.times} the noise of the two others (rescale it)"]
    reading = ", or ".join(readings)
    name = named.name if named else "a unit"
    raise LogError(
        "log", PLACES["accel"], f"specific force in {name} (--units accel=g, or another unit, decides)",
        f"a median norm of {force.median:.4g}, which would be {reading}",
    )  # fmt: skip


def _is_gravity(force: samples.Force, size: float, rate_hz: float) -> bool | None:
    """Return whether the norm is gravity with this factor to SI; None where gravity was removed."""
    ratios = [norm * size / STANDARD_GRAVITY for norm in (force.quiet, force.median)]
    if any(1 / samples.GRAVITY_TOLERANCE <= ratio <= samples.GRAVITY_TOLERANCE for ratio in ratios):
        return True
    otherwise = samples.are_increments(force, rate_hz) or samples.gravity_units(force)
    return None if without_gravity(force, size) and not (otherwise and force.scatter < samples.CONSTANT) else False


def without_gravity(force: samples.Force, size: float) -> bool:
    """Return whether the norm with this factor to SI is too small for gravity."""
    return force.quiet * size < samples.NONE_LEFT * STANDARD_GRAVITY


def gyro_unit(
    gyro: np.ndarray,
    accel: np.ndarray | None,
    rate_hz: float,
    given: str | None,
    stated: str | None,
    contract: bool,
    canonical: bool = False,
) -> Unit:
    """Return the unit of angular rates, shape (n, axes); LogError where nothing decides or physics contradicts.

    Parameters
    ----------
    accel
        Specific force [m/s^2], shape (n, 3), or None.
    canonical
        Whether their names alone are those of the contract: then a noise of deg/s does not decide.
    """
    if given:
        return Unit(given, OPTION)
    if stated and quantity_of(stated) is None:
        raise _unknown("gyro", stated, COUNTED_RATES if stated == COUNTS else None)
    named = Unit(stated, "the header") if stated else Unit(SI["gyro"]) if contract else None
    if named is not None and named.name not in ("rad/s", "deg/s"):
        return named
    if named is None and samples.are_whole(gyro):
        raise _undecided("gyro", f"whole numbers, which may be {COUNTED_RATES}")
    found = samples.gyro_unit(gyro, accel, rate_hz)
    if named is None and found is None:
        raise _undecided("gyro", "rates that may be in rad/s or in deg/s")
    if named is None and canonical and found.unit != SI["gyro"] and found.noise:
        raise _undecided("gyro", f"names of rates in {SI['gyro']}, but {found.reason}, which is that of {found.unit}")
    if named is None:
        loud = samples.too_loud(gyro, accel, rate_hz) if found.unit == "deg/s" else None
        if loud is not None:
            raise _undecided("gyro", f"noise at rest of {loud:.2g} per sqrt(Hz), too much for deg/s (mdeg/s? deg/h?)")
        if found.unit == "rad/s" and found.noise:
            other = "of a MEMS in rad/s, or of a quieter gyroscope in deg/s (--units gyro=deg/s)"
            return Unit(found.unit, f"{found.reason}, {other}")
        return Unit(found.unit, found.reason)
    if found is None or found.unit == named.name:
        return named
    if found.strong:
        expected = f"angular rate in {named.name} (--units gyro=rad/s or gyro=deg/s decides)"
        raise LogError("log", PLACES["gyro"], expected, f"{found.reason}; is it in {found.unit}?")
    if found.unit == "deg/s":
        return Unit(named.name, f"{named.evidence or 'its name'}, though {found.reason} is that of deg/s")
    return named


def in_one_unit(quantity: str, unit: str, stated: Mapping[str, str | None]) -> dict[str, float]:
    """Return the factor of each axis of a triad to one unit, from those that the header gives; LogError for others.

    ``stated``: canonical name of the axis to its unit.
    """
    known = [one for one in stated.values() if one in QUANTITIES[quantity]]
    if len(known) < len(stated) or len({one in INCREMENTS for one in known}) > 1:
        found = ", ".join(f"{axis} in {one or 'none'}" for axis, one in stated.items())
        expected = f"a known unit for each axis (--units {quantity}= decides for all of them)"
        raise LogError("log", PLACES[quantity], expected, found)
    return {axis: factor(one) / factor(unit) for axis, one in stated.items()}


def require_own_names(gyro: np.ndarray, accel: np.ndarray, rate_hz: float) -> None:
    """Raise a LogError where the rates have the norm of gravity and the accelerations have none, shape (n, 3)."""
    rate, force = samples.force_of(gyro), samples.force_of(accel)
    if rate is None or force is None or rate.scatter > samples.CONSTANT:
        return
    steady = force.scatter < samples.CONSTANT
    held = steady and (samples.gravity_units(force) or samples.are_increments(force, rate_hz))
    if samples.gravity_units(rate) and not held and force.quiet < samples.NONE_LEFT * rate.quiet:
        expected = "angular rates in gyro_x to gyro_z, specific force in accel_x to accel_z (--columns names them)"
        found = f"a norm of {rate.quiet:.4g}, of gravity, in the rates, and none in the accelerations: exchanged names?"
        raise LogError("log", "columns", expected, found)


def _unknown(quantity: str, unit: str, reading: str | None) -> LogError:
    """Return the error of a unit in the header that is none of the quantity."""
    expected = f"one of {', '.join(QUANTITIES[quantity])} (--units {quantity}= decides)"
    found = f"{unit!r} in the header" if reading is None else f"{unit!r} in the header: {reading}"
    return LogError("log", PLACES[quantity], expected, found)


def _undecided(quantity: str, found: str) -> LogError:
    units = " or ".join(f"{quantity}={unit}" for unit in QUANTITIES[quantity][:2])
    return LogError("log", PLACES[quantity], f"a unit in the header (--units {units} decides)", found)


def temperature_unit(readings: np.ndarray, given: str | None, stated: str | None) -> Unit:
    """Return the unit of readings, shape (n,): of the option, of the header, or that of a device at such readings."""
    if given or stated:
        return Unit(given or stated, OPTION if given else "the header")
    known = readings[np.isfinite(readings)]
    low, high = KELVINS
    kelvins = len(known) > 0 and low < np.median(known) < high
    return Unit("K", "its size") if kelvins else Unit(SI["temperature"])


def to_celsius(unit: Unit) -> tuple[float, float]:
    """Return the factor of a unit of temperature to degC, and what is added afterwards."""
    base, _, counts = unit.name.partition("//")
    scale, offset = TEMPERATURES[base]
    return scale / (float(counts) if counts else 1.0), offset

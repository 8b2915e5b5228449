"""Meaning of the names of columns: quantity, axis and unit, in the words of the common loggers.

A name is split into words (``w_RS_S_x [rad s^-1]`` is w, rs, s, x and a unit). Words say the quantity, one of them the
axis; a unit in brackets or in the last words decides where the words do not. Of several triads of one quantity the one
with the plainest name is taken.
"""

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise

from imugap import spelling
from imugap.io.recognition.unit_text import (
    COUNT_WORDS,
    COUNTS,
    INCREMENTS,
    QUANTITIES,
    is_foreign,
    looks_like_unit,
    quantity_of,
    unit_of,
)
from imugap.log import AXES, COLUMNS, TEMPERATURE, TIME, TRIADS
from imugap.units import factor

SKIP = "-"
"""Stands for a column that is not read."""
WORDS = {
    "gyro": "gyro gyros gyr gyroscope gyroscopes omega rotation turn angrate gy rate rates pqr wb",
    "accel": "accel accels accl acc accelerometer accelerometers acceleration accelerations specific ac gf xl alpha "
    "force gforce fb",
    TEMPERATURE: "temp temperature tmp temperatures",
    TIME: "time timestamp timestamps stamp ts elapsed epoch timeus utime times seconds tow sow itow zeit temps "
    "tempo tiempo tijd",
    "counter": "counter count packet number seq index samples sample row iteration",
}
QUANTITY = {word: quantity for quantity, words in WORDS.items() for word in words.split()}
SYMBOLS = {"w": "gyro", "g": "gyro", "a": "accel", "f": "accel", "t": TIME}
"""Letters that say the quantity where they are the first word."""
OTHER_SYMBOLS = (["m"], ["h"], ["b"], ["v"], ["p"])
"""Letters of magnetometers, velocities, positions, where they are the first word."""
OTHER = frozenset([
    "mag", "magn", "magnetometer", "magnetometers", "magnetic", "compass", "quat", "quaternion", "q", "covariance",
    "cov", "bias", "offset", "std", "sd", "sigma", "var", "variance", "error", "est", "estimated", "estimate",
    "predicted", "euler", "roll", "pitch", "yaw", "heading", "angle", "orientation", "gravity", "absolute", "abs",
    "norm", "magnitude", "position", "pos", "dt", "integral", "relative", "clipping", "clip", "status", "instance",
    "device", "id", "date", "integrated", "mean", "pressure", "pwm",
    "drift",
])  # fmt: skip
"""Words of columns that are no samples of an inertial sensor."""
DERIVED = frozenset([
    "rotated", "filtered", "filt", "smoothed", "smooth", "lpf", "linear", "earth", "world", "global", "nav", "ned",
    "enu", "ambient", "baro", "cpu",
])  # fmt: skip
"""Words of samples that something else than the sensor had a part in."""
FREE = frozenset(["free", "user"])
"""Words of accelerations without gravity."""
GRAVITY, WITH = "gravity", frozenset(["including", "incl", "with"])
"""Words of accelerations that say that gravity is in them."""
OF_SENSOR, OF_HOST = (
    frozenset(["header", "sample", "fine", "sensor", "device"]),
    frozenset(["update", "log", "logging", "received", "receive", "recv", "host", "system", "arrival", "gps", "file"]),
)
"""Words of stamps that the sensor gave, and of those that something later gave."""
CORE_MOTION = frozenset(["user", "acceleration"]), frozenset(["accelerometer", "acceleration"])
"""Words that names of Core Motion of Apple have together; in its accelerations gravity points down."""
DEVICE_MOTION = frozenset(["including", "gravity"])
"""Words of the accelerations of W3C DeviceMotion; in those of iOS gravity points down, in those of Android up
(dorukeker/gyronorm.js issue 54)."""
GREEK = {"alpha": "x", "beta": "y", "gamma": "z"}
"""Axes of the rotation rate of W3C DeviceMotion, as browsers have them (w3c/deviceorientation issue 44), in deg/s."""
ROTATION_RATE = frozenset(["rotation", "rate"])
FLIGHT = {"roll": "x", "pitch": "y", "yaw": "z"}
"""Axes of the rates that are named by the angle that they turn, such as ``roll_rate``."""
DELTA = frozenset(["delta", "del", "d", "inc", "increment", "increments", "da", "coning", "sculling"])
"""Words of increments over the sampling interval."""
DELTAS = {
    **dict.fromkeys(("angle", "angles", "ang", "theta"), "gyro"),
    **dict.fromkeys(("velocity", "velocities", "vel", "v"), "accel"),
}
"""What increments are of; ``dvel`` and ``delang`` are two words."""
INCREMENT = {"gyro": "rad", "accel": "m/s"}
"""Units of increments that the names do not give."""
BODY_RATES = ("p", "q", "r")
"""Rates of roll, pitch and yaw, as flight dynamics names them."""
COMPACT = re.compile(r"(gyroscope|gyros|gyro|gyr|acceleration|accel|accs|acc|omega|ac|gy|gf|w|a|g|f)([xyz])")
AXIS_FIRST = re.compile(r"([xyz])(gyroscope|gyros|gyro|gyr|acceleration|accel|accl|accs|acc|mag)")
COMPACT_FLIGHT = re.compile(rf"({'|'.join(FLIGHT)})(rate)")
COMPACT_DELTA = re.compile(rf"(delta|del|d|inc)({'|'.join(DELTAS)})([xyz]?)")
COUNTED = ("lsb", "lsbs", "counts")
"""Last words of the names of counts."""
ABSCISSA = "x_value"
"""Column of the time in files of measurements, as LabVIEW writes them."""
BRACKET = re.compile(r"[\[(]\s*([^\[\]]*?)\s*[\])]\s*$")
LETTERS = {"x": 0, "y": 1, "z": 2}
NUMBERED = LETTERS | {"0": 0, "1": 1, "2": 2, "3": 3}
"""Words of axes; a number beside a letter is that of a channel or a device. Numbers count from 0, or from 1 to 3."""
SHORT_WORD = re.compile(r"[A-Za-z]{2,3}")
"""Words in square brackets that are units, if of no known one."""
FRAME = re.compile(r"[FBLRUDNSEW]{2,3}|cal|imu|dev", re.IGNORECASE)
"""Words in square brackets that say the axes or the device."""
EXCERPT = 60


@dataclass(frozen=True)
class Meaning:
    """Meaning of the name of one column.

    Attributes
    ----------
    quantity
        ``gyro``, ``accel``, ``temperature``, ``time`` or ``counter``.
    axis
        0, 1 or 2 for x, y or z, 3 for the third of axes counted from 1; None where the quantity has none.
    unit
        Unit in the name, :data:`imugap.io.recognition.unit_text.COUNTS`, the text of an unknown one, or None.
    stem
        Words other than the axis and the unit: columns of one triad share them.
    free
        Whether gravity was removed.
    """

    quantity: str
    axis: int | None
    unit: str | None
    stem: tuple[str, ...]
    free: bool = False

    @property
    def rank(self) -> tuple[int, int]:
        """Return the distance from a plain name: derived or increments, then words that are not known."""
        derived = sum(word in DERIVED or word in DELTA for word in self.stem) + self.free
        derived -= GRAVITY in self.stem  # of accelerations with and without gravity, those with it
        if self.quantity == TIME:
            derived += sum((word in OF_HOST) - (word in OF_SENSOR) for word in self.stem)
        return derived, sum(word not in QUANTITY and word not in ("raw", "angular", "rate") for word in self.stem)


@dataclass(frozen=True)
class Assignment:
    """Columns of a file that are read.

    Attributes
    ----------
    columns
        Canonical name to the name in the file, canonical order.
    units
        Quantity (or ``time``) to the unit in the header; none where it has none.
    times
        Names in the file that may be the time, the plainest first, of these that in the finest unit.
    free
        Whether the accelerations are without gravity.
    counters
        Names in the file of counters of samples.
    contract
        Whether every name is the canonical one, which promises SI.
    downward
        Whether names are those of Core Motion, in whose accelerations gravity points down: -1 g along the axis that
        points up in a device at rest, where the specific force is 1 g.
    unsigned
        Whether names are those of W3C DeviceMotion, of which browsers have either sign.
    mixed
        Canonical name of each axis of a triad in several units to its unit in the header, None where it has none; the
        unit of the quantity is that of one of them.
    """

    columns: dict[str, str]
    units: dict[str, str]
    times: tuple[str, ...]
    free: bool = False
    counters: tuple[str, ...] = ()
    contract: bool = False
    downward: bool = False
    unsigned: bool = False
    mixed: Mapping[str, str | None] = field(default_factory=dict)


def meaning(name: str) -> Meaning | None:
    """Return what a column holds by its name; None if neither inertial sensor, temperature, time nor counter."""
    base, unit = _unbracketed(name.strip().lstrip("#%").strip())
    words = words_of(base)
    if set(words) > ROTATION_RATE and words[-1] in GREEK:
        words, unit = [*words[:-1], GREEK[words[-1]]], unit or "deg/s"
    turning = next((k for k, pair in enumerate(pairwise(words)) if pair[0] in FLIGHT and pair[1] == "rate"), None)
    if turning is not None:
        words = [*words[:turning], "rate", FLIGHT[words[turning]], *words[turning + 2 :]]
    axis = next((word for known in (LETTERS, NUMBERED) for word in reversed(words) if word in known), None)
    if axis is not None:
        place = len(words) - 1 - words[::-1].index(axis)
        words = words[:place] + words[place + 1 :]
    words = [word for word in words if word != "axis"]
    quantity = _quantity(words) or _quantity(words_of(base.rpartition(".")[2])) or _by_unit(words, axis, unit)
    if base.strip().lower() == ABSCISSA:
        return Meaning(TIME, None, unit, ())
    if quantity is None and len(base) > 1 and unit is None and unit_of(base) in QUANTITIES[TIME]:
        return Meaning(TIME, None, unit_of(base), ())
    if quantity is None:
        return None
    if quantity == "counter" and unit in QUANTITIES[TIME]:
        quantity = TIME
    if unit is None:
        words, unit = _unit_of_words(words, quantity)
    if unit is None and DELTA & set(words):
        unit = INCREMENT.get(quantity)
    if unit is None and quantity in TRIADS:
        unit = _foreign_unit(base)
    if unit is not None and quantity_of(unit) not in (quantity, *((None,) if quantity in TRIADS else ())):
        return None if quantity in (*TRIADS, TEMPERATURE) else Meaning(quantity, None, None, tuple(words))
    inertial = quantity in TRIADS
    if inertial and axis is None:
        return None
    return Meaning(quantity, NUMBERED[axis] if inertial else None, unit, tuple(words), bool(FREE & set(words)))


def assign(names: Sequence[str]) -> Assignment:
    """Return which of the columns of a file are read; ValueError where two triads are equally plain."""
    known = _counted_from_zero({name: found for name in names if name and (found := meaning(name)) is not None})
    if not any(found.quantity == "gyro" for found in known.values()):
        known |= _body_rates(names)
    columns: dict[str, str] = {}
    units: dict[str, str] = {}
    mixed: dict[str, str | None] = {}
    free = False
    for quantity, axes in TRIADS.items():
        triad = _plainest({name: found for name, found in known.items() if found.quantity == quantity}, quantity)
        columns |= {axes[found.axis]: name for name, found in triad.items()}
        by_axis = {axes[found.axis]: found.unit for found in triad.values()}
        stated = [unit for unit in by_axis.values() if unit]
        units |= {quantity: stated[0]} if stated else {}
        mixed |= by_axis if len({*stated}) > 1 else {}
        free |= any(found.free for found in triad.values())
    thermometers = _least([name for name, found in known.items() if found.quantity == TEMPERATURE], known)
    if len(thermometers) == 1:
        columns[TEMPERATURE] = thermometers[0]
        unit = known[thermometers[0]].unit
        units |= {TEMPERATURE: unit} if unit else {}
    clocks = {name: found for name, found in known.items() if found.quantity == TIME}
    times = sorted(clocks, key=lambda name: (clocks[name].rank, factor(clocks[name].unit or "s")))
    counters = tuple(name for name, found in known.items() if found.quantity == "counter")
    ordered = {name: columns[name] for name in COLUMNS if name in columns}
    contract = all(name == of for name, of in ordered.items()) and (not times or TIME in times)
    downward = any(one.issubset(parts_of(name)[0]) for one in CORE_MOTION for name in names)
    unsigned = any(DEVICE_MOTION.issubset(parts_of(name)[0]) for name in ordered.values())
    return Assignment(ordered, units, tuple(times), free, counters, contract, downward, unsigned, mixed)


def _counted_from_zero(known: dict[str, Meaning]) -> dict[str, Meaning]:
    """Return the meanings with axes 0 to 2 also where a triad counts them from 1, and without a fourth axis."""
    from_one = {(one.quantity, one.stem) for one in known.values() if one.axis == len(LETTERS)}
    from_one -= {(one.quantity, one.stem) for one in known.values() if one.axis == 0}
    counted = {
        name: replace(one, axis=one.axis - 1) if (one.quantity, one.stem) in from_one else one
        for name, one in known.items()
    }
    return {name: one for name, one in counted.items() if one.axis is None or one.axis < len(LETTERS)}


def _body_rates(names: Sequence[str]) -> dict[str, Meaning]:
    """Return the meaning of the names p, q and r, with a unit or a group before them, where there are all three."""
    groups: dict[str, dict[str, Meaning]] = {}
    for name in names:
        base, unit = _unbracketed(name.strip())
        group, _, letter = base.strip().rpartition(".")
        if letter.lower() in BODY_RATES and (base == name.strip() or unit in QUANTITIES["gyro"]):
            axis = BODY_RATES.index(letter.lower())
            groups.setdefault(group, {})[name] = Meaning("gyro", axis, unit, tuple(words_of(group)))
    return {name: one for found in groups.values() if len(found) == len(BODY_RATES) for name, one in found.items()}


def unread(names: Sequence[str], assignment: Assignment) -> dict[str, list[str]]:
    """Return names that look like the axes of a triad of which not all axes are read, by its quantity."""
    lacking = {quantity: len({*axes} - {*assignment.columns}) for quantity, axes in TRIADS.items()}
    others = [name for name in names if name not in assignment.columns.values() and meaning(name) is None]
    found = {quantity: [name for name in others if _resembles(name, quantity)] for quantity in lacking}
    return {quantity: alike for quantity, alike in found.items() if len(alike) >= lacking[quantity] > 0}


def _resembles(name: str, quantity: str) -> bool:
    """Return whether the words of a name that has no axis are of a quantity, and no unit in it is of another."""
    words, unit = parts_of(name)
    of_words = _quantity(words) if set(words) & {*QUANTITY, *DELTAS} else None
    return of_words == quantity and (unit is None or quantity_of(unit) in (quantity, None))


def stated_unit(name: str) -> str | None:
    """Return the unit in the name of a column, or None."""
    found = meaning(name)
    return None if found is None else found.unit


def chosen(names: Sequence[str], columns: Sequence[str]) -> tuple[str, ...]:
    """Return the names of the columns of a file as the user gives them.

    Parameters
    ----------
    names
        Names in the file, or empty texts where it has no header.
    columns
        Either a name for each column of the file from left to right, ``-`` for one that is not read; or
        ``canonical=name in the file`` for some; or names in the file (or canonical ones) of those that are read. Where
        ``time`` or ``temperature`` alone is given so, the axes are those that the names in the file say.
    """
    if any("=" in one for one in columns):
        pairs = dict(one.split("=", 1)[::-1] for one in columns)
        _require_known(pairs, names)
        others = [SKIP] * len(names) if set(pairs.values()) & set(AXES) else _without(names, pairs)
        return tuple(pairs.get(name, other) for name, other in zip(names, others, strict=True))
    if len(columns) == len(names) and not set(columns) <= set(names):
        return tuple(columns)
    if not any(names):
        raise ValueError(f"--columns: expected {len(names)} names, one for each column; found {len(columns)}")
    canonical = {of: name for name, of in assign(names).columns.items()}
    return_names = {canonical.get(name, name): name for name in names} | {name: name for name in names}
    _require_known(columns, list(return_names))
    kept = {return_names[one] for one in columns}
    return tuple(name if name in kept else SKIP for name in names)


def _without(names: Sequence[str], pairs: Mapping[str, str]) -> list[str]:
    """Return the names of the columns of a file, without those that mean what pairs of a name and a meaning give."""
    found = [None if name in pairs else meaning(name) for name in names]
    return [
        SKIP if one is not None and one.quantity in pairs.values() else name
        for name, one in zip(names, found, strict=True)
    ]


def nearest(names: Iterable[str]) -> str:
    """Return names that are not known, the first with the nearest canonical name."""
    names = list(names)
    for name in names:
        near = spelling.nearest(name, (TIME, *COLUMNS))
        if near not in (None, name):
            return f"{name[:EXCERPT]!r} (did you mean {near}?)"
    return ", ".join(names)[: 2 * EXCERPT] or "nothing"


def _require_known(asked: Iterable[str], names: Sequence[str]) -> None:
    for one in asked:
        if one not in names:
            raise ValueError(f"--columns: expected names in the file; found {one!r}{spelling.hint(one, names)}")


def _unbracketed(name: str) -> tuple[str, str | None]:
    """Return a name without the brackets at its end, and the unit in them."""
    found = BRACKET.search(name)
    if found is None or found[1].isdigit():
        return name, None
    text, unit = found[1], unit_of(found[1])
    stated = looks_like_unit(text) or (found[0].startswith("[") and _is_short_unit(text))
    return name[: found.start()], text if unit is None and stated else unit


def _is_short_unit(text: str) -> bool:
    """Return whether a text of two or three letters is no word of names of columns."""
    known = {*QUANTITY, *OTHER, *DERIVED, *FREE, *COUNT_WORDS, *DELTA}
    return SHORT_WORD.fullmatch(text) is not None and FRAME.fullmatch(text) is None and text.lower() not in known


def _foreign_unit(base: str) -> str | None:
    """Return the unit of no inertial sensor at the end of a name without brackets, such as mV, or None."""
    *_, last = [part for part in re.split(r"[\W_]+", base) if part.lower() not in NUMBERED] or [""]
    return last if len(last) > 1 and last != base and is_foreign(last) else None


def parts_of(name: str) -> tuple[list[str], str | None]:
    """Return the words of a name, in small letters, and the unit in brackets behind them."""
    base, unit = _unbracketed(name.strip())
    return words_of(base), unit


def words_of(base: str) -> list[str]:
    """Return the words of a name, in small letters."""
    whole = _compact(base.strip().lower())
    if whole:
        return whole
    parts = [part.lower() for part in re.findall(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|\d+", base)]
    return [word for part in parts for word in _compact(part) or [part]]


def _compact(word: str) -> list[str]:
    """Return the words that a word is made of: quantity and axis, an angle and its rate; none if of none."""
    forms = (COMPACT, AXIS_FIRST, COMPACT_FLIGHT, COMPACT_DELTA)
    found = next(filter(None, (form.fullmatch(word) for form in forms)), None)
    return [part for part in found.groups() if part] if found else []


def _quantity(words: list[str]) -> str | None:
    found = set(words)
    if found & DELTA and not (found - set(DELTAS)) & OTHER:
        return next((DELTAS[word] for word in words if word in DELTAS), None)
    if found & OTHER - ({GRAVITY} if found & WITH else set()):
        return None
    if TEMPERATURE in map(QUANTITY.get, words):
        return TEMPERATURE
    if "angular" in found or "ang" in found:
        return "gyro" if found & {"rate", "velocity", "speed", "vel"} else None
    quantities = [QUANTITY[word] for word in words if word in QUANTITY]
    for quantity in (TIME, "gyro", "accel", "counter"):
        if quantity in quantities:
            return quantity
    return SYMBOLS.get(words[0]) if words else None


def _by_unit(words: list[str], axis: str | None, unit: str | None) -> str | None:
    """Return the quantity of a column by its unit alone, where no word speaks against it."""
    if unit is None or OTHER & set(words) or words[:1] in OTHER_SYMBOLS:
        return None
    quantity = quantity_of(unit)
    return quantity if axis is not None or quantity == TIME else None


def _unit_of_words(words: list[str], quantity: str) -> tuple[list[str], str | None]:
    """Return the words without those of the unit at their end, and the unit; for a time, a word anywhere."""
    for count in range(min(4, len(words) - 1), 0, -1):
        unit = unit_of(" ".join(words[-count:]))
        if words[-1] in COUNTED:
            return words[:-1], COUNTS
        if unit in QUANTITIES.get(quantity, ()):
            rate = f"{unit}/s" if quantity == "gyro" and unit in INCREMENTS and not DELTA & set(words) else unit
            return words[:-count], rate
    anywhere = [unit for word in words if quantity == TIME and len(word) > 1 and (unit := unit_of(word))]
    return words, anywhere[0] if anywhere else None


def _plainest(known: dict[str, Meaning], quantity: str) -> dict[str, Meaning]:
    """Return the columns of the triad with the plainest name; ValueError where there are several."""
    stems: dict[tuple[str, ...], dict[str, Meaning]] = {}
    for name, found in known.items():
        stems.setdefault(found.stem, {})[name] = found
    order = sorted(stems.values(), key=_rank_of)
    if not order:
        return {}
    best, *others = order
    rivals = [one for one in others if _rank_of(one) == _rank_of(best)]
    if rivals or len({found.axis for found in best.values()}) < len(best):
        shown = " or ".join(", ".join(one) for one in (best, *rivals))
        raise ValueError(
            f"one set of columns for {quantity} (--columns decides, or --topic what stands before the dot, or begins "
            f"them); found {shown}"
        )
    return best


def _rank_of(triad: dict[str, Meaning]) -> tuple:
    return -len(triad) if len(triad) < 3 else -3, next(iter(triad.values())).rank


def _least(names: list[str], known: dict[str, Meaning]) -> list[str]:
    """Return the names of lowest rank."""
    lowest = min((known[name].rank for name in names), default=None)
    return [name for name in names if known[name].rank == lowest]

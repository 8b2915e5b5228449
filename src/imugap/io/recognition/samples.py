"""Units of samples by physics: gravity, how gravity turns with the device, noise at rest.

All on plain arrays, shape (n, 3), in the unit of the file.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import permutations, product

import numpy as np

from imugap.units import STANDARD_GRAVITY, factor

WINDOW = 16
"""Rows of a window."""
QUIET = 0.2
"""Share of the windows that are taken as quiet."""
GRAVITY_TOLERANCE = 1.25
"""Ratio within which a norm is that of gravity: walking, scale factors and other places stay well within it."""
NARROW = 1.06
"""The same for readings that are far from any usual one."""
READINGS = ("m/s^2", "g", "mg", "ug", "ft/s^2")
CONSTANT = 0.25
"""Scatter of the norm of a specific force below which it is gravity."""
NONE_LEFT = 0.15
"""Norm [g] at rest below which gravity was removed."""
COUNTS = 2.0 ** np.arange(8, 21)
"""Counts per g of usual converters."""
FASTEST_RAD_PER_S = np.radians(4000.0)
LOUD, SOFT = 2.6e-3, 6e-4
"""Noise densities [rad/s/sqrt(Hz)]: no gyroscope of a log is above the first, nearly none in deg/s below the second."""
SOFTEST = 3e-8
"""Noise density below that of any gyroscope [rad/s/sqrt(Hz)]: the best ring lasers have 1e-7."""
SHORTEST_S, LONGEST_S, DAY_S = 1.0, 10 * 86400.0, 86400.0
"""Lengths below and above which nobody keeps a log without another stamp [s]."""
SHAKEN = 0.05
"""Noise density of the specific force [m/s^2/sqrt(Hz)] above which a device shakes."""
QUIETEST_MEMS = 3e-5
"""Noise density of the quietest MEMS gyroscopes [rad/s/sqrt(Hz)].

A lower number is that of a fibre-optic gyroscope in rad/s or of a ring laser in deg/s.
"""
FEWEST_BLOCKS = 4
EARTH_RAD_PER_S = 7.292115e-5
EARTH_TOLERANCE = 1.1
LAG_S = 0.15
"""Time over which the change of the specific force is compared with its turn by the gyroscopes."""
FEWEST_WINDOWS = 40
CORRELATED, WELL_CORRELATED = 0.3, 0.5
"""Correlations of these from which the unit follows, and from which it outweighs a header."""
EXPLAINED, FAR_MORE = 0.8, 2.0
"""Correlation of these by other signs or another order of the axes, and ratio of what those of the file leave of the
change to what the others leave, from which the file has wrong ones."""
NEAR = 6.0
"""Ratio of the regression to 1 within which a unit is right."""
STRETCH, STRETCHES = 16384, 12
"""Rows of a stretch, and number of stretches, on which units are recognised."""


@dataclass(frozen=True)
class Force:
    """Norm of the specific force in the unit of the file.

    Attributes
    ----------
    median
        Median of the norm of all samples.
    quiet
        Median norm of the means over the quietest windows.
    scatter
        Standard deviation of these norms over their median: that of noise is 0.4, of gravity next to nothing.
    direction
        Mean of their unit vectors, shape (3,): its length is 1 for a device that lies one way.
    """

    median: float
    quiet: float
    scatter: float
    direction: np.ndarray


def excerpt(columns: Sequence[np.ndarray]) -> np.ndarray:
    """Return stretches spread evenly over columns, each of shape (n,), as one array, shape (rows, columns)."""
    count = len(columns[0])
    if count <= STRETCH * STRETCHES:
        return np.column_stack(columns)
    starts = np.linspace(0, count - STRETCH, STRETCHES).astype(int)
    rows = (starts[:, None] + np.arange(STRETCH)).ravel()
    return np.column_stack([column[rows] for column in columns])


def force_of(accel: np.ndarray) -> Force | None:
    """Return the norm of the specific force, shape (n, 3); None where there are too few samples."""
    finite = accel[np.isfinite(accel).all(axis=1)]
    means, spread = _windows(finite)
    if not len(means):
        return None
    calm = means[spread <= np.quantile(spread, QUIET)]
    norms = np.linalg.norm(calm, axis=1)
    unit = calm / np.where(norms > 0, norms, 1.0)[:, None]
    quiet = float(np.median(norms))
    scatter = float(norms.std() / quiet) if quiet > 0 else np.inf
    return Force(float(np.median(np.linalg.norm(finite, axis=1))), quiet, scatter, unit.mean(axis=0))


def gravity_units(force: Force) -> tuple[str, ...]:
    """Return the units in which the norm of all or of the quiet samples is gravity."""
    return tuple(
        unit
        for unit in READINGS
        if any(
            1 / GRAVITY_TOLERANCE <= norm * factor(unit) / STANDARD_GRAVITY <= GRAVITY_TOLERANCE
            for norm in (force.quiet, force.median)
        )
    )


def is_precise(force: Force, units: Sequence[str]) -> bool:
    """Return whether the norm is gravity in one of the units within :data:`NARROW`, and nearer to it than to counts."""
    distances = [abs(np.log(force.quiet * factor(unit) / STANDARD_GRAVITY)) for unit in units]
    return bool(distances) and min(distances) < min(np.log(NARROW), _from_counts(force.quiet))


def are_whole(values: np.ndarray) -> bool:
    """Return whether samples, shape (n, axes), are whole numbers, not all of them next to zero, as counts are."""
    finite = values[np.isfinite(values)]
    return len(finite) > 0 and bool(np.abs(finite).max() > 1) and bool((finite == np.rint(finite)).all())


def counts_of(force: Force) -> str:
    """Return the reading of a specific force as counts of a converter, in words."""
    norm = force.quiet
    if not 1 < norm < np.inf:
        return "counts of a converter of unknown size"
    if _from_counts(norm) < np.log(NARROW):
        near = COUNTS[np.argmin(np.abs(np.log(norm / COUNTS)))]
        return f"counts of a converter of {near:.0f} counts per g (--units accel=g/{near:.0f})"
    return f"counts of a converter of about {norm:.4g} per g (--units accel=g/{norm:.0f}, better by its data sheet)"


def _from_counts(norm: float) -> float:
    """Return the distance of the logarithm of a norm from that of the nearest usual number of counts per g."""
    return float(np.abs(np.log(norm / COUNTS)).min()) if norm > 0 else np.inf


def are_increments(force: Force, rate_hz: float) -> bool:
    """Return whether a specific force is gravity times the sampling interval."""
    return force.scatter < CONSTANT and 1 / NARROW < force.quiet * rate_hz / STANDARD_GRAVITY < NARROW


def other_reading(force: Force, rate_hz: float) -> str:
    """Return what a specific force may be whose norm is gravity in no unit."""
    if _from_counts(force.quiet) < np.log(NARROW):
        return counts_of(force)
    if are_increments(force, rate_hz):
        return "velocity increments [m/s] over the interval (--units accel=m/s,gyro=rad)"
    if force.quiet == 0:
        return "no samples"
    if force.scatter > CONSTANT or force.quiet < NONE_LEFT * STANDARD_GRAVITY:
        return "of no gravity: was it removed? (record the accelerations with gravity)"
    return "gravity in no known unit"


@dataclass(frozen=True)
class RateEvidence:
    """Unit by physics, the reason, whether it outweighs the word of a header, and whether it is the noise at rest."""

    unit: str
    reason: str
    strong: bool = True
    noise: bool = False


def gyro_unit(gyro: np.ndarray, accel: np.ndarray | None, rate_hz: float) -> RateEvidence | None:
    """Return whether angular rates are in rad/s or deg/s, or None where nothing shows it.

    Evidence, in this order: a rate that no gyroscope reaches in rad/s; the turns of gravity; noise and Earth rate at
    rest.

    Parameters
    ----------
    gyro
        Angular rate in the unit of the file, shape (n, axes).
    accel
        Specific force [m/s^2], shape (n, 3), or None.
    rate_hz
        Sampling rate.
    """
    finite = np.isfinite(gyro).all(axis=1) & (True if accel is None else np.isfinite(accel).all(axis=1))
    gyro, accel = gyro[finite], None if accel is None else accel[finite]
    if len(gyro) < 4 * WINDOW:
        return None
    fastest = np.quantile(np.abs(gyro), 0.99)
    if fastest > FASTEST_RAD_PER_S:
        return RateEvidence("deg/s", f"rates of {fastest:.4g}")
    turned = None if accel is None or gyro.shape[1] < 3 else _by_gravity(gyro, accel, rate_hz)
    return turned or _at_rest(gyro, accel, rate_hz)


def too_loud(gyro: np.ndarray, accel: np.ndarray | None, rate_hz: float) -> float | None:
    """Return the noise density at rest in the unit of the file where no gyroscope has it in deg/s; else None.

    Parameters as in :func:`gyro_unit`.
    """
    finite = np.isfinite(gyro).all(axis=1) & (True if accel is None else np.isfinite(accel).all(axis=1))
    found = _rest(gyro[finite], None if accel is None else accel[finite], rate_hz)
    if found is None:
        return None
    _, density, calm = found
    return density if calm and density * factor("deg/s") > LOUD else None


def time_unit(
    gyro: np.ndarray | None, accel: np.ndarray | None, unit: str, rates: Mapping[str, float], rows: int
) -> RateEvidence | None:
    """Return which of two units of the stamps is right, or None where nothing shows it.

    Evidence, in this order: a length that no log has; the turns of gravity; the noise at rest.

    Parameters
    ----------
    gyro, accel
        Angular rates and specific force in the units of the file, shape (n, axes); None where there are none.
    unit
        Unit of the angular rates.
    rates
        Sampling rate by each unit of the stamps [Hz], the lower one first.
    rows
        Number of rows.
    """
    (slow, low), (fast, high) = rates.items()
    if rows / high < SHORTEST_S:
        return RateEvidence(slow, f"a length of {rows / high:.2g} s in {fast}")
    if rows / low > LONGEST_S:
        return RateEvidence(fast, f"a length of {rows / low / DAY_S:.3g} days in {slow}")
    if gyro is None or unit not in ("rad/s", "deg/s"):
        return None
    if accel is not None and gyro.shape[1] == accel.shape[1] == 3:
        turned = {name: _by_gravity(gyro, accel, rate) for name, rate in rates.items()}
        right = [name for name, found in turned.items() if found is not None and found.unit == unit]
        if len(right) == 1:
            return RateEvidence(right[0], "the turns of gravity")
    begin, end = _longest_rest(gyro, WINDOW)
    if end - begin < FEWEST_BLOCKS:
        return None
    per_root_hz = _density(gyro[begin * WINDOW : end * WINDOW], WINDOW, 1.0) * factor(unit)
    if per_root_hz / np.sqrt(low) > LOUD:
        return RateEvidence(fast, f"noise at rest of {per_root_hz / np.sqrt(low):.2g} rad/s/sqrt(Hz) in {slow}")
    if per_root_hz / np.sqrt(high) < SOFTEST:
        return RateEvidence(slow, f"noise at rest of {per_root_hz / np.sqrt(high):.2g} rad/s/sqrt(Hz) in {fast}")
    return None


def opposed(gyro: np.ndarray, accel: np.ndarray, rate_hz: float) -> tuple[tuple[int, int], ...] | None:
    """Return the axes and signs of the gyroscopes that turn gravity as the rates of x, y and z; None where it is these.

    Of all orders and signs; one that is no rotation is of axes that are mirrored, or of a sense of rotation against the
    right-hand rule. It has to explain the change of the specific force, and leave far less of it than those of the
    file.

    Parameters
    ----------
    gyro, accel
        Angular rate and specific force, shape (n, 3), in any unit.
    rate_hz
        Sampling rate.
    """
    finite = np.isfinite(gyro).all(axis=1) & np.isfinite(accel).all(axis=1)
    found = _turns(gyro[finite], accel[finite], rate_hz)
    if found is None:
        return None
    change, force, rate = found
    by_order = {
        tuple(zip(order, signs, strict=True)): _correlation(change, -np.cross(rate[:, order] * signs, force))
        for order in permutations(range(3))
        for signs in product((1, -1), repeat=3)
    }
    best, own = max(by_order, key=by_order.__getitem__), ((0, 1), (1, 1), (2, 1))
    left = {order: 1 - max(by_order[order], 0.0) ** 2 for order in (best, own)}
    return best if by_order[best] > EXPLAINED and left[own] > FAR_MORE * left[best] else None


def _correlation(change: np.ndarray, turn: np.ndarray) -> float:
    size = np.sum(turn**2) * np.sum(change**2)
    return float(np.sum(change * turn) / np.sqrt(size)) if size > 0 else 0.0


def _turns(gyro: np.ndarray, accel: np.ndarray, rate_hz: float) -> tuple[np.ndarray, np.ndarray, np.ndarray] | None:
    """Return the change of the specific force from window to window, and its means and those of the rates between them.

    Shape (windows - 1, 3) each; None where there are too few windows.
    """
    width = max(int(LAG_S * rate_hz), 1)
    windows = len(accel) // width
    if windows < FEWEST_WINDOWS:
        return None
    force, rate = (one[: windows * width].reshape(windows, width, 3).mean(axis=1) for one in (accel, gyro))
    return np.diff(force, axis=0) * rate_hz / width, (force[1:] + force[:-1]) / 2, (rate[1:] + rate[:-1]) / 2


def _by_gravity(gyro: np.ndarray, accel: np.ndarray, rate_hz: float) -> RateEvidence | None:
    """Compare the change of the specific force with its turns by the gyroscopes, ``df/dt = -omega x f`` (regression).

    Motion adds to the change, but a factor of 57 shows through. A correlation is needed, for a device that turns about
    the vertical only shows nothing.
    """
    found = _turns(gyro, accel, rate_hz)
    if found is None:
        return None
    change, force, rate = found
    turn = -np.cross(rate, force)
    common, size, changed = np.sum(change * turn), np.sum(turn**2), np.sum(change**2)
    if not (size > 0 and changed > 0):
        return None
    correlation = abs(common) / np.sqrt(size * changed)
    slope = abs(common) / size
    for unit in ("rad/s", "deg/s"):
        if correlation > CORRELATED and 1 / NEAR < slope / factor(unit) < NEAR:
            return RateEvidence(unit, "the turns of gravity", strong=correlation > WELL_CORRELATED)
    return None


def _at_rest(gyro: np.ndarray, accel: np.ndarray | None, rate_hz: float) -> RateEvidence | None:
    """Decide by noise and Earth rate on the longest rest of the device."""
    found = _rest(gyro, accel, rate_hz)
    if found is None:
        return None
    rest, density, calm = found
    if density > LOUD and calm:
        reason = f"noise at rest of {density:.2g} per sqrt(Hz)"
        return RateEvidence("deg/s", reason, strong=accel is not None, noise=True)
    mean = float(np.linalg.norm(gyro[rest].mean(axis=0)))
    earth = [
        unit
        for unit in ("rad/s", "deg/s")
        if 1 / EARTH_TOLERANCE < mean * factor(unit) / EARTH_RAD_PER_S < EARTH_TOLERANCE
    ]
    if earth == ["rad/s"]:
        return RateEvidence("rad/s", "Earth rate", strong=False)
    if not earth and (QUIETEST_MEMS < density < SOFT or density * factor("deg/s") < SOFTEST):
        return RateEvidence("rad/s", f"noise at rest of {density:.2g} per sqrt(Hz)", strong=False, noise=True)
    return None


def _rest(gyro: np.ndarray, accel: np.ndarray | None, rate_hz: float) -> tuple[slice, float, bool] | None:
    """Return the rows of the longest rest, the noise density of the gyroscopes there, and whether nothing shakes them.

    None where it is too short.
    """
    block = max(WINDOW, int(rate_hz))
    begin, end = _longest_rest(gyro, block)
    if end - begin < FEWEST_BLOCKS:
        return None
    rest = slice(begin * block, end * block)
    calm = accel is None or _density(accel[rest], block, rate_hz) < SHAKEN
    return rest, _density(gyro[rest], block, rate_hz), calm


def _density(values: np.ndarray, block: int, rate_hz: float) -> float:
    """Return the root density of white noise by the Allan variance of means over blocks, the median of the axes."""
    means = values.reshape(-1, block, values.shape[1]).mean(axis=1)
    allan = np.mean(np.diff(means, axis=0) ** 2, axis=0) / 2
    return float(np.sqrt(np.median(allan) * block / rate_hz))


def _longest_rest(gyro: np.ndarray, block: int) -> tuple[int, int]:
    """Return begin and end of the longest row of blocks with the same mean and scatter as the quietest ones."""
    blocks = len(gyro) // block
    if not blocks:
        return 0, 0
    parts = gyro[: blocks * block].reshape(blocks, block, -1)
    means, scatter = parts.mean(axis=1), parts.std(axis=1)
    floor = np.quantile(scatter, QUIET / 2, axis=0)
    quiet = (scatter <= 2 * floor).all(axis=1)
    steps = np.zeros(blocks, bool)
    steps[1:] = (np.abs(np.diff(means, axis=0)) > 2 * np.maximum(floor, 1e-300)).any(axis=1)
    edges = np.flatnonzero(np.r_[True, ~quiet[1:] | ~quiet[:-1] | steps[1:], True])
    longest = int(np.argmax(np.diff(edges)))
    return int(edges[longest]), int(edges[longest + 1])


def _windows(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the means over windows, shape (windows, 3), and the spread within them."""
    width = min(WINDOW, len(values))
    if not width:
        return np.empty((0, 3)), np.empty(0)
    parts = values[: len(values) // width * width].reshape(-1, width, 3)
    return parts.mean(axis=1), parts.var(axis=1).sum(axis=1)

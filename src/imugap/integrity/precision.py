"""Rounding of stored numbers: decimals of a text, significant digits, single precision.

Differences finer than the rounding are those of the file, not of the device.
"""

import numpy as np

from imugap.integrity.report import lattice
from imugap.units import factor

DIGITS = 14
"""Decimal digits of a double after a conversion of units."""
LEAST = 1e-290
"""Least number of which all digits are numbers as well; one below it counts as zero."""
SAMPLE = 200
"""Numbers on which a format is tested before all."""
PART = 1 << 16
"""Numbers that are tested at once."""
SEVERAL = 8
"""Fewest levels to separate a lattice from its clipped ends, or to identify a number of digits."""
UNITS = ("1", "deg", "g")
"""Units in which files hold decimal numbers."""


def grain(values: np.ndarray) -> np.ndarray:
    """Return the spacing of storable numbers at each of ``values``, shape (n,).

    The largest of: common number of decimals, common number of significant digits (in the unit of the log, in degrees
    and in standard gravity), single precision, double precision after a few operations.
    """
    largest = np.abs(values).max(initial=0.0)
    result = np.full(len(values), 16 * np.spacing(largest))
    if np.array_equal(values, values.astype(np.float32)):
        result = np.maximum(result, np.spacing(np.abs(values).astype(np.float32)))
    for unit in UNITS:
        result = np.maximum(result, factor(unit) * _decimal(np.abs(values) / factor(unit)))
    return result


def spacing(values: np.ndarray) -> tuple[float, float]:
    """Return the greatest common step of ``values``, shape (n,), and its uncertainty; zeros if there is none.

    The highest and the lowest value may be clipped, off the lattice. A lattice written as decimal text fits only to
    within the last decimal; it is searched before the lattice of the decimals themselves.
    """
    levels = np.unique(values)
    levels = levels[1:-1] if len(levels) > SEVERAL else levels
    if len(levels) < 2:
        return 0.0, 0.0
    fine = float(grain(levels).max())
    for coarse in (fine, 0.0):
        step = lattice(levels, 2 * len(levels), coarse)
        exact = max(coarse, 16 * float(np.spacing(np.abs(levels).max())))
        if step is not None and _holds(levels, step, exact):
            return step, max(exact * step / float(np.ptp(levels)), 4 * float(np.spacing(step)))
    return 0.0, 0.0


def _holds(levels: np.ndarray, step: float, exact: float) -> bool:
    """Return whether enough differences of levels for significance are multiples of a step, each to ``exact``."""
    apart = np.diff(levels)
    multiples = np.rint(apart / step)
    telling = (multiples > 0) & (multiples < step / (20 * exact))
    return np.count_nonzero(telling) >= min(SEVERAL, len(apart))


def decimal(step: float) -> bool:
    """Return whether a step is a power of ten in a unit in which files hold decimal numbers."""
    exponents = np.log10([step / factor(unit) for unit in UNITS])
    return bool(np.any(np.abs(exponents - np.rint(exponents)) < 1e-6))


def _decimal(values: np.ndarray) -> np.ndarray:
    """Return the spacing of non-negative numbers written as decimal text, shape (n,); zero for other numbers."""
    values = np.where(values < LEAST, 0.0, values)
    some = values[:: max(len(values) // SAMPLE, 1)]
    if not values.any():
        return np.zeros(len(values))
    top = int(np.floor(np.log10(values.max()))) + 1
    shifts = range(DIGITS + 1)
    common = next((k for k in shifts if _fits(some, top - k) and _fits(values, top - k)), None)
    own = None
    if any(
        len(np.unique(ones)) > SEVERAL for ones in (some, values)
    ):  # few levels may share their digits by coincidence
        own = next(
            (k for k in shifts[1:] if _fits(some, _decades(some) - k) and _fits(values, _decades(values) - k)), None
        )
    result = np.zeros(len(values)) if common is None else np.full(len(values), 10.0 ** (top - common))
    return result if own is None else np.maximum(result, 10.0 ** (_decades(values) - own))


def _decades(values: np.ndarray) -> np.ndarray:
    """Return the number of digits before the point of non-negative numbers, as floats; for 0 that of the smallest."""
    least = values[values > 0].min(initial=np.inf)
    return np.floor(np.log10(np.where(values > 0, values, least if least < np.inf else 1e-300)) + 1e-12) + 1


def _fits(values: np.ndarray, exponents: np.ndarray | int) -> bool:
    """Return whether all values are multiples of powers of ten, part by part."""
    every = np.broadcast_to(exponents, values.shape)
    return all(
        _fit(values[begin : begin + PART], every[begin : begin + PART]) for begin in range(0, max(len(values), 1), PART)
    )


def _fit(values: np.ndarray, exponents: np.ndarray) -> bool:
    ratio = values / 10.0**exponents
    return bool(np.all(np.abs(ratio - np.rint(ratio)) <= 8 * np.finfo(float).eps * np.maximum(ratio, 1.0)))

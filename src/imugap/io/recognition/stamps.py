"""Unit of the stamps of a recording: from the header, the option, the year, or the rates of inertial sensors.

Stamps in another unit than the true one would be off by 1000 or more; the admitted rates are wide enough for any
inertial sensor and leave one unit for most.
"""

import numpy as np

from imugap.units import factor

TICKS = ("s", "ms", "us", "ns")
"""Units of stamps that name none."""
LAG = 16
"""Rows over which the mean interval is taken: stamps may come in bursts."""
ROWS = 200_000
"""Rows on which the step is taken."""
FEWEST = 32
"""Fewest rows from which a unit is inferred."""
SLOWEST_HZ, FASTEST_HZ = 1.5, 2e4
"""Rates of inertial sensors."""
SLOWEST_CONTRACT_HZ = 0.5
"""Lowest rate at which stamps named ``time`` are in seconds without any doubt."""
LEAST_HZ, MOST_HZ = 0.1, 1e6
"""Rates beyond which no option is right."""
YEARS = (9.5e8, 4.1e9)
"""Seconds since 1970 of the years 2000 to 2099."""
EPOCHS = (("d", 25_569 * 86_400), ("d", 719_529 * 86_400), ("100ns", 11_644_473_600), ("100ns", 62_135_596_800))
"""Units of clocks of programs, and the seconds from their zero to 1970: spreadsheets (1899-12-30), MATLAB (year 0),
Windows (1601), .NET (year 1)."""
FINE, FINE_TICKS, FINE_FASTEST_HZ = "sampletimefine", ("us", "100us"), 3e3
"""Counter of some devices, its ticks by their kind, and the highest rate of these."""
MINUTE, CENTURY, DAY_NUMBER = 60, 100, 240_000
"""Seconds of a minute, what a minute counts in HHMMSS, and the end of the day in it."""
CARRIED = (41, 4041, -235_959)
"""What follows 59 s in HHMMSS is larger by: the next minute, the next hour, the next day."""
PARTS = (1, 10, 100, 1000)
"""Parts of a second in which times of day may be counted, such as the milliseconds of HHMMSSmmm."""
MOST = 0.3
"""Share of the stamps that advance, in a column of stamps: they may repeat in bursts."""


def step_of(time: np.ndarray) -> float:
    """Return the median step of stamps, shape (n,), of means over :data:`LAG` rows; NaN where none increases."""
    first = time[:ROWS]
    finite = first[np.isfinite(first)] if time.dtype.kind == "f" else first
    lag = min(LAG, max(len(finite) - 1, 1))
    steps = (finite[lag:] - finite[:-lag]) / lag
    steps = steps[steps > 0]
    return float(np.median(steps)) if len(steps) else np.nan


def seconds(time: np.ndarray, unit_s: float) -> np.ndarray:
    """Return stamps, shape (n,), in seconds; whole numbers keep the digits that a double can hold."""
    if time.dtype.kind != "i" or unit_s >= 1:
        return time * unit_s if unit_s != 1 else time
    per_second = round(1 / unit_s)
    whole, rest = np.divmod(time, per_second)
    return whole + rest / per_second


def unit_of_stamps(time: np.ndarray, contract: bool) -> tuple[str, str]:
    """Return the unit of stamps that name none, and why; ValueError with the readings where there are several.

    Parameters
    ----------
    time
        Stamps, shape (n,).
    contract
        Whether the name of the column promises seconds; then only a rate that no inertial sensor has speaks against it.
    """
    step = step_of(time)
    if len(time) < FEWEST or not np.isfinite(step):
        return "s", "too few stamps"
    first = float(time[0] if time.dtype.kind == "i" else time[np.isfinite(time)][0])
    by_year = [unit for unit in TICKS if _is_dated(first * factor(unit), step * factor(unit))]
    if by_year:
        return by_year[0], "the year"
    rates = {unit: 1 / (step * factor(unit)) for unit in TICKS}
    slowest = SLOWEST_CONTRACT_HZ if contract else SLOWEST_HZ
    if slowest <= rates["s"] <= FASTEST_HZ:
        return "s", "the rate"
    of_program = [unit for unit, zero in EPOCHS if _is_dated(first * factor(unit) - zero, step * factor(unit))]
    if of_program:
        return of_program[0], "the year"
    admitted = [unit for unit, rate in rates.items() if SLOWEST_HZ < rate < FASTEST_HZ]
    if SLOWEST_CONTRACT_HZ <= rates["s"] < SLOWEST_HZ:
        admitted = ["s", *admitted]
    if len(admitted) == 1:
        return admitted[0], "the rate"
    readings = " or ".join(f"{rates[unit]:.4g} Hz in {unit}" for unit in admitted or rates)
    raise ValueError(f"the unit of the stamps (--time-unit decides); found a step of {step:.6g}: {readings}")


def _is_dated(since_1970: float, step: float) -> bool:
    """Return whether a stamp [s] is of the years of :data:`YEARS`, and the step [s] of an inertial sensor."""
    return YEARS[0] < since_1970 < YEARS[1] and SLOWEST_CONTRACT_HZ < 1 / step < FASTEST_HZ


def require_rate(time: np.ndarray, unit: str) -> None:
    """Raise a ValueError where stamps, shape (n,), in the unit of a header have a rate of no inertial sensor."""
    step = step_of(time)
    rates = {one: 1 / (step * factor(one)) for one in dict.fromkeys((unit, *TICKS))}
    if len(time) < FEWEST or not np.isfinite(step) or SLOWEST_CONTRACT_HZ <= rates[unit] <= FASTEST_HZ:
        return
    admitted = [one for one, rate in rates.items() if SLOWEST_HZ < rate < FASTEST_HZ]
    if admitted:
        readings = " or ".join(f"{rates[one]:.4g} Hz in {one}" for one in (unit, *admitted))
        raise ValueError(f"stamps in {unit} as the header has it (--time-unit decides); found {readings}")


def require_possible(time: np.ndarray, unit: str) -> None:
    """Raise a ValueError where stamps, shape (n,), have a rate of no inertial sensor, in any stated unit."""
    rate = 1 / (step_of(time) * factor(unit))
    if len(time) >= FEWEST and not LEAST_HZ <= rate <= MOST_HZ:
        limits = f"{LEAST_HZ:g} to {MOST_HZ:g} Hz"
        raise ValueError(f"stamps of an inertial sensor, {limits} (--time-unit decides); found {rate:.3g} Hz in {unit}")


def are_clock_numbers(time: np.ndarray) -> bool:
    """Return whether stamps, shape (n,), are times of day as numbers, HHMMSS or with the parts of the second behind it.

    59 s is followed by the next minute.
    """
    finite = time[:ROWS][np.isfinite(time[:ROWS].astype(float))].astype(float)
    return len(finite) >= FEWEST and any(_carries(np.floor(finite / parts)) for parts in PARTS)


def _carries(whole: np.ndarray) -> bool:
    """Return whether whole numbers, shape (n,), count as HHMMSS does."""
    if (whole % CENTURY >= MINUTE).any() or not (whole < DAY_NUMBER).all():
        return False
    carried = (whole[:-1] % CENTURY == MINUTE - 1) & np.isin(np.diff(whole), CARRIED)
    return bool(carried.any())


def unit_of_fine(time: np.ndarray) -> tuple[str, str]:
    """Return the tick of the counter :data:`FINE`, and why."""
    rates = {unit: 1 / (step_of(time) * factor(unit)) for unit in FINE_TICKS}
    return next((unit for unit, rate in rates.items() if SLOWEST_HZ < rate < FINE_FASTEST_HZ), "100us"), "the rate"


def advances(time: np.ndarray) -> bool:
    """Return whether most of the stamps, shape (n,), exceed the one before."""
    steps = np.diff(time[np.isfinite(time.astype(float))])
    return bool(len(steps) and np.mean(steps > 0) > MOST)


def run(time: np.ndarray) -> bool:
    """Return whether numbers, shape (n,), are stamps that advance, and no times of day as numbers."""
    return advances(time) and not are_clock_numbers(time)


def unevenness(time: np.ndarray) -> float:
    """Return the mean deviation of the steps of stamps, shape (n,), from their mean, over it; inf where none advances.

    Stamps of one rate have 0, those that come in packets of many nearly 2.
    """
    steps = np.diff(time[np.isfinite(time.astype(float))].astype(float))
    mean = float(steps.mean()) if len(steps) else 0.0
    return float(np.abs(steps - mean).mean() / mean) if mean > 0 else np.inf

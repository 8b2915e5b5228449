"""Physics of a drive: whether device and receiver see the same motion, before a filter is run.

Over windows with much motion the velocities of the fixes are matched with the samples
(:mod:`imugap.navigation.drive.velocity_matching`). What the samples leave unexplained of the changes of velocity is
small where both belong together, for any vehicle. Each candidate error is tried: units, signs and orders of the
samples, an order of the columns of the fixes, a wrong rate, and a time offset between the clocks. The candidate that
explains the changes is named, with those that explain them as well: a mirrored log is the same as a mirrored map, for a
heading that is not known. A unit, a sign or an order is refused, a time offset is compensated. Where neither does, both
together are tried. Where the device points to the same side of the course in all windows, so does its mounting.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple, NoReturn

import numpy as np
import pandas as pd

from imugap.kinematics.strapdown import ATTITUDE
from imugap.log import ACCEL, GYRO
from imugap.navigation.drive.clock_rate import clock_correction, with_clock, with_drift
from imugap.navigation.drive.correction import Correction
from imugap.navigation.drive.fix_screening import middle
from imugap.navigation.drive.vehicle import DriveInputs
from imugap.navigation.drive.vehicle_alignment import velocity_pair
from imugap.navigation.drive.velocity_matching import AFTER_S, BEFORE_S, SPAN_S, MatchedAttitude, VelocityPair
from imugap.navigation.sample_errors import SAMPLE_ERRORS, SampleError
from imugap.numerics.rotation import from_euler, to_euler
from imugap.units import STANDARD_GRAVITY

WINDOWS = 6
"""Number of windows, those with the largest changes of velocity."""
EVERY_S = 10.0
"""Time between the windows to choose from [s]."""
UNEXPLAINED, EXPLAINED = 0.08, 0.15
"""Unexplained share from which on a drive is doubtful, and below which an error is named."""
CONTRADICTING, FEW_WINDOWS = 0.3, 2
"""Unexplained share from which on two errors at once are searched for, and number of windows of that search."""
BETTER = 0.4
"""Largest unexplained share with a named error corrected, as a multiple of that without it."""
SURE, TIED = 20.0, 3.0
"""Gain of the log-likelihood that names an error where the drive is not doubtful otherwise, and difference of gains
within which two errors are not told apart."""
INDEPENDENT = 0.5
"""Independent residuals, as a share of all: a change of velocity shares a fix with the next one."""
SMALLEST_SIGNAL = 1.5
"""Root mean square of the changes of velocity that a comparison needs, as a multiple of their noise."""
SPANS_S = SPAN_S, 2.5
"""Intervals of a change of velocity, the first that stands out of the noise is used [s]."""
LONGEST_OFFSET_S, COARSE_S = 90.0, 0.5
"""Largest time offset that is tried, and the step of the search [s]."""
FINE_S = 0.05, 0.01
"""Steps of the refinement [s]."""
DRIFTS_S = (4.0, 0.2), (0.4, 0.02)
"""Reach and step of the time offset of a single window [s], twice."""
LEAP_S = {18: "GPS time against UTC", 17: "GPS time against UTC before 2017", 37: "TAI against UTC",
          19: "TAI against GPS time"}  # fmt: skip
"""Offsets of time scales [s]."""
NEAR_LEAP_S = 0.6
"""Largest difference of a time offset from one of time scales [s]."""
ASKEW, ALIGNED = np.radians(25.0), 0.98
"""Smallest angle of a mounting that is named [rad], and mean resultant length of the angles of the windows."""
COURSE_SPEED = 3.0
"""Smallest speed with a course [m/s]."""
GRAVITY_SHARE = 0.85, 1.15
"""Range of the median norm of the specific force, in units of gravity."""


class MotionFit(NamedTuple):
    """Fit of samples to changes of velocity.

    Attributes
    ----------
    unexplained
        Share of the changes that samples do not explain, nor noise; inf without any.
    spread
        Mean square of the residuals over that of the changes.
    freedom
        Number of independent residuals.
    """

    unexplained: float
    spread: float
    freedom: float

    def gain(self, plain: "MotionFit") -> float:
        """Return the gain of the log-likelihood over another fit, for noise of unknown size."""
        if not np.isfinite(self.unexplained):
            return -np.inf
        if not np.isfinite(plain.unexplained):
            return np.inf
        return 0.5 * self.freedom * float(np.log(plain.spread / self.spread))


NOTHING = MotionFit(np.inf, np.inf, 0.0)


@dataclass(frozen=True)
class DriveWindows:
    """Windows of a drive with much motion: their times, and the interval of a change of velocity [s]."""

    times: tuple[float, ...]
    span: float

    def match(self, pair: VelocityPair) -> list[MatchedAttitude]:
        """Return the attitudes by velocity matching in all windows that have one."""
        found = (pair.match(at, self.span) for at in self.times)
        return [one for one in found if one is not None]

    def fit(self, pair: VelocityPair) -> MotionFit:
        """Return how the samples explain the changes of velocity."""
        found = self.match(pair)
        if len(found) < max(len(self.times) / 2, 1):
            return NOTHING
        change, freedom = max(sum(one.change for one in found), 1e-12), sum(one.freedom for one in found)
        rest = sum(max(one.residual * (1 - 1 / one.misfit**2), 0.0) for one in found)
        return MotionFit(rest / change, sum(one.residual for one in found) / change, INDEPENDENT * freedom)


@dataclass(frozen=True)
class _Candidate:
    """What may be wrong with the inputs: a change of the pair that corrects it, what was expected, and what found."""

    change: Callable[[], VelocityPair]
    expected: str
    found: str

    def fit(self) -> MotionFit:
        """Return the fit of the corrected pair."""
        return _fit(self.change())

    def is_needed(self, pair: VelocityPair) -> bool:
        """Return whether the samples leave changes of ``pair`` unexplained where the corrected one shows motion."""
        windows = windows_of(self.change())
        return windows is not None and windows.fit(pair).unexplained >= UNEXPLAINED


def windows_of(pair: VelocityPair) -> DriveWindows | None:
    """Return the windows with the largest changes of velocity; None where nothing stands out of the noise."""
    low, high = max(pair.stamp[0], pair.time[0]), min(pair.stamp[-1], pair.time[-1])
    for span in SPANS_S:
        found = {}
        for at in np.arange(low + BEFORE_S, high - AFTER_S / 2, EVERY_S):
            chosen = pair.chosen(at, span)
            if len(chosen) > 5:
                change = np.diff(pair.velocity[chosen], axis=0)
                noise = pair.std[chosen][1:] ** 2 + pair.std[chosen][:-1] ** 2
                found[float(at)] = (np.sum(change**2) / len(change), np.sum(noise) / len(change))
        best = sorted(found, key=lambda at: -found[at][0])[:WINDOWS]
        if best and sum(found[at][0] for at in best) > SMALLEST_SIGNAL**2 * sum(found[at][1] for at in best):
            return DriveWindows(tuple(sorted(best)), span)
    return None


def check_physics(inputs: DriveInputs) -> tuple[DriveInputs, tuple[Correction, ...]]:
    """Return the inputs with a gross time offset compensated, and that; a ValueError names any other gross error."""
    _check_gravity(inputs)
    pair = velocity_pair(inputs)
    windows, plain = windows_of(pair), _fit(pair)
    doubtful = plain.unexplained >= UNEXPLAINED
    limit = min(EXPLAINED, BETTER * plain.unexplained)
    candidates = [one for one in _candidates(inputs, pair) if windows or one.is_needed(pair)]
    gains = {
        one: fit.gain(plain)
        for one, fit in ((one, one.fit()) for one in candidates)
        if fit.unexplained < limit and (doubtful or fit.gain(plain) > SURE)
    }
    offset, late = _time_offset(pair, windows) if doubtful and windows is not None else (0.0, NOTHING)
    if gains and max(gains.values()) > late.gain(plain):
        _refuse(gains)
    if late.unexplained < limit:
        return _with_offset(inputs, offset, plain, late)
    if plain.unexplained >= CONTRADICTING and windows is not None:
        _refuse_both(candidates, windows, limit)
    return inputs, ()


def _fit(pair: VelocityPair) -> MotionFit:
    """Return how the samples explain the changes of velocity in the windows with the largest ones."""
    windows = windows_of(pair)
    return NOTHING if windows is None else windows.fit(pair)


def _refuse(gains: dict[_Candidate, float], besides: str = "") -> NoReturn:
    """Raise a ValueError with the candidate of the largest gain, and those that are not told apart from it."""
    first, *others = (one for one, gain in gains.items() if gain > max(gains.values()) - TIED)
    tied = f"; as well explained by {', or by '.join(one.found for one in others)}" if others else ""
    raise ValueError(f"{first.expected}; found {first.found}{besides}{tied}")


def _refuse_both(candidates: list[_Candidate], windows: DriveWindows, limit: float) -> None:
    """Raise a ValueError where a candidate and a time offset together explain what neither does."""
    few = replace(windows, times=windows.times[:FEW_WINDOWS])
    found = {one: _time_offset(one.change(), few) for one in candidates}
    best = min(found, key=lambda one: found[one][1].spread, default=None)
    if best is None:
        return
    offset, pair = found[best][0], best.change()
    if _fit(replace(pair, time=pair.time + offset)).unexplained < limit:
        _refuse({best: 0.0}, f", and stamps of the fixes that are {_late(offset)}")


def with_mounting(
    inputs: DriveInputs, mounting: tuple[float, float, float]
) -> tuple[DriveInputs, tuple[float, float, float], tuple[Correction, ...]]:
    """Return the inputs with the device turned to the course, if it points to one side of it, its mounting, and that.

    ``mounting`` is the one by which the log was turned (roll, pitch, heading [rad]).
    """
    angle = mounting_of(inputs)
    if angle is None:
        return inputs, mounting, ()
    turn, columns = from_euler(np.array([0.0, 0.0, angle])), {}
    for triad in (GYRO, ACCEL):
        turned = turn.apply(inputs.log[list(triad)].to_numpy(copy=True))
        columns |= dict(zip(triad, turned.T, strict=True))
    roll, pitch, heading = map(float, to_euler(turn * from_euler(np.array(mounting))))
    side = "right" if angle > 0 else "left"
    found = f"the device points {np.degrees(abs(angle)):.0f} deg to the {side} of the course"
    whole = zip(ATTITUDE, np.degrees([roll, pitch, heading]), strict=True)
    setting = f"mounting: {{{', '.join(f'{name}_deg: {round(one)}' for name, one in whole)}}}"
    named = Correction("mounting", found, setting)
    return replace(inputs, log=inputs.log.assign(**columns)), (roll, pitch, heading), (named,)


def mounting_of(inputs: DriveInputs) -> float | None:
    """Return the angle of the device right of the course, if it is large and the same in all windows [rad]."""
    pair = velocity_pair(inputs)
    windows = windows_of(pair)
    if windows is None or windows.fit(pair).unexplained > EXPLAINED:
        return None
    angles = []
    for at in windows.times:
        for around in np.arange(at, at + AFTER_S / 2, 1.0):
            number = int(np.clip(np.searchsorted(pair.time, around), 0, len(pair.time) - 1))
            north, east = pair.velocity[number, :2]
            if np.hypot(north, east) > COURSE_SPEED:
                found = pair.match(pair.time[number], windows.span)
                if found is not None and found.heading_std < 0.2:
                    angles.append(found.heading - np.arctan2(east, north))
                break
    if len(angles) < WINDOWS / 2:
        return None
    mean = np.mean(np.exp(1j * np.array(angles)))
    return float(np.angle(mean)) if abs(mean) > ALIGNED and abs(np.angle(mean)) > ASKEW else None


def _check_gravity(inputs: DriveInputs) -> None:
    """Raise a ValueError where the median norm of the specific force is not gravity."""
    share = float(np.median(np.linalg.norm(inputs.log[list(ACCEL)], axis=1))) / STANDARD_GRAVITY
    if not GRAVITY_SHARE[0] < share < GRAVITY_SHARE[1]:
        raise ValueError(
            f"drive: expected a specific force with a median norm near {STANDARD_GRAVITY:.2f} m/s^2; found "
            f"{share * STANDARD_GRAVITY:.3g} m/s^2 (a wrong unit or scale, or gravity is removed)"
        )


def _candidates(inputs: DriveInputs, pair: VelocityPair) -> list[_Candidate]:
    """Return the errors that are tried; of those that are not told apart the first is named."""
    return [*_of_fixes(inputs, pair), *_of_samples(pair)]


def _of_fixes(inputs: DriveInputs, pair: VelocityPair) -> list[_Candidate]:
    """Return errors of the columns of the fixes."""

    def exchanged() -> VelocityPair:
        return replace(pair, velocity=pair.velocity[:, [1, 0, 2]], std=pair.std[:, [1, 0, 2]])

    def places(latitude: pd.Series, longitude: pd.Series) -> Callable[[], VelocityPair]:
        fixes = inputs.fixes.assign(latitude=latitude, longitude=longitude)
        return lambda: velocity_pair(replace(inputs, fixes=fixes, ellipsoid=middle(fixes)))

    order = "a motion that turns against the device: the two are exchanged, or one has the opposite sign"
    if "vel_n" in inputs.fixes:
        return [_Candidate(exchanged, "fixes: expected vel_n, vel_e in this order", order)]
    latitude, longitude = inputs.fixes["latitude"], inputs.fixes["longitude"]
    found = [_Candidate(places(latitude, -longitude), "fixes: expected latitude, longitude in this order", order)]
    if longitude.abs().max() < np.pi / 2:
        found.append(replace(found[0], change=places(longitude, latitude)))
    if latitude.abs().max() < np.radians(np.pi / 2):
        found.append(_Candidate(
            places(np.degrees(latitude), np.degrees(longitude)), "fixes: expected latitude and longitude in degrees",
            "a motion 57.3 times smaller than that of the device, as in radians",
        ))  # fmt: skip
    return found


def _of_samples(pair: VelocityPair) -> list[_Candidate]:
    """Return errors of the samples of the device."""

    def corrected(error: SampleError) -> Callable[[], VelocityPair]:
        return lambda: _with_samples(pair, *error.corrected(pair.stamp, pair.samples))

    return [_Candidate(corrected(one), f"drive: expected {one.expected}", one.found) for one in SAMPLE_ERRORS]


def _with_samples(pair: VelocityPair, stamp: np.ndarray, samples: np.ndarray) -> VelocityPair:
    return replace(pair, stamp=stamp, samples=samples)


def _time_offset(pair: VelocityPair, windows: DriveWindows) -> tuple[float, MotionFit]:
    """Return what to add to the times of the fixes so that most is explained [s], and the fit then."""

    def fit(offset: float) -> MotionFit:
        """Move the windows with the fixes, so that the same changes of velocity are explained."""
        own = replace(windows, times=tuple(at + offset for at in windows.times))
        return own.fit(replace(pair, time=pair.time + offset))

    best, reach = 0.0, LONGEST_OFFSET_S
    for step in (COARSE_S, *FINE_S):
        tried = best + step * np.arange(-round(reach / step), round(reach / step) + 1)
        values = np.array([fit(one).spread for one in tried])
        best, reach = float(tried[int(np.argmin(values))]), step
    return best, fit(best)


def _with_offset(
    inputs: DriveInputs, offset: float, plain: MotionFit, late: MotionFit
) -> tuple[DriveInputs, tuple[Correction, ...]]:  # fmt: skip
    """Compensate a gross time offset."""
    steady = _steadied(inputs, offset)
    if steady is not None:
        return steady, (clock_correction(steady, inputs),)
    whole = inputs.assumptions.time_offset_s + offset
    found = (
        f"the stamps of the fixes are {_late(offset)}: the samples leave {plain.unexplained:.0%} of their changes of "
        f"velocity unexplained, and {late.unexplained:.0%} with the offset"
    )
    corrected = replace(inputs, assumptions=replace(inputs.assumptions, time_offset_s=whole))
    return corrected, (Correction("time offset", found, f"time_offset: {{offset_s: {whole:.3g}}}"),)


def _steadied(inputs: DriveInputs, offset: float) -> DriveInputs | None:
    """Return the inputs with the clock compensated that the offsets of single windows show; None for a steady one."""
    moved = with_clock(inputs, 0.0, offset)
    tried, windows = moved, windows_of(velocity_pair(moved))
    if windows is None or len(windows.times) < WINDOWS:
        return None
    for reach, step in DRIFTS_S:
        pair, own = velocity_pair(tried), []
        for at in windows_of(pair).times:
            steps = step * np.arange(-round(reach / step), round(reach / step) + 1)
            spread = [DriveWindows((at + one,), windows.span).fit(replace(pair, time=pair.time + one)).spread
                      for one in steps]  # fmt: skip
            own.append((at, float(steps[int(np.argmin(spread))])))
        from scipy.stats import theilslopes  # long import, and few drives get here

        slope, at_zero = theilslopes(*np.array(own)[:, ::-1].T)[:2]
        tried = with_drift(tried, float(slope), float(at_zero + slope * pair.stamp[0]))
    plain, fit = (_fit(velocity_pair(one)) for one in (moved, tried))
    better = fit.unexplained < BETTER * plain.unexplained and fit.gain(plain) > SURE
    return tried if better else None


def _late(offset: float) -> str:
    """Return in words how late stamps are to which ``offset`` has to be added [s]."""
    scales = (f", as of {name}" for leap, name in LEAP_S.items() if abs(abs(offset) - leap) < NEAR_LEAP_S)
    return f"{abs(offset):.2f} s {'late' if offset < 0 else 'early'}{next(scales, '')}"

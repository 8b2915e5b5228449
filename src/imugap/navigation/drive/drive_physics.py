"""Physics of a drive: whether device and receiver see the same motion, before a filter is run.

Over windows with much motion the velocities of the fixes are matched with the samples
(:mod:`imugap.navigation.drive.velocity_matching`). What the samples leave unexplained of the changes of velocity is
small where both belong together, for any vehicle. If it is not, each candidate error is tried: units and signs of the
samples, an order of the columns of the fixes, and a time offset between the clocks. The candidate that explains the
changes is named: a unit, a sign or an order is refused, a time offset is compensated. Where the device points to the
same side of the course in all windows, so does its mounting.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from imugap.log import ACCEL, GYRO
from imugap.navigation.drive.correction import Correction
from imugap.navigation.drive.fix_screening import middle
from imugap.navigation.drive.vehicle import DriveInputs
from imugap.navigation.drive.vehicle_alignment import velocity_pair
from imugap.navigation.drive.velocity_matching import AFTER_S, BEFORE_S, SPAN_S, MatchedAttitude, VelocityPair
from imugap.numerics.rotation import from_euler
from imugap.units import STANDARD_GRAVITY

WINDOWS = 6
"""Number of windows, those with the largest changes of velocity."""
EVERY_S = 10.0
"""Time between the windows to choose from [s]."""
UNEXPLAINED, EXPLAINED = 0.08, 0.15
"""Unexplained share from which on a drive is doubtful, and below which an error is named."""
BETTER = 0.4
"""Largest unexplained share with a named error corrected, as a multiple of that without it."""
SMALLEST_SIGNAL = 1.5
"""Root mean square of the changes of velocity that a comparison needs, as a multiple of their noise."""
SPANS_S = SPAN_S, 2.5
"""Intervals of a change of velocity, the first that stands out of the noise is used [s]."""
LONGEST_OFFSET_S, COARSE_S = 90.0, 0.5
"""Largest time offset that is tried, and the step of the search [s]."""
FINE_S = 0.05, 0.01
"""Steps of the refinement [s]."""
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


@dataclass(frozen=True)
class DriveWindows:
    """Windows of a drive with much motion: their times, and the interval of a change of velocity [s]."""

    times: tuple[float, ...]
    span: float

    def match(self, pair: VelocityPair) -> list[MatchedAttitude]:
        """Return the attitudes by velocity matching in all windows that have one."""
        found = (pair.match(at, self.span) for at in self.times)
        return [one for one in found if one is not None]

    def unexplained(self, pair: VelocityPair, noise: bool = True) -> float:
        """Return the share of the changes of velocity that samples do not explain, nor ``noise``; inf without any."""
        found = self.match(pair)
        if len(found) < max(len(self.times) / 2, 1):
            return np.inf
        rest = sum(max(one.residual * (1 - noise / one.misfit**2), 0.0) for one in found)
        return rest / max(sum(one.change for one in found), 1e-12)


@dataclass(frozen=True)
class _Candidate:
    """What may be wrong with the inputs: a change of the pair that corrects it, and the message that refuses them."""

    change: Callable[[], VelocityPair]
    message: str

    def unexplained(self) -> float:
        """Return the unexplained share of the corrected pair."""
        pair = self.change()
        windows = windows_of(pair)
        return np.inf if windows is None else windows.unexplained(pair)

    def is_needed(self, pair: VelocityPair) -> bool:
        """Return whether the samples leave changes of ``pair`` unexplained where the corrected one shows motion."""
        windows = windows_of(self.change())
        return windows is not None and windows.unexplained(pair) >= UNEXPLAINED


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
    windows = windows_of(pair)
    plain = np.inf if windows is None else windows.unexplained(pair)
    if plain < UNEXPLAINED:
        return inputs, ()
    limit = min(EXPLAINED, BETTER * plain)
    candidates = {one: one.unexplained() for one in _candidates(inputs, pair) if windows or one.is_needed(pair)}
    best = min(candidates, key=candidates.get, default=None)
    offset, rest = (0.0, np.inf) if windows is None else _time_offset(pair, windows)
    if best is not None and candidates[best] < min(limit, rest):
        raise ValueError(best.message)
    return _with_offset(inputs, offset, plain, rest) if rest < limit else (inputs, ())


def with_mounting(inputs: DriveInputs) -> tuple[DriveInputs, tuple[Correction, ...]]:
    """Return the inputs with the device turned to the course, if it points to one side of it, and that."""
    angle = mounting_of(inputs)
    if angle is None:
        return inputs, ()
    turn, columns = from_euler(np.array([0.0, 0.0, angle])), {}
    for triad in (GYRO, ACCEL):
        turned = turn.apply(inputs.log[list(triad)].to_numpy(copy=True))
        columns |= dict(zip(triad, turned.T, strict=True))
    degrees = np.degrees(angle)
    found = f"the device points {abs(degrees):.0f} deg to the {'right' if angle > 0 else 'left'} of the course"
    setting = f"mounting: {{heading_deg: {degrees:.0f}}}, added to the given one"
    return replace(inputs, log=inputs.log.assign(**columns)), (Correction("mounting", found, setting),)


def mounting_of(inputs: DriveInputs) -> float | None:
    """Return the angle of the device right of the course, if it is large and the same in all windows [rad]."""
    pair = velocity_pair(inputs)
    windows = windows_of(pair)
    if windows is None or windows.unexplained(pair) > EXPLAINED:
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
    """Return the errors of units, signs and orders that are tried."""

    def samples(rates: float | np.ndarray = 1.0, forces: float | np.ndarray = 1.0) -> Callable[[], VelocityPair]:
        factors = np.concatenate([np.broadcast_to(rates, 3), np.broadcast_to(forces, 3)])
        return lambda: replace(pair, samples=pair.samples * factors)

    def exchanged() -> VelocityPair:
        return replace(pair, velocity=pair.velocity[:, [1, 0, 2]], std=pair.std[:, [1, 0, 2]])

    def places(latitude: pd.Series, longitude: pd.Series) -> Callable[[], VelocityPair]:
        fixes = inputs.fixes.assign(latitude=latitude, longitude=longitude)
        return lambda: velocity_pair(replace(inputs, fixes=fixes, ellipsoid=middle(fixes)))

    names, flip = ", ".join(GYRO), 1 - 2 * np.eye(3)
    found = [
        _Candidate(samples(rates=np.radians(1)), f"drive: expected {names} in rad/s; found rates 57.3 times those of "
                   "the turns of the fixes, as in deg/s (convert them)"),
        _Candidate(samples(rates=np.degrees(1)), f"drive: expected {names} in rad/s; found rates 57.3 times too small "
                   "for the turns of the fixes (converted twice?)"),
        _Candidate(samples(rates=-1.0), f"drive: expected {names} right-handed about the axes of the accelerometers; "
                   "found the opposite sign of the turns of the fixes"),
        *(_Candidate(samples(rates=flip[k]), f"drive: expected a right-handed {name}; found the opposite sign of the "
                     "turns of the fixes") for k, name in enumerate(GYRO)),
        *(_Candidate(samples(forces=flip[k]), f"drive: expected {ACCEL[k]} along the axis of {GYRO[k]}; found the "
                     "opposite sign of the changes of velocity of the fixes") for k in range(2)),
    ]  # fmt: skip
    order = "in this order; found a motion that turns against the device: the two are exchanged"
    if "vel_n" in inputs.fixes:
        return [*found, _Candidate(exchanged, f"fixes: expected vel_n, vel_e {order}")]
    latitude, longitude = inputs.fixes["latitude"], inputs.fixes["longitude"]
    if longitude.abs().max() < np.pi / 2:
        found.append(_Candidate(places(longitude, latitude), f"fixes: expected latitude, longitude {order}"))
    if latitude.abs().max() < np.radians(np.pi / 2):
        found.append(_Candidate(places(np.degrees(latitude), np.degrees(longitude)), "fixes: expected latitude and "
                              "longitude in degrees; found a motion 57.3 times smaller than that of the device, as in "
                              "radians"))  # fmt: skip
    return found


def _time_offset(pair: VelocityPair, windows: DriveWindows) -> tuple[float, float]:
    """Return what to add to the times of the fixes so that most is explained [s], and the unexplained share then."""

    def rest(offset: float, noise: bool = False) -> float:
        """Move the windows with the fixes, so that the same changes of velocity are explained."""
        own = replace(windows, times=tuple(at + offset for at in windows.times))
        return own.unexplained(replace(pair, time=pair.time + offset), noise)

    best, reach = 0.0, LONGEST_OFFSET_S
    for step in (COARSE_S, *FINE_S):
        tried = best + step * np.arange(-round(reach / step), round(reach / step) + 1)
        values = np.array([rest(one) for one in tried])
        best, reach = float(tried[int(np.argmin(values))]), step
    return best, rest(best, True)


def _with_offset(
    inputs: DriveInputs, offset: float, plain: float, rest: float
) -> tuple[DriveInputs, tuple[Correction, ...]]:  # fmt: skip
    """Compensate a gross time offset."""
    whole = inputs.assumptions.time_offset_s + offset
    scales = (f", as of {name}" for leap, name in LEAP_S.items() if abs(abs(offset) - leap) < NEAR_LEAP_S)
    found = (
        f"the stamps of the fixes are {abs(offset):.2f} s {'late' if offset < 0 else 'early'}{next(scales, '')}: "
        f"the samples leave {plain:.0%} of their changes of velocity unexplained, and {rest:.0%} with the offset"
    )
    corrected = replace(inputs, assumptions=replace(inputs.assumptions, time_offset_s=whole))
    return corrected, (Correction("time offset", found, f"time_offset: {{offset_s: {whole:.3g}}}"),)

"""Errors of a drive that the filter tries: the one that makes the innovations likely is named and corrected.

Each candidate is added to the filter: a time offset, a lever arm (also the given one with the opposite sign) and scale
factors as states, a receiver or a device with more noise than stated. The logarithm of the likelihood of the
innovations, with heavy tails so that no gross error decides, integrates over the state: its gain is a Bayes factor.
The error with the largest gain is corrected, if it is significant and large enough to matter, and the others are tried
again. A receiver that does not state its noise gets it by the same likelihood, with slow errors of its position where
the fixes show them.

Source: R. K. Mehra, On the identification of variances and adaptive Kalman filtering, IEEE Trans. Autom. Control 15
(1970) 175-184 (noise of the receiver by the likelihood of the innovations).
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
import pandas as pd
from scipy.spatial.transform import Rotation
from scipy.special import bdtrc, chdtri

from imugap.effects import WhiteNoise
from imugap.effects.effect import AxisModel
from imugap.filters.innovation_gate import QualityControl
from imugap.log import AXES, TIME
from imugap.model import ErrorModel
from imugap.navigation.drive.clock_rate import clock_correction, with_drift
from imugap.navigation.drive.correction import Correction
from imugap.navigation.drive.vehicle import LEVER_ARM, TIME_OFFSET, DriveInputs, DriveSolution, navigate
from imugap.navigation.drive.vehicle_alignment import align

CONTROL = QualityControl(component=6.0, gated=False, reset_s=None, separation_s=None)
"""Quality control of the trials: components are weighed down, and nothing else."""
CAP = 8.0
"""NIS of a fix, over its degrees of freedom, beyond which the likelihood has heavy tails."""
GAIN, GAIN_SHARE = 20.0, 0.01
"""Smallest gain of the log-likelihood of a correction, and the same per fix."""
ROUNDS = 6
"""Largest number of corrections."""
OFFSET_STD, OFFSET_LEAST = 0.3, 0.01
"""Standard deviation of a candidate time offset, and smallest that is named [s]."""
OFFSET_STEPS = 0.08, 0.02, 0.005
"""Steps in which a time offset is followed to the largest likelihood [s]."""
BOTH_TIMES, POSITION_TIMES, VELOCITY_TIMES = (1, 0), (1, 1), (0, 1)
"""Moves of time offset and delay of the velocities: of all of a fix, of its position alone, of its velocity alone."""
LEVER_STD, LEVER_LEAST, LEVER_SIGMA = 2.0, 0.05, 5.0
"""Standard deviation of a candidate lever arm, smallest change that is named [m], and its significance."""
SCALE_STD, SCALE_LEAST = 0.03, 0.01
"""Standard deviation of candidate scale factors, and smallest that is named."""
NOISE_LIMITS = 0.5, 2.0
"""Range of the noise of a receiver over the stated one that is not named."""
NOISE_STEPS, NOISE_GAIN = (4.0, 2.0, 2**0.5), 3.0
"""Steps of a factor, and smallest gain of the log-likelihood of a step."""
SMALLEST_FACTOR, LARGEST_FACTOR = 0.05, 100.0
"""Limits of the factor on a standard deviation of a receiver."""
SLOW_STD, SLOW_STEPS = (1.5, 1.5, 3.0), (4.0, 2.0)
"""Standard deviations of slow errors of a position from which their fit starts [m], and steps of its factors."""
SLOW_S, SLOW_CORRELATION = 1.0, 0.3
"""Lag [s], and correlation of the fixes off the smoothed path from which on their errors are slow."""
DEVICE_NOISE = "device noise"
"""Name of the error that stands for any other, which keeps the path near the fixes."""
DEVICE_FACTORS, DEVICE_STEP = (3.0, 10.0, 30.0), 10**0.25
"""Factors on the white noise of a device that are tried, and half a step of them."""
GROUPS = (0, 1), (2,), (3, 4), (5,)
"""Components of a fix that share a factor: position across and down, velocity across and down."""
FACTOR_KEYS = "horizontal_factor", "vertical_factor", "horizontal_velocity_factor", "vertical_velocity_factor"
"""Keys of a configuration for the factor of each of them."""
CLOCK_PARTS, CLOCK_SIGMA = 4, 5.0
"""Parts of a drive of which each gets a time offset of its own, and significance of a clock rate that is named."""
CHANCE = 1e-6
"""Probability of as many failing fixes below which they are not chance."""
FAILING, LARGEST_NIS = 0.05, 1.6
"""Share of failing fixes, and capped NIS over its degrees of freedom, above which a filter does not fit."""


@dataclass(frozen=True)
class InnovationFit:
    """Fit of a filter to its fixes.

    Attributes
    ----------
    nis
        Mean NIS over its degrees of freedom, each capped at :data:`CAP`; 1 for a consistent filter.
    failing
        Share of fixes that fail the global test.
    likelihood
        Logarithm of the likelihood of the innovations, with heavy tails beyond the cap.
    chance
        Probability of as many failing fixes for a consistent filter.
    """

    nis: float
    failing: float
    likelihood: float
    chance: float = 1.0

    @classmethod
    def of(cls, solution: DriveSolution) -> "InnovationFit":
        """Return the fit of a solution."""
        record = solution.record
        used = record.freedom > 0
        statistic, freedom = record.statistic[used], record.freedom[used]
        most = CAP * freedom
        capped = np.minimum(statistic, most)
        tailed = capped + most * np.log(np.maximum(statistic / most, 1.0))
        failing = int(np.sum(statistic > chdtri(freedom, CONTROL.false_alarm)))
        return cls(
            float(capped.sum() / freedom.sum()), failing / len(freedom),
            float(-0.5 * np.sum(tailed + record.log_det[used])),
            float(bdtrc(failing - 1, len(freedom), CONTROL.false_alarm)) if failing else 1.0,
        )  # fmt: skip

    @property
    def fits(self) -> bool:
        """Whether innovations are as large as the filter expects."""
        return self.nis < LARGEST_NIS and self.failing < FAILING

    @property
    def sound(self) -> bool:
        """Whether no more fixes fail than may be chance."""
        return self.fits and self.chance > CHANCE


def solve(inputs: DriveInputs, smooth: bool = False) -> DriveSolution:
    """Align and navigate a drive with the control of the trials."""
    inputs = replace(inputs, quality=CONTROL)
    return navigate(inputs, align(inputs), smooth)


def correct(inputs: DriveInputs, stated: bool) -> tuple[DriveInputs, tuple[Correction, ...]]:
    """Return the inputs with the errors corrected that the innovations show, and these.

    Parameters
    ----------
    stated
        Whether the noise of the receiver is stated; if not, it is estimated without a word.
    """
    corrections, model, factors = [], inputs.model, inputs.assumptions.std_factors
    if not stated:
        inputs = with_estimated_noise(inputs)
    while len(corrections) < ROUNDS:
        base = InnovationFit.of(solve(inputs))
        least = max(GAIN, GAIN_SHARE * len(inputs.fixes))
        best, gained = None, least
        for tried, found in _candidates(inputs, base, stated, [one.error for one in corrections]):
            gain = InnovationFit.of(solve(tried)).likelihood - base.likelihood
            if gain > gained:
                best, gained = (tried, found), gain
        if best is None:
            break
        inputs = best[0]
        if not stated:
            plain = replace(inputs.assumptions, std_factors=factors)
            inputs = with_estimated_noise(replace(inputs, assumptions=plain))
        corrections.append(best[1])
        if best[1].error != DEVICE_NOISE:
            inputs, corrections = _with_noise_anew(inputs, corrections, model)
    return inputs, tuple(corrections)


def _with_noise_anew(
    inputs: DriveInputs, corrections: list[Correction], model: ErrorModel
) -> tuple[DriveInputs, list[Correction]]:
    """Return inputs and corrections with the likeliest noise of the device over that of a model, if more was named.

    Before it stood for what has been corrected since as well.
    """
    named = [one.error for one in corrections]
    if DEVICE_NOISE not in named:
        return inputs, corrections
    plain, place = replace(inputs, model=model), named.index(DEVICE_NOISE)
    tried = [(plain, ()), *((one, (found,)) for one, found in _device_noise(plain))]
    best, found = max(tried, key=lambda one: _likelihood(one[0]))
    return best, [*corrections[:place], *found, *corrections[place + 1 :]]


def _candidates(
    inputs: DriveInputs, base: InnovationFit, stated: bool, named: list[str]
) -> Iterator[tuple[DriveInputs, Correction]]:  # fmt: skip
    """Yield the inputs with each candidate corrected that is large enough to matter, and the correction."""
    assumptions = inputs.assumptions
    if "time offset" not in named and assumptions.time_offset_std == 0:
        yield from _time_offset(inputs)
    if "lever arm" not in named and assumptions.lever_std == 0:
        yield from _lever_arm(inputs)
    if not {"clock rate", "unsteady clock"} & set(named):
        yield from _clock_rate(inputs)
    if stated and not {"slow errors", "receiver noise"} & set(named) and not any(assumptions.slow_position_std):
        yield from _slow_receiver(inputs)
    if "scale factor" not in named and not base.sound:
        yield from _scale_factor(inputs)
    if base.fits:
        return
    if stated and "receiver noise" not in named:
        yield from _receiver_noise(inputs)
    if DEVICE_NOISE not in named:
        yield from _device_noise(inputs)


def _time_offset(inputs: DriveInputs) -> Iterator[tuple[DriveInputs, Correction]]:
    """Estimate a time offset, twice, for the second estimate is nearer to where the equations are linear.

    Other states take a part of a large one. So it is followed to the largest likelihood besides, and with it the delay
    of the velocities, which are late by another time than the positions.
    """
    tried = replace(inputs, assumptions=replace(inputs.assumptions, time_offset_std=OFFSET_STD))
    for _ in range(2):
        one = solve(tried)
        moved = tried.assumptions.time_offset_s + float(one.sensors[TIME_OFFSET].iloc[-1])
        tried = replace(tried, assumptions=replace(tried.assumptions, time_offset_s=moved))
    known = inputs.assumptions
    offset, delay = (round(one, 3) for one in _likeliest_times(inputs, (moved, known.velocity_delay_s)))
    tried = with_times(inputs, offset, delay)
    tried = replace(tried, assumptions=replace(tried.assumptions, time_offset_std=OFFSET_STD))
    found, setting = [], f"time_offset: {{offset_s: {offset:.3f}, std_s: {OFFSET_STD}}}"
    if abs(offset - known.time_offset_s) > OFFSET_LEAST:
        found.append(f"the stamps of the fixes are {_late(known.time_offset_s - offset)}")
    if abs(delay - known.velocity_delay_s) > OFFSET_LEAST:
        found.append(f"their velocities are {_late(delay)} against the positions")
        setting = f"{{{setting}, receiver: {{velocity_delay_s: {delay:.3f}}}}}"
    if found:
        yield tried, Correction("time offset", ", and ".join(found), setting)


def _late(seconds: float) -> str:
    """Return in words by how much stamps are late [s]."""
    return f"{abs(seconds):.3f} s {'late' if seconds > 0 else 'early'}"


def with_times(inputs: DriveInputs, offset: float, delay: float) -> DriveInputs:
    """Return the inputs with a time offset of the fixes, and a delay of their velocities [s]."""
    known = replace(inputs.assumptions, time_offset_s=float(offset), velocity_delay_s=float(delay))
    return replace(inputs, assumptions=known)


def _likeliest_times(inputs: DriveInputs, times: tuple[float, float]) -> tuple[float, float]:
    """Return time offset and delay of the velocities [s] near given ones at which the innovations are most likely.

    Both are moved together first; the delay by itself only as far as it gains what a correction has to.
    """
    best = _followed(inputs, times, (BOTH_TIMES,))
    if not inputs.measured.with_velocity.any():
        return best
    apart = _followed(inputs, best, (BOTH_TIMES, POSITION_TIMES, VELOCITY_TIMES))
    gain = np.subtract(*(_likelihood(with_times(inputs, *one)) for one in (apart, best)))
    return apart if gain > GAIN else best


def _followed(
    inputs: DriveInputs, times: tuple[float, float], ways: tuple[tuple[int, int], ...]
) -> tuple[float, float]:  # fmt: skip
    """Return time offset and delay [s], moved from given ones along some ways while the likelihood increases."""
    best, reached = np.array(times), _likelihood(with_times(inputs, *times))
    for step in OFFSET_STEPS:
        moves = [sign * step * np.array(way) for way in ways for sign in (1, -1)]
        untried = list(moves)
        while untried:
            move = untried.pop(0)
            found = _likelihood(with_times(inputs, *(best + move)))
            if found > reached + NOISE_GAIN:
                best, reached = best + move, found
                untried = [move, *(one for one in moves if not np.allclose(one, move) and not np.allclose(one, -move))]
    return float(best[0]), float(best[1])


def _clock_rate(inputs: DriveInputs) -> Iterator[tuple[DriveInputs, Correction]]:
    """Estimate how fast the clock of the device goes, by the time offsets of parts of a drive.

    Offsets on a line are those of a clock. Others change where samples or fixes were lost from the count of a clock;
    following them between the middles of the parts bears with that, but does not explain it.
    """
    time = inputs.fixes.index.to_numpy(dtype=float)
    parts = np.array_split(np.arange(len(time)), CLOCK_PARTS)
    found = [(time[part].mean(), *_offset_of(replace(inputs, fixes=inputs.fixes.iloc[part]))) for part in parts]
    known = [one for one in found if np.isfinite(one[1])]
    if len(known) < 2:
        return
    middle, offset, std = np.array(known).T
    begin, change = inputs.log.index[0] - inputs.assumptions.time_offset_s, float(np.ptp(offset))
    (drift, first), covariance = np.polyfit(middle - begin, offset, 1, w=1 / std, cov="unscaled")
    off_line = float(np.sum(((offset - first - drift * (middle - begin)) / std) ** 2))
    if change < OFFSET_LEAST:
        return
    if len(middle) > 2 and off_line > chdtri(len(middle) - 2, CHANCE):
        stamps = pd.Index(time + np.interp(time, middle, offset), name=TIME)
        words = (
            f"the time offset of the fixes changes by {change:.2f} s, not evenly (lost samples, a clock that was set?)"
        )
        tried = replace(inputs, fixes=inputs.fixes.set_axis(stamps))
        yield tried, Correction("unsteady clock", words, "stamps of the fixes moved", explains=False)
    elif abs(drift) > CLOCK_SIGMA * np.sqrt(covariance[0, 0]):
        tried = with_drift(inputs, float(drift), float(first))
        yield tried, clock_correction(tried, inputs)


def _offset_of(inputs: DriveInputs) -> tuple[float, float]:
    """Return the time offset of the fixes beyond the assumed one, and its standard deviation [s]; NaN without one."""
    try:
        one = solve(replace(inputs, assumptions=replace(inputs.assumptions, time_offset_std=OFFSET_STD)))
    except ValueError:
        return np.nan, np.nan
    return float(one.sensors[TIME_OFFSET].iloc[-1]), float(one.sensors_std[TIME_OFFSET].iloc[-1])


def _lever_arm(inputs: DriveInputs) -> Iterator[tuple[DriveInputs, Correction]]:
    """Estimate a lever arm."""
    assumptions = inputs.assumptions
    tried = replace(inputs, assumptions=replace(assumptions, lever_std=LEVER_STD))
    one = solve(tried)
    change = one.sensors[list(LEVER_ARM)].iloc[-1].to_numpy()
    std = one.sensors_std[list(LEVER_ARM)].iloc[-1].to_numpy()
    seen = (np.abs(change) > LEVER_SIGMA * std) & (np.abs(change) > LEVER_LEAST)
    if not seen.any():
        return
    given, known = np.array(assumptions.lever_m), std < 0.5 * LEVER_STD
    arm = np.where(known, given + change, given)
    turned = bool(np.any(given[seen] != 0)) and np.allclose(arm[seen], -given[seen], rtol=0.2, atol=0.1)
    arm = np.round(np.where(turned & ~known, -given, arm), 3)
    assumptions = replace(assumptions, lever_m=tuple(map(float, arm)), lever_std=LEVER_STD)
    shown = ", ".join(f"{name}_m: {value:.3g}" for name, value in zip("xyz", arm, strict=True))
    what = "the lever arm has the opposite sign (from the antenna to the device)" if turned else (
        f"the antenna is {np.linalg.norm(change[seen]):.2g} m away from where the lever arm has it"
    )  # fmt: skip
    yield replace(inputs, assumptions=assumptions), Correction("lever arm", what, f"lever_arm: {{{shown}}}")


def _receiver_noise(inputs: DriveInputs) -> Iterator[tuple[DriveInputs, Correction]]:
    """Estimate the noise of the receiver by the innovations."""
    factors = noise_factors(inputs)
    if min(factors) < NOISE_LIMITS[0] or max(factors) > NOISE_LIMITS[1]:
        tried = with_noise(inputs, factors)
        found = (
            f"the noise of the receiver is {factors[0]:.2g} and {factors[1]:.2g} times the stated one of positions, "
            f"{factors[2]:.2g} and {factors[3]:.2g} times that of velocities (horizontal, vertical)"
        )
        yield tried, Correction("receiver noise", found, f"receiver: {{{_factors_text(tried)}}}")


def _factors_text(inputs: DriveInputs) -> str:
    """Return the factors on the standard deviations of the fixes, by the keys of a configuration."""
    pairs = zip(FACTOR_KEYS, inputs.assumptions.std_factors, strict=True)
    return ", ".join(f"{name}: {factor:.2g}" for name, factor in pairs)


def _slow_receiver(inputs: DriveInputs) -> Iterator[tuple[DriveInputs, Correction]]:
    """Estimate slow errors of the positions of a receiver that states its noise."""
    if not _slow_errors(inputs):
        return
    tried = _with_slow_errors(inputs)
    known = tried.assumptions
    across, _, down = known.slow_position_std
    found = (
        f"the errors of the positions last for seconds: {across:.2g} m horizontally and {down:.2g} m vertically over "
        f"some {known.slow_position_s:.2g} s"
    )
    setting = (
        f"receiver: {{{_factors_text(tried)}, slow_horizontal_m: {across:.2g}, slow_vertical_m: {down:.2g}, "
        f"slow_s: {known.slow_position_s:.2g}}}"
    )
    yield tried, Correction("slow errors", found, setting)


def _scale_factor(inputs: DriveInputs) -> Iterator[tuple[DriveInputs, Correction]]:
    """Estimate scale factors."""
    tried = replace(inputs, assumptions=replace(inputs.assumptions, scale_std=(SCALE_STD, SCALE_STD)))
    one = solve(tried)
    names = [name for name in one.names if name.endswith("_scale")]
    last = one.sensors[names].iloc[-1]
    seen = last[(last.abs() > SCALE_LEAST) & (last.abs() > LEVER_SIGMA * one.sensors_std[names].iloc[-1])]
    if len(seen):
        found = "scale factors of " + ", ".join(
            f"{name.removesuffix('_scale')} {one:+.1%}" for name, one in seen.items()
        )
        yield (
            tried,
            Correction("scale factor", found, f"scale_factor: {{gyro_std: {SCALE_STD}, accel_std: {SCALE_STD}}}"),
        )


def _device_noise(inputs: DriveInputs) -> Iterator[tuple[DriveInputs, Correction]]:
    """Multiply the white noise of the device, as of vibration, which its samples then show; else nothing is explained.

    Noise in place of any other error of the device keeps the path near the fixes.
    """
    shown = _noise_ratio(inputs)
    for factor in DEVICE_FACTORS:
        model = ErrorModel({
            axis: AxisModel(tuple(
                replace(one, density=factor * one.density) if isinstance(one, WhiteNoise) else one for one in own
            ))
            for axis, own in inputs.model.axes.items()
        })  # fmt: skip
        tried, setting = replace(inputs, model=model), "model: model.yaml"
        if shown > factor / DEVICE_STEP:
            found = f"the device has some {factor:g} times the white noise of its model, as under vibration"
            yield tried, Correction(DEVICE_NOISE, found, setting)
        else:
            found = (
                f"the device errs as by {factor:g} times the white noise of its model, which its samples do not show "
                "(a device that was turned in its mounting, a bias that stepped, axes or scales that are wrong?)"
            )
            yield tried, Correction(DEVICE_NOISE, found, setting, explains=False)


def _noise_ratio(inputs: DriveInputs) -> float:
    """Return the white noise of the samples over that of the model, of the axis with the largest ratio.

    That of the samples is of their second differences in the median second, which the motion of a vehicle leaves small.
    """
    steps, log = np.diff(inputs.log.index.to_numpy()), inputs.log
    differences = log.diff().diff().iloc[2:]
    seconds = np.floor(differences.index.to_numpy() - log.index[0])
    density = np.sqrt((differences**2).groupby(seconds).mean().median() / 6 * np.median(steps))
    white = inputs.assumptions.states(inputs.model).white
    return float(np.max(density[list(AXES)].to_numpy() / np.sqrt(np.maximum(white, 1e-30))))


def with_noise(inputs: DriveInputs, factors: tuple[float, ...]) -> DriveInputs:
    """Return the inputs with the standard deviations of the fixes multiplied, a factor for each of :data:`GROUPS`."""
    known = inputs.assumptions
    product_of = tuple(float(one * other) for one, other in zip(known.std_factors, factors, strict=True))
    return replace(inputs, assumptions=replace(known, std_factors=product_of))


def noise_factors(inputs: DriveInputs) -> tuple[float, ...]:
    """Return the noise of the receiver over the stated one, for each of :data:`GROUPS`, by maximum likelihood."""
    return _most_likely(inputs, with_noise, _seen_groups(inputs), NOISE_STEPS)


def with_receiver(inputs: DriveInputs, factors: tuple[float, ...]) -> DriveInputs:
    """Return the inputs with noise and slow errors of the receiver multiplied.

    Parameters
    ----------
    factors
        Those of :func:`with_noise`, then those on the slow errors across and down, and on their correlation time.
    """
    known = inputs.assumptions
    *noise, across, down, longer = factors
    slow = tuple(float(one) for one in np.array(known.slow_position_std) * (across, across, down))
    assumptions = replace(known, slow_position_std=slow, slow_position_s=known.slow_position_s * longer)
    return with_noise(replace(inputs, assumptions=assumptions), tuple(noise))


def _seen_groups(inputs: DriveInputs) -> list[int]:
    """Return the numbers of the :data:`GROUPS` that the fixes have."""
    seen = np.isfinite(inputs.measured.seen).any(axis=0)
    return [k for k, group in enumerate(GROUPS) if seen[list(group)].any()]


def _most_likely(
    inputs: DriveInputs,
    change: Callable[[DriveInputs, tuple[float, ...]], DriveInputs],
    free: list[int],
    steps: tuple[float, ...],
) -> tuple[float, ...]:
    """Return the factors by which ``change`` makes the innovations most likely; those that are not ``free`` are 1.

    Each factor in turn is multiplied or divided while the likelihood increases, then by smaller steps.
    """
    factors = np.ones(max(len(GROUPS), max(free) + 1))
    best = _likelihood(change(inputs, tuple(factors)))
    for step in steps:
        moved = True
        while moved:
            moved = False
            for k, ratio in product(free, (step, 1 / step)):
                while SMALLEST_FACTOR <= factors[k] * ratio <= LARGEST_FACTOR:
                    tried = factors * np.where(np.arange(len(factors)) == k, ratio, 1.0)
                    found = _likelihood(change(inputs, tuple(tried)))
                    if found <= best + NOISE_GAIN:
                        break
                    factors, best, moved = tried, found, True
    return tuple(map(float, factors))


def _likelihood(inputs: DriveInputs) -> float:
    """Return the likelihood of the innovations; -inf where no drive starts with these inputs."""
    try:
        return InnovationFit.of(solve(inputs)).likelihood
    except ValueError:
        return -np.inf


def with_estimated_noise(inputs: DriveInputs) -> DriveInputs:
    """Return the inputs with the noise of the receiver by the innovations.

    Where the fixes stay to one side of the smoothed path for seconds, their position has slow errors besides, which are
    states of the filter; solution separation, which takes them for faults, is left out then.
    """
    return _with_slow_errors(inputs) if _slow_errors(inputs) else with_noise(inputs, noise_factors(inputs))


def _with_slow_errors(inputs: DriveInputs) -> DriveInputs:
    """Return the inputs with noise and slow errors of the positions by the innovations."""
    if not any(inputs.assumptions.slow_position_std):
        inputs = replace(inputs, assumptions=replace(inputs.assumptions, slow_position_std=SLOW_STD))
    inputs = replace(inputs, quality=replace(inputs.quality, separation_s=None))
    free = [*_seen_groups(inputs), *range(len(GROUPS), len(GROUPS) + 3)]
    return with_receiver(inputs, _most_likely(inputs, with_receiver, free, SLOW_STEPS))


def _slow_errors(inputs: DriveInputs) -> bool:
    """Return whether fixes are off the smoothed path to the same side a second later, in both halves of a drive.

    Of a normal process the arcsine law tells the correlation; an offset of some fixes does not count. Where no path is
    known, it is not seen.
    """
    try:
        one = solve(inputs, smooth=True)
    except ValueError:  # no path is known, as over an outage with far too little noise
        return False
    off = off_path(inputs, one)[:, :2]
    lag = max(round(SLOW_S / float(np.median(np.diff(one.fix_time)))), 1)
    alike = (np.sign(off[lag:]) * np.sign(off[:-lag])).mean(axis=1)
    halves = np.array_split(alike, 2)
    return bool(min(half.mean() for half in halves) > 2 / np.pi * np.arcsin(SLOW_CORRELATION))


def off_path(inputs: DriveInputs, one: DriveSolution) -> np.ndarray:
    """Return the positions of the fixes of a solution less those of the antenna by it, shape (fixes, 3) [m]."""
    navigation = one.history.navigation[one.fix_row]
    rows = np.searchsorted(inputs.fixes.index.to_numpy(), one.fix_time)
    antenna = navigation[:, :3] + Rotation.from_quat(navigation[:, 6:]).apply(np.array(inputs.assumptions.lever_m))
    return inputs.measured.seen[rows, :3] - antenna

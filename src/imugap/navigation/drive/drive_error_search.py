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
from scipy.spatial.transform import Rotation
from scipy.special import chdtri

from imugap.effects import WhiteNoise
from imugap.effects.effect import AxisModel
from imugap.filters.innovation_gate import QualityControl
from imugap.io import gnss
from imugap.io.gnss import PLACE_STD, VELOCITY_STD
from imugap.model import ErrorModel
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
CLIP_SIGMA = 4.0
"""Limit of an innovation in the estimate of the noise, in its standard deviations."""
DEVICE_FACTORS = 3.0, 10.0, 30.0
"""Factors on the white noise of a device that are tried."""
GROUPS = (0, 1), (2,), (3, 4), (5,)
"""Components of a fix that share a factor: position across and down, velocity across and down."""
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
    """

    nis: float
    failing: float
    likelihood: float

    @classmethod
    def of(cls, solution: DriveSolution) -> "InnovationFit":
        """Return the fit of a solution."""
        record = solution.record
        used = record.freedom > 0
        statistic, freedom = record.statistic[used], record.freedom[used]
        most = CAP * freedom
        capped = np.minimum(statistic, most)
        tailed = capped + most * np.log(np.maximum(statistic / most, 1.0))
        limit = chdtri(freedom, CONTROL.false_alarm)
        return cls(
            float(capped.sum() / freedom.sum()), float(np.mean(statistic > limit)),
            float(-0.5 * np.sum(tailed + record.log_det[used])),
        )  # fmt: skip

    @property
    def fits(self) -> bool:
        """Whether innovations are as large as the filter expects."""
        return self.nis < LARGEST_NIS and self.failing < FAILING


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
    corrections, fixes = [], inputs.fixes
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
        inputs = best[0] if stated else with_estimated_noise(replace(best[0], fixes=fixes))
        corrections.append(best[1])
    return inputs, tuple(corrections)


def _candidates(
    inputs: DriveInputs, base: InnovationFit, stated: bool, named: list[str]
) -> Iterator[tuple[DriveInputs, Correction]]:  # fmt: skip
    """Yield the inputs with each candidate corrected that is large enough to matter, and the correction."""
    assumptions = inputs.assumptions
    if "time offset" not in named and assumptions.time_offset_std == 0:
        yield from _time_offset(inputs)
    if "lever arm" not in named and assumptions.lever_std == 0:
        yield from _lever_arm(inputs)
    if base.fits:
        return
    if stated and "receiver noise" not in named:
        yield from _receiver_noise(inputs)
    if "scale factor" not in named:
        yield from _scale_factor(inputs)
    if "device noise" not in named:
        yield from _device_noise(inputs)


def _time_offset(inputs: DriveInputs) -> Iterator[tuple[DriveInputs, Correction]]:
    """Estimate a time offset, twice, for the second estimate is nearer to where the equations are linear."""
    tried = replace(inputs, assumptions=replace(inputs.assumptions, time_offset_std=OFFSET_STD))
    for _ in range(2):
        one = solve(tried)
        moved = tried.assumptions.time_offset_s + float(one.sensors[TIME_OFFSET].iloc[-1])
        tried = replace(tried, assumptions=replace(tried.assumptions, time_offset_s=moved))
    moved = float(np.round(moved, 4))
    tried = replace(tried, assumptions=replace(tried.assumptions, time_offset_s=moved, time_offset_std=OFFSET_STD))
    change = moved - inputs.assumptions.time_offset_s
    if abs(change) > OFFSET_LEAST:
        found = f"the stamps of the fixes are {abs(change):.3f} s {'late' if change < 0 else 'early'}"
        yield tried, Correction("time offset", found, f"time_offset: {{offset_s: {moved:.3f}}}")


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
        std = np.median(deviations(tried), axis=0)
        found = (
            f"the noise of the receiver is {factors[0]:.2g} and {factors[1]:.2g} times the stated one of positions, "
            f"{factors[2]:.2g} and {factors[3]:.2g} times that of velocities (horizontal, vertical)"
        )
        setting = (
            f"receiver: {{horizontal_m: {std[0]:.2g}, vertical_m: {std[2]:.2g}, horizontal_m_per_s: {std[3]:.2g}, "
            f"vertical_m_per_s: {std[5]:.2g}}}"
        )
        yield tried, Correction("receiver noise", found, setting)


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
    """Multiply the white noise of the device, as of vibration."""
    for factor in DEVICE_FACTORS:
        model = ErrorModel({
            axis: AxisModel(tuple(
                replace(one, density=factor * one.density) if isinstance(one, WhiteNoise) else one for one in own
            ))
            for axis, own in inputs.model.axes.items()
        })  # fmt: skip
        found = f"the device has some {factor:g} times the white noise of its model, as under vibration"
        yield replace(inputs, model=model), Correction("device noise", found, "model: a file with more white noise")


def deviations(inputs: DriveInputs) -> np.ndarray:
    """Return the standard deviations of the components of the fixes, shape (n, 6)."""
    return gnss.deviations(inputs.fixes, inputs.assumptions.position_std, inputs.assumptions.velocity_std)


def with_noise(inputs: DriveInputs, factors: tuple[float, ...]) -> DriveInputs:
    """Return the inputs with the standard deviations of the fixes multiplied, a factor for each of :data:`GROUPS`."""
    std = deviations(inputs)
    for group, factor in zip(GROUPS, factors, strict=True):
        std[:, list(group)] *= factor
    columns = dict(zip((*PLACE_STD, *VELOCITY_STD), std.T, strict=True))
    return replace(inputs, fixes=inputs.fixes.assign(**columns))


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
    seen = np.isfinite(gnss.local(inputs.fixes, inputs.ellipsoid)).any(axis=0)
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
    if not _slow_errors(inputs):
        return with_noise(inputs, noise_factors(inputs))
    if not any(inputs.assumptions.slow_position_std):
        inputs = replace(inputs, assumptions=replace(inputs.assumptions, slow_position_std=SLOW_STD))
    inputs = replace(inputs, quality=replace(inputs.quality, separation_s=None))
    free = [*_seen_groups(inputs), *range(len(GROUPS), len(GROUPS) + 3)]
    return with_receiver(inputs, _most_likely(inputs, with_receiver, free, SLOW_STEPS))


def _slow_errors(inputs: DriveInputs) -> bool:
    """Return whether the fixes are off the smoothed path in the same way a second later."""
    one = solve(inputs, smooth=True)
    navigation = one.history.navigation[one.fix_row]
    rows = np.searchsorted(inputs.fixes.index.to_numpy(), one.fix_time)
    antenna = navigation[:, :3] + Rotation.from_quat(navigation[:, 6:]).apply(np.array(inputs.assumptions.lever_m))
    off = (gnss.local(inputs.fixes, inputs.ellipsoid)[rows, :3] - antenna)[:, :2]
    lag = max(round(SLOW_S / float(np.median(np.diff(one.fix_time)))), 1)
    off = np.clip(off, *(sign * CLIP_SIGMA * np.median(np.abs(off), axis=0) for sign in (-1, 1)))
    return bool(np.sum(off[lag:] * off[:-lag]) > SLOW_CORRELATION * np.sum(off**2))

"""Quality control of a Kalman filter's measurements: tests of the innovations, and the response to a failure.

Per epoch, with the innovation ``r`` of ``m`` components and its covariance ``S = H P H' + R``:

component test
    ``|r_i| > c sqrt(S_ii)`` removes the component with its rows of H and R, or reduces its weight: R_ii is multiplied
    by ``(|r_i|/(c sqrt(S_ii)))^(2 k)``, which is 1 at the limit (equivalent weights: Yang et al. 2001). From ``k = 1``
    on the correction by such a component falls as it gets larger.
global test
    ``r' S^-1 r``, chi-square with m degrees of freedom, fails above the quantile of the false-alarm rate. It uses all
    components as received: after removal it would not be chi-square, and after weighting it would hardly ever fail.
gated feedback
    Where the global test fails the navigation is corrected, but the sensor errors keep their estimates: their rows of
    the gain are zero. The covariance is that of this gain (Joseph form), as for consider states (Schmidt 1966).
soft reset
    Where no epoch was trusted for longer than a set time, because the global test failed or an offset was open, the
    covariance is inflated. Estimates are kept, except those of sensor errors out of proportion, which restart, and the
    offset, which is dropped.
solution separation
    Not in the source: lasting position errors are a state (:mod:`imugap.filters.solution_separation`).

Source: a patent text, "IMU random error online estimation and compensation" (2022), which does not define the place of
the global test, nor whether the gain or the estimate is held. Y. Yang, H. He, G. Xu, Adaptively robust filtering for
kinematic geodetic positioning, J. Geod. 75 (2001) 109-116; S. F. Schmidt, Application of state-space methods to
navigation problems, Adv. Control Syst. 3 (1966) 293-340.
"""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import pandas as pd
from scipy.special import chdtri

from imugap.numerics.rotation import kernel

RESET_SIGMA = 5.0
"""Limit of a sensor-error estimate at a soft reset, in its initial standard deviations; beyond it restarts at zero."""
REMOVED, WEIGHED, FAILED, RESET = "removed", "weighed down", "global test failed", "soft reset"
SET_ASIDE, OPENED, SEPARATED, CLOSED = "set aside", "offset opened", "offset opened by separation", "offset closed"
"""Names of events."""
ACCEPTED, EXCLUDED, RESTARTED, HELD = range(4)
"""Use of a position: accepted, excluded, first one of a new offset, used with the present offset."""
OFFSET_STATES = 3
"""Number of states of the position offset."""
OFFSET_EVENTS = ("", OPENED, SEPARATED, CLOSED)
"""Event of the offset at a fix, by number."""


@dataclass(frozen=True)
class QualityControl:
    """Settings of the quality control; each part can be switched off.

    Attributes
    ----------
    component
        Limit ``c`` of the component test, or None. Normal innovations pass with 95 % for 2, with 99.73 % for 3.
    robust
        Whether a failing component is weighted down instead of removed.
    steepness
        Exponent ``k`` of the weighting.
    false_alarm
        False-alarm probability of the global test.
    gated
        Whether sensor errors are fed back only where the global test passes.
    reset_s
        Time without a trusted fix after which a soft reset follows [s], or None; longer than any gross error that the
        filter has to bridge.
    reset_std
        Least increase of the standard deviations of position [m], velocity [m/s] and attitude [rad] at a soft reset;
        position and velocity get the innovation where it is larger. Sensor errors get their initial variance.
    separation_s
        Age of the oldest sub-filter of the solution separation (:mod:`imugap.filters.solution_separation`) [s], or None
        for no separation and no offset. Its tests have the false-alarm rate of the global test, or its square.
    """

    component: float | None = 3.0
    robust: bool = True
    steepness: float = 2.0
    false_alarm: float = 1e-3
    gated: bool = True
    reset_s: float | None = 90.0
    reset_std: tuple[float, float, float] = (30.0, 1.0, 0.05)
    separation_s: float | None = 30.0

    def __post_init__(self) -> None:
        """Check the settings."""
        if self.component is not None and not self.component > 0:
            raise ValueError(f"component: expected a number > 0 or none; found {self.component}")
        if not self.steepness > 0:
            raise ValueError(f"steepness: expected a number > 0; found {self.steepness}")
        if not 0 < self.false_alarm < 1:
            raise ValueError(f"false_alarm: expected a probability between 0 and 1; found {self.false_alarm}")
        if self.reset_s is not None and not self.reset_s > 0:
            raise ValueError(f"reset_s: expected a time > 0 [s] or none; found {self.reset_s}")
        if self.separation_s is not None and not self.separation_s > 0:
            raise ValueError(f"separation_s: expected a time > 0 [s] or none; found {self.separation_s}")
        if len(self.reset_std) != 3 or min(self.reset_std) < 0:
            raise ValueError(f"reset_std: expected 3 numbers >= 0; found {self.reset_std}")

    def limits(self, components: int) -> np.ndarray:
        """Return the limits of the global test for 0 to ``components`` degrees of freedom."""
        return np.array([np.inf, *chdtri(np.arange(1, components + 1), self.false_alarm)])

    @property
    def separation_limit(self) -> float:
        """Limit of the tests that open an offset by separation, or close one: at the square of the false-alarm rate."""
        return float(chdtri(OFFSET_STATES, self.false_alarm**2))


NO_CONTROL = QualityControl(component=None, gated=False, reset_s=None, separation_s=None)
SCHEMES = {
    "none": NO_CONTROL,
    "gate": replace(NO_CONTROL, gated=True),
    "remove": replace(NO_CONTROL, component=3.0, robust=False),
    "robust": replace(NO_CONTROL, component=3.0),
    "gated": replace(NO_CONTROL, component=3.0, gated=True),
    "reset": QualityControl(separation_s=None),
    "separation": QualityControl(),
}
"""No control; gated feedback alone; removal; weighting; weighting with gated feedback; soft reset, as in the source;
solution separation."""


class KernelControl(NamedTuple):
    """A :class:`QualityControl` for compiled code; a part that is switched off has an infinite limit."""

    component: float
    robust: bool
    steepness: float
    limits: np.ndarray
    gated: bool
    reset_s: float
    reset_std: tuple[float, float, float]
    separation_s: float
    separation_limit: float

    @classmethod
    def of(cls, quality: QualityControl, components: int) -> "KernelControl":
        """Convert a quality control for measurements of ``components`` components."""
        return cls(
            np.inf if quality.component is None else float(quality.component),
            quality.robust,
            float(quality.steepness),
            quality.limits(components),
            quality.gated,
            np.inf if quality.reset_s is None else float(quality.reset_s),
            tuple(map(float, quality.reset_std)),
            np.inf if quality.separation_s is None else float(quality.separation_s),
            quality.separation_limit,
        )


@kernel
def noise_after_test(innovation, variance, noise, component, robust, steepness):
    """Return the noise variance of a component after the component test; infinite for a removed one.

    Parameters
    ----------
    innovation, variance, noise
        r_i, S_ii and R_ii.
    component, robust, steepness
        As in :class:`QualityControl`; ``component`` may be infinite.
    """
    square = innovation * innovation
    if square <= component * component * variance:
        return noise
    return noise * (square / (component * component * variance)) ** steepness if robust else np.inf


@kernel
def chi_square(innovation, covariance, count, factor, whitened):
    """Return ``r' S^-1 r`` and ``ln det S`` of the first ``count`` components.

    Parameters
    ----------
    innovation, covariance
        r, shape (m,), and S, shape (m, m).
    factor, whitened
        Workspaces of their shapes; ``whitened`` is ``L^-1 r`` afterwards, with L the Cholesky factor of S.
    """
    statistic, log_det = 0.0, 0.0
    for i in range(count):
        value = innovation[i]
        for j in range(i + 1):
            total = covariance[i, j]
            for k in range(j):
                total -= factor[i, k] * factor[j, k]
            factor[i, j] = np.sqrt(total) if i == j else total / factor[j, j]
        for j in range(i):
            value -= factor[i, j] * whitened[j]
        whitened[i] = value / factor[i, i]
        statistic += whitened[i] * whitened[i]
        log_det += 2 * np.log(factor[i, i])
    return statistic, log_det


class InnovationRecord(NamedTuple):
    """Innovations and decisions of the quality control, a row per epoch of measurements.

    Attributes
    ----------
    innovation, variance
        Estimated - measured, and S_ii, shape (epochs, m); NaN for a missing component.
    share
        Original R_ii over the one used: 1 for an accepted component, 0 for a removed one.
    whitened
        ``L^-1 r``: independent standard normal for a consistent filter, shape (epochs, m).
    statistic, log_det, freedom
        Of the global test, shape (epochs,).
    passed, reset
        Whether the global test passed; whether a soft reset preceded the update.
    position_use, offset_event, offset_statistic
        Final use of the position; index of the offset event in :data:`OFFSET_EVENTS`; and their statistic
        (:mod:`imugap.filters.solution_separation`).
    """

    innovation: np.ndarray
    variance: np.ndarray
    share: np.ndarray
    whitened: np.ndarray
    statistic: np.ndarray
    log_det: np.ndarray
    freedom: np.ndarray
    passed: np.ndarray
    reset: np.ndarray
    position_use: np.ndarray
    offset_event: np.ndarray
    offset_statistic: np.ndarray

    @classmethod
    def empty(cls, epochs: int, components: int) -> "InnovationRecord":
        """Allocate ``epochs`` rows."""
        matrices = (np.full((epochs, components), np.nan) for _ in range(4))
        vectors = np.full(epochs, np.nan), np.full(epochs, np.nan), np.zeros(epochs, np.int64)
        marks = np.zeros(epochs, np.int8), np.zeros(epochs, np.int8), np.full(epochs, np.nan)
        return cls(*matrices, *vectors, np.ones(epochs, bool), np.zeros(epochs, bool), *marks)

    def events(self, time: np.ndarray, names: tuple[str, ...], quality: QualityControl) -> pd.DataFrame:
        """Return the events: ``time`` [s], ``event``, ``component``, ``statistic``, ``threshold``, ``share``.

        The statistic of a component is ``|r_i|/sqrt(S_ii)``; ``share`` is its remaining weight. The statistic of a soft
        reset is the time without a trusted fix [s].
        """
        limits, rows, since, opened = quality.limits(len(names)), [], np.nan, False
        for k in range(len(time)):
            opened = self.offset_event[k] in (1, 2) or (opened and self.offset_event[k] != 3)
            fine = self.passed[k] and not opened
            since = np.nan if fine else time[k] if np.isnan(since) else since
            if not self.passed[k]:
                rows.append((time[k], FAILED, "all", self.statistic[k], limits[self.freedom[k]], np.nan))
            if self.reset[k]:
                rows.append((time[k], RESET, "all", time[k] - since, quality.reset_s, np.nan))
                since, opened = np.nan, False
            excluded = self.position_use[k] == EXCLUDED
            if excluded or self.offset_event[k]:
                what = SET_ASIDE if excluded else OFFSET_EVENTS[self.offset_event[k]]
                limit = (
                    limits[min(OFFSET_STATES, len(names))]
                    if excluded or self.offset_event[k] == 1
                    else quality.separation_limit
                )
                rows.append((time[k], what, "position", self.offset_statistic[k], limit, np.nan))
            for i in np.flatnonzero(self.share[k] < 1):
                if not excluded and not (self.offset_event[k] == 1 and i >= OFFSET_STATES):
                    size = abs(self.innovation[k, i]) / np.sqrt(self.variance[k, i])
                    what = WEIGHED if self.share[k, i] > 0 else REMOVED
                    rows.append((time[k], what, names[i], size, quality.component, self.share[k, i]))
        return pd.DataFrame(rows, columns=["time", "event", "component", "statistic", "threshold", "share"])

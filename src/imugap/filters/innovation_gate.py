"""Quality control of a Kalman filter's measurements: what an innovation may be, and what follows if it is not.

Per epoch, with the innovation ``r`` of ``m`` components and its covariance ``S = H P H' + R``:

component test
    ``|r_i| > c sqrt(S_ii)`` removes the component with its rows of H and R, or weighs it down: R_ii grows
    by the power ``2 k`` of ``|r_i|/(c sqrt(S_ii))``, from one at the limit on, without a jump (equivalent weights: Yang
    et al. 2001). From ``k = 1`` on the correction by such a component falls as it gets larger.
global test
    ``r' S^-1 r``, chi-square with m degrees of freedom, fails above the quantile of the false-alarm rate. It is that of
    all components as they came, before any is removed or weighed down: of what the component test leaves it would not
    be chi-square, and of what it has weighed down it would hardly ever fail.
gated feedback
    Where the global test fails the navigation is corrected, but the errors of the sensors keep their estimates: their
    rows of the gain are zero. The covariance is that of this gain (Joseph's form), as for considered parameters
    (Schmidt 1966), so that it goes on telling how large the errors are. With all gates open this is the plain filter.
soft reset
    Where no epoch was trusted for longer than a set time, because the global test failed or an offset was open, the
    covariance is inflated. Estimates are kept, but for those of sensors that are out of all proportion, which start
    again, and the offset, which is given up.
hindsight
    What the source has not: errors of position that stay are a state (:mod:`imugap.filters.solution_separation`).

Source: a patent text, "IMU random error online estimation and compensation" (2022), which leaves open where the global
test stands, and whether the gain or the estimate is held. Y. Yang, H. He, G. Xu, Adaptively robust filtering for
kinematic geodetic positioning, J. Geod. 75 (2001) 109-116; S. F. Schmidt, Application of state-space methods to
navigation problems, Adv. Control Syst. 3 (1966) 293-340.
"""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import pandas as pd
from scipy.special import chdtri

from imugap.numerics.rotation import kernel

SANE = 5.0
"""Estimates of sensor errors beyond so many of their standard deviations at the start are given up at a soft reset."""
REMOVED, WEIGHED, FAILED, RESET = "removed", "weighed down", "global test failed", "soft reset"
SET_ASIDE, OPENED, LOOKED_BACK, CLOSED = "set aside", "offset opened", "offset opened in hindsight", "offset closed"
"""What an event can be."""
TAKEN, ASIDE, FRESH, HELD = range(4)
"""What became of a position: taken as it is, set aside, the first with an offset, one with the offset held."""
OFFSET = 3
"""Components of an offset."""
TURNS = ("", OPENED, LOOKED_BACK, CLOSED)
"""What became of the offset at a fix."""


@dataclass(frozen=True)
class Quality:
    """What is done about measurements that do not fit; everything can be switched off.

    Attributes
    ----------
    component
        The ``c`` of the component test; None leaves it out. 2 keeps 95 % of what is normal, 3 keeps 99.73 %.
    robust
        Whether a component that fails is weighed down and not removed.
    steepness
        How steeply it is weighed down: ``k`` above.
    false_alarm
        Probability that the global test fails where nothing is wrong.
    gated
        Whether the errors of the sensors are fed back only where the global test passes.
    reset_s
        Time without trust that is followed by a soft reset [s]; None leaves it out. It has to be longer than the gross
        errors that are to be lived through.
    reset_std
        What a soft reset adds at least to the standard deviations of position [m], velocity [m/s] and attitude [rad]:
        for position and velocity the innovation, where it is larger. The sensor errors get the variance of the start.
    hindsight_s
        How long the filter looks back for errors of position that stay (:mod:`imugap.filters.solution_separation`) [s];
        None leaves it out, and what it keeps in mind too. Its tests have the false-alarm rate of the global one, or its
        square.
    """

    component: float | None = 3.0
    robust: bool = True
    steepness: float = 2.0
    false_alarm: float = 1e-3
    gated: bool = True
    reset_s: float | None = 90.0
    reset_std: tuple[float, float, float] = (30.0, 1.0, 0.05)
    hindsight_s: float | None = 30.0

    def __post_init__(self) -> None:
        """Refuse what is no test."""
        if self.component is not None and not self.component > 0:
            raise ValueError(f"component: expected a number > 0 or none; found {self.component}")
        if not self.steepness > 0:
            raise ValueError(f"steepness: expected a number > 0; found {self.steepness}")
        if not 0 < self.false_alarm < 1:
            raise ValueError(f"false_alarm: expected a probability between 0 and 1; found {self.false_alarm}")
        if self.reset_s is not None and not self.reset_s > 0:
            raise ValueError(f"reset_s: expected a time > 0 [s] or none; found {self.reset_s}")
        if self.hindsight_s is not None and not self.hindsight_s > 0:
            raise ValueError(f"hindsight_s: expected a time > 0 [s] or none; found {self.hindsight_s}")
        if len(self.reset_std) != 3 or min(self.reset_std) < 0:
            raise ValueError(f"reset_std: expected 3 numbers >= 0; found {self.reset_std}")

    def limits(self, components: int) -> np.ndarray:
        """Return the limits of the global test for 0 to ``components`` degrees of freedom."""
        return np.array([np.inf, *chdtri(np.arange(1, components + 1), self.false_alarm)])

    @property
    def lasting(self) -> float:
        """Limit of the tests that open an offset in hindsight, or close one: the square of the rate, since it lasts."""
        return float(chdtri(OFFSET, self.false_alarm**2))


NOTHING = Quality(component=None, gated=False, reset_s=None, hindsight_s=None)
SCHEMES = {
    "none": NOTHING,
    "gate": replace(NOTHING, gated=True),
    "remove": replace(NOTHING, component=3.0, robust=False),
    "robust": replace(NOTHING, component=3.0),
    "gated": replace(NOTHING, component=3.0, gated=True),
    "reset": Quality(hindsight_s=None),
    "hindsight": Quality(),
}
"""No control; gated feedback alone; test and remove; weigh down; this with gated feedback; with soft reset, all that
the source has; with hindsight."""


class Control(NamedTuple):
    """A :class:`Quality` as kernels take it; what is left out has an infinite limit."""

    component: float
    robust: bool
    steepness: float
    limits: np.ndarray
    gated: bool
    reset_s: float
    reset_std: tuple[float, float, float]
    hindsight_s: float
    lasting: float

    @classmethod
    def of(cls, quality: Quality, components: int) -> "Control":
        """Take over a quality control of measurements of so many components."""
        return cls(
            np.inf if quality.component is None else float(quality.component),
            quality.robust,
            float(quality.steepness),
            quality.limits(components),
            quality.gated,
            np.inf if quality.reset_s is None else float(quality.reset_s),
            tuple(map(float, quality.reset_std)),
            np.inf if quality.hindsight_s is None else float(quality.hindsight_s),
            quality.lasting,
        )


@kernel
def weigh(innovation, variance, noise, component, robust, steepness):
    """Return the variance of a component's noise after the component test; infinite for one that is removed.

    Parameters
    ----------
    innovation, variance, noise
        r_i, S_ii and R_ii.
    component, robust, steepness
        As in :class:`Quality`; ``component`` may be infinite.
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
        Room of their shapes; ``whitened`` is ``L^-1 r`` afterwards, with L the Cholesky factor of S.
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


class Record(NamedTuple):
    """What the quality control saw and did, a row per epoch of measurements.

    Attributes
    ----------
    innovation, variance
        Estimated less measured, and S_ii, shape (epochs, m); NaN for a component that is not there.
    share
        R_ii over what it was made: 1 for a component that is taken as it is, 0 for one that is removed.
    whitened
        ``L^-1 r``: independent standard normal where the filter is right, shape (epochs, m).
    statistic, log_det, freedom
        Of the global test, shape (epochs,).
    passed, reset
        Whether the global test passed; whether a soft reset came before the measurements were taken in.
    course, turn, doubt
        What became of the position, as it is known in the end; of the offset, a number in :data:`TURNS`; and the
        statistic of either (:mod:`imugap.filters.solution_separation`).
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
    course: np.ndarray
    turn: np.ndarray
    doubt: np.ndarray

    @classmethod
    def empty(cls, epochs: int, components: int) -> "Record":
        """Return room for so many epochs."""
        matrices = (np.full((epochs, components), np.nan) for _ in range(4))
        vectors = np.full(epochs, np.nan), np.full(epochs, np.nan), np.zeros(epochs, np.int64)
        marks = np.zeros(epochs, np.int8), np.zeros(epochs, np.int8), np.full(epochs, np.nan)
        return cls(*matrices, *vectors, np.ones(epochs, bool), np.zeros(epochs, bool), *marks)

    def events(self, time: np.ndarray, names: tuple[str, ...], quality: Quality) -> pd.DataFrame:
        """Return what happened: ``time`` [s], ``event``, ``component``, ``statistic``, ``threshold``, ``share``.

        The statistic of a component is ``|r_i|/sqrt(S_ii)``; ``share`` is what is left of its weight. A soft reset has
        the time for which no fix was trusted, and that for which it may be so.
        """
        limits, rows, since, opened = quality.limits(len(names)), [], np.nan, False
        for k in range(len(time)):
            opened = self.turn[k] in (1, 2) or (opened and self.turn[k] != 3)
            fine = self.passed[k] and not opened
            since = np.nan if fine else time[k] if np.isnan(since) else since
            if not self.passed[k]:
                rows.append((time[k], FAILED, "all", self.statistic[k], limits[self.freedom[k]], np.nan))
            if self.reset[k]:
                rows.append((time[k], RESET, "all", time[k] - since, quality.reset_s, np.nan))
                since, opened = np.nan, False
            aside = self.course[k] == ASIDE
            if aside or self.turn[k]:
                what = SET_ASIDE if aside else TURNS[self.turn[k]]
                limit = limits[min(OFFSET, len(names))] if aside or self.turn[k] == 1 else quality.lasting
                rows.append((time[k], what, "position", self.doubt[k], limit, np.nan))
            for i in np.flatnonzero(self.share[k] < 1):
                if not aside and not (self.turn[k] == 1 and i >= OFFSET):
                    size = abs(self.innovation[k, i]) / np.sqrt(self.variance[k, i])
                    what = WEIGHED if self.share[k, i] > 0 else REMOVED
                    rows.append((time[k], what, names[i], size, quality.component, self.share[k, i]))
        return pd.DataFrame(rows, columns=["time", "event", "component", "statistic", "threshold", "share"])

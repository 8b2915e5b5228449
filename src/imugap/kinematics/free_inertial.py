"""Free-inertial drift of static logs, and the errors of simulated drifts (He et al. 2023, eqs. 19-21).

A *drift* is navigated minus true for a device at rest: an array of shape (starts, epochs, 9), columns
:data:`imugap.kinematics.strapdown.COLUMNS` with the heading unwrapped. The starts are :data:`STARTS`: ``raw`` navigates
the log as it is, as in the source; ``calibrated`` first subtracts the mean error over the calibration time before the
start, relative to the input with which the mechanisation stays at rest.
"""

from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from imugap import log
from imugap.kinematics import strapdown
from imugap.kinematics.site import Site

STARTS = ("raw", "calibrated")
QUANTITIES = {"east": strapdown.COLUMNS.index("east"), "north": 0, "heading": strapdown.COLUMNS.index("heading")}
"""The compared quantities and their columns: positions [m], heading [rad]."""


@dataclass(frozen=True)
class StaticNavigation:
    """Settings of the free-inertial navigation of static logs.

    Attributes
    ----------
    site
        Site of the device; its gravity and, if the heading is known, the Earth rate are the true input.
    full
        Whether the mechanisation has Earth rate, transport rate and ellipsoid, or is the local form.
    calibration_s, length_s, epoch_s
        Rest before the start, length of the navigation, step of the stored drift [s].
    """

    site: Site
    full: bool
    calibration_s: float
    length_s: float
    epoch_s: float

    @classmethod
    def from_mapping(cls, site: dict, navigation: dict, length_s: float) -> "StaticNavigation":
        """Build from the configuration of a site and of the navigation, and the length to navigate [s]."""
        return cls(
            Site.from_mapping(site),
            navigation["mechanisation"] == "ellipsoid",
            navigation["calibration_s"],
            length_s,
            navigation["epoch_s"],
        )

    def epochs(self) -> np.ndarray:
        """Return the times of the stored drift since the start [s]."""
        return self.epoch_s * np.arange(round(self.length_s / self.epoch_s) + 1)

    def ideal(self, interval: float) -> pd.DataFrame:
        """Return the error-free log of calibration and navigation."""
        count = round((self.calibration_s + self.length_s) / interval) + 1
        return self.site.rest(count, interval)

    def rest(self) -> pd.Series:
        """Return the input with which the mechanisation stays at rest, per axis, SI.

        The local form stays at rest with zero rate, the full one with the Earth rate (heading north where unknown). It
        is the target of the calibration.
        """
        place = self.site if self.site.heading is not None else replace(self.site, heading=0.0)
        ideal = place.ideal()
        return ideal if self.full else ideal.where(~ideal.index.isin(log.GYRO), 0.0)

    def _check_steps(self, time: np.ndarray, interval: float) -> None:
        """Check for gaps, and that an epoch is a whole number of intervals (within 0.1 %); raise otherwise."""
        largest = np.diff(time).max()
        if largest > 1.5 * interval:
            raise log.LogError("log", "time", f"steps of {interval:g} s to navigate", f"one of {largest:g} s")
        steps = self.epoch_s / interval
        if abs(steps / max(round(steps), 1) - 1) > 1e-3:
            raise ValueError(f"epoch_s: expected a multiple of the interval {interval:g} s; found {self.epoch_s} s")

    def drift(self, table: pd.DataFrame) -> np.ndarray:
        """Navigate the log of a device at rest from both starts; return its drift, shape (2, epochs, 9)."""
        interval = log.interval(table)
        count = sum(self._counts(interval))
        if len(table) < count:
            raise log.LogError("log", "rows", f"{count} samples to navigate", str(len(table)))
        self._check_steps(table.index.to_numpy()[:count], interval)
        return self.drift_of(table[list(log.AXES)].to_numpy(), interval)

    def _counts(self, interval: float) -> tuple[int, int]:
        """Return the number of samples of calibration and navigation."""
        return round(self.calibration_s / interval), round(self.length_s / interval) + 1

    def drift_of(self, samples: np.ndarray, interval: float) -> np.ndarray:
        """Navigate the samples of a device at rest, shape (n, 6), an interval [s] apart, from both starts.

        Return the drift, shape (2, epochs, 9).
        """
        start, count = self._counts(interval)
        samples = samples[: start + count]
        error = samples[:start].mean(axis=0) - self.rest().to_numpy()
        moving = np.stack([samples[start:], samples[start:] - error])
        place = self.site
        mechanisation = (
            strapdown.Ellipsoid(place.latitude, 0.0, place.height) if self.full else strapdown.Local(place.gravity)
        )
        attitude = np.array([0.0, 0.0, place.heading or 0.0])
        start, every = strapdown.NavigationState(attitude=tuple(attitude)), round(self.epoch_s / interval)
        path = strapdown.navigate(moving[..., :3], moving[..., 3:], interval, start, mechanisation, every)
        path[..., 8] = np.unwrap(path[..., 8], axis=-1)
        path[..., 6:] -= attitude
        return path


def differences(measured: np.ndarray, simulated: np.ndarray) -> np.ndarray:
    """Return d = measured - simulated (eq. 19) for every run and trial, shape (runs, trials, epochs, quantities)."""
    return measured[:, None] - simulated[None]


def errors(measured: np.ndarray, simulated: np.ndarray, at: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return e_abs = max |d| and e_rel = e_abs/|measured(end)| (eqs. 20-21) for navigations that end at epochs ``at``.

    Parameters
    ----------
    measured
        Drifts of the runs, shape (runs, epochs, quantities).
    simulated
        Drifts of the trials, shape (trials, epochs, quantities).
    at
        Indices of the last epoch, shape (horizons,).

    Returns
    -------
    tuple of numpy.ndarray
        Both of shape (runs, trials, horizons, quantities).
    """
    largest = np.empty((len(measured), len(simulated), len(at), measured.shape[-1]))
    for run, drift in enumerate(measured):
        running = np.maximum.accumulate(np.abs(drift - simulated), axis=1)
        largest[run] = running[:, at]
    return largest, largest / np.abs(measured[:, None][:, :, at])


def crps(observed: np.ndarray, ensemble: np.ndarray) -> np.ndarray:
    """Return the continuous ranked probability score of an ensemble, a proper score in the unit of the observation.

    The fair form E|X - y| - E|X - X'|/2 over distinct members (Ferro 2014, eq. 6): its expectation does not depend on
    the ensemble size, and no ensemble does better on average than the distribution that the observations come from.

    Parameters
    ----------
    observed
        Shape (runs, ...).
    ensemble
        Shape (trials, ...).
    """
    trials = len(ensemble)
    ordered = np.sort(ensemble, axis=0)
    weights = 2 * np.arange(1, trials + 1) - trials - 1
    spread = np.tensordot(weights, ordered, axes=1) / (trials * (trials - 1))
    return np.array([np.abs(ensemble - value).mean(axis=0) for value in observed]) - spread

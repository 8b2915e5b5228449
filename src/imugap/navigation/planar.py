"""Planar vehicle with one gyroscope, two accelerometers and position fixes, and its error-state filter.

The simplified example of Farrell et al. (2022): predicted error of a filter under one model of the sensors, against its
actual error under another. The navigation state is north, east [m], their velocities [m/s] and the heading [rad],
clockwise from north; the body axes are x forward and y right. Errors are estimated - true; the estimated quantities are
the columns :data:`COLUMNS`, the navigation state and the slow error of each sensor.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import yaml
from numba import njit

from imugap.effects import Conditions, WhiteNoise
from imugap.effects.effect import AxisModel
from imugap.interchange.augmentation import Chain, augmentation, residual
from imugap.interchange.datasheet import DataSheet, Slow
from imugap.numerics.rotation import wrap
from imugap.numerics.small_matrix import invert
from imugap.numerics.state_space import StateSpace
from imugap.stream import stream

SENSORS = ("gyro_z", "accel_x", "accel_y")
VEHICLE = ("north", "east", "vel_n", "vel_e", "heading")
COLUMNS = (*VEHICLE, *(f"bias_{sensor}" for sensor in SENSORS))
QUANTITIES = {"position": (0, 1), "velocity": (2, 3), "heading": (4,), "gyro bias": (5,), "accel bias": (6, 7)}
"""Quantities that are compared, and their columns."""
SCOPES = {"navigation": len(VEHICLE), "with biases": len(COLUMNS)}
"""Scopes of the normalised error, and the number of leading columns of each."""


@dataclass(frozen=True, eq=False)
class PlanarDrive:
    """A planar drive and its position fixes.

    Attributes
    ----------
    interval
        Sampling interval [s].
    inputs
        True rate [rad/s] and body accelerations [m/s^2], constant over each interval, shape (steps, 3).
    states
        True navigation state, shape (steps + 1, 5).
    every
        Number of intervals between epochs.
    aided
        Whether an epoch has a fix, shape (epochs,); epoch j is at step (j + 1) every.
    fix_std
        Standard deviation of a fix, north and east [m].
    """

    interval: float
    inputs: np.ndarray
    states: np.ndarray
    every: int
    aided: np.ndarray
    fix_std: float

    @classmethod
    def winding(
        cls, duration_s: float, rate_hz: float, speed_m_per_s: float, surge_m_per_s: float, surge_period_s: float,
        turn_rad_per_s: float, turn_period_s: float, lap_s: float, fix_interval_s: float, fix_std_m: float,
        outages_s: Sequence[tuple[float, float]], heading_rad: float = 0.0,
    ) -> "PlanarDrive":  # fmt: skip
        """Drive laps without slip, with sinusoidal variations of speed and turn rate.

        An outage excludes fixes after its start up to and including its end.
        """
        count, interval = round(duration_s * rate_hz), 1 / rate_hz
        time = interval * (np.arange(count) + 0.5)
        surge, turn = 2 * np.pi / surge_period_s, 2 * np.pi / turn_period_s
        speed = speed_m_per_s + surge_m_per_s * np.sin(surge * time)
        rate = 2 * np.pi / lap_s + turn_rad_per_s * np.cos(turn * time)
        inputs = np.column_stack([rate, surge_m_per_s * surge * np.cos(surge * time), speed * rate])
        start = np.array([0, 0, *(speed_m_per_s * _direction(heading_rad)), heading_rad])
        every = round(fix_interval_s * rate_hz)
        epochs = interval * every * np.arange(1, count // every + 1)
        aided = np.all([(epochs <= a + 1e-9) | (epochs > b + 1e-9) for a, b in outages_s] or [epochs > 0], axis=0)
        return cls(interval, inputs, navigate(start, inputs, interval), every, aided, fix_std_m)

    def epochs(self) -> np.ndarray:
        """Return the times of the epochs [s]."""
        return self.interval * self.every * np.arange(1, len(self.aided) + 1)

    def ends(self) -> np.ndarray:
        """Return the indices of the last epochs of the outages."""
        return np.flatnonzero(~self.aided & np.r_[self.aided[1:], True])


@dataclass(frozen=True, eq=False)
class PlanarExample:
    """The example: data sheets of :data:`SENSORS`, drive, initial standard deviations of the navigation state."""

    sheets: tuple[DataSheet, ...]
    drive: PlanarDrive
    start_std: np.ndarray

    @classmethod
    def read(cls, path: str | Path) -> "PlanarExample":
        """Read a recipe (YAML with ``sensors``, ``drive`` and ``start_std``)."""
        recipe = yaml.safe_load(Path(path).read_text())
        try:
            sheets = tuple(DataSheet(**recipe["sensors"][sensor]) for sensor in SENSORS)
            return cls(sheets, PlanarDrive.winding(**recipe["drive"]), np.array(recipe["start_std"], float))
        except (KeyError, TypeError, ValueError) as error:
            raise ValueError(f"{path}: expected sensors, drive and start_std; found {error}") from error

    def models(self, slow: Sequence[Slow]) -> tuple[AxisModel, ...]:
        """Return the models of the sensors with the slow processes ``slow``."""
        return tuple(sheet.model(slow) for sheet in self.sheets)


@dataclass(frozen=True, eq=False)
class PlanarErrors:
    """Errors of a filter over runs of a drive, at the epochs, after the update.

    Attributes
    ----------
    error
        Estimated - true, shape (runs, epochs, 8).
    variance
        Variance of the error predicted by the filter, shape (runs, epochs, 8).
    nees
        Normalised estimation error squared, error' covariance^-1 error, of each of :data:`SCOPES`, shape
        (runs, epochs, 2).
    """

    error: np.ndarray
    variance: np.ndarray
    nees: np.ndarray


def monte_carlo(
    drive: PlanarDrive, truth: Sequence[AxisModel], modelled: Sequence[AxisModel], start_std: np.ndarray, runs: int,
    seed: int, *labels: object,
) -> PlanarErrors:  # fmt: skip
    """Navigate ``runs`` drives with sensors of models ``truth`` and a filter of models ``modelled``.

    The same seed and labels give the same sensor errors, fixes and initial errors for any filter.

    Parameters
    ----------
    truth, modelled
        Models of :data:`SENSORS`.
    start_std
        Standard deviation of the error of the navigation state at the start, shape (5,).
    """
    chain = Chain.of([augmentation(model) for model in modelled], drive.interval)
    drawn = (draw(drive, truth, start_std, seed, *labels, run) for run in range(runs))
    found = [filter_run(drive, chain, start_std, *one) for one in drawn]
    return PlanarErrors(*(np.array(one) for one in zip(*found, strict=True)))


def draw(
    drive: PlanarDrive, truth: Sequence[AxisModel], start_std: np.ndarray, seed: int, *labels: object
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Draw sensor errors and their slow part, (steps + 1, 3) each, starting error (5,), and fix errors (epochs, 2)."""
    count = len(drive.states)
    at = Conditions(drive.interval * np.arange(count), drive.interval)
    parts = np.zeros((2, count, len(SENSORS)))
    for k, (name, model) in enumerate(zip(SENSORS, truth, strict=True)):
        slow = AxisModel(tuple(effect for effect in model if not isinstance(effect, WhiteNoise)))
        for part, one in zip(parts, (model, slow), strict=True):
            part[:, k] = one.simulate(np.zeros(count), at, seed, *labels, name)
    start = start_std * stream(seed, *labels, "start").standard_normal(len(VEHICLE))
    fixes = drive.fix_std * stream(seed, *labels, "fixes").standard_normal((len(drive.aided), 2))
    return *parts, start, fixes


def filter_run(
    drive: PlanarDrive, chain: Chain, start_std: np.ndarray, errors: np.ndarray, slow: np.ndarray, start: np.ndarray,
    fixes: np.ndarray,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:  # fmt: skip
    """Navigate one run of :func:`draw` with the error-state filter of ``chain``.

    Returns
    -------
    tuple of numpy.ndarray
        Error and its variance predicted by the filter, both (epochs, 8), and NEES (epochs, 2).
    """
    at = drive.every * np.arange(1, len(drive.aided) + 1)
    truth = np.concatenate([drive.states[at], slow[at]], axis=1)
    seen = np.where(drive.aided[:, None], truth[:, :2] + fixes, np.nan)
    covariance = _start(start_std, chain.initial_covariance)
    return _filter(
        drive.inputs + errors[:-1], drive.states[0] + start, covariance, seen, drive.fix_std**2, truth,
        drive.every, drive.interval, chain.transition, chain.noise, chain.output,
    )  # fmt: skip


def covariances(
    drive: PlanarDrive, truth: Sequence[AxisModel], modelled: Sequence[AxisModel], start_std: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return predicted and actual variance of the error, each (epochs, 8), by covariance analysis.

    Both are linearised about the true drive. The predicted one is that of the filter; the actual one that of the joint
    state of vehicle error, true sensor errors and their estimates under the gains of the filter (Maybeck 1979,
    sec. 6.8). ``truth`` needs a state space.
    """
    sensors = [(augmentation(true), augmentation(model)) for true, model in zip(truth, modelled, strict=True)]
    own = Chain.of([model for _, model in sensors], drive.interval)
    joint = Chain.of([residual(true, model) for true, model in sensors], drive.interval)
    return _covariances(
        drive.inputs, drive.states, drive.aided, drive.fix_std**2, drive.every, drive.interval,
        own.transition, own.noise, own.output, _start(start_std, own.initial_covariance),
        joint.transition, joint.noise, joint.output, _start(start_std, joint.initial_covariance),
        _estimates(sensors),
    )  # fmt: skip


def _estimates(sensors: Sequence[tuple[StateSpace, StateSpace]]) -> np.ndarray:
    """Return the indices of the filter's estimates in the joint state of the sensors."""
    places, first = [], 0
    for true, model in sensors:
        first += len(true.output)
        places += range(first, first + len(model.output))
        first += len(model.output)
    return np.array(places, dtype=np.int64)


def _start(start_std: np.ndarray, sensors: np.ndarray) -> np.ndarray:
    """Return the covariance at the start of independent navigation and sensor errors."""
    size = len(start_std)
    covariance = np.zeros((size + len(sensors), size + len(sensors)))
    covariance[:size, :size] = np.diag(np.square(start_std))
    covariance[size:, size:] = sensors
    return covariance


@njit(cache=True)
def _direction(heading):
    return np.array([np.cos(heading), np.sin(heading)])


@njit(cache=True)
def _advance(state, sample, interval):
    """Return the navigation state after an interval of constant rate and body acceleration."""
    middle = _direction(state[4] + sample[0] * interval / 2)
    gain = np.array([middle[0] * sample[1] - middle[1] * sample[2], middle[1] * sample[1] + middle[0] * sample[2]])
    after = state.copy()
    after[:2] += interval * (state[2:4] + gain * interval / 2)
    after[2:4] += interval * gain
    after[4] += interval * sample[0]
    return after


@njit(cache=True)
def navigate(start, inputs, interval):
    """Return the navigation states, shape (steps + 1, 5), from ``start``, (5,), and ``inputs``, (steps, 3)."""
    states = np.empty((len(inputs) + 1, 5))
    states[0] = start
    for k in range(len(inputs)):
        states[k + 1] = _advance(states[k], inputs[k], interval)
    return states


@njit(cache=True)
def predict_covariance(covariance, state, sample, interval, chain_transition, chain_noise):
    """Return the covariance of vehicle error and sensor states after an interval, and the transition of the states.

    With heading and acceleration constant over the interval (their values at its middle), the vehicle error is a linear
    map of integrals of the sensor errors: heading of the first, velocity of the first and second, position of the
    second and third. The discretisation of the chain is exact and the same for all intervals.
    """
    middle = _direction(state[4] + sample[0] * interval / 2)
    pull = np.array([-middle[1] * sample[1] - middle[0] * sample[2], middle[0] * sample[1] - middle[1] * sample[2]])
    sensors = len(chain_transition) - 9
    lift = np.zeros((5 + sensors, 9 + sensors))
    for order in range(2):
        row, column = 2 * order, 3 * order
        lift[row, column], lift[row + 1, column] = pull
        lift[row, column + 4], lift[row, column + 5] = middle[0], -middle[1]
        lift[row + 1, column + 4], lift[row + 1, column + 5] = middle[1], middle[0]
    lift[4, 6] = 1.0
    for k in range(sensors):
        lift[5 + k, 9 + k] = 1.0
    transition = np.zeros((5 + sensors, 5 + sensors))
    transition[:, 5:] = lift @ np.ascontiguousarray(chain_transition[:, 9:])
    for k in range(5):
        transition[k, k] = 1.0
    for k in range(2):
        transition[k, 2 + k] = interval
        transition[2 + k, 4] = interval * pull[k]
        transition[k, 4] = interval**2 / 2 * pull[k]
    noise = lift @ chain_noise @ lift.T
    return transition @ covariance @ transition.T + noise, transition


@njit(cache=True)
def fix_gain(covariance, variance):
    """Return the gain for a fix of both coordinates with ``variance`` each, shape (states, 2)."""
    innovation = covariance[:2, :2] + variance * np.eye(2)
    return np.ascontiguousarray(covariance[:, :2]) @ invert(innovation)[0]


@njit(cache=True)
def update_covariance(covariance, gain, variance):
    """Return the covariance after an update with any gain (Joseph's form)."""
    left = np.eye(len(covariance))
    left[:, :2] -= gain
    return left @ covariance @ left.T + variance * (gain @ gain.T)


@njit(cache=True)
def _shown(output):
    """Return the map from vehicle error and sensor states to the columns; a bias error is estimated - true."""
    shown = np.zeros((5 + len(output), 5 + output.shape[1]))
    for k in range(5):
        shown[k, k] = 1.0
    shown[5:, 5:] = -output
    return shown


@njit(cache=True)
def _filter(
    samples, start, covariance, fixes, variance, truth, every, interval, chain_transition, chain_noise, output
):  # fmt: skip
    state, sensors, shown = start.copy(), np.zeros(output.shape[1]), _shown(output)
    hold = np.ascontiguousarray(chain_transition[9:, 9:])
    errors, variances = np.empty_like(truth), np.empty_like(truth)
    nees = np.empty((len(truth), 2))
    for epoch in range(len(truth)):
        for k in range(epoch * every, (epoch + 1) * every):
            sample = samples[k] - output @ sensors
            covariance, _ = predict_covariance(covariance, state, sample, interval, chain_transition, chain_noise)
            state = _advance(state, sample, interval)
            sensors = hold @ sensors
        if not np.isnan(fixes[epoch, 0]):
            gain = fix_gain(covariance, variance)
            correction = gain @ (state[:2] - fixes[epoch])
            state = state - correction[:5]
            sensors = sensors + correction[5:]
            covariance = update_covariance(covariance, gain, variance)
        error = np.concatenate((state, output @ sensors)) - truth[epoch]
        error[4] = wrap(error[4])
        spread = shown @ covariance @ shown.T
        errors[epoch], variances[epoch] = error, np.diag(spread)
        nees[epoch, 0] = error[:5] @ invert(spread[:5, :5])[0] @ error[:5]
        nees[epoch, 1] = error @ invert(spread)[0] @ error
    return errors, variances, nees


@njit(cache=True)
def _covariances(
    inputs, states, aided, variance, every, interval, own_transition, own_noise, own_output, own,
    joint_transition, joint_noise, joint_output, joint, estimates,
):  # fmt: skip
    own_shown, joint_shown = _shown(own_output), _shown(joint_output)
    predicted, actual = np.empty((2, len(aided), len(own_shown)))
    for epoch in range(len(aided)):
        for k in range(epoch * every, (epoch + 1) * every):
            own, _ = predict_covariance(own, states[k], inputs[k], interval, own_transition, own_noise)
            joint, _ = predict_covariance(joint, states[k], inputs[k], interval, joint_transition, joint_noise)
        if aided[epoch]:
            gain = fix_gain(own, variance)
            wide = np.zeros((len(joint), 2))
            wide[:5] = gain[:5]
            for k in range(len(estimates)):
                wide[5 + estimates[k]] = -gain[5 + k]
            own, joint = update_covariance(own, gain, variance), update_covariance(joint, wide, variance)
        predicted[epoch] = np.diag(own_shown @ own @ own_shown.T)
        actual[epoch] = np.diag(joint_shown @ joint @ joint_shown.T)
    return predicted, actual

"""How far a measured log is from simulated ones on held-out data: before, after, and the floor.

The *before* and *after* are the distances to ensembles of the start and of the final model, the *floor* the distance
of simulations of the final model from each other. Each is in units of the scatter of the model's own simulations: a
model that claims to know more than it does is far away, not close.
Logs are taken as evenly sampled; errors of the clock are left out.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import radians

import numpy as np
import pandas as pd
from scipy.fft import dct
from scipy.special import ndtri

from imugap import log
from imugap.discovery.evaluation.parameter_ensemble import UncertainModel
from imugap.discovery.finding import Interval
from imugap.discovery.preparation.rounding import level_before_rounding
from imugap.discovery.views.curve import block_starts
from imugap.discovery.views.spectral import bands
from imugap.effects.conditions import Conditions
from imugap.effects.effect import AxisModel
from imugap.estimation import allan
from imugap.kinematics import free_inertial as drift
from imugap.kinematics.site import Site
from imugap.model import ErrorModel, conditions, offset_of
from imugap.stream import stream

COUNT = 60
"""Simulations of each model."""
BLOCKS, SHORTEST = 16, 16
"""Blocks of the held-out part, and fewest samples of one."""
WIDTH, PER_DECADE = 0.3, 4
"""Relative width of bands of frequency; averaging times per decade."""
SHARES = np.array([0.001, 0.01, 0.05, 0.25, 0.5, 0.75, 0.95, 0.99, 0.999])
"""Shares of normal values below the bounds at which shares of the samples are compared."""
COUNTED = 8
"""Fewest samples that are to be expected beyond a bound."""
EPOCHS = 16
"""Steps of a drift."""
HORIZONS = np.array([1 / 16, 1 / 8, 1 / 4, 1 / 2, 1])
"""Shares of the held-out part after which drifts are compared."""
LEAST = 0.1
"""Smallest scatter of an entry, over the median one of its view: some hardly vary."""
LEVEL = 0.95
SIDES = ("before", "after")
"""Names of the two models."""
ANYWHERE = Site(radians(45.0), 0.0)
"""Where a device stands if nobody says: only the gravity of the place matters."""

Model = ErrorModel | UncertainModel


@dataclass(frozen=True)
class Distances:
    """Distances of the measured log to the start and to the final model, and what the final model makes by itself.

    Of before and after, the value is the median over the simulations and the interval holds 95 % of them. The floor
    is that median for each simulation of the final model against the others: its median and 95 % interval. If the
    final model is right, the value of *after* lies in the floor's interval in 95 % of the cases.
    """

    before: Interval
    after: Interval
    floor: Interval


@dataclass(frozen=True, eq=False)
class SquaredDistances:
    """Squared distances on one log, from which those over several logs follow.

    Attributes
    ----------
    before, after
        Of the measured log to each simulation of the start and of the final model, shape (count,).
    floor
        Of each simulation of the final model to the others, shape (count, count - 1).
    """

    before: np.ndarray
    after: np.ndarray
    floor: np.ndarray


def combined(logs: Sequence[SquaredDistances]) -> Distances:
    """Return the distances over several logs of a device, each of the same weight: root mean squares."""
    before, after, floor = (
        np.sqrt(np.mean([getattr(one, name) for one in logs], axis=0)) for name in ("before", "after", "floor")
    )
    return Distances(_interval(before), _interval(after), _interval(np.median(floor, axis=1)))


@dataclass(frozen=True, eq=False)
class LogStatistics:
    """What is compared of one log.

    Attributes
    ----------
    views
        Of each axis the logarithms of Allan variance, spectrum and block variances, block means, and shares.
    path
        Drift through the held-out part, position north, east, down [m], shape (epochs, 3); None if not navigated.
    """

    views: list[np.ndarray]
    path: np.ndarray | None


@dataclass(frozen=True, eq=False)
class HeldOutComparison:
    """A log beside two models: what follows on its first part is compared with what they make of it.

    Attributes
    ----------
    measured
        The whole log.
    split
        Time [s] of the log at which the held-out part begins.
    before, after
        Start and final model, with or without the uncertainty of their parameters.
    reference
        Error-free log at the same times, of all axes that effects may go with, for a device in motion; a device at
        rest needs none.
    level
        Mean of each axis over the held-in part, which is that of the measured values unless it is given: clipped
        values have another one than the device.
    """

    measured: pd.DataFrame
    split: float
    before: Model
    after: Model
    reference: pd.DataFrame | None = None
    level: Mapping[str, float] | None = None

    @cached_property
    def held_in(self) -> int:
        """Return the number of samples of the held-in part; ValueError if either part has too few."""
        held_in = int(np.searchsorted(self.measured.index.to_numpy(), self.split))
        fewest = 4 * SHORTEST
        if min(held_in, len(self.measured) - held_in) < fewest:
            raise ValueError(
                f"split: expected {fewest} samples on either side; found {held_in} before {self.split:g} s"
            )
        return held_in

    @cached_property
    def course(self) -> drift.StaticNavigation | None:
        """Return how the held-out part is navigated, from biases that are the means of the held-in one.

        None for a device in motion or without all six axes.
        """
        if self.reference is not None or not all(axis in self.measured for axis in log.AXES):
            return None
        interval = log.interval(self.measured)
        length = (len(self.measured) - self.held_in - 1) // EPOCHS * EPOCHS
        return drift.StaticNavigation(
            ANYWHERE, False, self.held_in * interval, length * interval, length // EPOCHS * interval
        )

    def statistics(self) -> LogStatistics:
        """Return the summary of the measured log."""
        return self._summary(self.measured)

    def simulate(self, name: str, seed: int, numbers: Iterable[int]) -> list[LogStatistics]:
        """Return the summaries of the simulations of these numbers of a model, ``before`` or ``after``."""
        return [self._summary(table) for table in self._simulations(name, seed, numbers)]

    def distribution(self, seed: int, count: int = COUNT) -> SquaredDistances:
        """Return the distances over views of the error."""
        return distribution(self.statistics(), *(self.simulate(name, seed, range(count)) for name in SIDES))

    def drifts(self, seed: int, count: int = COUNT) -> "Drifts":
        """Return the drifts of a device at rest."""
        return self.drifts_of(self.statistics(), *(self.simulate(name, seed, range(count)) for name in SIDES))

    def drifts_of(
        self, own: LogStatistics, before: Sequence[LogStatistics], after: Sequence[LogStatistics]
    ) -> "Drifts":
        """Return the drifts of which summaries tell."""
        start, final = (np.array([one.path for one in ensemble]) for ensemble in (before, after))
        return Drifts(self.course.epochs(), own.path, start, final)

    def _summary(self, table: pd.DataFrame) -> LogStatistics:
        """Return the summary of the log or of a simulation of it."""
        first, errors, scale = self.held_in, self._errors(table), self._scale
        views = [view for axis, x in errors.items() for view in _views(x[first:], x[:first].mean(), scale[axis])]
        return LogStatistics(views, None if self.course is None else self._path(table))

    def _path(self, table: pd.DataFrame) -> np.ndarray:
        even = log.from_samples({axis: table[axis].to_numpy(float) for axis in log.AXES}, log.interval(self.measured))
        return self.course.drift(even)[drift.STARTS.index("calibrated"), :, :3]

    def _errors(self, table: pd.DataFrame) -> dict[str, np.ndarray]:
        axes = list(log.axes(self.measured))
        own = table[axes] if self.reference is None else table[axes] - self.reference[axes].to_numpy()
        return {axis: own[axis].to_numpy(float) for axis in axes}

    @cached_property
    def _scale(self) -> dict[str, float]:
        """Return the standard deviation of the measured errors of the held-in part."""
        return {axis: values[: self.held_in].std() for axis, values in self._errors(self.measured).items()}

    def _simulations(self, name: str, seed: int, numbers: Iterable[int]) -> Iterator[pd.DataFrame]:
        """Simulate the whole log, the held-out part as what follows on the held-in one."""
        model = getattr(self, name)
        for number in numbers:
            labels = ("distance", name, number)
            rng = stream(seed, *labels, "parameters")
            drawn = model.draw(rng) if isinstance(model, UncertainModel) else model
            sensors = ErrorModel({axis: drawn.axes.get(axis, AxisModel()) for axis in log.axes(self.measured)})
            ideal, at = (self._at_rest(sensors), None) if self.reference is None else self._in_motion
            yield sensors.simulate(ideal, seed, *labels, at=at)

    def _at_rest(self, model: ErrorModel) -> pd.DataFrame:
        """Return the error-free log of a device at rest: the level less the model's biases."""
        table, interval = self.measured.copy(), log.interval(self.measured)
        for axis in log.axes(self.measured):
            biases = offset_of(model[axis])
            table[axis] = level_before_rounding(self._levels[axis], model[axis], interval) - biases
        return self._with_temperature(table)

    @cached_property
    def _in_motion(self) -> tuple[pd.DataFrame, Mapping[str, Conditions]]:
        """Return the reference as the error-free log, and its conditions, which all simulations share."""
        ideal = self._with_temperature(self.reference.copy())
        return ideal, conditions(ideal)

    def _with_temperature(self, table: pd.DataFrame) -> pd.DataFrame:
        """Return an error-free log with the temperature of the measured one, at times since its start."""
        if log.TEMPERATURE in self.measured:
            table[log.TEMPERATURE] = self.measured[log.TEMPERATURE].to_numpy()
        return table.set_axis(pd.Index(self.measured.index - self.measured.index[0], name=log.TIME))

    @cached_property
    def _levels(self) -> Mapping[str, float]:
        if self.level is not None:
            return self.level
        return {axis: float(self.measured[axis].iloc[: self.held_in].mean()) for axis in log.axes(self.measured)}


@dataclass(frozen=True, eq=False)
class Drifts:
    """Free-inertial drift of a device at rest through the held-out part, measured and simulated.

    Attributes
    ----------
    time
        Since the start of the navigation [s], shape (epochs,).
    measured
        Position north, east, down less the true one [m], shape (epochs, 3).
    before, after
        The same of simulations of the start and of the final model, shape (count, epochs, 3).
    """

    time: np.ndarray
    measured: np.ndarray
    before: np.ndarray
    after: np.ndarray

    def distances(self) -> SquaredDistances:
        """Return the distances over the drift at :data:`HORIZONS`."""
        at = np.rint((len(self.time) - 1) * HORIZONS).astype(int)
        start, final = ([list(one[at]) for one in ensemble] for ensemble in (self.before, self.after))
        return _apart(list(self.measured[at]), start, final)


def distribution(
    own: LogStatistics, before: Sequence[LogStatistics], after: Sequence[LogStatistics]
) -> SquaredDistances:
    """Return the distances over views: of the measured log and of simulations of the start and of the final model."""
    return _apart(own.views, *([one.views for one in ensemble] for ensemble in (before, after)))


def _views(values: np.ndarray, level: float, scale: float) -> list[np.ndarray]:
    """Return what views say of the held-out values of one axis, ``level`` being the mean of the held-in ones.

    ``scale`` is the standard deviation of measured values, which sets the bounds below which samples are counted: on
    a lattice their shares vary as those of a binomial law, while quantiles jump.
    """
    first = block_starts(len(values), BLOCKS, SHORTEST)
    number = np.diff(np.r_[first, len(values)])
    means = np.add.reduceat(values - level, first) / number
    squares = np.add.reduceat((values - level - np.repeat(means, number)) ** 2, first) / number
    edges, widths = bands(len(values) - 1, WIDTH, 1)
    power = np.add.reduceat(dct(values - values.mean(), norm="ortho")[1:] ** 2, edges) / widths
    averaging = allan.factors(len(values), PER_DECADE)
    told = np.minimum(SHARES, 1 - SHARES) * len(values) >= COUNTED
    below = np.searchsorted(np.sort(values - level), scale * ndtri(SHARES[told]))
    shares = np.arcsin(np.sqrt((below + 3 / 8) / (len(values) + 3 / 4)))
    tiny = np.finfo(float).tiny
    logs = [np.log(np.maximum(part, tiny)) for part in (allan.variance(values, averaging), power, squares)]
    return [*logs, means, shares]


def _apart(own: list[np.ndarray], start: list[list[np.ndarray]], final: list[list[np.ndarray]]) -> SquaredDistances:
    """Return the squared distances of vectors of the measured log and of the simulations of both models."""
    floor = [_squares(one, final[:i] + final[i + 1 :]) for i, one in enumerate(final)]
    return SquaredDistances(_squares(own, start), _squares(own, final), np.array(floor))


def _squares(one: list[np.ndarray], ensemble: list[list[np.ndarray]]) -> np.ndarray:
    """Return the mean square, over views, of the standardised difference from each member, shape (count,).

    Differences are divided by sqrt(2) times the scatter of the entry among the members, so that two members are
    about 1 apart. A mean over the entries of a view comes first: each view of each axis weighs the same.
    """
    squares = []
    for part, rows in zip(one, map(np.array, zip(*ensemble, strict=True)), strict=True):
        spread = rows.std(axis=0, ddof=1)
        spread = np.maximum(spread, LEAST * np.median(spread) + np.finfo(float).tiny)
        squares.append(np.mean(((part - rows) / spread) ** 2, axis=1) / 2)
    return np.mean(squares, axis=0)


def _interval(values: list[float] | np.ndarray) -> Interval:
    """Return the median and the interval that another value of the same law falls into with :data:`LEVEL`."""
    low, middle, high = np.quantile(values, [(1 - LEVEL) / 2, 0.5, (1 + LEVEL) / 2], method="weibull")
    return Interval(float(middle), float(low), float(high), "1")

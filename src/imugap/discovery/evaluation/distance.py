"""Distances of a measured log to simulated ones on held-out data: before, after, and the floor.

The *before* and *after* are the distances to ensembles of the start and of the final model, the *floor* the distance
between simulations of the final model. Each is in units of the scatter of the model's own simulations, so that an
overconfident model is far from the data. Logs are taken as evenly sampled; errors of the clock are excluded.
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
from imugap.discovery.preparation.rounding import level_before_rounding, mean_of_terms
from imugap.discovery.views.curve import block_starts
from imugap.discovery.views.spectral import bands
from imugap.effects.conditions import Conditions
from imugap.effects.effect import AxisModel
from imugap.estimation.variances import allan
from imugap.kinematics import free_inertial as drift
from imugap.kinematics.site import Site
from imugap.model import ErrorModel, conditions, offset_of
from imugap.stream import stream

SIMULATIONS = 60
"""Number of simulations of each model."""
BLOCKS, MIN_BLOCK_SAMPLES = 16, 16
"""Blocks of the held-out part, and fewest samples of one."""
BAND_WIDTH, PER_DECADE = 0.3, 4
"""Relative width of bands of frequency; averaging times per decade."""
SHARES = np.array([0.001, 0.01, 0.05, 0.25, 0.5, 0.75, 0.95, 0.99, 0.999])
"""Probabilities at whose normal quantiles the empirical distribution functions are compared."""
MIN_EXPECTED = 8
"""Minimum expected number of samples beyond such a quantile."""
EPOCHS = 16
"""Number of time steps of a drift."""
HORIZONS = np.array([1 / 16, 1 / 8, 1 / 4, 1 / 2, 1])
"""Times of comparison of drifts, as shares of the held-out part."""
MIN_RELATIVE_SCATTER = 0.1
"""Minimum scatter of an entry, over the median of those entries of its view that have any."""
ROUNDING = 8 * float(np.finfo(float).eps)
"""Scatter of an entry, over its magnitude, up to which it is by rounding."""
COVERAGE = 0.95
SIDES = ("before", "after")
"""Names of the two models."""
ASSUMED_SITE = Site(radians(45.0), 0.0)
"""Assumed site of the device; only its gravity matters."""

Model = ErrorModel | UncertainModel


@dataclass(frozen=True)
class Distances:
    """Distances of the measured log to the start model and to the final model, and the floor of the final model.

    The value of before and after is the median over the simulations, the interval holds 95 % of them. The floor is the
    distribution of that median for each simulation of the final model against the others: its median and 95 %
    interval. If the final model is right, *after* lies in the interval of the floor in 95 % of the cases.
    """

    before: Interval
    after: Interval
    floor: Interval

    @property
    def farther(self) -> bool:
        """Return whether the final model is farther than the start model, and not within the floor."""
        return self.after.value > max(self.before.high, self.floor.high)

    @property
    def reached(self) -> bool:
        """Return whether the final model is within the floor."""
        return self.after.value <= self.floor.high

    @property
    def judgement(self) -> str:
        """Return in words what the distances say of the final model."""
        if not self.reached:
            return "the model does not yet describe the device"
        if self.before.value <= self.floor.high:
            return "within the floor before and after, nothing to gain"
        return "the model is within the floor"


@dataclass(frozen=True, eq=False)
class Evaluation:
    """Distances of both models from held-out data.

    Attributes
    ----------
    distances
        By name of the distance: ``distribution`` over all axes, ``navigation`` where the logs can be navigated.
    axes
        Distance in distribution of each axis.
    drifts
        Drifts of each log that can be navigated.
    """

    distances: Mapping[str, Distances]
    axes: Mapping[str, Distances]
    drifts: tuple["Drifts", ...]


@dataclass(frozen=True, eq=False)
class SquaredDistances:
    """Squared distances on one log.

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
    """Combine several logs of a device with equal weights: return the root mean square distances."""
    before, after, floor = (
        np.sqrt(np.mean([getattr(one, name) for one in logs], axis=0)) for name in ("before", "after", "floor")
    )
    return Distances(_interval(before), _interval(after), _interval(np.median(floor, axis=1)))


@dataclass(frozen=True, eq=False)
class LogStatistics:
    """Statistics of one log that are compared.

    Attributes
    ----------
    views
        Of each axis: logarithms of Allan variance, spectrum and block variances; block means; transformed shares.
    path
        Drift through the held-out part, position north, east, down [m], shape (epochs, 3); None if not navigated.
    """

    views: Mapping[str, list[np.ndarray]]
    path: np.ndarray | None


@dataclass(frozen=True, eq=False)
class HeldOutComparison:
    """A log and two models: its last part is compared with simulations of both.

    Attributes
    ----------
    measured
        The whole log.
    split
        Time [s] at which the held-out part begins.
    before, after
        Start and final model, with or without the uncertainty of their parameters.
    reference
        Error-free log at the same times, for a device in motion; None for a device at rest.
    level
        Mean of each axis over the training part; default that of the measured values, which clipping would bias.
    motion
        Error-free log beyond both ends too, index: time since the start [s]; default the reference alone.
    """

    measured: pd.DataFrame
    split: float
    before: Model
    after: Model
    reference: pd.DataFrame | None = None
    level: Mapping[str, float] | None = None
    motion: pd.DataFrame | None = None

    @cached_property
    def training(self) -> int:
        """Return the number of samples of the training part; ValueError if either part has too few."""
        training = int(np.searchsorted(self.measured.index.to_numpy(), self.split))
        fewest = 4 * MIN_BLOCK_SAMPLES
        if min(training, len(self.measured) - training) < fewest:
            raise ValueError(
                f"split: expected {fewest} samples on either side; found {training} before {self.split:g} s"
            )
        return training

    @cached_property
    def course(self) -> drift.StaticNavigation | None:
        """Return the navigation of the held-out part, with biases estimated on the training part.

        None for a device in motion or without all six axes.
        """
        if self.reference is not None or not all(axis in self.measured for axis in log.AXES):
            return None
        interval = self._interval
        length = (len(self.measured) - self.training - 1) // EPOCHS * EPOCHS
        return drift.StaticNavigation(
            ASSUMED_SITE, False, self.training * interval, length * interval, length // EPOCHS * interval
        )

    def statistics(self) -> LogStatistics:
        """Return the statistics of the measured log."""
        return self._summary(self.measured)

    def simulate(self, name: str, seed: int, numbers: Iterable[int]) -> list[LogStatistics]:
        """Simulate a model, ``before`` or ``after``, once for each of ``numbers``; return the statistics."""
        return [self._summary(table) for table in self._simulations(name, seed, numbers)]

    def distribution(self, seed: int, count: int = SIMULATIONS) -> SquaredDistances:
        """Return the distances over views of the error."""
        return distribution(self.statistics(), *(self.simulate(name, seed, range(count)) for name in SIDES))

    def drifts(self, seed: int, count: int = SIMULATIONS) -> "Drifts":
        """Return the drifts of a device at rest."""
        return self.drifts_of(self.statistics(), *(self.simulate(name, seed, range(count)) for name in SIDES))

    def drifts_of(
        self, own: LogStatistics, before: Sequence[LogStatistics], after: Sequence[LogStatistics]
    ) -> "Drifts":
        """Return the drifts for the statistics of the measured and the simulated logs."""
        start, final = (np.array([one.path for one in ensemble]) for ensemble in (before, after))
        return Drifts(self.course.epochs(), own.path, start, final)

    def _summary(self, table: pd.DataFrame) -> LogStatistics:
        """Return the statistics of the log or of a simulation of it."""
        first, errors, scale = self.training, self._errors(table), self._scale
        views = {axis: _views(x[first:], x[:first].mean(), scale[axis]) for axis, x in errors.items()}
        return LogStatistics(views, None if self.course is None else self._path(table))

    def _path(self, table: pd.DataFrame) -> np.ndarray:
        found = self.course.drift_of(table[list(log.AXES)].to_numpy(float), self._interval)
        return found[drift.STARTS.index("calibrated"), :, :3]

    def _errors(self, table: pd.DataFrame) -> dict[str, np.ndarray]:
        axes = list(log.axes(self.measured))
        own = table[axes] if self.reference is None else table[axes] - self.reference[axes].to_numpy()
        return {axis: own[axis].to_numpy(float) for axis in axes}

    @cached_property
    def _interval(self) -> float:
        """Sampling interval [s]."""
        return log.interval(self.measured)

    @cached_property
    def _scale(self) -> dict[str, float]:
        """Return the standard deviation of the measured errors of the training part."""
        return {axis: values[: self.training].std() for axis, values in self._errors(self.measured).items()}

    def _simulations(self, name: str, seed: int, numbers: Iterable[int]) -> Iterator[pd.DataFrame]:
        """Simulate the whole log, of which the held-out part is the continuation of the training part.

        Both models get the same random numbers, so that models that are alike are at the same distance.
        """
        model = getattr(self, name)
        for number in numbers:
            labels = ("distance", number)
            rng = stream(seed, *labels, "parameters")
            drawn = model.draw(rng) if isinstance(model, UncertainModel) else model
            sensors = ErrorModel({axis: drawn.axes.get(axis, AxisModel()) for axis in log.axes(self.measured)})
            ideal, at = (self._at_rest(sensors), None) if self.reference is None else self._in_motion
            yield sensors.simulate(ideal, seed, *labels, at=at)

    def _at_rest(self, model: ErrorModel) -> pd.DataFrame:
        """Return the error-free log of a device at rest: the level less what the model adds to it on the average."""
        table = self._with_temperature(self.measured.copy())
        training = conditions(table.iloc[: self.training])
        for axis in log.axes(self.measured):
            added = offset_of(model[axis]) + mean_of_terms(model[axis], training[axis])
            table[axis] = level_before_rounding(self._levels[axis], model[axis], self._interval) - added
        return table

    @cached_property
    def _in_motion(self) -> tuple[pd.DataFrame, Mapping[str, Conditions]]:
        """Return the reference as the error-free log, and its conditions, which all simulations share."""
        ideal = self._with_temperature(self.reference.copy())
        return ideal, conditions(ideal, self.motion)

    def _with_temperature(self, table: pd.DataFrame) -> pd.DataFrame:
        """Return an error-free log with the measured temperature, at times since its start."""
        if log.TEMPERATURE in self.measured:
            table[log.TEMPERATURE] = self.measured[log.TEMPERATURE].to_numpy()
        return table.set_axis(pd.Index(self.measured.index - self.measured.index[0], name=log.TIME))

    @cached_property
    def _levels(self) -> Mapping[str, float]:
        if self.level is not None:
            return self.level
        return {axis: float(self.measured[axis].iloc[: self.training].mean()) for axis in log.axes(self.measured)}


@dataclass(frozen=True, eq=False)
class Drifts:
    """Free-inertial drift of a device at rest through the held-out part, measured and simulated.

    Attributes
    ----------
    time
        Since the start of the navigation [s], shape (epochs,).
    measured
        Position error north, east, down [m], shape (epochs, 3).
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
    own: LogStatistics, before: Sequence[LogStatistics], after: Sequence[LogStatistics], axes: Iterable[str] = ()
) -> SquaredDistances:
    """Return the distances over the views of some axes, by default all, from the statistics of log and ensembles."""
    names = tuple(axes) or tuple(own.views)
    flat = [[view for axis in names for view in one.views[axis]] for one in (own, *before, *after)]
    return _apart(flat[0], flat[1 : 1 + len(before)], flat[1 + len(before) :])


def have_scatter(simulations: Sequence[LogStatistics]) -> bool:
    """Return whether simulations of a model differ in each view of each axis.

    Where they do not, as without noise, the distance of a log that is different has no scale.
    """
    return all(
        np.any(rows.std(axis=0, ddof=1) > _rounding(rows))
        for axis in simulations[0].views
        for rows in _rows([one.views[axis] for one in simulations])
    )


def _views(values: np.ndarray, level: float, scale: float) -> list[np.ndarray]:
    """Return the statistics of the held-out values of one axis; ``level`` is the mean of the training parts.

    ``scale`` is the standard deviation of the measured values, which sets the bounds below which samples are counted:
    on a lattice these shares are binomial, while quantiles jump.
    """
    first = block_starts(len(values), BLOCKS, MIN_BLOCK_SAMPLES)
    number = np.diff(np.r_[first, len(values)])
    off = values - level
    means = np.add.reduceat(off, first) / number
    squares = np.add.reduceat((off - np.repeat(means, number)) ** 2, first) / number
    edges, widths = bands(len(values) - 1, BAND_WIDTH, 1)
    power = np.add.reduceat(dct(values - values.mean(), norm="ortho")[1:] ** 2, edges) / widths
    averaging = allan.factors(len(values), PER_DECADE)
    told = np.minimum(SHARES, 1 - SHARES) * len(values) >= MIN_EXPECTED
    below = np.array([np.count_nonzero(off < bound) for bound in scale * ndtri(SHARES[told])])
    shares = np.arcsin(np.sqrt((below + 3 / 8) / (len(values) + 3 / 4)))
    tiny = np.finfo(float).tiny
    logs = [np.log(np.maximum(part, tiny)) for part in (allan.variance(values, averaging), power, squares)]
    return [*logs, means, shares]


def _apart(own: list[np.ndarray], start: list[list[np.ndarray]], final: list[list[np.ndarray]]) -> SquaredDistances:
    """Return the squared distances between the vectors of the measured log and of the simulations of both models."""
    floor = [_squares(one, final[:i] + final[i + 1 :]) for i, one in enumerate(final)]
    return SquaredDistances(_squares(own, start), _squares(own, final), np.array(floor))


def _squares(one: list[np.ndarray], ensemble: list[list[np.ndarray]]) -> np.ndarray:
    """Return the mean square, over views, of the standardised difference from each member, shape (count,).

    Differences are divided by sqrt(2) times the scatter of the entry among the members, so that two members have
    distance 1 on average. The mean over the entries of a view comes first: all views of all axes have equal weight.
    """
    squares = []
    for part, rows in zip(one, _rows(ensemble), strict=True):
        spread, least = rows.std(axis=0, ddof=1), _rounding(np.vstack([part, rows]))
        if np.any(varied := spread > least):
            least = np.maximum(least, MIN_RELATIVE_SCATTER * np.median(spread[varied]))
        squares.append(np.mean(((part - rows) / np.maximum(spread, least)) ** 2, axis=1) / 2)
    return np.mean(squares, axis=0)


def _rounding(rows: np.ndarray) -> np.ndarray:
    """Return the scatter that rounding may make of each entry of rows, shape (members, entries)."""
    return ROUNDING * np.abs(rows).max(axis=0) + np.finfo(float).tiny


def _rows(ensemble: Sequence[list[np.ndarray]]) -> Iterator[np.ndarray]:
    """Iterate over the views of the members of an ensemble, shape (members, entries) each."""
    return map(np.array, zip(*ensemble, strict=True))


def _interval(values: list[float] | np.ndarray) -> Interval:
    """Return the median and the prediction interval of probability :data:`COVERAGE`."""
    low, middle, high = np.quantile(values, [(1 - COVERAGE) / 2, 0.5, (1 + COVERAGE) / 2], method="weibull")
    return Interval(float(middle), float(low), float(high), "1")

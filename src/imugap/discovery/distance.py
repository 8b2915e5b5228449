"""How far a measured log is from simulated ones on held-out data: before, after, and the floor.

The *before* and *after* are the distances to ensembles of the start and of the final model, the *floor* the distance
of simulations of the final model from each other. Each is in units of the scatter of the model's own simulations: a
model that claims to know more than it does is far away, not close.
Logs are taken as evenly sampled; errors of the clock are left out.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import radians

import numpy as np
import pandas as pd
from scipy.fft import dct
from scipy.special import ndtri

from imugap import allan, drift, log
from imugap.discovery.finding import Interval
from imugap.discovery.rounding import level_ahead
from imugap.discovery.uncertain import Uncertain
from imugap.discovery.views.curve import blocks
from imugap.discovery.views.spectral import bands
from imugap.effects import Bias
from imugap.model import AxisModel, ErrorModel
from imugap.site import Site
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
ANYWHERE = Site(radians(45.0), 0.0)
"""Where a device stands if nobody says: only the gravity of the place matters."""

Model = ErrorModel | Uncertain


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
class Apart:
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


def together(logs: Sequence[Apart]) -> Distances:
    """Return the distances over several logs of a device, each of the same weight: root mean squares."""
    before, after, floor = (
        np.sqrt(np.mean([getattr(one, name) for one in logs], axis=0)) for name in ("before", "after", "floor")
    )
    return Distances(_interval(before), _interval(after), _interval(np.median(floor, axis=1)))


def distribution(
    measured: pd.DataFrame,
    split: float,
    before: Model,
    after: Model,
    seed: int,
    count: int = COUNT,
    reference: pd.DataFrame | None = None,
    level: Mapping[str, float] | None = None,
) -> Apart:
    """Return the distances over views of the error: Allan variance, spectrum, block means and variances, shares.

    Parameters
    ----------
    measured
        The whole log.
    split
        Time [s] of the log at which the held-out part begins.
    before, after
        Start and final model, with or without the uncertainty of their parameters.
    reference
        Error-free log at the same times, for a device in motion; a device at rest needs none.
    level
        Mean of each axis over the held-in part, which is that of the measured values unless it is given: clipped
        values have another one than the device.
    """
    held_in, axes = _split(measured, split), log.axes(measured)

    def errors(table: pd.DataFrame) -> dict[str, np.ndarray]:
        own = table[list(axes)] if reference is None else table[list(axes)] - reference[list(axes)].to_numpy()
        return {axis: own[axis].to_numpy(float) for axis in axes}

    scale = {axis: values[:held_in].std() for axis, values in errors(measured).items()}

    def vector(table: pd.DataFrame) -> list[np.ndarray]:
        columns = errors(table).items()
        return [one for axis, x in columns for one in _views(x[held_in:], x[:held_in].mean(), scale[axis])]

    simulations = Simulations(_means(measured, held_in) if level is None else level, seed, count, reference)
    start, final = ([vector(one) for one in tables] for tables in simulations.both(measured, before, after))
    return _apart(vector(measured), start, final)


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

    def apart(self) -> Apart:
        """Return the distances over the drift at :data:`HORIZONS`."""
        at = np.rint((len(self.time) - 1) * HORIZONS).astype(int)
        start, final = ([list(one[at]) for one in ensemble] for ensemble in (self.before, self.after))
        return _apart(list(self.measured[at]), start, final)


def drifts(
    measured: pd.DataFrame,
    split: float,
    before: Model,
    after: Model,
    seed: int,
    count: int = COUNT,
    level: Mapping[str, float] | None = None,
    site: Site = ANYWHERE,
) -> Drifts:
    """Return the drifts from biases that are the means of the held-in part.

    Parameters as those of :func:`distribution`; all six axes have to be there.
    """
    held_in, interval = _split(measured, split), log.interval(measured)
    length = (len(measured) - held_in - 1) // EPOCHS * EPOCHS
    course = drift.Course(site, False, held_in * interval, length * interval, length // EPOCHS * interval)

    def positions(table: pd.DataFrame) -> np.ndarray:
        even = log.from_samples({axis: table[axis].to_numpy(float) for axis in log.AXES}, interval)
        return course.drift(even)[drift.STARTS.index("calibrated"), :, :3]

    simulations = Simulations(_means(measured, held_in) if level is None else level, seed, count)
    start, final = (
        np.array([positions(one) for one in tables]) for tables in simulations.both(measured, before, after)
    )
    return Drifts(course.epochs(), positions(measured), start, final)


def _split(measured: pd.DataFrame, split: float) -> int:
    """Return the number of samples of the held-in part."""
    held_in = int(np.searchsorted(measured.index.to_numpy(), split))
    fewest = 4 * SHORTEST
    if min(held_in, len(measured) - held_in) < fewest:
        raise ValueError(f"split: expected {fewest} samples on either side; found {held_in} before {split:g} s")
    return held_in


def _means(measured: pd.DataFrame, held_in: int) -> dict[str, float]:
    return {axis: float(measured[axis].iloc[:held_in].mean()) for axis in log.axes(measured)}


@dataclass(frozen=True, eq=False)
class Simulations:
    """How a log is simulated again and again.

    Attributes
    ----------
    level
        Mean output of each axis of a device at rest.
    seed, count
        Seed and number of simulations.
    reference
        Error-free log, or None for a device at rest.
    """

    level: Mapping[str, float]
    seed: int
    count: int
    reference: pd.DataFrame | None = None

    def both(self, measured: pd.DataFrame, before: Model, after: Model) -> tuple[Iterator[pd.DataFrame], ...]:
        """Simulate with the start and with the final model."""
        return self.of(measured, before, "before"), self.of(measured, after, "after")

    def of(self, measured: pd.DataFrame, model: Model, name: str) -> Iterator[pd.DataFrame]:
        """Simulate the whole log, the held-out part as what follows on the held-in one."""
        for index in range(self.count):
            labels = ("distance", name, index)
            rng = stream(self.seed, *labels, "parameters")
            drawn = model.draw(rng) if isinstance(model, Uncertain) else model
            sensors = ErrorModel({axis: drawn.axes.get(axis, AxisModel()) for axis in log.axes(measured)})
            yield sensors.simulate(self._ideal(measured, sensors), self.seed, *labels)

    def _ideal(self, measured: pd.DataFrame, model: ErrorModel) -> pd.DataFrame:
        """Return the error-free log: the reference, or the level less the model's biases."""
        table = measured.copy() if self.reference is None else self.reference.set_axis(measured.index)
        if self.reference is None:
            for axis in log.axes(measured):
                biases = sum(effect.value for effect in model[axis] if isinstance(effect, Bias))
                table[axis] = level_ahead(self.level[axis], model[axis], log.interval(measured)) - biases
        if log.TEMPERATURE in measured:
            table[log.TEMPERATURE] = measured[log.TEMPERATURE]
        return table.set_axis(pd.Index(measured.index - measured.index[0], name=log.TIME))


def _views(values: np.ndarray, level: float, scale: float) -> list[np.ndarray]:
    """Return what views say of the held-out values of one axis, ``level`` being the mean of the held-in ones.

    ``scale`` is the standard deviation of measured values, which sets the bounds below which samples are counted: on
    a lattice their shares vary as those of a binomial law, while quantiles jump.
    """
    first = blocks(len(values), BLOCKS, SHORTEST)
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


def _apart(own: list[np.ndarray], start: list[list[np.ndarray]], final: list[list[np.ndarray]]) -> Apart:
    """Return the squared distances of vectors of the measured log and of the simulations of both models."""
    floor = [_squares(one, final[:i] + final[i + 1 :]) for i, one in enumerate(final)]
    return Apart(_squares(own, start), _squares(own, final), np.array(floor))


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

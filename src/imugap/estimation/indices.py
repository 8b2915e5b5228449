"""Performance indices of a device from static runs (IEEE 952, IEEE 1554, JJF 1535-2015; He et al. 2023, eqs. 5-9).

A table of indices has one row per axis and index, columns ``axis``, ``symbol`` (of :data:`INDICES`), ``value``,
``low``, ``high`` (95 % interval), all SI, and ``holds``: whether the value is a reading (True) or an upper bound.
"""

from dataclasses import dataclass

import numpy as np
import pandas as pd
from scipy.special import stdtrit

from imugap import log
from imugap.estimation.screening import information
from imugap.estimation.variances import allan
from imugap.numerics.samples.bias_stability import bias_stability, period_means

LEVEL = 0.95
ROUND_OFF = 1e-9
"""Relative round-off of a duration."""
BATCHES = 10
"""Number of batches of a run, whose scatter gives the intervals of its bias and bias stability."""


@dataclass(frozen=True)
class Index:
    """Performance index: symbol, title, data-sheet units, and shortest log [s] from which it can be computed."""

    symbol: str
    title: str
    gyro_unit: str
    accel_unit: str
    minimum_s: float

    def unit(self, axis: str) -> str:
        """Return the data-sheet unit for ``axis``."""
        return self.gyro_unit if axis in log.GYRO else self.accel_unit


INDICES = {
    index.symbol: index
    for index in (
        Index("bias", "bias", "deg/h", "mg", 10.0),
        Index("stability", "bias stability", "deg/h", "ug", 20.0),
        Index("repeatability", "bias repeatability", "deg/h", "mg", 10.0),
        Index("N", "white noise (random walk of the integral)", "deg/sqrt(h)", "m/s/sqrt(h)", 20.0),
        Index("B", "bias instability", "deg/h", "ug", 600.0),
        Index("K", "random walk of the rate", "deg/h/sqrt(h)", "m/s/h/sqrt(h)", 600.0),
    )
}


def of_run(table: pd.DataFrame, ideal: pd.Series, period: float, symbols: tuple[str, ...]) -> pd.DataFrame:
    """Return the indices of one static run, plus ``tau_low`` and ``tau_high`` [s] of the readings.

    Parameters
    ----------
    table
        Log of the run.
    ideal
        Error-free reading per axis, SI (Earth rate and gravity where they are known).
    period
        Averaging period P of the bias stability [s].
    symbols
        Indices to compute; the repeatability needs several runs (:func:`over_runs`).
    """
    interval = log.interval(table)
    parts = [
        of_samples(
            IndexSamples(axis, table[axis].to_numpy(), np.zeros(len(table), bool), interval),
            ideal[axis],
            period,
            symbols,
        )
        for axis in log.axes(table)
    ]
    return pd.concat(parts, ignore_index=True)


@dataclass(frozen=True, eq=False)
class IndexSamples:
    """Samples of one axis of a run.

    Attributes
    ----------
    axis
        Name of the axis.
    values
        Evenly spaced samples, shape (n,).
    drawn
        Which of them were not measured but drawn given the others, shape (n,).
    interval
        Sampling interval [s].
    """

    axis: str
    values: np.ndarray
    drawn: np.ndarray
    interval: float


def of_samples(one: IndexSamples, ideal: float, period: float, symbols: tuple[str, ...]) -> pd.DataFrame:
    """Return the indices of one axis of a static run as :func:`of_run` does; drawn samples have no part in the bias."""
    interval = one.interval
    _long_enough(len(one.values) * interval, interval, period, symbols)
    measured = np.count_nonzero(~one.drawn)
    if measured < BATCHES:
        raise log.LogError("log", one.axis, f"at least {BATCHES} measured samples", str(measured))
    error = one.values - ideal
    rows = []
    if "bias" in symbols:
        rows.append({"symbol": "bias", "holds": True} | _bias(error[~one.drawn]))
    if "stability" in symbols:
        share = information(1 - float(np.mean(one.drawn)))
        rows.append({"symbol": "stability", "holds": True} | _stability(error, interval, period, share))
    laws = [law for law in allan.LAWS.values() if law.symbol in symbols]
    if laws:
        asd = allan.curve(error, interval, LEVEL, one.drawn)
        rows += [{"symbol": law.symbol} | vars(allan.tangent(asd, law, LEVEL)) for law in laws]
    columns = ["axis", "symbol", "value", "low", "high", "holds", "tau_low", "tau_high"]
    return pd.DataFrame([{"axis": one.axis} | row for row in rows], columns=columns)


def over_runs(runs: pd.DataFrame) -> pd.DataFrame:
    """Return the indices of the device from those of its runs (a table of :func:`of_run` with a column ``run``).

    Values are means over the runs with Student intervals; the repeatability (eq. 9) has a chi-square interval. A
    coefficient that is identified in most of the runs is the mean over these, ``runs`` their number (one keeps the
    interval of its run); else its upper bound is the mean of those of all runs. A single run keeps its own intervals
    and has no repeatability.
    """
    if runs["run"].nunique() == 1:
        return runs.drop(columns=["run", "tau_low", "tau_high"]).assign(runs=1)
    rows = []
    for (axis, symbol), group in runs.groupby(["axis", "symbol"], sort=False):
        if group["holds"].mean() <= 0.5:
            rows.append(_row(axis, symbol, group["value"].mean(), 0.0, group["high"].mean(), False, len(group)))
            continue
        read = group[group["holds"]]
        if len(read) == 1:
            one = read.iloc[0]
            rows.append(_row(axis, symbol, one["value"], one["low"], one["high"], True, 1))
            continue
        values = read["value"].to_numpy()
        half = _student(len(values)) * values.std(ddof=1) / np.sqrt(len(values))
        rows.append(_row(axis, symbol, values.mean(), values.mean() - half, values.mean() + half, True, len(values)))
        if symbol == "bias":
            rows.append(_row(axis, "repeatability", *repeatability(values), True, len(values)))
    return pd.DataFrame(rows)


def repeatability(biases: np.ndarray, level: float = LEVEL) -> tuple[float, float, float]:
    """Return the standard deviation of the runs' biases (eq. 9) and its chi-square interval."""
    freedom = len(biases) - 1
    value = biases.std(ddof=1)
    low, high = allan.deviation_limits(value, freedom, level)
    return float(value), float(low), float(high)


def _row(axis: str, symbol: str, value: float, low: float, high: float, holds: bool, runs: int) -> dict:
    return {"axis": axis, "symbol": symbol, "value": value, "low": low, "high": high, "holds": holds, "runs": runs}


def _bias(error: np.ndarray) -> dict[str, float]:
    """Return the mean (eq. 5) with its interval from batch means."""
    means = np.array([batch.mean() for batch in np.array_split(error, BATCHES)])
    half = _student(BATCHES) * means.std(ddof=1) / np.sqrt(BATCHES)
    value = error.mean()
    return {"value": value, "low": value - half, "high": value + half}


def _stability(error: np.ndarray, interval: float, period: float, share: float) -> dict[str, float]:
    """Return the bias stability (eq. 7) with its interval from the mean squares of batches.

    ``share`` is the share of the information that is left where samples were drawn.
    """
    squares = (period_means(error, interval, period) - error.mean()) ** 2
    batches = np.array([batch.mean() for batch in np.array_split(squares, BATCHES)])
    half = _student(BATCHES) * batches.std(ddof=1) / np.sqrt(BATCHES * share)
    low, high = np.sqrt(np.maximum([batches.mean() - half, batches.mean() + half], 0))
    return {"value": bias_stability(error, interval, period), "low": low, "high": high}


def _student(count: int) -> float:
    return float(stdtrit(count - 1, (1 + LEVEL) / 2))


def shortest(symbol: str, period: float, interval: float) -> float:
    """Return the length [s] of the shortest log for an index, of given averaging period and sampling interval [s]."""
    needed = {"stability": 2 * BATCHES * period} | dict.fromkeys(allan.LAWS, allan.SHORTEST * interval)
    return max(INDICES[symbol].minimum_s, needed.get(symbol, 0.0))


def _long_enough(duration: float, interval: float, period: float, symbols: tuple[str, ...]) -> None:
    for symbol in symbols:
        needed = shortest(symbol, period, interval)
        if duration < needed * (1 - ROUND_OFF):
            expected = f"at least {needed:g} s for the {INDICES[symbol].title}"
            raise log.LogError("log", "duration", expected, f"{duration:g} s")

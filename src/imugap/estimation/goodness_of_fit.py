"""Goodness of fit: compare the wavelet variances of a log with those of a model, octave by octave.

The scatter of the wavelet variances is computed from the model itself.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
from scipy.special import chdtr, chdtrc

from imugap.effects.effect import AxisModel
from imugap.estimation.cramer_rao import fisher
from imugap.estimation.likelihood import Composition, Grid, parameters
from imugap.estimation.variances import wavelet_variance
from imugap.numerics.spectra.daubechies import depth

FITS = "fits"
MISFIT = "misfit"
DIFFERENCE = 1e-4
"""Change of a log parameter in a difference quotient."""
SATURATED = 1e-3
"""Lower limit of the share of the variance of an octave that remains after a fit."""
UNKNOWN = 1e-12
"""Information added to keep the matrix of parameters that the log does not separate invertible."""
NAMED = 3
"""Number of ranges of octaves that a verdict lists."""
TIMES = 3.0
"""Ratio above which a verdict gives a factor in place of per cent."""
SMALLEST = 1e-12
"""Smallest p-value that a verdict gives as a number."""


@dataclass(frozen=True)
class Goodness:
    """Goodness of fit of a model.

    Attributes
    ----------
    table
        Index ``level``; columns ``tau`` [s], ``low_hz``, ``high_hz`` (the octave), ``observed``, ``implied`` [unit^2],
        ``ratio``, ``deviation`` (in standard deviations under the model with known parameters), ``p`` (two-sided).
    p_value
        Probability of so large a deviation in any octave under the model; slightly conservative (Sidak's inequality).
    verdict
        "fits", or the octaves that deviate, by how much, the most significant first, and the p-value.
    off
        Shortest and longest averaging time [s] of each range of octaves that deviate, the most significant first.
    """

    table: pd.DataFrame
    p_value: float
    verdict: str
    off: tuple[tuple[float, float], ...] = ()

    @property
    def fits(self) -> bool:
        """Return whether no octave deviates significantly."""
        return self.verdict == FITS


def of(
    model: AxisModel,
    sequence: np.ndarray,
    interval: float,
    level: float = 0.95,
    width: int = 2,
    fitted: bool = True,
    highest: float = np.inf,
    share: float = 1.0,
) -> Goodness:
    """Test a model of an error sequence.

    Parameters
    ----------
    sequence, interval
        Samples, shape (n,), and sampling interval [s].
    level
        Probability that the true model passes.
    width
        Width of the wavelet filter. Wider filters separate octaves better, but do not respond to a ramp.
    fitted
        Whether the parameters were estimated from this sequence. The residuals of an efficient estimate have the
        covariance C - J V J', C of the wavelet variances, J their slopes, V the Cramer-Rao bound of the parameters; a
        ramp counts as known.
    highest
        Highest frequency [Hz] of the model: octaves above are not judged.
    share
        Share of the samples that were measured; the others are drawn given these.
    """
    sequence = np.asarray(sequence, float)
    levels = depth(len(sequence), width)
    observed, implied = (
        wavelet_variance.variance(sequence, levels, width),
        wavelet_variance.implied(model, interval, levels, width),
    )
    variance = np.diag(wavelet_variance.covariance(model, interval, len(sequence), levels, width))
    removed = _removed(model, interval, len(sequence), levels, width) if fitted else np.zeros(levels)
    scatter = np.maximum(variance - removed, SATURATED * variance)
    index = pd.RangeIndex(1, levels + 1, name="level")
    columns = {
        "tau": 2.0 ** (index - 1) * interval,
        "low_hz": 2.0 ** -(index + 1) / interval,
        "high_hz": 2.0**-index / interval,
        "observed": observed,
        "implied": implied,
        "ratio": observed / implied,
        "deviation": (observed - implied) / np.sqrt(variance),
        "p": _probability(observed / implied, share * 2 * implied**2 / scatter),
    }
    table = pd.DataFrame(columns, index=index)
    judged = table[table["high_hz"] <= max(highest, table["high_hz"].min())]
    joint = float(-np.expm1(len(judged) * np.log1p(-judged["p"].min())))
    off = judged[judged["p"] < 1 - level ** (1 / len(judged))]
    if not len(off):
        return Goodness(table, joint, FITS)
    ranges = _ranges(off)
    return Goodness(table, joint, _verdict(ranges, joint), tuple(_times(run) for run in ranges))


def _removed(model: AxisModel, interval: float, count: int, levels: int, width: int) -> np.ndarray:
    """Return the variance of each wavelet variance, shape (levels,), that fitting the parameters removes: J V J'."""
    composition, theta = parameters(AxisModel(tuple(effect for effect in model.stochastic() if _present(effect))))
    grid = Grid.of(count, interval)
    information = fisher(theta, composition.shapes(grid), grid) + UNKNOWN * np.eye(len(theta))
    slopes = [_slope(composition, theta, step, (interval, levels, width)) for step in DIFFERENCE * np.eye(len(theta))]
    return np.einsum("il,ij,jl->l", slopes, np.linalg.inv(information), slopes)


def _present(effect) -> bool:
    """Return whether all parameters of an effect are above zero."""
    return all(effect.parameters().values())


def _slope(composition: Composition, theta: np.ndarray, step: np.ndarray, analysis: tuple) -> np.ndarray:
    below, above = (wavelet_variance.implied(composition.model(theta + side * step), *analysis) for side in (-1, 1))
    return (above - below) / (2 * DIFFERENCE)


def _probability(ratio: np.ndarray, edf: np.ndarray) -> np.ndarray:
    """Return the two-sided p-value of the ratio of a variance with ``edf`` degrees of freedom to its expectation."""
    return np.minimum(2 * np.minimum(chdtr(edf, edf * ratio), chdtrc(edf, edf * ratio)), 1 - 1e-16)


def _ranges(off: pd.DataFrame) -> list[pd.DataFrame]:
    """Return the ranges of octaves that deviate, neighbours of the same sign in one, the most significant first."""
    more = off["ratio"] > 1
    starts = more.ne(more.shift()) | (off.index.to_series().diff() != 1)
    return sorted((run for _, run in off.groupby(starts.cumsum())), key=lambda run: -run["deviation"].abs().max())


def _times(run: pd.DataFrame) -> tuple[float, float]:
    return float(run["tau"].min()), float(run["tau"].max())


def _verdict(ranges: Sequence[pd.DataFrame], p_value: float) -> str:
    """Return in words the ranges of octaves that deviate."""
    rest = len(ranges) - NAMED
    named = [*map(_range, ranges[:NAMED]), *([f"{rest} more"] if rest > 0 else [])]
    shown = f"p = {p_value:.2g}" if p_value > SMALLEST else f"p < {SMALLEST:g}"
    return f"{MISFIT} at {'; '.join(named)} ({shown})"


def _range(run: pd.DataFrame) -> str:
    """Return octaves and size of a misfit, e.g. "12.5-25 Hz, averaging time 0.02 s: 34 % more than the model"."""
    ratio = run["ratio"].loc[run["deviation"].abs().idxmax()]
    span = f"{run['low_hz'].min():.3g}-{run['high_hz'].max():.3g} Hz, {_averaging(*_times(run))}"
    if ratio > TIMES:
        return f"{span}: {ratio:.2g} times the model"
    percent = float(f"{100 * abs(ratio - 1):.2g}")
    return f"{span}: {percent:g} % {'more' if ratio > 1 else 'less'} than the model"


def _averaging(first: float, last: float) -> str:
    return f"averaging time {first:.3g} s" if first == last else f"averaging times {first:.3g} to {last:.3g} s"

"""Bias that follows the measured temperature of a device at rest: a term of the mean, added to the random processes.

The coefficients are those of generalised least squares with the spectrum of the random processes, in the cosine basis.
Term and processes are estimated in turn. The term is kept if the criterion of model selection is higher with it, so
that a random walk which happens to go along with the temperature is not taken for it.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from scipy.fft import dct

from imugap.effects import RateRamp, Temperature
from imugap.effects.conditions import Conditions
from imugap.effects.effect import AxisModel
from imugap.effects.temperature import LAWS
from imugap.estimation.model_selection import Choice, penalty
from imugap.estimation.result import Identifiability, ParameterEstimate
from imugap.integrity.thermometer import smoothed
from imugap.numerics.normal_quantile import NORMAL_QUANTILE

SPAN = 0.1
"""Least change of the temperature over a log that is considered [degC]."""
WORTH = 3.0
"""Gain of log-likelihood over the processes selected without temperature, from which the term is tried."""
MARGIN = 4.0
"""Gain of the criterion from which the term is kept: temperature and bias both drift, and may agree by chance."""


@dataclass(frozen=True, eq=False)
class TemperatureTerm:
    """Bias that follows the temperature: effect, estimates, values, shape (n,), and selection of the other effects."""

    effect: Temperature
    estimates: tuple[ParameterEstimate, ...]
    values: np.ndarray
    choice: Choice


def temperature_term(
    values: np.ndarray,
    temperature: np.ndarray,
    interval: float,
    without: Choice,
    select: Callable[[np.ndarray], Choice],
    level: float,
) -> TemperatureTerm | None:
    """Return the term of a log that explains it better than random processes alone, or None.

    Parameters
    ----------
    values, temperature
        Samples and readings [degC], shape (n,), every ``interval`` [s].
    without
        Selection without a term.
    select
        Function that selects the random processes of samples.
    level
        Confidence level of the decision.
    """
    readings = smoothed(temperature)
    if np.ptp(readings) < SPAN or len(values) < len(LAWS):
        return None
    conditions = Conditions(interval * np.arange(len(values)), interval, readings)
    reference = float(readings.mean())
    bases = [(law, _columns(law, reference, conditions)) for law in LAWS]
    worth = {law: _gain(_solved(values, columns, without.fit.model, interval)) for law, columns in bases}
    if max(worth.values()) < WORTH:
        return None
    best, least = None, _criterion(without) + MARGIN
    for law, columns in bases:
        model = without.fit.model
        for _ in range(2):
            coefficients, covariance = _solved(values, columns, model, interval)
            choice = select(values - columns @ coefficients)
            model = choice.fit.model
        value = _criterion(choice) - penalty(level) * len(law)
        if value > least:
            coefficients, covariance = _solved(values, columns, model, interval)
            effect = Temperature(reference=reference, **dict(zip(law, coefficients.tolist(), strict=True)))
            estimates = tuple(_estimates(law, coefficients, covariance, reference))
            best, least = TemperatureTerm(effect, estimates, columns @ coefficients, choice), value
    return best


def _criterion(choice: Choice) -> float:
    return float(choice.candidates["criterion"].max())


def _columns(law: tuple[str, ...], reference: float, conditions: Conditions) -> np.ndarray:
    slopes = Temperature(0.0, reference).slopes(conditions)
    return np.column_stack([slopes[name] for name in law])


def _solved(
    values: np.ndarray, columns: np.ndarray, model: AxisModel, interval: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return the coefficients of columns, and their covariance, of generalised least squares with an unknown mean."""
    count = len(values)
    weight = 1 / np.sqrt(_variance(model, interval, count))
    ramp = interval * np.arange(count) if any(isinstance(one, RateRamp) for one in model) else np.empty((count, 0))
    design = np.column_stack([columns, ramp]) if ramp.size else columns
    design = dct(design, axis=0, norm="ortho")[1:] * weight[:, None]
    seen = dct(values, norm="ortho")[1:] * weight
    covariance = np.linalg.inv(design.T @ design)
    kept = slice(columns.shape[1])
    return (covariance @ (design.T @ seen))[kept], covariance[kept, kept]


def _variance(model: AxisModel, interval: float, count: int) -> np.ndarray:
    """Return the variance of the cosine coefficients k = 1..n-1 of the random processes of a model."""
    frequency = np.arange(1, count) / (2 * count * interval)
    knots = np.unique(
        np.r_[np.arange(1, min(count, 257)), np.geomspace(min(count - 1, 256), count - 1, 512).astype(int)]
    )
    at = knots / (2 * count * interval)
    psd = AxisModel(model.stochastic()).sampled_psd(at, interval) / interval
    return np.exp(np.interp(np.log(frequency), np.log(at), np.log(psd)))


def _gain(solved: tuple[np.ndarray, np.ndarray]) -> float:
    coefficients, covariance = solved
    return float(coefficients @ np.linalg.solve(covariance, coefficients)) / 2


def _estimates(
    law: tuple[str, ...], coefficients: np.ndarray, covariance: np.ndarray, reference: float
) -> Iterator[ParameterEstimate]:
    for name, value, error in zip(law, coefficients.tolist(), np.sqrt(np.diag(covariance)).tolist(), strict=True):
        low, high = value - NORMAL_QUANTILE * error, value + NORMAL_QUANTILE * error
        known = Identifiability.IDENTIFIED if low * high > 0 else Identifiability.UPPER_BOUND
        yield ParameterEstimate(Temperature.name, 1, name, value, low, high, error / abs(value), known)
    fixed = Identifiability.IDENTIFIED
    yield ParameterEstimate(Temperature.name, 1, "reference", reference, reference, reference, 0.0, fixed)

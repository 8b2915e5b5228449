"""Estimation of one axis by a chosen method, and its report: JSON records, tables, Allan curves."""

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from difflib import get_close_matches
from enum import StrEnum
from math import isfinite

import numpy as np
import pandas as pd
from scipy.special import chdtri

from imugap.effects import CATALOGUE, GaussMarkov, Quantization, RateRamp, WhiteNoise
from imugap.estimation import allan, allan_slopes, goodness_of_fit, maximum_likelihood
from imugap.estimation.gmwm import estimator
from imugap.estimation.gmwm.estimator import GmwmOptions
from imugap.estimation.model_selection import TERMS, Choice, Kinds, choose, title
from imugap.estimation.result import Fit, Identifiability, ParameterEstimate
from imugap.estimation.wavelet_variance import EFFICIENCY
from imugap.log import GYRO


class Method(StrEnum):
    """Method of estimation."""

    LIKELIHOOD = "likelihood"
    """Maximum likelihood (:mod:`imugap.estimation.maximum_likelihood`)."""
    WAVELET = "wavelet"
    """Generalised method of wavelet moments (:mod:`imugap.estimation.gmwm.estimator`)."""
    ALLAN = "allan"
    """Slopes of the Allan deviation (:mod:`imugap.estimation.allan_slopes`)."""


@dataclass(frozen=True)
class EstimatorSettings:
    """Settings of an estimation.

    Attributes
    ----------
    kinds
        Kinds of effects to estimate, or None to select them (:func:`imugap.estimation.model_selection.choose`).
    method
        Method of estimation.
    highest
        Highest frequency [Hz] that likelihood and selection use.
    robust
        Whether to use the robust wavelet variance, on which outliers have a bounded effect.
    level
        Confidence level.
    """

    kinds: Kinds | None = None
    method: Method = Method.LIKELIHOOD
    highest: float = np.inf
    robust: bool = False
    level: float = 0.95

    def __post_init__(self) -> None:
        """Check that the method supports the settings; ValueError otherwise."""
        if self.robust and self.method != Method.WAVELET:
            raise ValueError(f"robust: expected the method {Method.WAVELET}; found {self.method}")
        if isfinite(self.highest) and self.kinds and self.method != Method.LIKELIHOOD:
            raise ValueError(
                f"highest: expected the method {Method.LIKELIHOOD} or terms to choose; found {self.method}"
            )
        if self.kinds is not None:
            self.check(self.kinds)

    def check(self, kinds: Kinds) -> None:
        """Check that a composition has a random process, no repeated term, and suits the method; else ValueError."""
        for kind in kinds:
            if kind is not GaussMarkov and kinds.count(kind) > 1:
                raise ValueError(f"terms: expected only {GaussMarkov.name} more than once; found {title(kinds)}")
        if set(kinds) <= {RateRamp}:
            raise ValueError(f"terms: expected at least one random process; found {title(kinds) or 'none'}")
        if self.method == Method.ALLAN and kinds.count(GaussMarkov) > 1:
            expected = f"at most one {GaussMarkov.name} for the method {Method.ALLAN}"
            raise ValueError(f"terms: expected {expected}; found {title(kinds)}")

    def estimate(self, sequence: np.ndarray, interval: float, kinds: Kinds) -> Fit:
        """Estimate effects of the given kinds from samples, shape (n,), evenly spaced by ``interval`` [s]."""
        self.check(kinds)
        random, ramp = tuple(kind for kind in kinds if kind is not RateRamp), RateRamp in kinds
        match self.method:
            case Method.LIKELIHOOD:
                return maximum_likelihood.fit(sequence, interval, random, ramp, self.highest, self.level)
            case Method.WAVELET:
                efficiency = EFFICIENCY if self.robust else 1.0
                options = GmwmOptions(ramp, efficiency=efficiency, level=self.level)
                return estimator.fit(sequence, interval, random, options)
            case Method.ALLAN:
                return allan_slopes.fit(sequence, interval, kinds, self.level)


@dataclass(frozen=True)
class AxisEstimate:
    """Estimate of one axis: the fit, its goodness of fit in words, and compositions that fit as well."""

    axis: str
    method: Method
    fit: Fit
    goodness: str
    alternatives: tuple[Kinds, ...] = ()

    @property
    def unit(self) -> str:
        """Return the unit of the axis."""
        return "rad/s" if self.axis in GYRO else "m/s^2"

    def verdict(self) -> str:
        """Return in words the goodness of fit, the parameters that are not identified, and the alternatives."""
        parts = [self.goodness.rstrip(".")]
        unknown = [(one, one.verdict) for one, _ in self.parameters() if one.verdict != Identifiability.IDENTIFIED]
        if unknown:
            named = (f"{one.effect} {one.ordinal} {one.parameter} ({why})" for one, why in unknown)
            parts.append(f"Not identified: {', '.join(named)}")
        if self.alternatives:
            parts.append(f"The data do not separate it from: {'; '.join(map(title, self.alternatives))}")
        kinds = set(map(type, self.fit.model))
        if GaussMarkov in kinds and not kinds & {WhiteNoise, Quantization}:
            parts.append(f"Without white noise {GaussMarkov.name} 1 may be an output filter")
        return ". ".join(parts) + "."

    def parameters(self) -> list[tuple[ParameterEstimate, str]]:
        """Return the estimates of the parameters of the effects, each with its SI unit, without derived quantities."""
        units = [CATALOGUE[one.effect].units(self.unit).get(one.parameter) for one in self.fit.estimates]
        return [(one, unit) for one, unit in zip(self.fit.estimates, units, strict=True) if unit]

    def record(self) -> dict:
        """Return a record for JSON; a limit that is not finite is None."""
        terms: dict[tuple[str, int], dict] = {}
        for one, unit in self.parameters():
            numbers = {name: _finite(getattr(one, name)) for name in ("value", "low", "high")}
            terms.setdefault((one.effect, one.ordinal), {})[one.parameter] = numbers | {"unit": unit}
        return {
            "axis": self.axis,
            "method": str(self.method),
            "terms": [{"name": name, "parameters": parameters} for (name, _), parameters in terms.items()],
            "objective": _finite(self.fit.objective),
            "verdict": self.verdict(),
        }


def estimate_axis(axis: str, sequence: np.ndarray, interval: float, settings: EstimatorSettings) -> AxisEstimate:
    """Estimate the effects of one axis from its samples, shape (n,), evenly spaced by ``interval`` [s]."""
    choice: Choice | None = None
    try:
        if settings.kinds is None:
            choice = choose(sequence, interval, settings.highest, settings.level)
        if choice and settings.method == Method.LIKELIHOOD:
            fit = choice.fit
        else:
            fit = settings.estimate(sequence, interval, choice.kinds if choice else settings.kinds)
        checked = goodness_of_fit.of(fit.model, sequence, interval)
    except ValueError as error:
        raise ValueError(f"{axis}: {error}") from error
    return AxisEstimate(axis, settings.method, fit, checked.verdict, choice.alternatives if choice else ())


def kinds_of(names: Sequence[str]) -> Kinds:
    """Return the kinds of effects of the given names; ValueError for one that cannot be estimated."""
    known = {kind.name: kind for kind in TERMS}
    return tuple(known[known_name(name, tuple(known), "terms")] for name in names)


def known_name(name: str, known: Sequence[str], subject: str) -> str:
    """Return ``name`` if it is known; else raise a ValueError with the nearest known one."""
    if name not in known:
        near = get_close_matches(name.lower(), known, 1)
        expected = near[0] if near else f"one of {', '.join(known)}"
        raise ValueError(f"{subject}: expected {expected}; found {name!r}")
    return name


def to_json(estimates: Sequence[AxisEstimate]) -> str:
    """Return the records of all axes as JSON without NaN or infinity."""
    return json.dumps([one.record() for one in estimates], indent=1, allow_nan=False) + "\n"


def table(estimates: Sequence[AxisEstimate]) -> pd.DataFrame:
    """Return all estimates: ``axis``, ``method``, the columns of :class:`.result.ParameterEstimate`, ``unit``."""
    rows = [
        {"axis": one.axis, "method": str(one.method)} | asdict(estimate) | {"unit": unit}
        for one in estimates
        for estimate, unit in one.parameters()
    ]
    return pd.DataFrame(rows)


def curves(log: pd.DataFrame, interval: float, estimates: Sequence[AxisEstimate], level: float = 0.95) -> pd.DataFrame:
    """Return the Allan deviation of each axis, and that of its fitted model with limits for a log of this length.

    Returns
    -------
    pandas.DataFrame
        Columns ``axis``, ``tau`` [s], ``deviation`` (of the log), ``model`` (its expectation), ``low``, ``high``
        (chi-square limits of an estimate from a log of this length under the model) [unit of the axis].
    """
    parts = []
    for one in estimates:
        measured = allan.curve(log[one.axis].to_numpy(), interval)
        factors, edf = np.rint(measured.index / interval).astype(int), measured["edf"]
        model = np.sqrt(one.fit.model.sampled_allan_variance(factors, interval))
        low, high = (model * np.sqrt(chdtri(edf, 1 - p) / edf) for p in ((1 - level) / 2, (1 + level) / 2))
        columns = {"axis": one.axis, "deviation": measured["deviation"], "model": model, "low": low, "high": high}
        parts.append(pd.DataFrame(columns, index=measured.index).reset_index())
    return pd.concat(parts, ignore_index=True)


def _finite(value: float) -> float | None:
    return float(value) if isfinite(value) else None

"""What a log says about its axes: the effects found on each with intervals and a verdict, ready for JSON and tables."""

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
    """How parameters are estimated."""

    LIKELIHOOD = "likelihood"
    """Maximum likelihood (:mod:`imugap.estimation.maximum_likelihood`)."""
    WAVELET = "wavelet"
    """Wavelet variance matched by that of the model (:mod:`imugap.estimation.gmwm.estimator`)."""
    ALLAN = "allan"
    """Tangents to the Allan deviation, piece by piece (:mod:`imugap.estimation.allan_slopes`)."""


@dataclass(frozen=True)
class EstimatorSettings:
    """What is asked about an axis.

    Attributes
    ----------
    kinds
        The effects to estimate, or None: those that :func:`imugap.estimation.model_selection.choose` finds.
    method
        How they are estimated.
    highest
        Frequency [Hz] above which likelihood and choice leave the log out of account.
    robust
        Whether the wavelet variances are those that outliers have a bounded effect on.
    level
        Confidence level.
    """

    kinds: Kinds | None = None
    method: Method = Method.LIKELIHOOD
    highest: float = np.inf
    robust: bool = False
    level: float = 0.95

    def __post_init__(self) -> None:
        """Refuse what the method cannot do."""
        if self.robust and self.method != Method.WAVELET:
            raise ValueError(f"robust: expected the method {Method.WAVELET}; found {self.method}")
        if isfinite(self.highest) and self.kinds and self.method != Method.LIKELIHOOD:
            raise ValueError(
                f"highest: expected the method {Method.LIKELIHOOD} or terms to choose; found {self.method}"
            )
        if self.kinds is not None:
            self.check(self.kinds)

    def check(self, kinds: Kinds) -> None:
        """Refuse a composition that has no random process, a term twice, or more than the method can tell apart."""
        for kind in kinds:
            if kind is not GaussMarkov and kinds.count(kind) > 1:
                raise ValueError(f"terms: expected only {GaussMarkov.name} more than once; found {title(kinds)}")
        if set(kinds) <= {RateRamp}:
            raise ValueError(f"terms: expected at least one random process; found {title(kinds) or 'none'}")
        if self.method == Method.ALLAN and kinds.count(GaussMarkov) > 1:
            expected = f"at most one {GaussMarkov.name} for the method {Method.ALLAN}"
            raise ValueError(f"terms: expected {expected}; found {title(kinds)}")

    def estimate(self, sequence: np.ndarray, interval: float, kinds: Kinds) -> Fit:
        """Return the estimates of given effects by the method asked for."""
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
    """What was found on one axis; ``goodness`` says whether the model fits, ``alternatives`` what fits as well."""

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
        """Return in words whether the model fits, which parameters are not identified, and what fits as well."""
        parts = [self.goodness.rstrip(".")]
        unknown = [(one, one.verdict) for one, _ in self.parameters() if one.verdict != Identifiability.IDENTIFIED]
        if unknown:
            named = (f"{one.effect} {one.ordinal} {one.parameter} ({why})" for one, why in unknown)
            parts.append(f"Not identified: {', '.join(named)}")
        if self.alternatives:
            parts.append(f"The data cannot tell it from: {'; '.join(map(title, self.alternatives))}")
        kinds = set(map(type, self.fit.model))
        if GaussMarkov in kinds and not kinds & {WhiteNoise, Quantization}:
            parts.append(f"There is no white noise beside {GaussMarkov.name} 1: an output filter would look the same")
        return ". ".join(parts) + "."

    def parameters(self) -> list[tuple[ParameterEstimate, str]]:
        """Return the estimates of the parameters that the catalogue names, each with its SI unit."""
        units = [CATALOGUE[one.effect].units(self.unit).get(one.parameter) for one in self.fit.estimates]
        return [(one, unit) for one, unit in zip(self.fit.estimates, units, strict=True) if unit]

    def record(self) -> dict:
        """Return plain data for JSON; a number that is not finite (a limit that the log does not set) is None."""
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


def estimate_axis(axis: str, sequence: np.ndarray, interval: float, inquiry: EstimatorSettings) -> AxisEstimate:
    """Answer an inquiry about one axis: samples, shape (n,), evenly spaced by ``interval`` [s]."""
    choice: Choice | None = None
    try:
        if inquiry.kinds is None:
            choice = choose(sequence, interval, inquiry.highest, inquiry.level)
        if choice and inquiry.method == Method.LIKELIHOOD:
            fit = choice.fit
        else:
            fit = inquiry.estimate(sequence, interval, choice.kinds if choice else inquiry.kinds)
        judged = goodness_of_fit.of(fit.model, sequence, interval)
    except ValueError as error:
        raise ValueError(f"{axis}: {error}") from error
    return AxisEstimate(axis, inquiry.method, fit, judged.verdict, choice.alternatives if choice else ())


def kinds_of(names: Sequence[str]) -> Kinds:
    """Return the effects of the given names, among those that can be estimated; an unknown one names the nearest."""
    known = {kind.name: kind for kind in TERMS}
    return tuple(known[known_name(name, tuple(known), "terms")] for name in names)


def known_name(name: str, known: Sequence[str], what: str) -> str:
    """Return ``name`` if it is known; else raise a ValueError that says which of the known ones is nearest."""
    if name not in known:
        near = get_close_matches(name.lower(), known, 1)
        expected = near[0] if near else f"one of {', '.join(known)}"
        raise ValueError(f"{what}: expected {expected}; found {name!r}")
    return name


def to_json(findings: Sequence[AxisEstimate]) -> str:
    """Return the records of all axes as strict JSON."""
    return json.dumps([one.record() for one in findings], indent=1, allow_nan=False) + "\n"


def table(findings: Sequence[AxisEstimate]) -> pd.DataFrame:
    """Return all estimates: ``axis``, ``method``, the columns of :class:`.result.ParameterEstimate`, ``unit``."""
    rows = [
        {"axis": one.axis, "method": str(one.method)} | asdict(estimate) | {"unit": unit}
        for one in findings
        for estimate, unit in one.parameters()
    ]
    return pd.DataFrame(rows)


def curves(log: pd.DataFrame, interval: float, findings: Sequence[AxisEstimate], level: float = 0.95) -> pd.DataFrame:
    """Return the Allan deviation of each axis and where the fitted model expects that of so long a log.

    Returns
    -------
    pandas.DataFrame
        Columns ``axis``, ``tau`` [s], ``deviation`` (of the log), ``model``, ``low``, ``high`` (of the model, with
        the chi-square limits of an estimate from a log of this length) [unit of the axis].
    """
    parts = []
    for one in findings:
        measured = allan.curve(log[one.axis].to_numpy(), interval)
        factors, edf = np.rint(measured.index / interval).astype(int), measured["edf"]
        model = np.sqrt(one.fit.model.sampled_allan_variance(factors, interval))
        low, high = (model * np.sqrt(chdtri(edf, 1 - p) / edf) for p in ((1 - level) / 2, (1 + level) / 2))
        columns = {"axis": one.axis, "deviation": measured["deviation"], "model": model, "low": low, "high": high}
        parts.append(pd.DataFrame(columns, index=measured.index).reset_index())
    return pd.concat(parts, ignore_index=True)


def _finite(value: float) -> float | None:
    return float(value) if isfinite(value) else None

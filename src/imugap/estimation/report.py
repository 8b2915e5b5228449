"""Estimation of one axis by a chosen method, and its report: JSON records, tables, Allan curves."""

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field, replace
from enum import StrEnum
from math import isfinite

import numpy as np
import pandas as pd
from scipy.special import chdtri

from imugap import spelling
from imugap.effects import CATALOGUE, GaussMarkov, Quantization, RandomWalk, RateRamp, Temperature, WhiteNoise
from imugap.estimation import goodness_of_fit, maximum_likelihood
from imugap.estimation.gap_draws import with_gaps_drawn
from imugap.estimation.gmwm import estimator
from imugap.estimation.gmwm.estimator import GmwmOptions
from imugap.estimation.model_selection import TERMS, Choice, Kinds, choose, joint_level, title
from imugap.estimation.result import Fit, Identifiability, ParameterEstimate
from imugap.estimation.screening import screen
from imugap.estimation.temperature_term import TemperatureTerm, temperature_term
from imugap.estimation.variances import allan, allan_slopes
from imugap.estimation.variances.wavelet_variance import EFFICIENCY
from imugap.log import GYRO
from imugap.stream import stream

SEED = 0
"""Seed of the samples that are drawn where the log has none that is undisturbed."""
RESOLVED = 1.0
"""Least correlation time of a process, in samples: a faster one is white noise through an output filter."""
FLAT = 0.95
"""Spectrum of filtered white noise, over that at frequency zero, down to which it counts as white."""
SEPARATING = 8
"""Width of the wavelet filter that keeps octaves above the highest frequency apart from those below."""
NARROWINGS = 3
"""Most selections below lower and lower frequencies."""
NEXT = "Parameters of a model that does not fit are not yet those of the device: `imugap discover` finds what it lacks."
"""What to do where a model does not fit its log."""
ONE_SIDED = 0.9
"""Level of a two-sided interval whose upper end is the one-sided 95 % limit."""


class Method(StrEnum):
    """Method of estimation."""

    LIKELIHOOD = "likelihood"
    """Maximum likelihood (:mod:`imugap.estimation.maximum_likelihood`)."""
    WAVELET = "wavelet"
    """Generalised method of wavelet moments (:mod:`imugap.estimation.gmwm.estimator`)."""
    ALLAN = "allan"
    """Slopes of the Allan deviation (:mod:`imugap.estimation.variances.allan_slopes`)."""


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
        Confidence level of the intervals, and of the selections and tests of fit on all axes together.
    axes
        Number of axes that are estimated.
    """

    kinds: Kinds | None = None
    method: Method = Method.LIKELIHOOD
    highest: float = np.inf
    robust: bool = False
    level: float = 0.95
    axes: int = 1

    @property
    def decision_level(self) -> float:
        """Return the confidence level of the decisions on one axis."""
        return joint_level(self.level, self.axes)

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

    def supported(self, kinds: Kinds) -> Kinds:
        """Return the kinds of a selection that the method can estimate: that of slopes has one Gauss-Markov process."""
        return tuple(dict.fromkeys(kinds)) if self.method == Method.ALLAN else kinds

    def estimate(
        self, sequence: np.ndarray, interval: float, kinds: Kinds, highest: float = np.inf, share: float = 1.0
    ) -> Fit:
        """Estimate effects of the given kinds from samples, shape (n,), evenly spaced by ``interval`` [s].

        Likelihood alone uses the highest frequency [Hz], and the share of the samples that were measured.
        """
        self.check(kinds)
        random, ramp = tuple(kind for kind in kinds if kind is not RateRamp), RateRamp in kinds
        match self.method:
            case Method.LIKELIHOOD:
                return maximum_likelihood.fit(sequence, interval, random, ramp, highest, self.level, share)
            case Method.WAVELET:
                efficiency = EFFICIENCY if self.robust else 1.0
                options = GmwmOptions(ramp, efficiency=efficiency, level=self.level)
                return estimator.fit(sequence, interval, random, options)
            case Method.ALLAN:
                return allan_slopes.fit(sequence, interval, kinds, self.level)


@dataclass(frozen=True, eq=False)
class UsedSamples:
    """Samples of an estimate.

    Attributes
    ----------
    values
        Samples without disturbances, shape (n,).
    interval
        Sampling interval [s].
    highest
        Highest frequency that was used [Hz].
    share
        Share of the samples that were measured.
    """

    values: np.ndarray
    interval: float
    highest: float
    share: float


@dataclass(frozen=True)
class AxisEstimate:
    """Estimate of one axis.

    Attributes
    ----------
    axis, method, fit
        Name of the axis, method, and fitted effects.
    goodness
        Goodness of fit in words.
    alternatives
        Compositions that fit as well.
    remarks
        Sentences on what was left out of the log, and on what explains it.
    used
        Samples that were used.
    off
        Shortest and longest averaging time [s] of each range of octaves in which the model does not fit.
    """

    axis: str
    method: Method
    fit: Fit
    goodness: str
    alternatives: tuple[Kinds, ...] = ()
    remarks: tuple[str, ...] = ()
    used: "UsedSamples | None" = field(default=None, repr=False, compare=False)
    off: tuple[tuple[float, float], ...] = ()

    @property
    def fits(self) -> bool:
        """Return whether nothing in the log speaks against the model."""
        return not self.goodness.startswith(goodness_of_fit.MISFIT)

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
            parts.append(f"The data do not separate it from: {'; '.join(map(title, self.alternatives))}{self._kept()}")
        kinds = set(map(type, self.fit.model))
        if GaussMarkov in kinds and not kinds & {WhiteNoise, Quantization}:
            parts.append(f"Without white noise {GaussMarkov.name} 1 may be an output filter")
        parts.extend(self.remarks)
        return ". ".join(parts) + "."

    def _kept(self) -> str:
        """Return what the alternatives have in common with the model, and what may differ."""
        present = [type(one) for one in self.fit.model if any(one.parameters().values())]
        if WhiteNoise not in present or not all(WhiteNoise in kinds for kinds in self.alternatives):
            return ""
        return " (N changes little, the slow processes may)"

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


def estimate_axis(
    axis: str,
    sequence: np.ndarray,
    interval: float,
    settings: EstimatorSettings,
    temperature: np.ndarray | None = None,
    start: float = 0.0,
) -> AxisEstimate:
    """Estimate the effects of one axis; disturbed samples are left out.

    Parameters
    ----------
    axis
        Name of the axis.
    sequence
        Samples, shape (n,), evenly spaced by ``interval`` [s]; NaN where lost.
    settings
        What is estimated, and how.
    temperature
        Readings [degC], shape (n,), which may explain a part of the bias.
    start
        Time of the first sample [s].
    """
    try:
        screened = screen(sequence, stream(SEED, "estimate", axis))
        values, share = with_gaps_drawn(screened, interval, stream(SEED, "gaps", axis)), screened.information
        found = selected(values, interval, settings, share) if settings.kinds is None else None
        term = _temperature_term(values, temperature, interval, found, settings, share)
        if term is not None:
            values, found = values - term.values, replace(found, choice=term.choice)
        fit, highest = _fitted(values, interval, settings, found, share)
        width = SEPARATING if highest < 0.5 / interval else 2
        checked = goodness_of_fit.of(
            fit.model, values, interval, settings.decision_level, width, highest=highest, share=share
        )
    except ValueError as error:
        raise ValueError(f"{axis}: {error}") from error
    remarks = screened.sentences(interval, start)
    if found and isfinite(found.highest) and found.highest != settings.highest:
        remarks.append(
            f"Above {found.highest:.3g} Hz the noise is coloured, as by vibration or an output filter, and is not used"
        )
    if term is not None:
        fit = replace(fit, model=fit.model + term.effect, estimates=(*fit.estimates, *term.estimates))
        remarks.append("The temperature of the log explains a part of the bias, which is not a random process")
    alternatives = found.choice.alternatives if found else ()
    used = UsedSamples(values, interval, highest, share)
    return AxisEstimate(axis, settings.method, fit, checked.verdict, alternatives, tuple(remarks), used, checked.off)


def _fitted(
    values: np.ndarray, interval: float, settings: EstimatorSettings, found: "Selected | None", share: float
) -> tuple[Fit, float]:
    """Return the fit of the effects asked for or selected, and the highest frequency of the model [Hz]."""
    if found is None:
        return settings.estimate(values, interval, settings.kinds, settings.highest, share), settings.highest
    if settings.method == Method.LIKELIHOOD:
        return found.choice.fit, found.highest
    return settings.estimate(values, interval, settings.supported(found.choice.kinds)), found.highest


@dataclass(frozen=True)
class Selected:
    """Selection of effects, the highest frequency [Hz] that it uses, and the effects among which it was made."""

    choice: Choice
    highest: float
    terms: Kinds


def selected(values: np.ndarray, interval: float, settings: EstimatorSettings, share: float = 1.0) -> Selected:
    """Select the effects of samples; below the frequencies at which an output filter colours their white noise.

    Noise that is correlated over less than :data:`RESOLVED` samples is white noise through a filter: its density is
    that at frequencies where the filter is flat.
    """
    highest, terms = settings.highest, TERMS
    for _ in range(NARROWINGS):
        choice = choose(values, interval, highest, settings.level, share, terms, settings.axes)
        fast = [
            one.correlation_time / interval
            for one in choice.fit.model
            if isinstance(one, GaussMarkov) and one.std > 0 and one.correlation_time < RESOLVED * interval
        ]
        if not fast:
            break
        highest = min(highest, _flat_band(max(fast)) / interval)
        terms = tuple(kind for kind in TERMS if kind is not Quantization)  # shows at the highest frequencies alone
    else:
        kinds = _whitened(choice.kinds, len(fast))
        fit = settings.estimate(values, interval, kinds, highest, share)
        choice = replace(choice, kinds=kinds, fit=fit)
    return Selected(choice, highest, terms)


def _flat_band(samples: float) -> float:
    """Return the frequency [cycles per sample] up to which a Gauss-Markov process is nearly white."""
    decay = np.exp(-1 / samples)
    return float(np.arccos(max(1 - (1 - decay) ** 2 * (1 / FLAT - 1) / (2 * decay), -1.0)) / (2 * np.pi))


def _whitened(kinds: Kinds, fast: int) -> Kinds:
    """Return the kinds with the fastest Gauss-Markov processes replaced by white noise."""
    slow = max(kinds.count(GaussMarkov) - fast, 0)
    others = {kind for kind in kinds if kind is not GaussMarkov} | {WhiteNoise}
    return tuple(sorted((*others, *[GaussMarkov] * slow), key=TERMS.index))


def _temperature_term(
    values: np.ndarray,
    temperature: np.ndarray | None,
    interval: float,
    found: Selected | None,
    settings: EstimatorSettings,
    share: float,
) -> TemperatureTerm | None:
    if temperature is None or found is None:
        return None

    def select(rest: np.ndarray) -> Choice:
        return choose(rest, interval, found.highest, settings.level, share, found.terms, settings.axes)

    return temperature_term(values, temperature, interval, found.choice, select, settings.decision_level)


def bounds(estimate: AxisEstimate) -> tuple[WhiteNoise | RandomWalk, ...]:
    """Return white noise and random walk that the log of an axis may hide, where the estimate has none.

    Their densities are one-sided 95 % upper limits of the profile likelihood, the estimated effects included. A slow
    process is any with an Allan deviation that rises somewhere.
    """
    used, present = estimate.used, {type(one) for one in estimate.fit.model if any(one.parameters().values())}
    random = {RateRamp, Temperature}
    slow = present - {WhiteNoise, Quantization} - random
    missing = [kind for kind, has in ((WhiteNoise, WhiteNoise in present), (RandomWalk, slow)) if not has]
    kinds = tuple(type(one) for one in estimate.fit.model if type(one) in present - random)
    found = []
    for kind in missing:
        fit = maximum_likelihood.fit(
            used.values, used.interval, (*kinds, kind), RateRamp in present, used.highest, ONE_SIDED, used.share
        )
        (high,) = (one.high for one in fit.estimates if one.effect == kind.name)
        found.append(kind(high))
    return tuple(found)


def kinds_of(names: Sequence[str]) -> Kinds:
    """Return the kinds of effects of the given names; ValueError for one that cannot be estimated."""
    known = {kind.name: kind for kind in TERMS}
    return tuple(known[known_name(name, tuple(known), "terms")] for name in names)


def known_name(name: str, known: Sequence[str], subject: str) -> str:
    """Return ``name`` if it is known; else raise a ValueError with the nearest known one."""
    if name not in known:
        raise ValueError(f"{subject}: expected {spelling.expected(name, known)}; found {name!r}")
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


def curves(estimates: Sequence[AxisEstimate], level: float = 0.95) -> pd.DataFrame:
    """Return the Allan deviation of each axis, and that of its fitted model with limits for a log of this length.

    Returns
    -------
    pandas.DataFrame
        Columns ``axis``, ``tau`` [s], ``deviation`` (of the log), ``model`` (its expectation), ``low``, ``high``
        (chi-square limits of an estimate from a log of this length under the model) [unit of the axis].
    """
    parts = []
    for one in estimates:
        interval = one.used.interval
        measured = allan.curve(one.used.values, interval)
        factors, edf = np.rint(measured.index / interval).astype(int), measured["edf"]
        model = np.sqrt(one.fit.model.sampled_allan_variance(factors, interval))
        low, high = (model * np.sqrt(chdtri(edf, 1 - p) / edf) for p in ((1 - level) / 2, (1 + level) / 2))
        columns = {"axis": one.axis, "deviation": measured["deviation"], "model": model, "low": low, "high": high}
        parts.append(pd.DataFrame(columns, index=measured.index).reset_index())
    return pd.concat(parts, ignore_index=True)


def _finite(value: float) -> float | None:
    return float(value) if isfinite(value) else None

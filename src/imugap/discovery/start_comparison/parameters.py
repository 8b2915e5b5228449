"""Parameters of the start model beside those of the log: which agree, which differ, which are missing.

Every number of the start file is compared with the log by its likelihood, everything else free. The intervals are wide
enough that all of them hold together with probability 1 - alpha where the start model is right.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from enum import StrEnum
from functools import cached_property
from itertools import product
from math import exp, inf, isfinite, log, sqrt

import numpy as np
from scipy.stats import chi2, norm

from imugap.discovery.axis import AxisResult
from imugap.discovery.device import Discovery
from imugap.discovery.finding import MIN_LOG_P, Finding, Interval
from imugap.discovery.fit.axis_fit import AxisFit, jacobian, offset
from imugap.discovery.fit.description import Entry
from imugap.discovery.fit.start_model import noisy, undetermined
from imugap.discovery.preparation.rounding import unrounded
from imugap.discovery.runs.between_runs import mean_variance
from imugap.discovery.search.intervals import axis_unit
from imugap.discovery.start_comparison.noise_profile import NoiseProfile
from imugap.effects import CATALOGUE
from imugap.effects.effect import Effect, Evidence, Role, Stage
from imugap.interchange.start_models.reading import Key, Keys
from imugap.kinematics.earth import ROTATION_RATE
from imugap.log import ACCEL, GYRO, TIME
from imugap.model import ErrorModel, offset_of

BIAS = next(kind for kind in CATALOGUE.values() if kind.role is Role.BIAS)
"""Kind of the constant level of an axis."""
UNTOUCHED = 1e-6
"""Largest change of a sample, over the range of the samples, that is none."""
LATTICE_TOLERANCE = 1e-3
"""Relative difference of equal steps and full scales."""
SLOPE_STEP = 1e-6
"""Relative step of a difference quotient."""


class Comparison(StrEnum):
    """What a log says of a parameter of the start model."""

    AGREES = "agrees"
    DIFFERS = "differs"
    MISSING = "missing"
    """The start model does not have it."""
    OPEN = "not determined"


@dataclass(frozen=True)
class StartParameter:
    """Parameter of the start model on one axis, beside that of the log.

    Attributes
    ----------
    axis, effect
        Axis, and name of the effect.
    name, unit
        Name and unit in the start file; of a file of this library effect and parameter, SI.
    start
        Value of the start model, or None where it has none.
    log
        Value and interval of the log in the same unit, or None where it says nothing.
    p_value
        Probability of a difference as large where there is none; 1 where there is nothing to compare.
    agreement
        What the log says.
    remark
        Condition or reason, or an empty text.
    """

    axis: str
    effect: str
    name: str
    unit: str
    start: float | None
    log: Interval | None
    p_value: float
    agreement: Comparison
    remark: str = ""


def _alike(one: Effect, other: Effect) -> bool:
    """Return whether two effects are of one kind, or white noise of any law of its samples."""
    return type(one) is type(other) or (one.white and other.white)


def against_start(found: Discovery, known: ErrorModel, keys: Keys | None, alpha: float) -> tuple[StartParameter, ...]:
    """Compare each parameter of the start model with the log, and list what the start model lacks.

    Parameters
    ----------
    known
        Start model, as it was given.
    keys
        Keys of its file; None for a file of this library.
    alpha
        Probability that any parameter differs where the start model is right.
    """
    axes = [_Axis(axis, found, tuple(known.axes.get(axis, ())), _of_sensor(axis, keys)) for axis in found.results]
    count = sum(len(one.numbers(effect)) for one in axes for effect in one.effects) + len(axes)
    level = alpha / count
    rows = [row for one in axes for row in one.rows(level)]
    rows += [
        StartParameter(axis, effect.name, f"{effect.name}.{name}", effect.units("")[name], value, None, 1.0,
                       Comparison.OPEN, "the clock is not compared")
        for axis, effects in known.axes.items() if axis == TIME
        for effect in effects for name, value in effect.parameters().items()
    ]  # fmt: skip
    return (*rows, *(row for one in axes for row in one.missing(level)))


def kept_parameters(found: Discovery, level: float) -> tuple[StartParameter, ...]:
    """Return what the start model has, as the log has it, each parameter with an interval of its own.

    Parameters
    ----------
    level
        Probability that an interval misses its parameter.
    """
    axes = (_Axis(axis, found, tuple(found.start.axes.get(axis, ())), None) for axis in found.results)
    return tuple(row for one in axes for row in one.rows(level))


def _of_sensor(axis: str, keys: Keys | None) -> tuple[Key, ...] | None:
    return None if keys is None else keys.get("gyro" if axis in GYRO else "accel", ())


@dataclass(frozen=True)
class _Number:
    """Number of the start file as a function of an effect, in the unit of the file."""

    name: str
    unit: str
    of: Callable[[Effect], float]

    def log(self, effect: Effect) -> float:
        """Return its logarithm."""
        value = self.of(effect)
        return log(value) if value > 0 else -inf


@dataclass(frozen=True, eq=False)
class _Axis:
    """Start model and log of one axis."""

    name: str
    found: Discovery
    effects: tuple[Effect, ...]
    keys: tuple[Key, ...] | None

    @property
    def result(self) -> AxisResult:
        """Result of discovery on the axis."""
        return self.found.results[self.name]

    @property
    def fits(self) -> tuple[AxisFit, ...]:
        """Fits of all runs."""
        return (self.result.whole_fit, *self.found.further.get(self.name, ()))

    @cached_property
    def profile(self) -> NoiseProfile:
        """Likelihood of the noise of all runs."""
        return NoiseProfile.of(self.fits)

    @property
    def resting(self) -> bool:
        """Whether the device is at rest."""
        return self.fits[0].sequence.conditions.ideal is None

    def numbers(self, effect: Effect) -> tuple[_Number, ...]:
        """Return the numbers of the start file that an effect has; its parameters where the file has none."""
        own = [key for key in self.keys or () if isinstance(effect, key.kind)]
        return tuple(_Number(key.name, key.unit, key.value) for key in own) if own else self._native(effect)

    def _native(self, effect: Effect) -> tuple[_Number, ...]:
        """Return the parameters of an effect."""
        units = effect.units(axis_unit(self.name))
        given = [item.name for item in fields(effect) if item.name != "reference"]
        return tuple(
            _Number(f"{effect.name}.{name}", units[name], lambda one, name=name: getattr(one, name)) for name in given
        )

    def rows(self, level: float) -> Iterator[StartParameter]:
        """Yield the parameters of the start model."""
        matched = self._matched()
        yield from self._level(level)
        for place, effect in enumerate(self.effects):
            if effect.role is Role.BIAS:
                continue
            if effect.role in (Role.NOISE, Role.FILTER) and place in matched:
                yield from self._noise(effect, matched[place], level)
            elif effect.role is Role.MEAN and place in matched:
                yield from self._term(effect, matched[place], level)
            elif effect.role is Role.RUN and len(self.fits) > 1:
                yield from self._over_runs(effect, level)
            elif effect.role is Role.OUTPUT and effect.stage in (Stage.RANGE, Stage.WORD):
                yield from self._output(effect)
            else:
                yield from self._open(effect)

    def _matched(self) -> dict[int, int]:
        """Return the place in the description of each effect of the start model that is in it."""
        entries = self.fits[0].description.entries
        apart = undetermined(self.effects, self.fits[0].sequence)
        matched = {}
        for role in (Role.MEAN, Role.NOISE, Role.FILTER):
            fitted = [place for place, one in enumerate(entries) if one.known and one.effect.role is role]
            given = [
                place for place, one in enumerate(self.effects)
                if one.role is role and one not in apart and (role is not Role.NOISE or noisy(one))
            ]  # fmt: skip
            alike = (
                _alike(entries[one].effect, self.effects[other]) for one, other in zip(fitted, given, strict=False)
            )
            if len(fitted) == len(given) and all(alike):
                matched |= dict(zip(given, fitted, strict=True))
        return matched

    def _open(self, effect: Effect) -> Iterator[StartParameter]:
        """Yield the parameters of an effect that the log does not determine."""
        reason = "no fit adjusts it"
        if effect.role is Role.RUN:
            reason = "it takes several runs of the device"
        elif effect in undetermined(self.effects, self.fits[0].sequence):
            reason = "it takes a known motion or temperature"
        for number in self.numbers(effect):
            yield self._row(effect, number, None, 0.0, Comparison.OPEN, reason)

    def _row(
        self,
        effect: Effect,
        number: _Number,
        log: Interval | None,
        log_p: float,
        agreement: Comparison,
        remark: str = "",
    ) -> StartParameter:
        p_value = exp(max(log_p, MIN_LOG_P))
        return StartParameter(
            self.name, effect.name, number.name, number.unit, number.of(effect), log, p_value, agreement, remark
        )

    def _noise(self, effect: Effect, place: int, level: float) -> Iterator[StartParameter]:
        """Yield the parameters of a random process or a filter."""
        index = place - len(self.fits[0].description.terms)
        own, numbers = list(self.profile.noise)[index], self.numbers(effect)
        free = own.free()
        if effect.role is Role.NOISE and not effect.white and not self._seen(index, len(free), level):
            yield from self._unseen(effect, index, numbers, level)
            return
        rows = [self._marginal(effect, own, index, number, level) for number in numbers]
        if len(free) > 1 and not any(row.agreement is Comparison.DIFFERS for row in rows):
            held = self.profile.holding(index, {name: getattr(effect, name) for name in free})
            log_p = float(chi2.logsf(self.profile.deviance(held) / self.profile.excess(index), len(free)))
            if log_p < np.log(level):
                condition = f"with {' and '.join(name for name in free[1:])} of the start model"
                conditional = list(self._conditional(effect, index, numbers, level, condition))
                rows = [more if more.agreement is Comparison.DIFFERS else row
                        for row, more in zip(rows, conditional, strict=True)]  # fmt: skip
        yield from rows

    def _seen(self, index: int, count: int, level: float) -> bool:
        """Return whether the log shows a process of the start model beyond chance."""
        if len(self.profile.noise.effects) < 2:
            return True
        without = self.profile.without(index)
        gain = 2 * (self.profile.best.log_likelihood - without.best.log_likelihood) / self.profile.excess(index)
        return bool(chi2.logsf(max(gain, 0.0), count) < np.log(level))

    def _marginal(self, effect: Effect, own: Effect, index: int, number: _Number, level: float) -> StartParameter:
        """Return a number of a process beside that of the log, everything else free."""
        theirs, excess = self._as_fitted(effect), self.profile.excess(index)
        if not isfinite(number.log(theirs)) or not self._varies(own, number):
            return self._row(effect, number, None, 0.0, Comparison.OPEN, "no fit adjusts it")
        low, high = self.profile.interval(index, number.log, excess * float(chi2.isf(level, 1)))
        deviance = self.profile.at(index, number.log, number.log(theirs)) / excess
        log_p = float(chi2.logsf(deviance, 1))
        shift = number.of(own) ** 2 - number.of(self._before_rounding(own)) ** 2 if own.white else 0.0
        value, *ends = (sqrt(max(exp(end) ** 2 - shift, 0.0)) if end < 700 else inf
                        for end in (number.log(own), low, high))  # fmt: skip
        agreement = Comparison.DIFFERS if log_p < np.log(level) else Comparison.AGREES
        if ends[0] <= 0 and not isfinite(ends[1]):
            agreement = Comparison.OPEN
        return self._row(effect, number, Interval(value, *ends, number.unit), log_p, agreement)

    def _varies(self, own: Effect, number: _Number) -> bool:
        """Return whether a number depends on what a fit adjusts."""
        moved = replace(own, **{name: getattr(own, name) * (1 + SLOPE_STEP) for name in own.free()})
        single = (replace(own, **{name: getattr(moved, name)}) for name in own.free())
        return any(number.of(one) != number.of(own) for one in single)

    def _unseen(self, effect: Effect, index: int, numbers: Sequence[_Number], level: float) -> Iterator[StartParameter]:
        """Yield the parameters of a process that the log does not show: how large it may be at most."""
        condition = "the log shows none; the largest that it may have"
        if len(effect.free()) > 1:
            condition += f" with {' and '.join(effect.free()[1:])} of the start model"
        yield from self._conditional(effect, index, numbers, level, condition, none=True)

    def _conditional(
        self, effect: Effect, index: int, numbers: Sequence[_Number], level: float, condition: str, none: bool = False
    ) -> Iterator[StartParameter]:
        """Yield the parameters of a process with all but its size as the start model has them."""
        size, *_ = effect.free()
        excess, bound = self.profile.excess(index), float(chi2.isf(level, 1))
        sized = self.profile.sized(index, effect, size, excess * bound, none)
        log_p = float(chi2.logsf(sized.deviance / excess, 1))
        for number in numbers:
            of_size = number.of(replace(effect, **{size: 2 * getattr(effect, size)})) != number.of(effect)
            if not of_size:
                reason = "the log shows none of the process" if none else ""
                yield self._row(effect, number, None, 0.0, Comparison.OPEN if none else Comparison.AGREES, reason)
                continue
            scale = number.of(effect) / getattr(effect, size)
            value, low, high = (scale * one for one in (sized.value, sized.low, sized.high))
            differs = log_p < np.log(level)
            yield self._row(
                effect, number, Interval(0.0 if none else value, low, high, number.unit), log_p,
                Comparison.DIFFERS if differs else Comparison.AGREES, condition,
            )  # fmt: skip

    def _as_fitted(self, effect: Effect) -> Effect:
        """Return white noise of the start model with what the rounding of the log adds to it."""
        if not effect.white:
            return effect
        own = next(one for one in self.profile.noise.effects if one.white)
        added = own.density**2 - self._before_rounding(own).density ** 2
        return replace(effect, density=sqrt(effect.density**2 + added))

    def _before_rounding(self, white: Effect) -> Effect:
        """Return fitted white noise without what the rounding of the log adds to it."""
        final = tuple(self.found.final.axes.get(self.name, ()))
        behind = tuple(one for one in final if one.role is Role.FILTER)
        return unrounded((white, *behind), final, self.fits[0].sequence)[0]

    def _term(self, effect: Effect, place: int, level: float) -> Iterator[StartParameter]:
        """Yield the parameters of a term of the mean."""
        fit = self.fits[0]
        entry, covariance = fit.description.entries[place], fit.covariance
        first = sum(len(term.free) for term in fit.description.terms[:place])
        own = covariance[first : first + len(entry.free), first : first + len(entry.free)]
        for number in self.numbers(effect):
            error = _error(number, entry, own)
            if not error or not isfinite(error):
                yield self._row(effect, number, None, 0.0, Comparison.OPEN, "no fit adjusts it")
                continue
            yield self._normal(effect, number, number.of(entry.effect), error, 0.0, level)

    def _normal(
        self, effect: Effect, number: _Number, value: float, error: float, unknown: float, level: float,
        start: float | None = None,
    ) -> StartParameter:  # fmt: skip
        """Return a number beside a normally distributed one of the log, which may be off by ``unknown`` besides."""
        start = number.of(effect) if start is None else start
        far = max(abs(value - start) - unknown, 0.0) / error
        log_p = float(np.log(2) + norm.logsf(far)) if far else 0.0
        reach = float(norm.isf(level / 2)) * error + unknown
        agreement = Comparison.DIFFERS if log_p < np.log(level) else Comparison.AGREES
        row = self._row(effect, number, Interval(value, value - reach, value + reach, number.unit), log_p, agreement)
        return replace(row, start=start)

    def _level(self, level: float) -> Iterator[StartParameter]:
        """Yield the constant bias."""
        biases = [one for one in self.effects if one.role is Role.BIAS]
        given = BIAS(sum(one.value for one in biases))
        if not biases and self.keys is not None and not any(key.kind.role is Role.BIAS for key in self.keys):
            return
        (number,) = self.numbers(given)
        if self.resting and self.name in ACCEL and self.found.gravity is not None:
            if biases:
                reason = "at rest it cannot be distinguished from gravity and tilt"
                yield self._row(given, number, None, 0.0, Comparison.OPEN, reason)
            return
        level_of, error = self._mean_level()
        unknown = ROTATION_RATE if self.resting and self.name in GYRO else 0.0
        scale = abs(number.of(BIAS(1.0)))
        row = self._normal(given, number, number.of(BIAS(level_of)), scale * error, scale * unknown, level)
        if not biases:
            missing = row.agreement is Comparison.DIFFERS
            if missing:
                yield replace(row, start=None, agreement=Comparison.MISSING)
            return
        yield row

    def _mean_level(self) -> tuple[float, float]:
        """Return the mean of the levels of all runs, and its standard deviation with that of the start model."""
        levels = np.array([offset(one.sequence, one.description) for one in self.fits])
        levels[0] = offset_of(self.found.final[self.name]) if len(levels) == 1 else levels[0]
        spread = sum(one.std**2 for one in self.effects if one.role is Role.RUN)
        errors = np.array([self._level_error(one) for one in self.fits])
        return float(levels.mean()), float(np.sqrt(np.mean(errors**2 + spread) / len(levels)))

    def _level_error(self, run: AxisFit) -> float:
        """Return the standard deviation of the level of a run: by the fitted noise, or that of the start model."""
        conditions = run.sequence.conditions
        duration = conditions.interval * len(conditions)
        slopes = jacobian(run.description.terms, run.sequence).mean(axis=0)
        noises = run.description.noise.effects, [one for one in self.effects if noisy(one)]
        variance = max(sum(mean_variance(one, duration, conditions.interval) for one in some) for some in noises)
        return float(np.sqrt(variance + slopes @ run.covariance @ slopes))

    def _over_runs(self, effect: Effect, level: float) -> Iterator[StartParameter]:
        """Yield the spread of the levels over the runs."""
        levels = np.array([offset(one.sequence, one.description) for one in self.fits])
        noise = float(np.mean([self._level_error(one) ** 2 for one in self.fits]))
        free, squares = len(levels) - 1, float(np.sum((levels - levels.mean()) ** 2))
        ends = (sqrt(max(squares / chi2.ppf(share, free) - noise, 0.0)) for share in (1 - level / 2, level / 2))
        tail = chi2.cdf(squares / (effect.std**2 + noise), free)
        log_p = float(np.log(max(2 * min(tail, 1 - tail), exp(MIN_LOG_P))))
        agreement = Comparison.DIFFERS if log_p < np.log(level) else Comparison.AGREES
        value = sqrt(max(squares / free - noise, 0.0))
        for number in self.numbers(effect):
            scale = number.of(effect) / effect.std
            value, low, high = (scale * one for one in (value, *ends))
            yield self._row(effect, number, Interval(value, low, high, number.unit), log_p, agreement)

    def _output(self, effect: Effect) -> Iterator[StartParameter]:
        """Yield the parameters of an effect on the output, which the samples themselves show."""
        evidence = next((one for one in self._confirmed() if isinstance(one.effect, type(effect))), None)
        for number in self.numbers(effect):
            if evidence is None:
                changed = self._would_change(effect)
                agreement = Comparison.DIFFERS if changed else Comparison.OPEN
                reason = "the log has values that it would change" if changed else "the log does not show it"
                yield self._row(effect, number, None, 0.0, agreement, reason)
                continue
            corners = _corners(number, evidence.effect, evidence.intervals)
            start, near = number.of(effect), LATTICE_TOLERANCE
            inside = corners[0] * (1 - near) <= start <= corners[1] * (1 + near)
            interval = Interval(number.of(evidence.effect), *corners, number.unit)
            agreement = Comparison.AGREES if inside else Comparison.DIFFERS
            yield self._row(effect, number, interval, 0.0 if inside else evidence.log_p, agreement)

    def _confirmed(self) -> tuple[Evidence, ...]:
        return self.found.record.confirmed.get(self.name, ())

    def _would_change(self, effect: Effect) -> bool:
        """Return whether an effect would change samples of the log that are as they were measured."""
        sequence = self.found.record.sequences[self.name]
        values = self.found.record.outputs[self.name][~sequence.flawed]
        after = effect.apply(values, sequence.conditions, np.random.default_rng(0))
        return bool(np.abs(after - values).max() > UNTOUCHED * np.ptp(values))

    def missing(self, level: float) -> Iterator[StartParameter]:
        """Yield the parameters of the effects that the start model lacks."""
        for finding in self.found.findings:
            effect = finding.effects.get(self.name)
            if effect is None:
                continue
            for number in self._further(effect):
                yield replace(
                    self._row(effect, number, self._interval(finding, effect, number, level), finding.log_p,
                              Comparison.MISSING),
                    start=None,
                )  # fmt: skip

    def _further(self, effect: Effect) -> tuple[_Number, ...]:
        """Return the numbers of a missing effect; those of its law for white noise where the start model has some."""
        if not effect.white or not any(one.white for one in self.effects):
            return self.numbers(effect)
        return tuple(one for one in self._native(effect) if one.name != f"{effect.name}.{effect.size()}")

    def _interval(self, finding: Finding, effect: Effect, number: _Number, level: float) -> Interval:
        entries = self.fits[0].description.of(Role.NOISE)
        index = next(
            (place for place, one in enumerate(entries) if not one.known and type(one.effect) is type(effect)), None
        )
        if index is not None and effect.role is Role.NOISE and isfinite(number.log(effect)):
            ends = self.profile.interval(index, number.log, float(chi2.isf(level, 1)))
            return Interval(number.of(effect), *(exp(min(end, 700.0)) for end in ends), number.unit)
        spans = {
            name: (one.low, one.high)
            for name in effect.parameters()
            if (one := finding.parameters.get(name) or finding.parameters.get(f"{name}_{self.name}")) is not None
        }
        return Interval(number.of(effect), *_corners(number, effect, spans), number.unit)


def _error(number: _Number, entry: Entry, covariance: np.ndarray) -> float:
    """Return the standard deviation of a number of a term of the mean."""
    slopes = []
    for name in entry.free:
        value = getattr(entry.effect, name)
        step = SLOPE_STEP * max(abs(value), 1.0)
        ends = (number.of(replace(entry.effect, **{name: value + side * step})) for side in (1, -1))
        slopes.append((next(ends) - next(ends)) / (2 * step))
    return float(np.sqrt(np.array(slopes) @ covariance @ np.array(slopes))) if slopes else 0.0


def _corners(number: _Number, effect: Effect, spans: Mapping[str, tuple[float, float]]) -> tuple[float, float]:
    """Return the range of a number over the intervals of the parameters of an effect."""
    limits = effect.limits()
    clipped = {name: [min(max(end, limits[name][0]), limits[name][1]) for end in ends] for name, ends in spans.items()}
    values = [number.of(effect)]
    for ends in product(*clipped.values()):
        try:
            values.append(number.of(replace(effect, **dict(zip(clipped, ends, strict=True)))))
        except (ValueError, ArithmeticError):
            continue
    return min(values), max(values)

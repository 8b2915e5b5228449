"""What every effect is: a frozen value with described parameters that acts on a sequence at its stage of the chain."""

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import Field, dataclass, field, fields, replace
from enum import IntEnum
from functools import cache, partial
from math import isfinite
from numbers import Real
from types import MappingProxyType
from typing import ClassVar, Self

import numpy as np
import pandas as pd
from scipy.interpolate import CubicHermiteSpline

from imugap.effects.block import Block
from imugap.effects.conditions import Conditions, Run
from imugap.effects.residual import Residual
from imugap.integrity.timestamps import Stamps
from imugap.log import TIME
from imugap.numerics.samples.white_samples import WhiteSamples
from imugap.numerics.spectra.band_limited import interpolate
from imugap.numerics.state_space import StateSpace
from imugap.stream import stream

TINY = float(np.finfo(float).tiny)
"""Lower limit of parameters that have to be positive."""
EXCERPT = 40
"""Largest number of characters of a value in a message."""


Transform = Callable[[np.ndarray, Conditions], np.ndarray]
"""Function (sequence, conditions) of :meth:`Effect.apply` whose random stream is bound."""


class Stage(IntEnum):
    """Where in the chain from the physical input to the stored log an effect acts."""

    NOISE = 1
    """The white noise of the sensing element."""
    MODULATION = 2
    """Scales the noise."""
    ERROR = 3
    """Adds to the error, independent of its other terms."""
    SEQUENCE = 4
    """Transforms the whole error sequence once it is complete."""
    FILTER = 5
    """The filter before the output. From here on effects act on the output, i.e. on input plus error."""
    RANGE = 6
    """The full scale of the output."""
    WORD = 7
    """The word in which a value is stored."""
    TRANSFER = 8
    """The transfer of the words from the device to the log."""
    CLOCK = 9
    """The rows and stamps of the log, which all axes share: the pseudo-axis :data:`imugap.log.TIME`."""
    STANCE = 10
    """Acts on no log: on what a filter takes for known while the device stands."""


class Role(IntEnum):
    """What an effect is to a fit: how it enters the likelihood of a log, and what shows it."""

    MEAN = 1
    """Adds the same sequence whenever the conditions are the same: a term of the mean."""
    NOISE = 2
    """A random process: a term of the spectrum."""
    FILTER = 3
    """Filters what is sensed: a factor of the spectrum."""
    OUTLIERS = 4
    """Rare samples of another distribution."""
    VARIANCE = 5
    """Scales the noise over time."""
    BIAS = 6
    """The constant bias, which every fit leaves free."""
    RUN = 7
    """Differs from run to run only: the levels of several runs show it."""
    OUTPUT = 8
    """Acts on the output behind the filter: the samples themselves show it (``found(values, conditions)``)."""
    CLOCK = 9
    """Acts on rows and stamps: the stamps themselves show it (``found(stamps)``), or the clocks of several runs."""
    UNFITTED = 10
    """No fit adjusts it: it stays as the start model has it."""


@dataclass(frozen=True, eq=False)
class Evidence:
    """An effect seen in the samples or stamps themselves.

    Attributes
    ----------
    effect
        The effect at the estimated parameters.
    intervals
        Lower and upper limit of each parameter, 95 %.
    log_p
        Log p-value of the evidence.
    flawed
        Samples that carry no error of the sensor because of it, shape (n,).
    extent
        Interval of the output in which it acts [unit of the axis], or None for all of its range.
    bounds
        Lower and upper limit of the input of each flawed sample, shape (n,) each, or None where they are not known.
    """

    effect: "Effect"
    intervals: dict[str, tuple[float, float]]
    log_p: float
    flawed: np.ndarray
    extent: tuple[float, float] | None = None
    bounds: tuple[np.ndarray, np.ndarray] | None = None


@dataclass(frozen=True)
class Distribution:
    """White noise whose samples are not normal, seen in the distribution of what a fit makes white.

    Attributes
    ----------
    effect
        The noise at the estimated parameters.
    intervals
        Lower and upper limit of each parameter of its law, 95 %.
    log_p
        Log p-value of normal samples.
    gain
        Gain of log-likelihood over normal samples, to second order.
    """

    effect: "Effect"
    intervals: dict[str, tuple[float, float]]
    log_p: float
    gain: float


def parameter(unit: str, meaning: str, low: float = 0.0, high: float = np.inf, whole: bool = False, **kwargs) -> Field:
    """Declare a parameter of an effect: SI unit (``{u}`` stands for the unit of the axis), meaning, physical limits."""
    return field(metadata={"unit": unit, "meaning": meaning, "low": low, "high": high, "whole": whole}, **kwargs)


@cache
def declared(kind: type["Effect"]) -> tuple[Field, ...]:
    """Return the parameters that a kind of effects declares."""
    return fields(kind)


@cache
def _physical(kind: type["Effect"]) -> tuple[tuple[str, float, float, bool], ...]:
    """Return name, limits and wholeness of each parameter of a kind."""
    return tuple((one.name, *map(one.metadata.get, ("low", "high", "whole"))) for one in declared(kind))


@dataclass(frozen=True)
class Start:
    """Where the fit of an effect that may be missing starts.

    Attributes
    ----------
    effect
        The effect at start values.
    free
        Names of the parameters that the fit adjusts.
    trials
        Number of independent places or shapes among which it was chosen.
    gain
        Gain of log-likelihood that is expected before the fit, everything else held; infinite where not known.
    level
        What every gain of log-likelihood is to be divided by, because the fit is off in the whole neighbourhood.
    """

    effect: "Effect"
    free: tuple[str, ...]
    trials: float = 1.0
    gain: float = np.inf
    level: float = 1.0


@dataclass(frozen=True)
class Effect:
    """One physical cause of error on one axis.

    A subclass is a frozen dataclass in a file of its own. It gives its ``name`` (controlled vocabulary), its
    parameters (:func:`parameter`) and :meth:`apply`; effects that add derive from :class:`AdditiveEffect`, those
    with an Allan variance from :class:`AllanEffect`, those with a spectrum as well from :class:`StochasticEffect`,
    and those of the CLOCK stage from :class:`ClockEffect`.
    """

    name: ClassVar[str]
    stage: ClassVar[Stage]
    role: ClassVar[Role] = Role.UNFITTED
    most: ClassVar[int | None] = None
    """Largest number on one axis; with more, they stand for something else. None where there is no limit."""
    white: ClassVar[bool] = False
    """Whether it is white noise of one axis, of a ``density``."""
    normal: ClassVar[bool] = True
    """Whether its samples are normal, if it is white noise."""
    slow: ClassVar[bool] = False
    """Whether it is a random process with most of its power at low frequencies, Gaussian at any time."""
    stationary: ClassVar[bool] = True
    """Whether its statistics are the same at any time; else it begins with its run."""
    two_valued: ClassVar[bool] = False
    """Whether it is a random process that switches between two values."""
    title: ClassVar[str] = ""
    """Its name in words, where that is not the name with blanks."""
    named: ClassVar[bool] = True
    """Whether the name is one of the vocabulary; else it describes what has no name."""
    of_time: ClassVar[bool] = False
    """Whether it is a mean that follows from the time alone, and that slow noise may look like."""
    of_temperature: ClassVar[bool] = False
    """Whether it is a mean that follows from the temperature."""
    of_motion: ClassVar[bool] = False
    """Whether it answers the error-free motion, and nothing else."""
    transient: ClassVar[bool] = False
    """Whether it is a mean that fades away after power-on, with a ``time_constant``."""
    event: ClassVar[bool] = False
    """Whether it is a change of the mean by a ``step`` at one ``time``, which a matched filter over all times finds."""
    line: ClassVar[bool] = False
    """Whether it is a line of the spectrum, of one ``frequency``."""
    tonal: ClassVar[bool] = False
    """Whether it is a tone, steady or not, whose phase differs from run to run."""
    essential: ClassVar[tuple[str, ...]] = ()
    """Parameters that are not zero; else it is another effect."""
    rounds: ClassVar[bool] = False
    """Whether it spoils no sample: it rounds all of them to a lattice."""
    replaced: ClassVar[bool] = False
    """Whether discovery replaces the samples that it spoils."""
    memoryless: ClassVar[bool] = False
    """Whether, on a device at rest, a sample behind it depends on the same sample and its conditions alone, and what it
    draws for one sample comes after what it draws for the one before."""
    shared: ClassVar[bool] = False
    """Whether all axes with the effect draw from one random stream."""
    common: ClassVar[tuple[str, ...]] = ()
    """Axes of a device that have the effect together, by one value of its parameters; none where each has its own."""

    def __post_init__(self) -> None:
        """Check every parameter against its physical limits."""
        for name, low, high, whole in _physical(type(self)):
            value = getattr(self, name)
            number = type(value) is float or (isinstance(value, Real) and not isinstance(value, bool))
            inside = number and isfinite(value) and low <= value <= high
            if not inside or (whole and value != int(value)):
                span = "> 0" if low == TINY else f"in [{low:g}, {high:g}]"
                kind = "whole" if whole else "finite"
                found = f"{value!r:.{EXCERPT}}"
                raise ValueError(f"{self.name}.{name}: expected a {kind} number {span}; found {found}")

    @property
    def centre(self) -> float | None:
        """Frequency [Hz] of a line or cutoff of a filter; None where there is no such frequency."""
        return None

    @property
    def lattice(self) -> float:
        """Distance of the levels to which it rounds the output [unit of the axis]; 0 where it does not."""
        return 0.0

    @property
    def once(self) -> bool:
        """Whether it happens at a time of its own, so that another run need not have it."""
        return self.event

    def check_axis(self, axis: str) -> None:
        """Raise a ValueError if the effect has no place on ``axis``."""
        if axis == TIME:
            raise ValueError(f"{self.name}: expected a sensor axis; found the pseudo-axis {TIME}")

    def own_axis(self, conditions: Conditions) -> str:
        """Return the axis of the conditions; ValueError where there is none, or the effect has no place on it."""
        if conditions.axis is None:
            raise ValueError(f"{self.name}: expected conditions with an axis; found none")
        self.check_axis(conditions.axis)
        return conditions.axis

    @classmethod
    def error_free(cls, conditions: Conditions, axes: Sequence[str]) -> np.ndarray:
        """Return the error-free signals of ``axes``, shape (n, len(axes)); ValueError where one is not known."""
        cls._require(conditions.ideal, axes)
        return np.array([conditions.signals[axis] for axis in axes]).reshape(len(axes), len(conditions)).T

    @classmethod
    def interpolated(cls, conditions: Conditions, axes: Sequence[str]) -> CubicHermiteSpline:
        """Return the band-limited interpolation of the error-free signals of ``axes``, of shape (n, len(axes)).

        It covers the times of :attr:`Conditions.known_motion`; ValueError where a signal is not known.
        """
        motion = conditions.known_motion
        cls._require(motion, axes)
        return interpolate(motion.index.to_numpy(float), motion[list(axes)].to_numpy(float))

    @classmethod
    def _require(cls, ideal: pd.DataFrame | None, axes: Sequence[str]) -> None:
        """Raise a ValueError unless an error-free log has some axes."""
        if ideal is None:
            raise ValueError(f"{cls.name}: expected conditions with an error-free log; found none")
        missing = [axis for axis in axes if axis not in ideal]
        if missing:
            raise ValueError(f"{cls.name}: expected an error-free log with {', '.join(missing)}; found none")

    def apply(self, sequence: np.ndarray, conditions: Conditions, rng: np.random.Generator) -> np.ndarray:
        """Return what becomes of ``sequence``, shape (n,): the error up to this stage, or the output."""
        raise NotImplementedError

    @property
    def periodic(self) -> bool:
        """Return whether it repeats one wave of a free shape, which may have many causes; False by default."""
        return False

    def simpler(self, time: float) -> Start | None:
        """Return the effect that it is where its essential parameters are zero, most alike at a time [s], or None."""
        return None

    def in_parts(self, run: Run, rng: np.random.Generator) -> Transform | None:
        """Return :meth:`apply` as a function of one part of a run after the other, or None where there is none such."""
        return partial(self.apply, rng=rng) if self.memoryless else None

    def sweep(self, duration: float) -> tuple[float, float]:
        """Return the frequency [Hz] of a tone at the begin and at the end of a log of a duration [s]."""
        raise NotImplementedError

    def reach(self, duration: float) -> tuple[float, float]:
        """Return the lowest and the highest frequency [Hz] of a tone over a log of a duration [s]."""
        low, high = sorted(self.sweep(duration))
        return low, high

    def block(self, interval: float, axis: str) -> Block | None:
        """Return the effect as a step from sample to sample at an interval [s]; None where it has no such form."""
        return None

    def parameters(self) -> dict[str, float]:
        """Return the parameters by name, in SI units."""
        return {item.name: getattr(self, item.name) for item in declared(type(self))}

    def free(self) -> tuple[str, ...]:
        """Return the parameters that a fit adjusts: none that is whole, and none with a sign.

        Those of a term of the mean differ from fit to fit (:class:`Start`).
        """
        return tuple(
            item.name for item in declared(type(self)) if not item.metadata["whole"] and item.metadata["low"] >= 0
        )

    @classmethod
    def units(cls, axis_unit: str) -> dict[str, str]:
        """Return the SI unit of each parameter for an axis measured in ``axis_unit``."""
        return {item.name: item.metadata["unit"].replace("{u}", axis_unit) for item in declared(cls)}

    @classmethod
    @cache
    def limits(cls) -> Mapping[str, tuple[float, float]]:
        """Return the physical limits of each parameter."""
        return MappingProxyType({name: (low, high) for name, low, high, _ in _physical(cls)})

    @classmethod
    def starts(cls, fit: Residual) -> Iterator[Start]:
        """Yield where fits start of an effect of this kind that ``fit`` may miss; none by default."""
        return iter(())

    @classmethod
    def joining(cls, one: "Effect", other: "Effect", conditions: Conditions) -> Iterator[Start]:
        """Yield where fits start of one effect of this kind that may stand for two effects; none by default."""
        return iter(())

    @classmethod
    def shown(cls, samples: WhiteSamples, density: float) -> Distribution | None:
        """Return white noise of this kind and a density if its law is that of samples, or None."""
        return None

    def __add__(self, other):
        """Compose: ``WhiteNoise(1e-4) + RandomWalk(2e-6)`` is the error of an axis."""
        return AxisModel((self,)) + other


@dataclass(frozen=True)
class AdditiveEffect(Effect):
    """An effect that adds a sequence of its own to the error."""

    stage: ClassVar[Stage] = Stage.ERROR

    def sample(self, conditions: Conditions, rng: np.random.Generator) -> np.ndarray:
        """Draw the sequence that this effect adds, shape (n,)."""
        raise NotImplementedError

    def apply(self, sequence: np.ndarray, conditions: Conditions, rng: np.random.Generator) -> np.ndarray:
        """Add a drawn sequence."""
        return sequence + self.sample(conditions, rng)


@dataclass(frozen=True)
class SystematicEffect(AdditiveEffect):
    """An effect that adds the same sequence whenever the conditions are the same; it draws nothing."""

    role: ClassVar[Role] = Role.MEAN

    def slopes(self, conditions: Conditions) -> dict[str, np.ndarray]:
        """Return the derivative of :meth:`sample` in each parameter that a fit may adjust, arrays of shape (n,)."""
        raise NotImplementedError

    def near_misses(self, conditions: Conditions) -> list[np.ndarray]:
        """Return, for each function similar to this effect, the columns, shape (n, m), of the difference."""
        return []

    def proposed(self, fit: Residual, free: tuple[str, ...], trials: float = 1.0) -> Iterator[Start]:
        """Yield the start from here with ``free`` parameters if the data separate them from each other and the terms.

        The expected gain is that of the linear effect of these parameters.
        """
        slopes = self.slopes(fit.sequence.conditions)
        columns = np.column_stack([slopes[name] for name in free])
        gain, rank = fit.joint_gain(fit.whiten(columns))
        if rank == len(free):
            yield Start(self, free, trials, gain)


@dataclass(frozen=True)
class AllanEffect(AdditiveEffect):
    """An additive effect, random or not, whose Allan variance follows from its parameters alone."""

    def allan_variance(self, tau: np.ndarray) -> np.ndarray:
        """Return the Allan variance [unit^2] at averaging times ``tau`` [s] of the continuous process."""
        raise NotImplementedError

    def sampled_allan_variance(self, averaging: np.ndarray, interval: float) -> np.ndarray:
        """Return the Allan variance [unit^2] of what :meth:`sample` draws, exactly, at averaging factors ``averaging``.

        It is the expectation of :func:`imugap.estimation.variances.allan.variance`; the continuous
        :meth:`allan_variance` is its limit for averaging times far above the interval.
        """
        raise NotImplementedError


@dataclass(frozen=True)
class StochasticEffect(AllanEffect):
    """An additive random process with a spectrum, which goes with the square of its first parameter.

    Unless its own page says otherwise, what is drawn are values at the sample times, not means over the intervals:
    for slow processes the difference is of the order of interval/tau at averaging time tau.
    """

    role: ClassVar[Role] = Role.NOISE

    @classmethod
    def size(cls) -> str:
        """Return the name of its first parameter, with whose square the spectrum goes."""
        return declared(cls)[0].name

    def psd(self, frequency: np.ndarray) -> np.ndarray:
        """Return the two-sided power spectral density [unit^2/Hz] at ``frequency`` [Hz] of the continuous process."""
        raise NotImplementedError

    def sampled_psd(self, frequency: np.ndarray, interval: float) -> np.ndarray:
        """Return the two-sided PSD [unit^2/Hz], aliases included, of what :meth:`sample` draws.

        ``frequency`` [Hz] lies within (0, 1/(2 interval)]; the integral over both sides is the variance of a sample.
        """
        raise NotImplementedError

    @classmethod
    def starts(cls, fit: Residual) -> Iterator[Start]:
        """Yield the size at which the residual's spectrum, near the fit, has most room for the process.

        Only for processes of one density, of which there is one of a kind; others say themselves where they start.
        """
        names = tuple(cls.limits())
        if len(names) == 1 and not any(type(effect) is cls for effect in fit.description.noise):
            size = fit.room(cls(1.0))
            if size > 0:
                yield Start(cls(size), names, gain=fit.gain_of(cls(size)))

    def end_error(self, interval: float) -> float:
        """Return the standard deviation [unit] that errors just outside a log add to its end samples; 0 if none do."""
        return 0.0

    def state_space(self) -> StateSpace:
        """Return the process as a linear model driven by white noise; ValueError if none is of finite order."""
        raise ValueError(f"{self.name}: expected a process with a state space of finite order; found none")


@dataclass(frozen=True)
class EquivalentEffect(StochasticEffect):
    """A random process whose spectrum and Allan variance are those of another one, its :attr:`equivalent`."""

    @property
    def equivalent(self) -> StochasticEffect:
        """Return the process of the same spectrum."""
        raise NotImplementedError

    def psd(self, frequency: np.ndarray) -> np.ndarray:
        """Return the PSD of the equivalent."""
        return self.equivalent.psd(frequency)

    def allan_variance(self, tau: np.ndarray) -> np.ndarray:
        """Return the Allan variance of the equivalent."""
        return self.equivalent.allan_variance(tau)

    def sampled_psd(self, frequency: np.ndarray, interval: float) -> np.ndarray:
        """Return the sampled PSD of the equivalent."""
        return self.equivalent.sampled_psd(frequency, interval)

    def sampled_allan_variance(self, averaging: np.ndarray, interval: float) -> np.ndarray:
        """Return the sampled Allan variance of the equivalent."""
        return self.equivalent.sampled_allan_variance(averaging, interval)


@dataclass(frozen=True)
class FilterEffect(Effect):
    """A filter of the output, of which a fit adjusts one parameter."""

    stage: ClassVar[Stage] = Stage.FILTER
    role: ClassVar[Role] = Role.FILTER
    rippled: ClassVar[bool] = False
    """Whether its gain is a ripple of one shape; else filters of its kind represent all that are like them."""

    @property
    def adjusted(self) -> float:
        """Value of the parameter that a fit adjusts."""
        return getattr(self, *self.free())

    def adjusted_to(self, value: float) -> Self:
        """Return the filter with another value of the parameter that a fit adjusts."""
        return replace(self, **dict.fromkeys(self.free(), value))

    def passed(self, values: np.ndarray, interval: float) -> np.ndarray:
        """Return samples behind the filter, shape (n,) or (n, m), as if the first had been there for ever."""
        raise NotImplementedError

    def decay(self, count: int, interval: float) -> np.ndarray:
        """Return what the first ``count`` samples still hold of a one that was there for ever before them."""
        raise NotImplementedError

    def gain(self, frequency: np.ndarray, interval: float) -> np.ndarray:
        """Return the power gain at ``frequency`` [Hz], shape of it."""
        raise NotImplementedError

    def mean_gain(self, frequency: np.ndarray, width: np.ndarray, interval: float) -> np.ndarray:
        """Return the mean power gain over bands of a width [Hz] about ``frequency`` [Hz], shape of it.

        It is the gain in the middle of each, where the gain changes little within.
        """
        return self.gain(frequency, interval)

    def response(self, frequency: np.ndarray, interval: float) -> np.ndarray:
        """Return the complex gain at ``frequency`` [Hz], shape of it."""
        raise NotImplementedError

    def highest(self, interval: float) -> float:
        """Return the highest identifiable value of the parameter that a fit adjusts."""
        raise NotImplementedError

    def apply(self, sequence: np.ndarray, conditions: Conditions, rng: np.random.Generator) -> np.ndarray:
        """Filter the output."""
        return self.passed(sequence, conditions.interval)

    def unturned(self, spectrum: np.ndarray, frequency: np.ndarray, interval: float) -> np.ndarray:
        """Return a spectrum at ``frequency`` [Hz], shape of it, without the phase that the filter gave it."""
        return spectrum * np.exp(-1j * np.angle(self.response(frequency, interval)))


@dataclass(frozen=True)
class VarianceEffect(Effect):
    """A factor of the variance of the noise over time."""

    stage: ClassVar[Stage] = Stage.MODULATION
    role: ClassVar[Role] = Role.VARIANCE

    def factor(self, time: np.ndarray) -> np.ndarray:
        """Return the factor of the variance at each time [s], shape of it."""
        raise NotImplementedError

    def free(self) -> tuple[str, ...]:
        """Return the parameters that a search chooses besides the place."""
        raise NotImplementedError

    def apply(self, sequence: np.ndarray, conditions: Conditions, rng: np.random.Generator) -> np.ndarray:
        """Scale the noise."""
        return np.sqrt(self.factor(conditions.time)) * sequence


@dataclass(frozen=True)
class ClockEffect(Effect):
    """An effect on the rows or stamps of a whole log, at home on the pseudo-axis :data:`imugap.log.TIME`."""

    stage: ClassVar[Stage] = Stage.CLOCK
    role: ClassVar[Role] = Role.CLOCK

    displaces: ClassVar[bool] = False
    """Whether it displaces the stamps, so that the samples are even in time where the stamps are not."""

    def keep(self, log: pd.DataFrame, rng: np.random.Generator) -> pd.DataFrame:
        """Return the log that is kept of ``log``."""
        raise NotImplementedError

    def keep_parts(
        self, parts: Iterator[pd.DataFrame], count: int, rng: np.random.Generator
    ) -> Iterator[pd.DataFrame] | None:
        """Return :meth:`keep` of a log of at most ``count`` rows that comes in parts, or None where there is none."""
        return (self.keep(part, rng) for part in parts) if self.memoryless else None

    @classmethod
    def found(cls, stamps: Stamps) -> Evidence | None:
        """Return what the stamps of a log show of it, or None."""
        return None

    @classmethod
    def between(cls, log_interval: float, std: float) -> Evidence | None:
        """Return what two runs show of it, or None.

        ``log_interval`` is the logarithm of the true over the stamped interval of one, and ``std`` its deviation.
        """
        return None

    @classmethod
    def missing(cls, lost: np.ndarray) -> Evidence | None:
        """Return what samples without a value on one axis, shape (n,), show of it, or None."""
        return None

    def apply(self, sequence: np.ndarray, conditions: Conditions, rng: np.random.Generator) -> np.ndarray:
        """Refuse: the sequence of one axis has no stamps."""
        raise ValueError(f"{self.name}: expected a whole log (the pseudo-axis {TIME}); found the sequence of one axis")

    def check_axis(self, axis: str) -> None:
        """Raise a ValueError unless ``axis`` is the pseudo-axis."""
        if axis != TIME:
            raise ValueError(f"{self.name}: expected the pseudo-axis {TIME}; found {axis}")


@dataclass(frozen=True)
class AxisModel:
    """The error of one axis: a sum of effects, kept in the order of the signal chain."""

    effects: tuple[Effect, ...] = ()

    def __post_init__(self) -> None:
        """Sort by stage; within a stage the given order stays."""
        object.__setattr__(self, "effects", tuple(sorted(self.effects, key=lambda effect: effect.stage)))

    def __add__(self, other: "Effect | AxisModel") -> "AxisModel":
        """Add an effect or all effects of another axis model."""
        if isinstance(other, Effect):
            return AxisModel((*self.effects, other))
        return AxisModel(self.effects + other.effects) if isinstance(other, AxisModel) else NotImplemented

    def __iter__(self) -> Iterator[Effect]:
        """Iterate over the effects."""
        return iter(self.effects)

    def streams(
        self, seed: int, *labels: object, axis: str | None = None
    ) -> Iterator[tuple[Effect, np.random.Generator]]:
        """Iterate over the effects with the random stream of each; a shared one has no axis in its name."""
        count: Counter = Counter()
        for effect in self.effects:
            count[effect.name] += 1
            own = () if axis is None or effect.shared else (axis,)
            yield effect, stream(seed, *labels, *own, effect.name, count[effect.name])

    def simulate(self, ideal: np.ndarray, conditions: Conditions, seed: int, *labels: object) -> np.ndarray:
        """Return the output, shape (n,), for the error-free input ``ideal``; each effect draws from its own stream."""
        streams = self.streams(seed, *labels, axis=conditions.axis)
        return self._chained([partial(effect.apply, rng=rng) for effect, rng in streams], ideal, conditions)

    def in_parts(self, run: Run, axis: str, seed: int, *labels: object) -> Transform | None:
        """Return :meth:`simulate` as a function of one part of a run after the other, or None where an effect has none.

        Parts have the values of the whole run, to rounding; effects that have another form in parts say so.
        """
        steps = [effect.in_parts(run, rng) for effect, rng in self.streams(seed, *labels, axis=axis)]
        return None if None in steps else partial(self._chained, steps)

    def _chained(self, steps: Sequence[Transform], ideal: np.ndarray, conditions: Conditions) -> np.ndarray:
        """Return the output of the steps of all effects: those ahead of the filter act on the error alone."""
        error, output = np.zeros(len(conditions)), None
        for effect, step in zip(self.effects, steps, strict=True):
            if effect.stage < Stage.FILTER:
                error = step(error, conditions)
            else:
                output = step(ideal + error if output is None else output, conditions)
        return ideal + error if output is None else output

    def stochastic(self) -> tuple[StochasticEffect, ...]:
        """Return the effects that have a spectrum."""
        return tuple(effect for effect in self.effects if isinstance(effect, StochasticEffect))

    def psd(self, frequency: np.ndarray) -> np.ndarray:
        """Return the two-sided PSD [unit^2/Hz] of the stochastic effects at ``frequency`` [Hz]."""
        return sum((effect.psd(frequency) for effect in self.stochastic()), np.zeros(np.shape(frequency)))

    def sampled_psd(self, frequency: np.ndarray, interval: float) -> np.ndarray:
        """Return the two-sided PSD [unit^2/Hz], aliases included, of the samples of the stochastic effects."""
        zero = np.zeros(np.shape(frequency))
        return sum((effect.sampled_psd(frequency, interval) for effect in self.stochastic()), zero)

    def allan_variance(self, tau: np.ndarray) -> np.ndarray:
        """Return the Allan variance [unit^2] at ``tau`` [s] of the effects that have one, stochastic or ramp."""
        return sum((effect.allan_variance(tau) for effect in self._with_allan()), np.zeros(np.shape(tau)))

    def sampled_allan_variance(self, averaging: np.ndarray, interval: float) -> np.ndarray:
        """Return the Allan variance [unit^2] of their samples, exactly, at averaging factors ``averaging``."""
        zero = np.zeros(np.shape(averaging))
        return sum((effect.sampled_allan_variance(averaging, interval) for effect in self._with_allan()), zero)

    def _with_allan(self) -> tuple[AllanEffect, ...]:
        return tuple(effect for effect in self.effects if isinstance(effect, AllanEffect))

    def state_space(self) -> StateSpace:
        """Return the state space of the stochastic effects."""
        return sum((effect.state_space() for effect in self.stochastic()), StateSpace.white(0.0))

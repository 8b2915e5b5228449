"""Values and 95 % intervals of the effects of a fitted axis."""

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from imugap.discovery.finding import Interval
from imugap.discovery.fit.axis_fit import AxisFit, fit
from imugap.effects.effect import Effect, Role
from imugap.log import GYRO
from imugap.numerics.normal_quantile import NORMAL_QUANTILE

MAX_GAIN_DROP = 3.676
"""Drop of log-likelihood at the ends of a 95 % interval of the place of a change.

On either side of the true place the likelihood is a random walk that falls; how far it climbs above its begin is
exponential, and the higher of the two climbs is below x in the share (1 - exp(-x))^2 of cases (Hinkley 1970).
"""
MAX_LOG_STD = 20.0
"""Standard deviation of a log parameter above which nothing is known of it."""


def intervals(fit: AxisFit, index: int) -> dict[str, Interval]:
    """Return the parameters of the effect at ``index`` of the description."""
    effect = fit.description.entries[index].effect
    units = effect.units(axis_unit(fit.sequence.conditions.axis))
    if effect.role is Role.MEAN:
        ends = term_intervals(fit, index)
        if effect.event:
            ends["time"] = times_near_best(fit.steps_without(index).gains, fit.sequence.conditions.time, effect.time)
    elif effect.role is Role.VARIANCE:
        ends = _swing(fit, effect) if effect.depth else _stretch(fit, effect)
    else:
        ends = _random(fit, index - len(fit.description.terms))
    return {
        name: Interval(value, *map(float, ends.get(name, (value, value))), units[name])
        for name, value in effect.parameters().items()
    }


def repeats(kind: type[Effect]) -> bool:
    """Return whether an effect is a slow mean, which every run of a device has by the same parameters."""
    return kind.role is Role.MEAN and not (kind.event or kind.tonal or kind.of_motion)


def intervals_beside_slow_noise(found: AxisFit, index: int, catalogue: Iterable[type[Effect]]) -> dict[str, Interval]:
    """Return the parameters of the slow mean at ``index``, with the widest ends beside further slow noise as likely.

    Slow noise that is not significant may be there, and most of the error of a slow mean is its.
    """
    starts = (start for kind in catalogue if kind.slow for start in kind.starts(found))
    wider = (fit(found.sequence, found.description.adding(start.effect)) for start in starts)
    likelier = [one for one in wider if one.log_likelihood > found.log_likelihood]
    ends = [intervals(one, index) for one in (found, *likelier)]
    return {
        name: replace(one, low=min(other[name].low for other in ends), high=max(other[name].high for other in ends))
        for name, one in ends[0].items()
    }


def axis_unit(axis: str) -> str:
    """Return the SI unit of an axis."""
    return "rad/s" if axis in GYRO else "m/s^2"


def term_intervals(fit: AxisFit, index: int) -> dict[str, tuple[float, float]]:
    """Return the 95 % interval of each free parameter of a term."""
    first = sum(len(term.free) for term in fit.description.terms[:index])
    term = fit.description.terms[index]
    errors = np.sqrt(np.maximum(np.diag(fit.covariance), 0.0))[first : first + len(term.free)]
    values = {name: getattr(term.effect, name) for name in term.free}
    limits = term.effect.limits()
    return {
        name: tuple(float(np.clip(values[name] + side * NORMAL_QUANTILE * error, *limits[name])) for side in (-1, 1))
        for name, error in zip(term.free, errors, strict=True)
    }


def _random(fit: AxisFit, index: int) -> dict[str, tuple[float, float]]:
    """Return the intervals of a random process or the filter, in logarithms, from the expected information."""
    noise = fit.description.noise
    information = fit.noise.information
    covariance = np.linalg.pinv(information, rcond=1e-12, hermitian=True)
    ends = {}
    for j, (i, name) in enumerate(noise.parameters):
        if i == index:
            value = getattr(list(noise)[i], name)
            error = np.sqrt(max(covariance[j, j], 0.0))
            known = information[j, j] > 0 and error < MAX_LOG_STD
            factor = np.exp(NORMAL_QUANTILE * error) if known else np.inf
            limits = list(noise)[i].limits()[name]
            ends[name] = tuple(float(np.clip(end, *limits)) for end in (value / factor, value * factor))
    return ends


def _swing(fit: AxisFit, change: Effect) -> dict[str, tuple[float, float]]:
    """Return the intervals of a line of amplitude ``depth`` in squares of relative variance 2 (Rife, Boorstyn 1974)."""
    count, interval = len(fit.sequence.values), fit.sequence.conditions.interval
    errors = {
        "depth": 2 / np.sqrt(count),
        "phase": 4 / change.depth / np.sqrt(count),
        "frequency": np.sqrt(48 / count) / change.depth / (2 * np.pi * count * interval),
    }
    return {
        name: (getattr(change, name) - NORMAL_QUANTILE * error, getattr(change, name) + NORMAL_QUANTILE * error)
        for name, error in errors.items()
    }


def _stretch(fit: AxisFit, change: Effect) -> dict[str, tuple[float, float]]:
    """Return the ratio's interval from the numbers of samples, and the ends from the likelihood of their places."""
    time = fit.sequence.conditions.time
    inside = change.within(time)
    count = inside.sum()
    error = np.sqrt(2 / count + 2 / max(len(time) - count, 1))
    raw = fit.residual**2 * np.square(fit.scale)
    low, high = raw[~inside].mean(), raw[inside].mean()
    slope = 0.5 * (raw * (1 / low - 1 / high) - np.log(high / low))
    climb = np.r_[0.0, np.cumsum(slope)]
    first, last = np.searchsorted(time, [change.start, change.stop])
    extended = np.r_[time, time[-1] + fit.sequence.conditions.interval]
    return {
        "ratio": (change.ratio * np.exp(-NORMAL_QUANTILE * error), change.ratio * np.exp(NORMAL_QUANTILE * error)),
        "start": times_near_best(-climb[:last], extended[:last], extended[first]),
        "stop": times_near_best(climb[first + 1 :], extended[first + 1 :], extended[last]),
    }


def times_near_best(gain: np.ndarray, time: np.ndarray, best: float) -> tuple[float, float]:
    """Return the first and the last time at which the gain is no further below the best than the interval allows.

    A change that the sample at ``time`` is the first to show came at any time since the sample before.
    """
    index = int(np.clip(np.searchsorted(time, best), 0, len(gain) - 1))
    near = np.flatnonzero(gain >= gain[index] - MAX_GAIN_DROP)
    return float(time[max(near[0] - 1, 0)]), float(time[near[-1]])

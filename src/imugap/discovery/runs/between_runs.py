"""Effects that differ between runs of one device: turn-on bias and sampling clock."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np
from scipy.stats import chi2

from imugap.discovery.checks import MAX_LOG_P, shape_log_p
from imugap.discovery.finding import Finding, Interval, finding
from imugap.discovery.fit.axis_fit import AxisFit, fit, jacobian, offset
from imugap.discovery.fit.description import Description, Entry
from imugap.discovery.preparation.sequence import AxisSequence
from imugap.discovery.search.intervals import axis_unit, term_intervals
from imugap.effects import CATALOGUE
from imugap.effects.effect import Effect, Role, StochasticEffect
from imugap.integrity.sampling_clock import BLOCKS, SHORTEST, relative_interval, spectra
from imugap.log import TIME, from_samples
from imugap.numerics.normal_quantile import NORMAL_QUANTILE

WALK_CUTOFF, STATIONARY_CUTOFF = 0.1049769, 1e-7
"""Lower limits [periods per run] of the variance integral of a mean: of noise that starts with the run, and stationary.

With the first, the spectrum of a random walk makes that of its mean, K^2 duration/3: the integral of sinc^2(x)/x^2
is 2 pi^2/3.
"""
MAX_CORRELATION_TIME = 0.2
"""Maximum correlation time [runs] of noise that does not imitate a constant level in a run."""
FREQUENCIES = 20_000
"""Number of frequencies of the integral over the spectrum."""
MAX_LINE_SHIFT = 0.01
"""Maximum relative shift of a line between runs whose clocks no other evidence compares."""
MIN_LINE_GAIN = 20.0
"""Minimum log-likelihood gain of a line to be identified with that of the other run."""
SEARCH_WIDTH = 4.0
"""Half-width of the search for a line [standard deviations of the clock ratio, or periods per log]."""
MIN_AGREEMENT = 0.01
"""Minimum probability for kinds of evidence to agree."""
Runs = list[Mapping[str, AxisFit]]
"""Fit of each axis, for each run."""
Catalogue = Sequence[type[Effect]]
"""Kinds of effects that may be missing."""
ALL_KINDS = tuple(CATALOGUE.values())


def turn_on_findings(fits: Runs, log_alpha: float, catalogue: Catalogue = ALL_KINDS) -> tuple[Finding, ...]:
    """Return the axes whose levels differ significantly between runs, with their turn-on bias.

    A level is the mean less the systematic terms, which each run may have; its error is :func:`level_error`. The
    weighted scatter of the levels is chi-square distributed with one degree of freedom less
    than runs.
    """
    axes = [axis for axis in fits[0] if all(axis in one for one in fits)]
    found = (_turn_on_finding(axis, [one[axis] for one in fits], catalogue, log_alpha) for axis in axes)
    return tuple(one for one in found if one is not None)


def _turn_on_finding(axis: str, runs: list[AxisFit], catalogue: Catalogue, log_alpha: float) -> Finding | None:
    levels = np.array([offset(run.sequence, run.description) for run in runs])
    errors = np.array([level_error(run) for run in runs])
    if not np.isfinite(errors).all():
        return None
    found = (kind.between(levels, errors) for kind in catalogue if kind.role is Role.RUN)
    strongest = min(found, key=lambda evidence: evidence.log_p, default=None)
    if strongest is None or strongest.log_p > log_alpha:
        return None
    return finding({axis: strongest.effect}, strongest, axis_unit(axis))


def level_error(run: AxisFit) -> float:
    """Return the standard deviation of the level of a run, of its mean and of the subtracted terms.

    Infinite with noise whose correlation time may reach the run, or of free slope, which cannot be distinguished from a
    bias.
    """
    conditions, noise = run.sequence.conditions, run.description.noise
    duration = conditions.interval * len(conditions)
    if any(memory > MAX_CORRELATION_TIME * duration for memory in _correlation_times(run)) or not all(
        one.named for one in noise.effects
    ):
        return np.inf
    slopes = jacobian(run.description.terms, run.sequence).mean(axis=0)
    variance = sum(mean_variance(effect, duration, conditions.interval) for effect in noise.effects)
    return float(np.sqrt(variance + slopes @ run.covariance @ slopes))


def _correlation_times(run: AxisFit) -> Iterator[float]:
    """Yield the upper end of the 95 % interval of each correlation time [s]."""
    covariance = run.noise.covariance
    for place, (index, name) in enumerate(run.description.noise.parameters):
        if name == "correlation_time":
            time = run.description.noise.effects[index].correlation_time
            yield float(time * np.exp(NORMAL_QUANTILE * np.sqrt(covariance[place, place])))


def mean_variance(effect: StochasticEffect, duration: float, interval: float) -> float:
    """Return the variance of the mean of noise over a run, the integral of S(f) sinc^2(f duration).

    A random walk starts with its run: the integral from :data:`WALK_CUTOFF` periods per run makes it K^2 duration/3.
    Flicker noise, whose variance is unbounded, has the same limit.
    """
    lowest = (STATIONARY_CUTOFF if effect.stationary else WALK_CUTOFF) / duration
    frequency = np.geomspace(lowest, 0.5 / interval, FREQUENCIES)
    passed = effect.sampled_psd(frequency, interval) * np.sinc(frequency * duration) ** 2
    return 2 * float(np.trapezoid(passed, frequency))


def clock_findings(fits: Runs, log_alpha: float, catalogue: Catalogue = ALL_KINDS) -> tuple[Finding, ...]:
    """Return the clock errors of the runs relative to the first, each with the number of its run.

    Evidence is the shift of lines and roll-off in the spectra of blocks (:mod:`imugap.integrity.sampling_clock`), for
    any ratio, and the frequencies of lines that are steady in both runs, for a ratio near one. All terms of the fits
    but the lines have to be those of any run of the device.
    """
    first, *others = fits
    found = (
        _clock_finding(first, other, run, catalogue, log_alpha - np.log(len(others)))
        for run, other in enumerate(others, start=2)
    )
    return tuple(one for one in found if one is not None)


def _clock_finding(
    first: Mapping[str, AxisFit], other: Mapping[str, AxisFit], run: int, catalogue: Catalogue, log_alpha: float
) -> Finding | None:
    """Return the clock error of a run if significant; None where kinds of evidence disagree."""
    blocks = _weighted_mean(_from_blocks(first, other))
    lines = _weighted_mean(_from_lines(first, other, blocks))
    known = _weighted_mean([one for one in (blocks, lines) if one is not None])
    if known is None:
        return None
    mean, sd = known
    found = (kind.between(mean, sd) for kind in catalogue if kind.role is Role.CLOCK)
    strongest = min(filter(None, found), key=lambda evidence: evidence.log_p, default=None)
    if strongest is None or strongest.log_p > log_alpha:
        return None
    found = finding({TIME: strongest.effect}, strongest, "s")
    return replace(found, parameters=found.parameters | {"run": Interval(run, run, run, "1")})


LogRatio = tuple[float, float]
"""Logarithm of the ratio of true to stamped sampling interval, relative to the first run, and its standard
deviation."""


def _weighted_mean(found: list[LogRatio]) -> LogRatio | None:
    """Return the inverse-variance mean, or None without values or where they disagree."""
    if not found:
        return None
    values, weights = np.array([value for value, _ in found]), np.array([sd**-2 for _, sd in found])
    mean = float(np.average(values, weights=weights))
    agree = chi2.sf(weights @ (values - mean) ** 2, max(len(found) - 1, 1)) > MIN_AGREEMENT
    return (mean, float(weights.sum() ** -0.5)) if agree or len(found) == 1 else None


def _from_blocks(first: Mapping[str, AxisFit], other: Mapping[str, AxisFit]) -> list[LogRatio]:
    """Return the ratios by the spectra of blocks, none for runs that are too short.

    Spectra compare samples; the known ratio of the stamped intervals is subtracted.
    """
    intervals = [next(iter(one.values())).sequence.conditions.interval for one in (first, other)]
    logs = [
        from_samples({axis: found.sequence.values for axis, found in one.items()}, interval)
        for one, interval in zip((first, other), intervals, strict=True)
    ]
    if min(map(len, logs)) < BLOCKS * SHORTEST:
        return []
    clock = relative_interval(*map(spectra, logs))
    stamped = float(np.log(intervals[1] / intervals[0]))
    return [(one.log_ratio - stamped, one.sd) for one in (clock.lines, clock.rolloff) if one and one.sd > 0]


def _from_lines(first: Mapping[str, AxisFit], other: Mapping[str, AxisFit], blocks: LogRatio | None) -> list[LogRatio]:
    """Return the ratio by each line that is steady in both runs."""
    return [
        evidence
        for axis, found in first.items()
        if axis in other
        for evidence in _line_ratios(found, other[axis], blocks)
    ]


def _line_ratios(first: AxisFit, other: AxisFit, blocks: LogRatio | None) -> Iterator[LogRatio]:
    terms = first.description.terms
    without_lines = fit(other.sequence, other.description.keeping(lambda entry: not entry.effect.line))
    for index in (i for i, term in enumerate(terms) if term.effect.line):
        line = _line_near(without_lines, terms[index], blocks)
        if line is None:
            continue
        found = fit(other.sequence, without_lines.description.adding(line))
        last = len(found.description.terms) - 1
        if _is_steady(first, index) and _is_steady(found, last):
            before, after = _frequency(first, index), _frequency(found, last)
            yield float(np.log(after[0] / before[0])), float(np.hypot(before[1] / before[0], after[1] / after[0]))


def _line_near(without_lines: AxisFit, line: Entry, blocks: LogRatio | None) -> Entry | None:
    """Return the strongest line within the search width of a line of the first run, or None below the minimum gain."""
    ratio, sd = blocks or (0.0, MAX_LINE_SHIFT / SEARCH_WIDTH)
    duration = without_lines.sequence.conditions.interval * len(without_lines.residual)
    tried, gains, _ = without_lines.lines
    frequency = line.effect.frequency
    near = np.abs(tried - frequency * np.exp(ratio)) < SEARCH_WIDTH * max(sd * frequency, 1 / duration)
    if not near.any() or gains[near].max() < MIN_LINE_GAIN:
        return None
    best = float(tried[near][np.argmax(gains[near])])
    return replace(line, known=False, effect=type(line.effect).at(best, without_lines))


def _is_steady(found: AxisFit, index: int) -> bool:
    return shape_log_p(found, index) > MAX_LOG_P


def _frequency(found: AxisFit, index: int) -> tuple[float, float]:
    """Return the frequency of a line and its standard deviation [Hz]."""
    low, high = term_intervals(found, index)["frequency"]
    return found.description.terms[index].effect.frequency, (high - low) / 2 / NORMAL_QUANTILE


def fit_like_first(sequence: AxisSequence, terms: Sequence[Entry], first: AxisFit) -> AxisFit:
    """Fit another run of a device with the terms of the start model and the terms and noise of the first run.

    Lines and steps are left out: their phase and time differ from run to run.
    """
    added = first.description.terms[len(terms) :]
    repeated = (term for term in added if not (term.effect.event or term.effect.tonal))
    random = (entry for role in (Role.NOISE, Role.FILTER) for entry in first.description.of(role))
    return fit(sequence, Description((*terms, *repeated, *random)))

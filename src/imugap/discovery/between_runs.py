"""Several runs of one device: does its bias differ from run to run, does its sampling clock?"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np
from scipy.stats import chi2

from imugap.discovery.checks import LEVEL as DRIFTING
from imugap.discovery.checks import shape_log_p
from imugap.discovery.finding import Finding, Interval, finding
from imugap.discovery.fit.axis_fit import AxisFit, Description, Term, fit, jacobian, offset
from imugap.discovery.preparation.sequence import AxisSequence
from imugap.discovery.search.intervals import NORMAL, axis_unit, term_intervals
from imugap.effects import CATALOGUE
from imugap.effects.effect import Effect, Role, StochasticEffect
from imugap.integrity.sampling_clock import BLOCKS, SHORTEST, relative_interval, spectra
from imugap.log import TIME, from_samples

BEGIN, NEVER = 0.1049769, 1e-7
"""Periods per run above which noise adds to the variance of a mean: of what begins with the run, and of other noise.

From the first on the spectrum of a random walk makes that of its mean, K^2 duration/3: the integral of sinc^2(x)/x^2
is 2 pi^2/3.
"""
LASTING = 0.2
"""Correlation time, in runs, from which on noise holds a level through a run."""
FREQUENCIES = 20_000
"""At which the integral over the spectrum is taken."""
NEAR = 0.01
"""Largest relative difference of the frequency of a line between runs whose clocks nothing else compares."""
CLEAR = 20.0
"""Gain of log-likelihood from which a line is the one of the other run."""
WIDE = 4.0
"""Standard deviations of the ratio of clocks, or periods per log, within which a line is looked for."""
CONFLICT = 0.01
"""Probability below which kinds of evidence disagree."""
Runs = list[Mapping[str, AxisFit]]
"""Axis to its fit, for each run."""
Catalogue = Sequence[type[Effect]]
"""Kinds of effects that may be missing."""
EVERY = tuple(CATALOGUE.values())


def turn_on(fits: Runs, log_alpha: float, catalogue: Catalogue = EVERY) -> tuple[Finding, ...]:
    """Return the axes whose levels differ between runs by more than the noise of each run lets them.

    A level is the mean less the systematic terms, which every run may have; where it stands is told by
    :func:`level_error`. The weighted scatter of the levels is chi-square distributed with one degree of freedom less
    than runs.
    """
    axes = [axis for axis in fits[0] if all(axis in one for one in fits)]
    found = (_turn_on(axis, [one[axis] for one in fits], catalogue, log_alpha) for axis in axes)
    return tuple(one for one in found if one is not None)


def _turn_on(axis: str, runs: list[AxisFit], catalogue: Catalogue, log_alpha: float) -> Finding | None:
    levels = np.array([offset(run.sequence, run.description) for run in runs])
    errors = np.array([level_error(run) for run in runs])
    if not np.isfinite(errors).all():
        return None
    found = (kind.between(levels, errors) for kind in catalogue if kind.role is Role.RUN)
    surest = min(found, key=lambda evidence: evidence.log_p, default=None)
    if surest is None or surest.log_p > log_alpha:
        return None
    return finding({axis: surest.effect}, surest, axis_unit(axis))


def level_error(run: AxisFit) -> float:
    """Return the standard deviation of the level of a run: that of its mean, and of the terms that are taken off it.

    Infinite beside noise with a memory that may be as long as the run, or of any slope: it holds a level like a bias.
    """
    conditions, noise = run.sequence.conditions, run.description.noise
    duration = conditions.interval * len(conditions)
    if any(memory > LASTING * duration for memory in _memories(run)) or not all(one.named for one in noise.effects):
        return np.inf
    slopes = jacobian(run.description.terms, run.sequence).mean(axis=0)
    variance = sum(mean_variance(effect, duration, conditions.interval) for effect in noise.effects)
    return float(np.sqrt(variance + slopes @ run.covariance @ slopes))


def _memories(run: AxisFit) -> Iterator[float]:
    """Yield the correlation time of each Gauss-Markov process, the upper end of its interval [s]."""
    covariance = run.noise.covariance
    for place, (index, name) in enumerate(run.description.noise.parameters()):
        if name == "correlation_time":
            time = run.description.noise.effects[index].correlation_time
            yield float(time * np.exp(NORMAL * np.sqrt(covariance[place, place])))


def mean_variance(effect: StochasticEffect, duration: float, interval: float) -> float:
    """Return the variance of the mean of noise over a run, the integral of S(f) sinc^2(f duration).

    A random walk begins with its run: below :data:`BEGIN` periods per run nothing is
    missing, which makes it K^2 duration/3; and neither is of flicker, whose variance has no bound.
    """
    lowest = (NEVER if effect.stationary else BEGIN) / duration
    frequency = np.geomspace(lowest, 0.5 / interval, FREQUENCIES)
    passed = effect.sampled_psd(frequency, interval) * np.sinc(frequency * duration) ** 2
    return 2 * float(np.trapezoid(passed, frequency))


def clocks(fits: Runs, log_alpha: float, catalogue: Catalogue = EVERY) -> tuple[Finding, ...]:
    """Return the runs whose clock differs from that of the first, each with its number: lines and roll-off have moved.

    Evidence are the spectra of blocks (:mod:`imugap.integrity.sampling_clock`), which find any ratio, and the lines
    that are steady through both runs, which tell a ratio near one as closely as their frequencies are known. The other
    terms of the fits but the lines have to be what any run of the device has.
    """
    first, *others = fits
    found = (
        _clock(first, other, run, catalogue, log_alpha - np.log(len(others)))
        for run, other in enumerate(others, start=2)
    )
    return tuple(one for one in found if one is not None)


def _clock(
    first: Mapping[str, AxisFit], other: Mapping[str, AxisFit], run: int, catalogue: Catalogue, log_alpha: float
) -> Finding | None:
    """Return by how much the clock of a run differs, if it does; nothing where kinds of evidence disagree."""
    blocks = _mean(_by_blocks(first, other))
    lines = _mean(_by_lines(first, other, blocks))
    known = _mean([one for one in (blocks, lines) if one is not None])
    if known is None:
        return None
    mean, sd = known
    found = (kind.between(mean, sd) for kind in catalogue if kind.role is Role.CLOCK)
    surest = min(filter(None, found), key=lambda evidence: evidence.log_p, default=None)
    if surest is None or surest.log_p > log_alpha:
        return None
    found = finding({TIME: surest.effect}, surest, "s")
    return replace(found, parameters=found.parameters | {"run": Interval(run, run, run, "1")})


Measure = tuple[float, float]
"""Logarithm of the true sampling interval of a run over that of its stamps, of which the first run sets the measure,
and its standard deviation."""


def _mean(found: list[Measure]) -> Measure | None:
    """Return the mean by inverse variance, or None where there is none or what there is disagrees."""
    if not found:
        return None
    values, weights = np.array([value for value, _ in found]), np.array([sd**-2 for _, sd in found])
    mean = float(np.average(values, weights=weights))
    agree = chi2.sf(weights @ (values - mean) ** 2, max(len(found) - 1, 1)) > CONFLICT
    return (mean, float(weights.sum() ** -0.5)) if agree or len(found) == 1 else None


def _by_blocks(first: Mapping[str, AxisFit], other: Mapping[str, AxisFit]) -> list[Measure]:
    """Return what the spectra of blocks say, if the runs are long enough for them.

    They compare samples; that the stamps of the runs have other intervals is no error of a clock.
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


def _by_lines(first: Mapping[str, AxisFit], other: Mapping[str, AxisFit], blocks: Measure | None) -> list[Measure]:
    """Return the ratio of the frequencies of each line that is steady in both runs."""
    return [
        evidence for axis, found in first.items() if axis in other for evidence in _moved(found, other[axis], blocks)
    ]


def _moved(first: AxisFit, other: AxisFit, blocks: Measure | None) -> Iterator[Measure]:
    terms = first.description.terms
    quiet = fit(other.sequence, replace(other.description, terms=_others(other.description.terms)))
    for index in (i for i, term in enumerate(terms) if term.effect.line):
        line = _line_near(quiet, terms[index], blocks)
        if line is None:
            continue
        found = fit(other.sequence, replace(quiet.description, terms=(*quiet.description.terms, line)))
        if _steady(first, index) and _steady(found, len(found.description.terms) - 1):
            before, after = _frequency(first, index), _frequency(found, len(found.description.terms) - 1)
            yield float(np.log(after[0] / before[0])), float(np.hypot(before[1] / before[0], after[1] / after[0]))


def _others(terms: tuple[Term, ...]) -> tuple[Term, ...]:
    return tuple(term for term in terms if not term.effect.line)


def _line_near(quiet: AxisFit, line: Term, blocks: Measure | None) -> Term | None:
    """Return the highest line where that of the first run may be, or None if none is clear."""
    ratio, sd = blocks or (0.0, NEAR / WIDE)
    duration = quiet.sequence.conditions.interval * len(quiet.residual)
    tried, gains, _ = quiet.lines
    frequency = line.effect.frequency
    near = np.abs(tried - frequency * np.exp(ratio)) < WIDE * max(sd * frequency, 1 / duration)
    if not near.any() or gains[near].max() < CLEAR:
        return None
    best = float(tried[near][np.argmax(gains[near])])
    return replace(line, effect=type(line.effect).at(best, quiet))


def _steady(found: AxisFit, index: int) -> bool:
    return shape_log_p(found, index) > DRIFTING


def _frequency(found: AxisFit, index: int) -> tuple[float, float]:
    """Return the frequency of a line and its standard deviation [Hz]."""
    low, high = term_intervals(found, index)["frequency"]
    return found.description.terms[index].effect.frequency, (high - low) / 2 / NORMAL


def as_first(sequence: AxisSequence, terms: tuple[Term, ...], first: AxisFit) -> AxisFit:
    """Fit another run of a device: the terms of the start model, and terms and noise that the first run shows.

    Lines have another phase in each run, and steps another time.
    """
    added = first.description.terms[len(terms) :]
    repeated = tuple(term for term in added if not (term.effect.event or term.effect.line))
    return fit(sequence, Description((*terms, *repeated), first.description.noise))

"""Noise of a device over several of its runs: its processes, their scatter from run to run, and what does not recur.

The likelihood of all runs together has its maximum at the parameters of the device. The scores of the runs there
scatter more than their information where the parameters differ from run to run (the sandwich of Huber 1967, with each
run as one independent unit); what exceeds the information is the scatter of the parameters.

Processes and systematic effects too faint for one run are searched for in all runs together. One counts where it is
significant without the run that gains most by it: what is of the device recurs. A process describes the noise, and is
not named: the checks of names need a run that shows it. A systematic effect is named: that all runs repeat it, with one
sign and size, is its check.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from imugap.discovery.finding import MIN_LOG_P, Finding, Rival
from imugap.discovery.fit.axis_fit import AxisFit, fit, log_score
from imugap.discovery.fit.description import Description, Entry
from imugap.discovery.fit.whittle import PRIOR_LOG_STD, NoiseFit, NoiseSpectra, log_likelihood
from imugap.discovery.fit.whittle import fit as fit_noise
from imugap.discovery.runs.shared_term import SharedTerm, fit_to_runs, with_term
from imugap.discovery.search.intervals import intervals, repeats
from imugap.discovery.search.search import Trial, log_p_of_gain
from imugap.effects.effect import Effect, Role, Start

RECURRING = (Role.MEAN, Role.NOISE, Role.FILTER)
"""Roles of the effects that another run of the device has, too, apart from events and lines."""
MIN_ODDS = 20.0
"""Odds of the likelihood of further runs without an effect, or with another in its place, to that with it, from which
it does not recur.

Runs of a device that has it reach them with a probability of at most 1/20 (Markov's inequality).
"""
MAX_ADDITIONS = 4
"""Maximum number of effects of an axis that only all runs together show."""
TERM_ROUNDS = 2
"""Rounds in which a systematic effect and the noise of all runs are fitted in turn."""


@dataclass(frozen=True, eq=False)
class OverRuns:
    """Noise of one axis over all runs of a device, and what all runs repeat.

    Attributes
    ----------
    runs
        Fit of each run, with the processes of all runs.
    fit
        Fit of the first run with the noise of all runs.
    added
        The processes that only all runs together show; they are the last of the noise.
    terms
        The systematic effects that only all runs together show.
    """

    runs: tuple[AxisFit, ...]
    fit: AxisFit
    added: tuple[Trial, ...] = ()
    terms: tuple[SharedTerm, ...] = ()

    @property
    def axis(self) -> str:
        """Return the name of the axis."""
        return self.fit.sequence.conditions.axis

    def findings(self) -> list[Finding]:
        """Return the added processes, with their values and intervals of all runs."""
        axis, description = self.axis, self.fit.description
        indices = _processes(description)[-len(self.added) :] if self.added else []
        return [
            Finding(
                {axis: description.entries[i].effect}, intervals(self.fit, i), max(trial.log_p, MIN_LOG_P), trial.gain
            )
            for i, trial in zip(indices, self.added, strict=True)
        ]

    def beside(self, one: AxisFit) -> AxisFit:
        """Return a fit of one run with the systematic effects of all runs."""
        for term in self.terms:
            (one,) = with_term((one,), term.entry)
        return one

    def without(self, number: int) -> "OverRuns":
        """Return the noise without its process of a number, from 0 on."""
        runs = tuple(
            replace(one, description=one.description.without([_processes(one.description)[number]]))
            for one in self.runs
        )
        first = len(_processes(self.fit.description)) - len(self.added)
        added = tuple(trial for place, trial in enumerate(self.added) if first + place != number)
        return OverRuns(runs, fit_over_runs(runs), added, self.terms)

    def without_term(self, term: SharedTerm) -> "OverRuns":
        """Return what is left without a systematic effect, all else fitted anew."""
        runs = tuple(fit(one.sequence, one.description.keeping(lambda entry: entry != term.held)) for one in self.runs)
        return replace(
            self, runs=runs, fit=fit_over_runs(runs), terms=tuple(other for other in self.terms if other is not term)
        )

    def log_p_without(self, number: int) -> float:
        """Return the log p-value of the likelihood ratio of all processes and those without the one of a number."""
        loss = self.fit.noise.log_likelihood - self.without(number).fit.noise.log_likelihood
        effect = self.fit.description.entries[_processes(self.fit.description)[number]].effect
        return log_p_of_gain(loss, len(effect.free()))


def _processes(description: Description) -> list[int]:
    """Return the indices of the random processes among the entries of a description."""
    return [index for index, entry in enumerate(description.entries) if entry.effect.role is Role.NOISE]


def search_over_runs(runs: Sequence[AxisFit], catalogue: Sequence[type[Effect]], log_alpha: float) -> OverRuns:
    """Add random processes to those of the first run until all runs together show no further one.

    Parameters
    ----------
    runs
        Fits of the runs, with the processes found in the first.
    catalogue
        Kinds of effects that may be missing.
    log_alpha
        Logarithm of the false-alarm probability of one proposal.
    """
    found = OverRuns(tuple(runs), fit_over_runs(runs))
    for _ in range(MAX_ADDITIONS if len(runs) > 1 else 0):
        significant = ((trial, after) for trial, after in _trials(found, catalogue) if trial.log_p < log_alpha)
        best, after = max(significant, key=lambda one: one[0].worth, default=(None, found))
        if best is None:
            break
        found = _settled(_pruned(after, log_alpha), log_alpha)
    return _with_rivals(_cautious(found, catalogue), catalogue)


def _settled(found: OverRuns, log_alpha: float) -> OverRuns:
    """Return what was found with every systematic effect fitted anew beside all else, if it is significant still."""
    for term in found.terms:
        before = found.without_term(term)
        trial, after = _with_shared(before, Start(term.entry.effect, term.entry.free, trials=term.trial.trials))
        found = after if trial.log_p < log_alpha else before
    return found


def _cautious(found: OverRuns, catalogue: Sequence[type[Effect]]) -> OverRuns:
    """Return what was found, each systematic effect as it is under the slow noise that leaves it least certain.

    The noise is that of the model, with one more slow process or none. The process has to raise the likelihood; it need
    not be significant, since most of the error of a slow effect is that of slow noise.
    """
    slow = [kind for kind in catalogue if kind.slow]
    for term in found.terms:
        likelier = (
            after for _, after in _process_trials(found, slow) if _log_likelihood(after) > _log_likelihood(found)
        )
        values = (_values_beside(noise, term) for noise in (found, *likelier))
        entry, covariance = max(values, key=lambda one: float(np.linalg.det(one[1])))
        before, term = found.without_term(term), replace(term, entry=entry, covariance=covariance)
        wider = with_term(before.runs, entry)
        found = replace(before, runs=wider, fit=fit_over_runs(wider), terms=(*before.terms, term))
    return found


def _log_likelihood(found: OverRuns) -> float:
    """Return the log-density of all runs under their noise."""
    return found.fit.noise.log_likelihood


def _values_beside(noise: OverRuns, term: SharedTerm) -> tuple[Entry, np.ndarray]:
    """Return a systematic effect of all runs, and the covariance of its parameters, beside the noise of all runs."""
    runs = [
        replace(one, description=one.description.keeping(lambda entry: entry != term.held))
        for one in _sharing_noise(noise.runs, noise.fit)
    ]
    return fit_to_runs(runs, Start(term.entry.effect, term.entry.free))


def _with_rivals(found: OverRuns, catalogue: Sequence[type[Effect]]) -> OverRuns:
    """Return what was found with what could be in the place of each systematic effect."""
    terms = []
    for term in found.terms:
        others = (one for one in _trials(found.without_term(term), catalogue) if one[0].name != term.trial.name)
        rivals = (
            Rival(trial.name, trial.worth - term.trial.worth, after.fit.description.effects())
            for trial, after in others
        )
        terms.append(replace(term, rivals=tuple(rivals)))
    return replace(found, terms=tuple(terms))


def _pruned(found: OverRuns, log_alpha: float) -> OverRuns:
    """Return the noise without the added processes that later ones explain."""
    count = len(_processes(found.fit.description))
    earlier = range(count - len(found.added), count - 1)
    number = next((one for one in earlier if found.log_p_without(one) > log_alpha), None)
    return found if number is None else _pruned(found.without(number), log_alpha)


def _trials(before: OverRuns, catalogue: Sequence[type[Effect]]) -> Iterator[tuple[Trial, OverRuns]]:
    """Yield each kind of random process and of systematic effect, added."""
    yield from _process_trials(before, catalogue)
    yield from _term_trials(before, catalogue)


def _process_trials(before: OverRuns, catalogue: Sequence[type[Effect]]) -> Iterator[tuple[Trial, OverRuns]]:
    """Yield each kind of random process, added where a run has most room for it."""
    runs = _sharing_noise(before.runs, before.fit)
    scores = _noise_scores(runs)
    for kind in (kind for kind in catalogue if kind.role is Role.NOISE):
        start = max((start for one in runs for start in kind.starts(one)), key=lambda start: start.gain, default=None)
        if start is None:
            continue
        wider = tuple(replace(one, description=one.description.adding(start.effect)) for one in runs)
        fit = fit_over_runs(wider)
        gains = _noise_scores(_sharing_noise(wider, fit)) - scores
        trial = Trial(start.effect, fit, float(gains.sum() - gains.max()), len(start.free), start.trials)
        yield trial, replace(before, runs=wider, fit=fit, added=(*before.added, trial))


def _term_trials(before: OverRuns, catalogue: Sequence[type[Effect]]) -> Iterator[tuple[Trial, OverRuns]]:
    """Yield each kind of systematic effect that runs repeat, with each of its laws, where every run can have it."""
    runs = _sharing_noise(before.runs, before.fit)
    for kind in filter(repeats, catalogue):
        for proposed in zip(*(kind.starts(one) for one in runs), strict=False):
            yield _with_shared(before, max(proposed, key=lambda start: start.gain))


def _with_shared(before: OverRuns, start: Start) -> tuple[Trial, OverRuns]:
    """Return a systematic effect of all runs, fitted in turn with their noise."""
    runs = noisy = _sharing_noise(before.runs, before.fit)
    for _ in range(TERM_ROUNDS):
        entry, covariance = fit_to_runs(noisy, start)
        wider = with_term(runs, entry)
        fit = fit_over_runs(wider)
        noisy = _sharing_noise(runs, fit)
    gains = _noise_scores(_sharing_noise(wider, fit)) - _noise_scores(runs)
    trial = Trial(entry.effect, fit, float(gains.sum() - gains.max()), len(start.free), start.trials)
    term = SharedTerm(entry, covariance, trial)
    return trial, replace(before, runs=wider, fit=fit, terms=(*before.terms, term))


def _sharing_noise(runs: Sequence[AxisFit], shared: AxisFit) -> list[AxisFit]:
    """Return the fits of the runs with the noise of one fit in place of their own."""
    noise = shared.description.noise
    return [replace(one, description=one.description.with_noise(noise)) for one in runs]


def _noise_scores(runs: Sequence[AxisFit]) -> np.ndarray:
    """Return the log-density of the coefficients of each run under the noise of its description, shape (runs,)."""
    noises = ((one.description.noise, one.sequence.bins, one.power) for one in runs)
    return np.array([log_likelihood(noise.variance(bins), power, bins.number) for noise, bins, power in noises])


def not_needed(found: OverRuns, log_alpha: float) -> Effect | None:
    """Return the process of the first run that is not significant given those of all runs together, or None."""
    entries = [found.fit.description.entries[index] for index in _processes(found.fit.description)]
    first = entries[: len(entries) - len(found.added)] if found.added else []
    numbers = (i for i, entry in enumerate(first) if not entry.known and found.log_p_without(i) > log_alpha)
    return next((first[number].effect for number in numbers), None)


def better_over_runs(runs: Sequence[AxisFit], catalogue: Sequence[type[Effect]], log_alpha: float) -> Effect | None:
    """Return the systematic effect of the first run in the place of which all runs together show another, or None."""
    for index, entry in enumerate(runs[0].description.entries):
        if entry.known or not repeats(type(entry.effect)) or len(runs) == 1:
            continue
        left = tuple(fit(one.sequence, one.description.without([index])) for one in runs)
        trials = [trial for trial, _ in _term_trials(OverRuns(left, fit_over_runs(left)), catalogue)]
        own = max((trial.worth for trial in trials if trial.name == entry.effect.name), default=-np.inf)
        others = (one for one in trials if one.name != entry.effect.name and one.log_p < log_alpha)
        if max((one.worth for one in others), default=-np.inf) > own + np.log(MIN_ODDS):
            return entry.effect
    return None


def recurring(description: Description) -> Description:
    """Return the part of a description that another run has, too: without events, lines and changes of the variance."""
    return description.keeping(
        lambda entry: entry.effect.role in RECURRING and not (entry.effect.event or entry.effect.tonal)
    )


def fit_over_runs(runs: Sequence[AxisFit]) -> AxisFit:
    """Return the fit of the first run with the noise of all runs of the device.

    The runs have the same random processes. The information is that of the mean over the runs.
    """
    first = runs[0]
    if len(runs) == 1:
        return first
    spectra = [(one.sequence.bins, one.power) for one in runs]
    together = fit_noise(first.description.noise, *spectra[0], others=spectra[1:])
    description = first.description.with_noise(together.noise)
    noise = replace(together, **_scattered(together, spectra))
    return replace(first, description=description, log_likelihood=log_score(first.sequence, description), noise=noise)


def _scattered(together: NoiseFit, spectra: Sequence[tuple]) -> dict[str, np.ndarray]:
    """Return the information of the mean over the runs, and the covariance from run to run, of the log parameters."""
    theta, count = together.noise.theta(), len(spectra)
    scores = np.array([NoiseSpectra(together.noise, bins).expand(theta, power)[1] for bins, power in spectra])
    prior = np.eye(len(theta)) / PRIOR_LOG_STD**2
    own = np.linalg.inv(together.information + prior)
    sandwich = own @ np.cov(scores.T, ddof=1).reshape(prior.shape) @ own * count
    values, vectors = np.linalg.eigh(count * (sandwich - own))
    between = (vectors * np.maximum(values, 0.0)) @ vectors.T
    return {"information": np.linalg.inv(own + between / count), "between": between}


def not_recurring(first: AxisFit, others: Sequence[AxisFit]) -> Effect | None:
    """Return the effect found in the first run without which further runs are far more likely, or None to keep all.

    Further runs are scored by the values of the first run; without an effect the others stay or are fitted to it anew,
    whichever scores higher.
    """
    score, left_out = _score(first.description, others) + np.log(MIN_ODDS), None
    for entry in recurring(first.description).entries:
        kept = first.description.keeping(lambda one, of=entry: one != of)
        if entry.known or not kept.noise.effects:
            continue
        without = max(_score(one, others) for one in (kept, fit(first.sequence, kept).description))
        if without > score:
            score, left_out = without, entry.effect
    return left_out


def _score(description: Description, runs: Sequence[AxisFit]) -> float:
    """Return the log-density of further runs under the description of the first."""
    return sum(log_score(run.sequence, recurring(description)) for run in runs)

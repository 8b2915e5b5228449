"""Stepwise search for the missing effects of one axis: add, exchange and remove until none improves the fit.

Every kind of the catalogue proposes itself (:meth:`imugap.effects.effect.Effect.starts`). Each proposal is fitted
together with all effects of the description, and the one of the smallest p-value is added. After each
addition two tones that one effect explains as well give way to it (:meth:`imugap.effects.effect.Effect.joining`), and
every added effect is removed and exchanged for every other, so that an effect which only stands in for another
does not stay.
"""

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from itertools import combinations

import numpy as np
from scipy.special import chdtrc, gammaln

from imugap.discovery.fit.axis_fit import AxisFit, fit
from imugap.discovery.fit.description import Description, Entry
from imugap.discovery.fit.whittle import Noise
from imugap.discovery.fit.whittle import fit as fit_noise
from imugap.discovery.preparation.sequence import AxisSequence
from imugap.discovery.search.pairs import Pair, SmoothTerms
from imugap.effects import CATALOGUE
from imugap.effects.effect import Effect, Role, Start, StochasticEffect
from imugap.numerics.samples.contaminated_normal import Tails
from imugap.stream import stream

TAIL_SHAPES = 100.0
"""Upper bound of the number of independent shapes of a heavy-tailed distribution."""
MAX_ADDITIONS = 12
"""Maximum number of additions to one axis."""
MAX_EXACT_GAIN = 300.0
"""Gain of log-likelihood above which the asymptote of its probability is used."""
MIN_EXCHANGE_GAIN = 0.1
"""Minimum gain of log-likelihood of an exchange, after the cost of parameters and places."""
MIN_GAIN_CHANGE, MIN_RELATIVE_GAIN_CHANGE = 1.0, 0.05
"""Change of the gain of log-likelihood of an effect, and relative to it, by which a further effect may explain what it
stood for: it is examined again."""
MAX_CACHED_SAMPLES = 3e6
"""Maximum number of samples of all fits whose derived arrays are kept in memory."""
OUTLIER_ROUNDS = 3
"""Rounds in which outliers and changes of the variance are estimated in turn."""
LOG_P_MARGIN = 20.0
"""Log-probability by which an effect of higher worth may be less certain."""
PARAMETER_COST = 2.5
"""Cost of a parameter in log-likelihood, where two effects are compared.

A superfluous parameter gains as much in 2.5 % of cases (Wilks 1938).
"""
MAX_UNCERTAIN_LOG_P, MAX_UNCERTAIN = -4.0, 2
"""Log-probability below which an uncertain effect is added on trial, and the number of such effects.

They stay if the exchange of the others makes all effects certain: an effect that stands for two others hides both.
"""
SLOW_NOISE_LOG_ODDS = 1.5
"""Prior log-odds of slow noise against another effect: most sensors have some."""
MIN_WHITE_SHARE = 0.01
"""Share of the power, at every frequency, below which white noise counts as absent."""
KEPT_SIZE_SHARE = 0.03
"""Share of its size that slow noise of the start model keeps where other slow noise is tried in its place."""
MIN_PAIR_GAIN_RATIO = 0.6
"""Minimum expected gain of a pair, over that of the single effect, for the pair to be fitted."""
MAX_PAIRS = 4
"""Number of pairs that are fitted: of two smooth terms, and of a term and a step."""
CUTOFF_FACTORS = (1.0, 0.3, 0.1, 0.03)
"""Cutoffs at which a filter is tried, over the proposed one."""
MAX_RESHAPING_GAIN, RESHAPING_SPREAD = 30.0, 10.0
"""Upper bounds of the gain of log-likelihood by what a filter does to the terms, and of its spread over filters."""
GAIN_SLACK = 2.0
"""Ratio of the gain after the fit to the expected gain before it, at most."""


def _nothing(_: AxisFit) -> float:
    return -np.inf


@dataclass(frozen=True, eq=False)
class Trial:
    """Fit of a description with one more effect.

    Attributes
    ----------
    effect
        The effect, as proposed.
    fit
        The fit with it.
    gain
        Gain of log-likelihood over the fit without it.
    parameters, trials
        Number of further parameters, and of independent places or shapes among which the effect was chosen.
    """

    effect: Effect
    fit: AxisFit
    gain: float
    parameters: int
    trials: float

    @property
    def name(self) -> str:
        """Return the name of the effect."""
        return self.effect.name

    @property
    def log_p(self) -> float:
        """Log p-value of the gain (likelihood ratio, Bonferroni over the trials)."""
        return min(log_p_of_gain(self.gain, self.parameters) + float(np.log(self.trials)), 0.0)

    @property
    def cost(self) -> float:
        """Cost of its parameters and trials in log-likelihood."""
        return cost(self.parameters, self.trials)

    @property
    def worth(self) -> float:
        """Gain less cost, by which effects are compared.

        The prior odds of slow noise do not count where it leaves no white noise, which every sensor has.
        """
        white = self.fit.description.noise.share(0, self.fit.sequence.bins).max()
        return self.gain - self.cost + (expected(type(self.effect)) if white > MIN_WHITE_SHARE else 0.0)


@dataclass(frozen=True, eq=False)
class Search:
    """Search for the missing effects of one axis.

    Attributes
    ----------
    start
        Description of the start model, whose effects stay.
    catalogue
        Kinds of effects that may be missing.
    log_alpha
        Logarithm of the false-alarm probability of one proposal.
    """

    start: Description
    catalogue: tuple[type[Effect], ...]
    log_alpha: float
    memory: dict[Description, AxisFit] = field(default_factory=dict)
    """Fits, by the description from which they started."""
    behind: dict[tuple[Description, Effect], float] = field(default_factory=dict)
    """Log-likelihoods of fits behind a filter, by the description without it and the filter from which they started."""
    tails: dict[Effect, Tails] = field(default_factory=dict)
    """Distribution of the residual by which outliers were found."""
    raw: dict[Effect, AxisSequence] = field(default_factory=dict)
    """Samples before the outliers were replaced."""

    def without_memory(self) -> "Search":
        """Return the search without its stored fits."""
        return replace(self, memory={}, behind={})

    def for_new_samples(self) -> "Search":
        """Return the same search for another sequence."""
        return Search(self.start, self.catalogue, self.log_alpha)

    def start_has(self, kind: type[Effect]) -> bool:
        """Return whether the start model has an effect of a kind."""
        return any(isinstance(effect, kind) for effect in self.start.effects())

    def fitted(self, sequence: AxisSequence, start: Description) -> AxisFit:
        """Return the fit from a start, computed once; derived arrays are kept for the latest fits only."""
        found = self.memory.pop(start, None)
        self.memory[start] = fit(sequence, start) if found is None else found
        latest = max(int(MAX_CACHED_SAMPLES / len(sequence.values)), 3)
        if len(self.memory) > latest:
            older = list(self.memory)[-latest - 1]
            self.memory[older] = self.memory[older].without_cache()
        return self.memory[start]

    def explore(self, before: AxisFit, nameless: Callable[[AxisFit], float] = _nothing) -> AxisFit:
        """Add effects until no proposal improves the fit, and return that fit.

        Where both outliers and a filter were added, outliers are estimated again: behind an unknown filter a single
        event looks like many outliers.

        Parameters
        ----------
        before
            Fit to begin with.
        nameless
            Function that returns the gain of log-likelihood by an unnamed effect in place of the added ones. The search
            ends where all further proposals together cannot reach it.
        """
        found = self._selected(before, nameless)
        roles = {candidate.role for candidate in self.added(found)}
        if {Role.OUTLIERS, Role.FILTER} <= roles:
            found = self._selected(self.refined(self.with_outlier_samples(found)), nameless)
        return self.relocate_steps(self.refit_outliers_and_changes(found))

    def refit_outliers_and_changes(self, found: AxisFit) -> AxisFit:
        """Estimate outliers and changes of the variance in turn.

        Outliers were found first: the largest samples of a noisier stretch count among them, and lack in the change.
        """
        for _ in range(OUTLIER_ROUNDS):
            outliers = found.description.outliers
            if outliers not in self.raw or not self.added(found, changing):
                break
            found = self._refit_changes(found)
            restored = found.description.exchanging(Role.OUTLIERS)
            raw = replace(found, sequence=self.raw[outliers], description=restored)
            same = np.array_equal(raw.tails.flagged, self.tails[outliers].flagged)
            wide = None if same else self.without_outliers(raw)
            if wide is None:
                break
            found = wide.fit
        return found

    def _refit_changes(self, found: AxisFit) -> AxisFit:
        """Fit every added change of the variance again, all other effects held."""
        for index in [candidate.index for candidate in self.added(found, changing)]:
            own, without = found.description.entries[index].effect, Candidate(self, found, index).without
            alike = (start.effect for start in type(own).starts(without) if start.free == own.free())
            moved = self.fitted(found.sequence, found.description.with_effect(index, next(alike, own)))
            found = moved if moved.log_likelihood > found.log_likelihood else found
        return found

    def relocate_steps(self, found: AxisFit) -> AxisFit:
        """Move every added step to its most likely time, given the effects that were added after it."""
        for index in [candidate.index for candidate in self.added(found, stepping)]:
            time = found.sequence.conditions.time[np.argmax(found.steps_without(index).gains)]
            step = replace(found.description.entries[index].effect, time=float(time))
            moved = self.fitted(found.sequence, found.description.with_effect(index, step))
            found = moved if moved.log_likelihood > found.log_likelihood else found
        return found

    def _selected(self, before: AxisFit, nameless: Callable[[AxisFit], float]) -> AxisFit:
        for _ in range(MAX_ADDITIONS):
            if self.too_many_changes(before):
                break
            bar = MAX_UNCERTAIN_LOG_P if self.added(before) else self.log_alpha
            trials = sorted((one for one in self.trials(before, bar) if one.log_p < bar), key=lambda one: one.log_p)
            wide = self.without_outliers(before)
            if wide is not None and wide.log_p < min([self.log_alpha, *(one.log_p for one in trials)]):
                before = self.refit_outliers_and_changes(self.refined(wide.fit))
                continue
            most = max((one.fit.log_likelihood - before.log_likelihood for one in trials), default=0.0)
            if trials and nameless(before) > MAX_ADDITIONS * most:
                break
            if trials and trials[0].log_p < self.log_alpha:
                pair = self.pair(before, trials[0])
                first = not self.added(before) and pair is None
                before = self.refit_outliers_and_changes(
                    trials[0].fit if first else self.refined((pair or trials[0]).fit, before)
                )
                continue
            hopes = (self.refined(trial.fit, before, type(trial.effect)) for trial in trials[:MAX_UNCERTAIN])
            proven = next((after for after in hopes if self._all_certain(after, before)), self.refined(before))
            if proven is before:
                break
            before = proven
        return before

    def too_many_changes(self, found: AxisFit) -> bool:
        """Return whether more changes of the variance were added than may have that name.

        They stand for an unnamed effect, and no other effect of such samples is searched for.
        """
        changes = self.added(found, changing)
        return bool(changes) and len(changes) > changes[0].effect.most

    def _all_certain(self, after: AxisFit, before: AxisFit) -> bool:
        """Return whether a fit has more effects than before, each of them significant."""
        added = self.added(after)
        return len(added) > len(self.added(before)) and all(one.significant for one in added)

    def trials(
        self, before: AxisFit, bar: float, whole: AxisFit | None = None, worth: float = -np.inf
    ) -> Iterator[Trial]:
        """Yield every proposal, fitted, whose log-probability may come below ``bar``, and whose worth above another.

        ``whole`` is a fit to the same samples with all effects of ``before`` and more, whose likelihood behind a filter
        is no less than that of ``before`` behind it.
        """
        for kind in self.catalogue:
            if sum(isinstance(one, kind) for one in before.description.effects()) > (kind.most or MAX_ADDITIONS):
                continue
            if kind.role is Role.FILTER:
                yield from self._filters(kind, before, bar, whole, worth)
                continue
            for start in kind.starts(before):
                if _moves(start.effect, before) or (may_reach(start, bar) and most_worth(start) > worth):
                    yield self.trial_of(start, before)
        yield from self._noise_instead(before)

    def _filters(
        self, kind: type[Effect], before: AxisFit, bar: float, whole: AxisFit | None, worth: float
    ) -> Iterator[Trial]:
        """Yield the filters of a kind that may come below ``bar`` and be worth more, fitted."""
        starts = [start for start in kind.starts(before) if may_reach(start, bar)]
        if before.sequence.in_motion:
            return self._filters_in_motion(starts, before, bar, whole)
        return self._filters_at_rest(starts, before, bar, worth)

    def _filters_at_rest(self, starts: Sequence[Start], before: AxisFit, bar: float, worth: float) -> Iterator[Trial]:
        """Yield the filters whose noise gains most, until what they do to the terms cannot make up for the noise.

        The noise behind each is fitted from that behind the one of its form before. Filters of like gain do the like to
        the terms.
        """
        behind, noise = [], None
        for start in starts:
            alike = noise is not None and noise.output_filter.form == start.effect.form
            start, noise = behind_filter(start, before, noise if alike else None)
            behind.append((start, noise))
        reshaping = MAX_RESHAPING_GAIN
        for start, noise in sorted(behind, key=lambda one: -one[0].gain):
            likely = replace(start, gain=start.gain + reshaping)
            if may_reach(likely, bar) and likely.gain - cost(len(start.free), start.trials) > worth:
                trial = self.trial_of(start, before, before.description.with_noise(noise))
                reshaping = min(reshaping, trial.gain - start.gain + RESHAPING_SPREAD)
                yield trial

    def _filters_in_motion(
        self, starts: Sequence[Start], before: AxisFit, bar: float, whole: AxisFit | None
    ) -> Iterator[Trial]:
        """Yield the filters that the noise alone shows; what they do to the motion is known after the fit only."""
        for start in starts:
            if whole is None or self._may_reach_behind(start, before, whole, bar):
                start, noise = behind_filter(start, before)
                trial = self.trial_of(start, before, before.description.with_noise(noise))
                if noise_shows_filter(trial, self.log_alpha):
                    yield trial

    def _may_reach_behind(self, start: Start, before: AxisFit, whole: AxisFit, bar: float) -> bool:
        """Return whether a filter may come below ``bar``, by what it reaches with more effects.

        In motion a fit behind a filter takes long, and most filters distort the motion beyond what any effect mends.
        """
        if whole.description.noise.output_filter is not None:
            return True
        key = whole.description, start.effect
        if key not in self.behind:
            filtered, noise = behind_filter(start, whole)
            beside = whole.description.with_noise(noise)
            self.behind[key] = self.trial_of(filtered, whole, beside).fit.log_likelihood
        return may_reach(replace(start, gain=self.behind[key] - before.log_likelihood), bar)

    def _noise_instead(self, before: AxisFit) -> Iterator[Trial]:
        """Yield slow noise in place of that of the start model, whose fitted size may stand for the missing noise.

        The noise of the start model keeps a small share, which is fitted together with the other.
        """
        for index, entry in enumerate(before.description.entries):
            effect = entry.effect
            if not (entry.known and effect.slow):
                continue
            without = Candidate(self, before, index).without
            given_up = before.description.with_effect(index, little(effect))
            for kind in self.catalogue:
                if kind.slow and kind is not type(effect):
                    for start in kind.starts(without):
                        yield self.trial_of(start, before, given_up)

    def pair(self, before: AxisFit, single: Trial) -> Trial | None:
        """Return two terms that together are worth more than one slow effect, or None; one of them may be a step.

        Two terms that nearly cancel gain little each, but much together, and a slow effect that stands for both hides
        them.
        """
        if not masking(single.effect):
            return None
        terms = SmoothTerms.proposed(before, self.catalogue)
        both = terms.smooth(), terms.stepped() if single.effect.slow else []
        count = sum(map(len, both))
        for pairs in both:
            likely = sorted(pairs, key=lambda pair: -pair.gain)[:MAX_PAIRS]
            chosen = [pair for pair in likely if pair.gain > MIN_PAIR_GAIN_RATIO * single.gain]
            fitted = (self._pair_trial(pair, before, count) for pair in chosen)
            best = max(fitted, key=lambda trial: trial.worth, default=None)
            if (
                best is not None
                and best.worth > single.worth + MIN_EXCHANGE_GAIN
                and self._needs_both(best.fit, before)
            ):
                return best
        return None

    def _needs_both(self, after: AxisFit, before: AxisFit) -> bool:
        """Return whether each of the two added terms is significant given the other."""
        indices = range(len(before.description.terms), len(after.description.terms))
        return all(Candidate(self, after, index).significant for index in indices)

    def _pair_trial(self, pair: Pair, before: AxisFit, count: int) -> Trial:
        """Fit two proposals together, one pair among ``count``, and compare with the fit without them."""
        one, other = pair.starts
        after = self.fitted(before.sequence, before.description.adding(entry_of(one), entry_of(other)))
        parameters, trials = len(one.free) + len(other.free), count * one.trials * other.trials
        return Trial(other.effect, after, after.log_likelihood - before.log_likelihood, parameters, trials)

    def without_outliers(self, before: AxisFit) -> Trial | None:
        """Return the trial of outliers, fitted to the samples without them; None where the description has outliers."""
        outliers = None if before.description.outliers is not None else self._outliers(before)
        if outliers is None:
            return None
        found, axis = self.tails[outliers], before.sequence.conditions.axis
        sequence = before.sequence.with_replaced(found.flagged, stream(0, "mended", axis))
        entry = replace(Entry.of(outliers), known=self.start.outliers is not None)
        after = self.fitted(sequence, before.description.exchanging(Role.OUTLIERS, [entry]))
        return Trial(outliers, after, found.gain, 2, TAIL_SHAPES)

    def with_outlier_samples(self, found: AxisFit) -> AxisFit:
        """Return the fit of the other effects to the samples before the outliers were replaced."""
        restored = found.description.exchanging(Role.OUTLIERS)
        return self.fitted(self.raw.get(found.description.outliers, found.sequence), restored)

    def _outliers(self, before: AxisFit) -> Effect | None:
        """Return the outliers of a fit without any, if they are significant."""
        if before.sequence.coarse and before.cells is None:
            return None
        found = before.tails
        if log_p_of_gain(found.gain, 2) + np.log(TAIL_SHAPES) > self.log_alpha or not found.flagged.any():
            return None
        kind = next(one for one in (*self.catalogue, *CATALOGUE.values()) if one.role is Role.OUTLIERS)
        outliers = kind(found.probability, found.excess * before.unit)
        self.tails[outliers], self.raw[outliers] = found, before.sequence
        return outliers

    def without_known_outliers(self, before: AxisFit) -> AxisFit:
        """Return the fit to the samples without outliers, if the start model has outliers."""
        if self.start.outliers is None:
            return before
        wide = self.without_outliers(replace(before, description=before.description.exchanging(Role.OUTLIERS)))
        return before if wide is None else wide.fit

    def trial_of(self, start: Start, before: AxisFit, beside: Description | None = None) -> Trial:
        """Fit a proposal together with the description, or with ``beside``, and compare with the fit before."""
        after = self.fitted(before.sequence, (beside or before.description).adding(entry_of(start)))
        gain = (after.log_likelihood - before.log_likelihood) / start.level
        return Trial(start.effect, after, gain, len(start.free), start.trials)

    def refined(self, found: AxisFit, settled: AxisFit | None = None, hoped: type[Effect] | None = None) -> AxisFit:
        """Remove or exchange every added effect that is not significant, or for which another one is worth more.

        Parameters
        ----------
        found
            Fit to begin with.
        settled
            Fit with fewer effects, which were examined; None to examine all. What was examined, there or before an
            exchange, is examined again only if its gain has changed.
        hoped
            Kind of effects that come last: the exchange of the others may make them significant.
        """
        examined = {} if settled is None else {key: one.gain for key, one in self._by_kind(settled)}

        def last(added: tuple[tuple[type[Effect], int], "Candidate"]) -> bool:
            return hoped is not None and isinstance(added[1].effect, hoped)

        for _ in range(MAX_ADDITIONS):
            found = self.joined(found)
            for key, one in sorted(self._by_kind(found), key=last):
                if key in examined and not _touched(examined[key], one.gain):
                    continue
                if (other := self._improvement(one)) is not None:
                    found = other
                    break
                examined[key] = one.gain
            else:
                return found
        return found

    def joined(self, found: AxisFit) -> AxisFit:
        """Return the fit with one effect in the place of two where what it cannot do is not significant."""
        for pair in combinations(self.added(found, lambda effect: effect.tonal), 2):
            one, other = (candidate.effect for candidate in pair)
            rest = found.description.without([candidate.index for candidate in pair])
            for kind in self.catalogue:
                for start in kind.joining(one, other, found.sequence.conditions):
                    after = self.fitted(found.sequence, rest.adding(entry_of(start)))
                    freed = found.description.size() - after.description.size()
                    if log_p_of_gain(found.log_likelihood - after.log_likelihood, freed) > self.log_alpha:
                        return self.joined(after)
        return found

    def _by_kind(self, found: AxisFit) -> Iterator[tuple[tuple[type[Effect], int], "Candidate"]]:
        """Yield the added effects of a fit, each with its kind and the number of those of its kind before it."""
        counts = Counter()
        for one in self.added(found, _adjusted):
            yield (type(one.effect), counts[type(one.effect)]), one
            counts[type(one.effect)] += 1

    def pruned(self, found: AxisFit) -> AxisFit:
        """Return the fit without the added effects that are not significant."""
        superfluous = next((one for one in self.added(found) if one.trial.log_p > self.log_alpha), None)
        return found if superfluous is None else self.pruned(superfluous.without)

    def _improvement(self, candidate: "Candidate") -> AxisFit | None:
        """Return a better fit without an added effect, or with another or a simpler one in its place; else None."""
        own, without = candidate.trial, candidate.without
        if own.log_p > self.log_alpha:
            return without
        bar = min(self.log_alpha, own.log_p + LOG_P_MARGIN)
        tried = (one for one in self.trials(without, bar, candidate.fit, own.worth) if one.log_p < bar)
        others = (one for one in tried if _another(one.effect, own.effect) or one.parameters < own.parameters)
        best = max(others, key=lambda trial: trial.worth, default=None)
        if best is not None and best.worth > own.worth + MIN_EXCHANGE_GAIN:
            return best.fit
        pair = self.pair(without, own)
        return pair.fit if pair is not None else None

    def added(self, found: AxisFit, which: Callable[[Effect], bool] = lambda _: True) -> list["Candidate"]:
        """Return the added effects of a fit for which ``which`` holds."""
        entries = enumerate(found.description.entries)
        return [Candidate(self, found, index) for index, one in entries if not one.known and which(one.effect)]


@dataclass(frozen=True)
class Candidate:
    """An effect of a fit, which is compared with the fit without it and with others in its place.

    Attributes
    ----------
    search
        The search that added the effect.
    fit
        The fit.
    index
        Index of the effect among the entries of the description; among the terms too, if it is a term of the mean.
    """

    search: Search
    fit: AxisFit
    index: int

    @property
    def entry(self) -> Entry:
        """Return the entry of the description."""
        return self.fit.description.entries[self.index]

    @property
    def effect(self) -> Effect:
        """Return the effect."""
        return self.entry.effect

    @property
    def role(self) -> Role:
        """Return the role of the effect."""
        return self.effect.role

    @property
    def without(self) -> AxisFit:
        """Return the fit without the effect; that with it, if it is outliers, which are not adjusted."""
        if self.role is Role.OUTLIERS:
            return self.fit
        return self.search.fitted(self.fit.sequence, self.fit.description.without([self.index]))

    @property
    def gain(self) -> float:
        """Return the gain of log-likelihood by the effect."""
        if self.role is Role.OUTLIERS:
            return self.search.tails[self.effect].gain
        return self.fit.log_likelihood - self.without.log_likelihood

    @cached_property
    def trial(self) -> Trial:
        """The likelihood ratio of the effect."""
        if self.role is Role.OUTLIERS:
            return Trial(self.effect, self.fit, self.gain, 2, TAIL_SHAPES)
        more = max(self.fit.description.size() - self.without.description.size(), 1)
        return Trial(self.effect, self.fit, self.gain, more, _places(self.effect, more, self.without))

    @property
    def significant(self) -> bool:
        """Return whether the gain by the effect is significant."""
        return self.trial.log_p < self.search.log_alpha

    def alternatives(self, bar: float) -> list[Trial]:
        """Return the trials of all other effects in its place whose log-probability may come below ``bar``."""
        if self.role is Role.OUTLIERS:
            return []
        return [trial for trial in self.search.trials(self.without, bar, self.fit) if trial.name != self.effect.name]


def without(found: AxisFit, candidates: Sequence[Candidate]) -> AxisFit:
    """Return the fit without the effects of some candidates, refitted."""
    left = found.description.without(candidate.index for candidate in candidates)
    return fit(found.sequence, left) if candidates else found


def entry_of(start: Start) -> Entry:
    """Return a proposal as an entry of a description."""
    return Entry(start.effect, start.free) if start.effect.role is Role.MEAN else Entry.of(start.effect)


def _adjusted(effect: Effect) -> bool:
    """Return whether an effect is adjusted by the fit: outliers are not."""
    return effect.role is not Role.OUTLIERS


def changing(effect: Effect) -> bool:
    """Return whether an effect changes the variance."""
    return effect.role is Role.VARIANCE


def stepping(effect: Effect) -> bool:
    """Return whether an effect is a step of the mean."""
    return effect.event


def coloured(effect: Effect) -> bool:
    """Return whether an effect is a named random process with a memory: slow, or of two values."""
    return effect.slow or effect.two_valued


def masking(effect: Effect) -> bool:
    """Return whether an effect may stand for two smooth terms: slow noise, and terms that follow from no motion."""
    return effect.slow or (effect.role is Role.MEAN and not effect.of_motion)


def _places(effect: Effect, parameters: int, without: AxisFit) -> float:
    """Return the number of independent places or shapes among which an effect is chosen."""
    starts = list(type(effect).starts(without))
    alike = [start.trials for start in starts if len(start.free) == parameters]
    return max(alike or [start.trials for start in starts], default=1.0)


def little(effect: StochasticEffect) -> StochasticEffect:
    """Return slow noise of a small share of its size."""
    return replace(effect, **{effect.size(): KEPT_SIZE_SHARE * getattr(effect, effect.size())})


def behind_filter(start: Start, before: AxisFit, near: Noise | None = None) -> tuple[Start, Noise]:
    """Return the start of a filter, and the noise behind it, from which its fit converges.

    Without the filter the noise was fitted to the filtered spectrum, far from its own. The gain of the noise is known
    here; that of the terms, and that of the filtered input, are not.

    Parameters
    ----------
    near
        Noise behind a filter of another order from which to begin; None to begin at :data:`CUTOFF_FACTORS`.
    """
    sequence = before.sequence
    if near is None:
        begun = [
            replace(before.description.noise, output_filter=start.effect.adjusted_to(factor * start.effect.adjusted))
            for factor in CUTOFF_FACTORS
        ]
    else:
        value = min(near.output_filter.adjusted, start.effect.highest(sequence.conditions.interval))
        begun = [replace(near, output_filter=start.effect.adjusted_to(value))]
    fits = []
    for noise in begun:
        power = before.power_behind(noise.output_filter)
        both = noise, noise.beneath(sequence.bins, power)
        fits += [fit_noise(one, sequence.bins, power, held=sequence.in_motion) for one in both]
    best = max(fits, key=lambda one: one.log_likelihood)
    gain = best.log_likelihood - before.noise.log_likelihood
    return replace(start, effect=best.noise.output_filter, gain=np.inf if sequence.in_motion else gain), best.noise


def noise_shows_filter(filtered: Trial, log_alpha: float) -> bool:
    """Return whether the noise alone shows the filter: the motion alone cannot distinguish it from a delay."""
    fit, bins = filtered.fit, filtered.fit.sequence.bins
    unfiltered = fit_noise(replace(fit.noise.noise, output_filter=None), bins, fit.power)
    gain = fit.noise.log_likelihood - unfiltered.log_likelihood
    return log_p_of_gain(gain, filtered.parameters) + np.log(filtered.trials) < log_alpha


def _touched(earlier: float, now: float) -> bool:
    """Return whether a gain differs from an earlier one so much that another effect may now be worth more."""
    return abs(now - earlier) > max(MIN_GAIN_CHANGE, MIN_RELATIVE_GAIN_CHANGE * abs(now))


def _another(one: Effect, other: Effect) -> bool:
    """Return whether two effects differ in kind, or in a whole number, which no fit adjusts."""
    whole = [item.name for item in fields(one) if item.metadata["whole"]]
    return one.name != other.name or any(getattr(one, name) != getattr(other, name) for name in whole)


def _moves(effect: Effect, before: AxisFit) -> bool:
    """Return whether the expected gain is unreliable because slow noise of the fit gives way to the effect."""
    slow = any(one.slow for one in before.description.noise.effects)
    return slow and effect.role is Role.NOISE


def may_reach(start: Start, bar: float) -> bool:
    """Return whether the log-probability of a proposal may come below ``bar``."""
    return log_p_of_gain(GAIN_SLACK * start.gain + GAIN_SLACK, len(start.free)) + np.log(start.trials) < bar


def most_worth(start: Start) -> float:
    """Return the highest worth that a proposal may have."""
    most = GAIN_SLACK * start.gain + GAIN_SLACK
    return most - cost(len(start.free), start.trials) + expected(type(start.effect))


def cost(parameters: int, trials: float) -> float:
    """Return the cost of parameters and trials in log-likelihood."""
    return PARAMETER_COST * parameters + float(np.log(trials))


def expected(*kinds: type[Effect]) -> float:
    """Return the prior log-odds of effects of some kinds."""
    return SLOW_NOISE_LOG_ODDS if any(kind.slow for kind in kinds) else 0.0


def log_p_of_gain(gain: float, parameters: int) -> float:
    """Return the log p-value of a gain of log-likelihood by further ``parameters`` (likelihood ratio, Wilks 1938)."""
    if not 0 < gain < np.inf:
        return 0.0 if gain <= 0 else -np.inf
    if gain < MAX_EXACT_GAIN:
        return float(np.log(chdtrc(parameters, 2 * gain)))
    return float(-gain + (parameters / 2 - 1) * np.log(gain) - gammaln(parameters / 2))

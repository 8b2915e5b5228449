"""What is missing on one axis: effects are added, exchanged and removed until none improves the description.

Every effect of the catalogue proposes itself (:meth:`imugap.effects.effect.Effect.starts`); each proposal is fitted
together with all that is there, and the one that chance explains least is taken. After an addition each effect that
was added is taken out again and exchanged for every other, so that what came first by masquerade does not stay.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, fields, replace

import numpy as np
from scipy.special import gammaln
from scipy.stats import chi2

from imugap.discovery.fit.axis_fit import AxisFit, Description, Term, fit
from imugap.discovery.fit.contaminated_normal import Tails
from imugap.discovery.fit.whittle import fit as fit_noise
from imugap.discovery.preparation.sequence import AxisSequence
from imugap.discovery.search.pairs import Couple, Means
from imugap.effects.effect import Effect, Role, Start, StochasticEffect
from imugap.stream import stream

TAILS = 100.0
"""Independent shapes of tails, on the safe side."""
LIMIT = 12
"""Additions to one axis; each gains less than the one before, as a rule."""
ASKED = 4
"""Additions from which on it is asked whether something without a name says more than all that may come."""
FAR = 300.0
"""Gain of log-likelihood above which the probability of a chance is its asymptote."""
MARGIN = 0.1
"""Gain of log-likelihood, parameters and places paid for, that an exchange has to make."""
HELD = 3e6
"""Samples of all fits together that have what is derived from them in memory."""
RETOLD = 3
"""Rounds in which outliers and changes of the variance are told beside each other."""
CLOSE = 20.0
"""Log-probability by which an effect that is worth more may be less certain."""
PARAMETER = 2.5
"""What a parameter is worth in log-likelihood where two effects are weighed against each other.

A parameter too many gains as much by chance in 2.5 % of cases (Wilks 1938).
"""
HOPE, HOPES = -4.0, 2
"""Log-probability of chance below which, and number of, effects that are added on trial where nothing is certain.

They stay if the exchange of what is there makes all of it certain: an effect that stands for two others hides both.
"""
EXPECTED = 1.5
"""Logarithm of how much likelier slow noise is than another effect before any sample: most sensors have some."""
TRACE = 0.01
"""Share of the power at every frequency below which white noise is gone."""
LITTLE = 0.03
"""Share of its size that slow noise keeps where other slow noise is tried in its place."""
ALIKE = 0.6
"""Share of the gain of one effect that a couple has to promise to be fitted."""
COUPLES = 4
"""Couples that are fitted, of smooth means and with a step each."""
CUTOFFS = (1.0, 0.3, 0.1, 0.03)
"""Cutoffs at which a filter is tried, over that which it proposes."""
RESHAPED = 30.0
"""Gain of log-likelihood, at most, that the terms are expected to make by what a filter does to them."""
SLACK = 2.0
"""How many times the gain that an effect expects before the fit it may make after it."""


def _nothing(_: AxisFit) -> float:
    return -np.inf


@dataclass(frozen=True, eq=False)
class Trial:
    """A description with one effect more, fitted.

    Attributes
    ----------
    effect
        The effect, as proposed.
    fit
        The fit with it.
    gain
        Gain of log-likelihood over the fit without it.
    parameters, trials
        Number of parameters more, and of independent places or shapes among which the effect was chosen.
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
        """Return the log-probability of that gain by chance (likelihood ratio, Bonferroni over the trials)."""
        return min(log_chance(self.gain, self.parameters) + float(np.log(self.trials)), 0.0)

    @property
    def cost(self) -> float:
        """Return what its parameters and trials cost in log-likelihood."""
        return PARAMETER * self.parameters + float(np.log(self.trials))

    @property
    def worth(self) -> float:
        """Return the gain less the cost: what effects are weighed by against each other.

        Slow noise is no likelier than another effect where it leaves no room for the white noise that every sensor has.
        """
        white = self.fit.description.noise.share(0, self.fit.sequence.bins).max()
        return self.gain - self.cost + (expected(type(self.effect)) if white > TRACE else 0.0)


@dataclass(frozen=True, eq=False)
class Search:
    """The search on one axis.

    Attributes
    ----------
    start
        What the start model describes; it stays.
    catalogue
        Kinds of effects that may be missing.
    log_alpha
        Logarithm of the probability that a proposal is taken by chance.
    """

    start: Description
    catalogue: tuple[type[Effect], ...]
    log_alpha: float
    memory: dict[Description, AxisFit] = field(default_factory=dict)
    """Fits by the description that they started from."""
    tails: dict[Effect, Tails] = field(default_factory=dict)
    """What outliers were found by; the samples without them say no more about them."""
    raw: dict[Effect, AxisSequence] = field(default_factory=dict)
    """The samples with the outliers."""

    def forgetful(self) -> "Search":
        """Return the search without the fits that it made on the way."""
        return replace(self, memory={})

    def afresh(self) -> "Search":
        """Return the same search for other samples."""
        return Search(self.start, self.catalogue, self.log_alpha)

    def knows(self, kind: type[Effect]) -> bool:
        """Return whether the start model has an effect of a kind."""
        return any(isinstance(effect, kind) for effect in self.start.effects())

    def fitted(self, sequence: AxisSequence, start: Description) -> AxisFit:
        """Return the fit from a start, made once; what was derived from it is kept of the latest fits only."""
        found = self.memory.pop(start, None)
        self.memory[start] = fit(sequence, start) if found is None else found
        latest = max(int(HELD / len(sequence.values)), 3)
        if len(self.memory) > latest:
            older = list(self.memory)[-latest - 1]
            self.memory[older] = self.memory[older].bare()
        return self.memory[start]

    def explore(self, before: AxisFit, nameless: Callable[[AxisFit], float] = _nothing) -> AxisFit:
        """Return the fit to which nothing is to be added.

        Behind a filter that was not known yet, a single event looks like many outliers: they are told anew.

        Parameters
        ----------
        before
            Fit to begin with.
        nameless
            Of a fit the gain of log-likelihood by what has no name, in the place of what was added; where all that may
            be added does not reach it, nothing more is.
        """
        found = self._explored(before, nameless)
        keys = {key.part for key in self.added(found.description)}
        if {"outliers", "filter"} <= keys:
            raw = self.fitted(self.raw[found.description.outliers], replace(found.description, outliers=None))
            found = self._explored(self.settled(raw), nameless)
        return self.placed(self.retold(found))

    def retold(self, found: AxisFit) -> AxisFit:
        """Return the fit with outliers and changes of the variance each as they are beside the others.

        Outliers came first: what more noise has farthest out was taken for some of them, and is missed in the change.
        """
        for _ in range(RETOLD):
            outliers = found.description.outliers
            if outliers not in self.raw or not self.added(found.description, changing):
                break
            found = self._changes_anew(found)
            raw = replace(found, sequence=self.raw[outliers], description=replace(found.description, outliers=None))
            same = np.array_equal(raw.tails.flagged, self.tails[outliers].flagged)
            wide = None if same else self.cleaned(raw)
            if wide is None:
                break
            found = wide.fit
        return found

    def _changes_anew(self, found: AxisFit) -> AxisFit:
        """Return the fit with every added change of the variance as it is most likely beside all else."""
        for key in self.added(found.description, changing):
            own = at(found.description, key)
            without = self.fitted(found.sequence, removed(found.description, key))
            changes = list(found.description.changes)
            alike = (start.effect for start in type(own).starts(without) if start.free == own.free())
            changes[key.index] = next(alike, own)
            moved = self.fitted(found.sequence, replace(found.description, changes=tuple(changes)))
            found = moved if moved.log_likelihood > found.log_likelihood else found
        return found

    def placed(self, found: AxisFit) -> AxisFit:
        """Return the fit with every added step where it is most likely beside all else, which came after it."""
        for key in self.added(found.description, stepping):
            time = found.sequence.conditions.time[np.argmax(found.steps_without(key.index).gains)]
            terms = list(found.description.terms)
            terms[key.index] = replace(terms[key.index], effect=replace(terms[key.index].effect, time=float(time)))
            moved = self.fitted(found.sequence, replace(found.description, terms=tuple(terms)))
            found = moved if moved.log_likelihood > found.log_likelihood else found
        return found

    def _explored(self, before: AxisFit, nameless: Callable[[AxisFit], float]) -> AxisFit:
        for _ in range(LIMIT):
            if self.restless(before.description):
                break
            bar = HOPE if self.added(before.description) else self.log_alpha
            trials = sorted((one for one in self.trials(before, bar) if one.log_p < bar), key=lambda one: one.log_p)
            wide = self.cleaned(before)
            if wide is not None and wide.log_p < min([self.log_alpha, *(one.log_p for one in trials)]):
                before = self.retold(self.settled(wide.fit))
                continue
            most = max((one.fit.log_likelihood - before.log_likelihood for one in trials), default=0.0)
            many = len(self.added(before.description)) >= ASKED
            if trials and many and nameless(before) > LIMIT * most:
                break
            if trials and trials[0].log_p < self.log_alpha:
                couple = self.couple(before, trials[0])
                first = not self.added(before.description) and couple is None
                before = self.retold(trials[0].fit if first else self.settled((couple or trials[0]).fit))
                continue
            hopes = (self.settled(trial.fit, type(trial.effect)) for trial in trials[:HOPES])
            proven = next((after for after in hopes if self._proven(after, before)), None)
            if proven is None:
                break
            before = proven
        return before

    def restless(self, description: Description) -> bool:
        """Return whether more changes of the variance were added than can have their name; they stand for what has not.

        What else such samples show is not to be told.
        """
        changes = [at(description, key) for key in self.added(description, changing)]
        return bool(changes) and len(changes) > changes[0].most

    def _proven(self, after: AxisFit, before: AxisFit) -> bool:
        """Return whether a fit has more effects than before, each of which chance does not explain."""
        keys = self.added(after.description)
        return len(keys) > len(self.added(before.description)) and all(
            self.weighed(after, key)[0].log_p < self.log_alpha for key in keys
        )

    def trials(self, before: AxisFit, bar: float) -> Iterator[Trial]:
        """Yield every proposal, fitted, whose log-probability may come below ``bar``."""
        for kind in self.catalogue:
            if sum(isinstance(one, kind) for one in before.description.effects()) > (kind.most or LIMIT):
                continue
            for start in kind.starts(before):
                if kind.role is Role.FILTER:
                    start, beside = behind_filter(start, before)
                    if may_reach(start, bar):
                        trial = self.judged(start, before, beside)
                        if not before.sequence.in_motion or noise_shows_filter(trial, self.log_alpha):
                            yield trial
                elif _moves(start.effect, before) or may_reach(start, bar):
                    yield self.judged(start, before)
        yield from self._instead(before)

    def _instead(self, before: AxisFit) -> Iterator[Trial]:
        """Yield slow noise in the place of that of the start model, which is free and may stand for what is missing.

        Beside it as it is there is no room; it keeps a little, and what it is worth beside the other.
        """
        noise = before.description.noise
        for index, effect in enumerate(noise.effects[: len(self.start.noise.effects)]):
            if not effect.slow:
                continue
            without = self.fitted(before.sequence, removed(before.description, Key("noise", index)))
            effects = (*noise.effects[:index], little(effect), *noise.effects[index + 1 :])
            given_up = replace(before.description, noise=replace(noise, effects=effects))
            for kind in self.catalogue:
                if kind.slow and kind is not type(effect):
                    for start in kind.starts(without):
                        yield self.judged(start, before, given_up)

    def couple(self, before: AxisFit, single: Trial) -> Trial | None:
        """Return two means that together are worth more than one slow effect, or None; one of them may be a step.

        Two that nearly cancel gain little by themselves, but much beside each other, and what stands for both hides
        them.
        """
        if not masking(single.effect):
            return None
        means = Means.proposed(before, self.catalogue)
        both = means.smooth(), means.stepped() if single.effect.slow else []
        count = sum(map(len, both))
        for couples in both:
            likely = sorted(couples, key=lambda couple: -couple.gain)[:COUPLES]
            chosen = [couple for couple in likely if couple.gain > ALIKE * single.gain]
            fitted = (self._coupled(couple, before, count) for couple in chosen)
            best = max(fitted, key=lambda trial: trial.worth, default=None)
            if best is not None and best.worth > single.worth + MARGIN and self._needs_both(best.fit, before):
                return best
        return None

    def _needs_both(self, after: AxisFit, before: AxisFit) -> bool:
        """Return whether chance explains neither of the two terms that a fit has more, beside the other."""
        keys = [Key("term", index) for index in range(len(before.description.terms), len(after.description.terms))]
        return all(self.weighed(after, key)[0].log_p < self.log_alpha for key in keys)

    def _coupled(self, couple: Couple, before: AxisFit, count: int) -> Trial:
        """Fit two proposals together, one couple among ``count``, and judge them against the fit without them."""
        one, other = couple.starts
        after = self.fitted(before.sequence, with_effect(with_effect(before.description, one), other))
        parameters, trials = len(one.free) + len(other.free), count * one.trials * other.trials
        return Trial(other.effect, after, after.log_likelihood - before.log_likelihood, parameters, trials)

    def cleaned(self, before: AxisFit) -> Trial | None:
        """Return the fit to the samples without outliers, and what speaks for outliers; None where they are known."""
        outliers = None if before.description.outliers is not None else self._outliers(before)
        if outliers is None:
            return None
        found, axis = self.tails[outliers], before.sequence.conditions.axis
        sequence = before.sequence.with_replaced(found.flagged, stream(0, "mended", axis))
        after = self.fitted(sequence, replace(before.description, outliers=outliers))
        return Trial(outliers, after, found.gain, 2, TAILS)

    def _outliers(self, before: AxisFit) -> Effect | None:
        """Return the outliers of samples that are described but for them, if chance does not explain them."""
        if before.sequence.coarse and before.cells is None:
            return None
        found = before.tails
        if log_chance(found.gain, 2) + np.log(TAILS) > self.log_alpha or not found.flagged.any():
            return None
        kind = next((one for one in self.catalogue if one.role is Role.OUTLIERS), None)
        if kind is None:
            return None
        outliers = kind(found.probability, found.excess * before.unit)
        self.tails[outliers], self.raw[outliers] = found, before.sequence
        return outliers

    def cleared(self, before: AxisFit) -> AxisFit:
        """Return the fit to the samples without the outliers that the start model knows of, if it knows of some."""
        if self.start.outliers is None:
            return before
        wide = self.cleaned(replace(before, description=replace(before.description, outliers=None)))
        return before if wide is None else wide.fit

    def judged(self, start: Start, before: AxisFit, beside: Description | None = None) -> Trial:
        """Fit a proposal, beside what is there or other values of it, and judge it against the fit without it."""
        after = self.fitted(before.sequence, with_effect(beside or before.description, start))
        gain = (after.log_likelihood - before.log_likelihood) / start.level
        return Trial(start.effect, after, gain, len(start.free), start.trials)

    def settled(self, found: AxisFit, hoped: type[Effect] | None = None) -> AxisFit:
        """Return the fit after the removal or exchange of every added effect that is superfluous or another one.

        Effects of a kind ``hoped`` for come last: the exchange of the others may make them certain.
        """
        for _ in range(LIMIT):
            keys = [key for key in self.added(found.description) if key.part != "outliers"]
            if hoped is not None:
                keys.sort(key=lambda key: isinstance(at(found.description, key), hoped))
            changed = next((other for key in keys if (other := self._improved(found, key)) is not None), None)
            if changed is None:
                return found
            found = changed
        return found

    def pruned(self, found: AxisFit) -> AxisFit:
        """Return the fit without the added effects that chance explains."""
        for key in self.added(found.description):
            own, without = self.weighed(found, key)
            if own.log_p > self.log_alpha:
                return self.pruned(without)
        return found

    def _improved(self, found: AxisFit, key: "Key") -> AxisFit | None:
        """Return a fit without the effect at ``key``, or with another or a simpler in its place, if it is better."""
        own, without = self.weighed(found, key)
        if own.log_p > self.log_alpha:
            return without
        bar = min(self.log_alpha, own.log_p + CLOSE)
        tried = self.trials(without, bar)
        others = (one for one in tried if _another(one.effect, own.effect) or one.parameters < own.parameters)
        best = max(others, key=lambda trial: trial.worth, default=None)
        if best is not None and best.worth > own.worth + MARGIN:
            return best.fit
        couple = self.couple(without, own)
        return couple.fit if couple is not None else None

    def weighed(self, found: AxisFit, key: "Key") -> tuple[Trial, AxisFit]:
        """Return one effect as a trial, and the fit without it."""
        if key.part == "outliers":
            outliers = found.description.outliers
            return Trial(outliers, found, self.tails[outliers].gain, 2, TAILS), found
        without = self.fitted(found.sequence, removed(found.description, key))
        effect = at(found.description, key)
        more = max(found.description.size() - without.description.size(), 1)
        gain = found.log_likelihood - without.log_likelihood
        return Trial(effect, found, gain, more, _places(effect, more, without)), without

    def rivals(self, found: AxisFit, key: "Key", without: AxisFit, bar: float) -> list[Trial]:
        """Return every other effect in the place of one, fitted, whose log-probability may come below ``bar``."""
        if key.part == "outliers":
            return []
        name = at(found.description, key).name
        return [trial for trial in self.trials(without, bar) if trial.name != name]

    def added(self, description: Description, which: Callable[[Effect], bool] = lambda _: True) -> list["Key"]:
        """Return where the effects are that the start model does not have, those for which ``which`` holds."""
        keys = [Key("term", i) for i in range(len(self.start.terms), len(description.terms))]
        keys += [Key("noise", i) for i in range(len(self.start.noise.effects), len(description.noise.effects))]
        if description.noise.output_filter is not None and self.start.noise.output_filter is None:
            keys.append(Key("filter", 0))
        if description.outliers is not None and self.start.outliers is None:
            keys.append(Key("outliers", 0))
        keys += [Key("change", i) for i in range(len(self.start.changes), len(description.changes))]
        return [key for key in keys if which(at(description, key))]


@dataclass(frozen=True)
class Key:
    """Where in a description an effect is: its part and its index there."""

    part: str
    index: int


def at(description: Description, key: Key) -> Effect:
    """Return the effect at ``key``."""
    if key.part == "term":
        return description.terms[key.index].effect
    if key.part == "noise":
        return description.noise.effects[key.index]
    if key.part == "outliers":
        return description.outliers
    return description.noise.output_filter if key.part == "filter" else description.changes[key.index]


def removed(description: Description, key: Key) -> Description:
    """Return the description without the effect at ``key``."""
    if key.part == "term":
        return replace(description, terms=_rest(description.terms, key.index))
    if key.part == "change":
        return replace(description, changes=_rest(description.changes, key.index))
    if key.part == "outliers":
        return replace(description, outliers=None)
    noise = description.noise
    if key.part == "filter":
        return replace(description, noise=replace(noise, output_filter=None))
    return replace(description, noise=replace(noise, effects=_rest(noise.effects, key.index)))


def without(found: AxisFit, keys: Sequence[Key]) -> AxisFit:
    """Return the fit without the effects at some keys."""
    description = found.description
    for key in sorted(keys, key=lambda key: -key.index):
        description = removed(description, key)
    return fit(found.sequence, description) if keys else found


def _rest(items: tuple, index: int) -> tuple:
    return items[:index] + items[index + 1 :]


def with_effect(description: Description, start: Start) -> Description:
    """Return the description with an effect more, in the part of it where its kind belongs."""
    effect = start.effect
    if effect.role is Role.MEAN:
        return replace(description, terms=(*description.terms, Term(effect, start.free)))
    if effect.role is Role.VARIANCE:
        return replace(description, changes=(*description.changes, effect))
    noise = description.noise
    if effect.role is Role.FILTER:
        return replace(description, noise=replace(noise, output_filter=effect))
    return replace(description, noise=replace(noise, effects=(*noise.effects, effect)))


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
    """Return whether an effect may stand for two smooth means: slow noise, and means that follow from no motion."""
    return effect.slow or (effect.role is Role.MEAN and not effect.of_motion)


def _places(effect: Effect, parameters: int, without: AxisFit) -> float:
    """Return the independent places or shapes among which an effect of so many parameters is chosen."""
    starts = list(type(effect).starts(without))
    alike = [start.trials for start in starts if len(start.free) == parameters]
    return max(alike or [start.trials for start in starts], default=1.0)


def little(effect: StochasticEffect) -> StochasticEffect:
    """Return slow noise much smaller; its first parameter is its size."""
    size = fields(effect)[0].name
    return replace(effect, **{size: LITTLE * getattr(effect, size)})


def behind_filter(start: Start, before: AxisFit) -> tuple[Start, Description]:
    """Return a filter, and the description with the noise behind it, from which a fit is most likely to get there.

    Without the filter noise has gone far to look like it, and may not find back. What the noise gains is known by then,
    what the terms may gain is not, nor what the filter takes from the input.
    """
    description, sequence = before.description, before.sequence
    fits = []
    for factor in CUTOFFS:
        filtered = replace(start.effect, cutoff=factor * start.effect.cutoff)
        noise, power = replace(description.noise, output_filter=filtered), before.power_behind(filtered)
        both = noise, noise.beneath(sequence.bins, power)
        fits += [fit_noise(one, sequence.bins, power, held=sequence.in_motion) for one in both]
    best = max(fits, key=lambda one: one.log_likelihood)
    beside = replace(description, noise=replace(best.noise, output_filter=None))
    gain = np.inf if sequence.in_motion else best.log_likelihood - before.noise.log_likelihood + RESHAPED
    return replace(start, effect=best.noise.output_filter, gain=gain), beside


def noise_shows_filter(filtered: Trial, log_alpha: float) -> bool:
    """Return whether the noise shows a filter, besides the motion: else what the motion shows may be a mere delay."""
    fit, bins = filtered.fit, filtered.fit.sequence.bins
    unfiltered = fit_noise(replace(fit.noise.noise, output_filter=None), bins, fit.power)
    gain = fit.noise.log_likelihood - unfiltered.log_likelihood
    return log_chance(gain, filtered.parameters) + np.log(filtered.trials) < log_alpha


def _another(one: Effect, other: Effect) -> bool:
    """Return whether two effects differ in more than what a fit adjusts: in kind, or in a whole number."""
    whole = [item.name for item in fields(one) if item.metadata["whole"]]
    return one.name != other.name or any(getattr(one, name) != getattr(other, name) for name in whole)


def _moves(effect: Effect, before: AxisFit) -> bool:
    """Return whether what an effect gains, everything else held, says little: other slow noise gives way to it."""
    slow = any(one.slow for one in before.description.noise.effects)
    return slow and effect.role is Role.NOISE


def may_reach(start: Start, bar: float) -> bool:
    """Return whether the log-probability of a proposal may come below ``bar``."""
    return log_chance(SLACK * start.gain + SLACK, len(start.free)) + np.log(start.trials) < bar


def expected(*kinds: type[Effect]) -> float:
    """Return the logarithm of how much likelier effects of some kinds are beforehand: slow noise, whatever beside."""
    return EXPECTED if any(kind.slow for kind in kinds) else 0.0


def log_chance(gain: float, more: int) -> float:
    """Return the log-probability of a gain of log-likelihood by chance (Wilks 1938), its asymptote far out."""
    if not 0 < gain < np.inf:
        return 0.0 if gain <= 0 else -np.inf
    if gain < FAR:
        return float(chi2.logsf(2 * gain, more))
    return float(-gain + (more / 2 - 1) * np.log(gain) - gammaln(more / 2))

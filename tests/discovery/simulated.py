"""Simulate the samples of an axis, fit them, and search them for effects."""

from dataclasses import replace

import numpy as np

from imugap.discovery.axis import conclude, search_axis
from imugap.discovery.fit.axis_fit import fit
from imugap.discovery.fit.description import Description
from imugap.discovery.preparation.cosine_bins import usable_share
from imugap.discovery.preparation.sequence import AxisSequence
from imugap.discovery.search.search import Search
from imugap.effects import CATALOGUE, OutputFilter, WhiteNoise
from imugap.effects.conditions import Conditions
from imugap.effects.effect import AxisModel
from imugap.stream import stream

COUNT = 24_000
INTERVAL = 0.04
TIME = INTERVAL * np.arange(COUNT)
WHITE = WhiteNoise(1e-3)
LOG_ALPHA = np.log(0.01 / 6 / 28)
KINDS = tuple(CATALOGUE.values())


KNOWN = Description.known(WHITE)
"""Start model with white noise alone."""


def simulated(effects, conditions, seed, *labels):
    """The error sequence of effects, without flaws."""
    return AxisSequence(AxisModel(effects).simulate(np.zeros(len(conditions)), conditions, seed, *labels), conditions)


def moved(data, added):
    """The sequence with a signal added to its values, shape (n,)."""
    return replace(data, values=data.values + added)


def sequence(
    *effects, added=None, white=WHITE, count=COUNT, interval=INTERVAL, axis="gyro_x", label="search", temperature=None
):
    """White noise, effects, and what ``added`` makes of the times [s] and a random generator."""
    conditions = Conditions(interval * np.arange(count), interval, temperature, axis)
    data = simulated((white, *effects), conditions, 1, label)
    return data if added is None else moved(data, added(conditions.time, stream(1, label, "added")))


def behind(data, smooth):
    """The sequence behind an output filter."""
    output = smooth.apply(data.values, data.conditions, stream(1))
    return replace(data, values=output, share=usable_share(output))


def fitted(data, *entries):
    """The fit of white noise and further entries to a sequence."""
    return fit(data, KNOWN.adding(*entries))


def searched(data, *kinds, start=(), log_alpha=LOG_ALPHA):
    """The search of a sequence, of which four fifths are held in, for all kinds of effects or some."""
    return search_axis(data, start, kinds or KINDS, log_alpha, int(0.8 * len(data.values)))


def result_of(data, *kinds, start=(), log_alpha=LOG_ALPHA):
    """The result of a search: what is named, and what is withheld."""
    return conclude(searched(data, *kinds, start=start, log_alpha=log_alpha))


def told_of(*effects, **kwargs):
    return result_of(sequence(*effects, **kwargs))


def explored(data, *kinds, start=KNOWN):
    """A search beside a start model among some kinds, and the fit that it ends with."""
    search = Search(start, kinds, LOG_ALPHA)
    return search, search.explore(fitted(data))


def added_to(found):
    """What a fit has beside white noise: candidates that a search could take out again."""
    return Search(KNOWN, (), LOG_ALPHA).added(found)


def names(result):
    return sorted(finding.name for finding in result.findings)


def filtered(order, cutoff, added=0.0, before=0.0):
    """A log behind a filter that has still to let go of what was before."""
    data, smooth = sequence(), OutputFilter(cutoff, order)
    output = smooth.passed(data.values + added, INTERVAL) + before * smooth.decay(COUNT, INTERVAL)
    return result_of(replace(data, values=output, share=usable_share(output)))


def beside_white(added, count=20_000, interval=0.05, label="beside"):
    """White noise and what ``added`` makes of the times [s] and a random generator."""
    conditions = Conditions(np.arange(count) * interval, interval, axis="gyro_x")
    rng = stream(5, label)
    values = WHITE.sample(conditions, rng) + added(conditions.time, rng)
    return AxisSequence(values, conditions)

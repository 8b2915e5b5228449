"""Simulate the samples of an axis, fit them, and search them for effects."""

from dataclasses import replace

import numpy as np

from imugap.discovery.axis import conclude, search_axis
from imugap.discovery.fit.axis_fit import fit
from imugap.discovery.fit.description import Description
from imugap.discovery.preparation.cosine_bins import usable_share
from imugap.discovery.preparation.sequence import AxisSequence
from imugap.effects import CATALOGUE, OutputFilter, WhiteNoise
from imugap.effects.conditions import Conditions
from imugap.effects.effect import AxisModel
from imugap.stream import stream

COUNT = 24_000


INTERVAL = 0.04


WHITE = WhiteNoise(1e-3)


LOG_ALPHA = np.log(0.01 / 6 / 28)


def simulated(effects, conditions, seed, *labels):
    """The error sequence of effects, without flaws."""
    count = len(conditions)
    values = AxisModel(effects).simulate(np.zeros(count), conditions, seed, *labels)
    return AxisSequence(values, conditions)


def sequence(*effects, count=COUNT, axis="gyro_x", label="search"):
    conditions = Conditions(INTERVAL * np.arange(count), INTERVAL, axis=axis)
    return simulated((WHITE, *effects), conditions, 1, label)


def plain(data):
    return fit(data, Description.known(WHITE))


def told_of(*effects, **kwargs):
    data = sequence(*effects, **kwargs)
    return conclude(search_axis(data, (), tuple(CATALOGUE.values()), LOG_ALPHA, int(0.8 * len(data.values))))


def names(result):
    return sorted(finding.name for finding in result.findings)


def filtered(order, cutoff, added=0.0, before=0.0):
    """A log behind a filter that has still to let go of what was before."""
    data, smooth = sequence(), OutputFilter(cutoff, order)
    output = smooth.passed(data.values + added, INTERVAL) + before * smooth.decay(COUNT, INTERVAL)
    moved = replace(data, values=output, share=usable_share(output))
    return conclude(search_axis(moved, (), tuple(CATALOGUE.values()), LOG_ALPHA, int(0.8 * COUNT)))


def beside_white(added, count=20_000, interval=0.05, label="beside"):
    """White noise and what ``added`` makes of the times [s] and a random generator."""
    conditions = Conditions(np.arange(count) * interval, interval, axis="gyro_x")
    rng = stream(5, label)
    values = WHITE.sample(conditions, rng) + added(conditions.time, rng)
    return AxisSequence(values, conditions)

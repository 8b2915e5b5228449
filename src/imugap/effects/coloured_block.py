"""Coloured noise as a block, and in parts: a sum of first-order processes, through a short filter, summed from zero."""

from collections.abc import Sequence

import numpy as np

from imugap.effects.block import Block
from imugap.effects.conditions import Conditions, Run
from imugap.effects.effect import Transform
from imugap.numerics.first_order import recurse
from imugap.numerics.spectra.fractional_bank import LOWEST, fractional_bank


def coloured_block(std: float, order: float, weights: Sequence[float] = (1.0,), sums: int = 0) -> Block:
    """Return fractionally integrated white noise as a block.

    Its PSD is std^2 |2 sin(pi f)|^(-2 order) before the summations, f in cycles per sample, down to
    :data:`imugap.numerics.spectra.fractional_bank.LOWEST`.

    Parameters
    ----------
    std
        Standard deviation of the white noise [unit].
    order
        Order of the integration, above -1/2 and below 1; below zero it is that of order + 1, differenced.
    weights
        Filter that the noise passes.
    sums
        Number of summations, from zero at the first sample.
    """
    weights, decays, stds = _bank(order, weights, LOWEST)
    values = {
        "decays": decays,
        "stds": std * stds,
        "drives": std * stds * np.sqrt(1 - decays**2),
        "levels": np.zeros(len(decays)),
        "weights": weights,
        "passed": np.zeros(len(weights)),
        "sums": np.zeros(sums),
        "first": 1.0,
    }
    return Block(_step, values, _start)


def coloured_parts(
    run: Run, rng: np.random.Generator, std: float, order: float, weights: Sequence[float] = (1.0,), sums: int = 0
) -> Transform:
    """Return a function that adds the noise of :func:`coloured_block` to one part of a run after the other.

    It has the spectrum down to a fourth of the lowest frequency of the run.
    """
    weights, decays, stds = _bank(order, weights, min(LOWEST, 1 / (4 * run.count)))
    drives = stds * np.sqrt(1 - decays**2)
    levels = stds * rng.standard_normal(len(stds))
    totals = np.zeros(sums)
    passed = np.zeros(0)

    def more(size: int) -> np.ndarray:
        values = np.zeros(size)
        for k in range(len(decays)):
            process = recurse(decays[k], drives[k] * rng.standard_normal(size), levels[k])
            levels[k] = process[-1]
            values += process
        return std * values

    def transform(sequence: np.ndarray, conditions: Conditions) -> np.ndarray:
        nonlocal passed
        first = not len(passed)
        passed = np.r_[more(len(weights)) if first else passed[-len(weights) :], more(len(sequence))]
        values = np.convolve(passed[1:], weights, "valid")
        for k in range(sums):
            values[0] = 0.0 if first else values[0] + totals[k]
            values = np.cumsum(values)
            totals[k] = values[-1]
        return sequence + values

    return transform


def _bank(order: float, weights: Sequence[float], lowest: float) -> tuple[Sequence[float], np.ndarray, np.ndarray]:
    """Return the filter, and decays and standard deviations of the processes of unit white noise that it passes."""
    if order < 0:
        weights = np.convolve(weights, (1.0, -1.0))
    decays, stds = map(np.array, fractional_bank(order % 1.0, lowest) if order else ((0.0,), (1.0,)))
    return weights, decays, stds


def _start(own, x, now):
    for k in range(len(own.levels)):
        own.levels[k] = own.stds[k] * own.draw.normal()
    for j in range(len(own.passed) - 1, 0, -1):
        for k in range(len(own.levels)):
            own.passed[j] = own.passed[j] + own.levels[k]
            own.levels[k] = own.decays[k] * own.levels[k] + own.drives[k] * own.draw.normal()


def _step(own, x, now):
    for j in range(len(own.passed) - 1, 0, -1):
        own.passed[j] = own.passed[j - 1]
    own.passed[0] = 0.0
    for k in range(len(own.levels)):
        own.passed[0] = own.passed[0] + own.levels[k]
        own.levels[k] = own.decays[k] * own.levels[k] + own.drives[k] * own.draw.normal()
    y = 0.0
    for j in range(len(own.weights)):
        y = y + own.weights[j] * own.passed[j]
    if len(own.sums) > 0 and own.first > 0.0:
        y = 0.0
    own.first = 0.0
    for j in range(len(own.sums)):
        own.sums[j] = own.sums[j] + y
        y = own.sums[j]
    return x + y

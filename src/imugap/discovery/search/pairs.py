"""Pairs of terms of the mean: the expected gain of both together, before any is fitted."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations

import numpy as np

from imugap.discovery.fit.axis_fit import AxisFit, jacobian
from imugap.discovery.fit.description import Entry
from imugap.effects.effect import TINY, Effect, Role, Start

MAX_SMOOTH_TRIALS = 10.0
"""Maximum number of trials of a start for which its term counts as smooth."""


@dataclass(frozen=True)
class Pair:
    """Two starts, and the expected gain of log-likelihood of both together."""

    starts: tuple[Start, Start]
    gain: float


@dataclass(frozen=True, eq=False)
class SmoothTerms:
    """Smooth terms of the mean that are candidates beside a fit.

    Attributes
    ----------
    fit
        The fit without them, of n samples.
    starts, columns
        The k starts, and the whitened derivatives by the parameters of each, k arrays of shape (n - 1, m).
    events
        Kinds of steps, which may be one of a pair.
    """

    fit: AxisFit
    starts: tuple[Start, ...]
    columns: tuple[np.ndarray, ...]
    events: tuple[type[Effect], ...]

    @staticmethod
    def proposed(fit: AxisFit, catalogue: Sequence[type[Effect]]) -> "SmoothTerms":
        """Return the smooth terms of the kinds of a catalogue."""
        kinds = [kind for kind in catalogue if kind.role is Role.MEAN]
        starts = tuple(start for kind in kinds for start in kind.starts(fit) if start.trials <= MAX_SMOOTH_TRIALS)
        slopes = (jacobian((Entry(start.effect, start.free),), fit.sequence) for start in starts)
        return SmoothTerms(fit, starts, tuple(map(fit.whiten, slopes)), tuple(kind for kind in kinds if kind.event))

    def smooth(self) -> list[Pair]:
        """Return the pairs of smooth terms of different kinds."""
        return [
            Pair((one, other), self._gain(i, j))
            for (i, one), (j, other) in combinations(enumerate(self.starts), 2)
            if type(one.effect) is not type(other.effect)
        ]

    def stepped(self) -> list[Pair]:
        """Return the pairs of a smooth term and the step with the largest gain beside it.

        Pairs of two steps are not needed: the larger step is found alone.
        """
        conditions = self.fit.sequence.conditions
        steps = [(event, column) for event in self.events for column in enumerate(self.columns)]
        highest = [(i, event.highest(self.fit.steps_beside(column), conditions)) for event, (i, column) in steps]
        return [Pair((self.starts[i], step), self._gain(i) + step.gain) for i, step in highest]

    def _gain(self, *chosen: int) -> float:
        """Return the gain of log-likelihood of the chosen terms together, to first order."""
        product, pull, own = self._normal
        at = np.concatenate([own[i] for i in chosen])
        return float(0.5 * pull[at] @ np.linalg.pinv(product[np.ix_(at, at)], rcond=1e-8, hermitian=True) @ pull[at])

    @cached_property
    def _normal(self) -> tuple[np.ndarray, np.ndarray, list[np.ndarray]]:
        """Return Gram matrix of unit columns, their products with the coefficients, and the indices of each term."""
        rest = self.fit.beyond(np.column_stack(self.columns))
        rest = rest / np.maximum(np.linalg.norm(rest, axis=0), TINY)
        ends = np.cumsum([column.shape[1] for column in self.columns])
        return rest.T @ rest, rest.T @ self.fit.coefficients, np.split(np.arange(ends[-1]), ends[:-1])

"""Couples of means: what two of them promise together, before any is fitted."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations

import numpy as np

from imugap.discovery.fit.axis_fit import AxisFit, jacobian
from imugap.discovery.fit.description import Entry
from imugap.effects.effect import TINY, Effect, Role, Start

FEW = 10.0
"""Trials of a start up to which it is one of a couple of smooth means."""


@dataclass(frozen=True)
class Pair:
    """Two proposals, and the gain of log-likelihood that they promise together."""

    starts: tuple[Start, Start]
    gain: float


@dataclass(frozen=True, eq=False)
class Means:
    """The smooth means that are proposed beside a fit.

    Attributes
    ----------
    fit
        The fit without them, with n samples.
    starts, columns
        The k proposals, and the whitened slopes of the parameters of each, shapes (n - 1, m).
    events
        Kinds of steps, which may be one of a couple.
    """

    fit: AxisFit
    starts: tuple[Start, ...]
    columns: tuple[np.ndarray, ...]
    events: tuple[type[Effect], ...]

    @staticmethod
    def proposed(fit: AxisFit, catalogue: Sequence[type[Effect]]) -> "Means":
        """Return those of the kinds of a catalogue."""
        kinds = [kind for kind in catalogue if kind.role is Role.MEAN]
        starts = tuple(start for kind in kinds for start in kind.starts(fit) if start.trials <= FEW)
        slopes = (jacobian((Entry(start.effect, start.free),), fit.sequence) for start in starts)
        return Means(fit, starts, tuple(map(fit.whiten, slopes)), tuple(kind for kind in kinds if kind.event))

    def smooth(self) -> list[Pair]:
        """Return the couples of two kinds of smooth means."""
        return [
            Pair((one, other), self._gain(i, j))
            for (i, one), (j, other) in combinations(enumerate(self.starts), 2)
            if type(one.effect) is not type(other.effect)
        ]

    def stepped(self) -> list[Pair]:
        """Return each smooth mean with the step that gains most beside it; of two steps the higher one shows alone."""
        conditions = self.fit.sequence.conditions
        steps = [(event, column) for event in self.events for column in enumerate(self.columns)]
        highest = [(i, event.highest(self.fit.steps_beside(column), conditions)) for event, (i, column) in steps]
        return [Pair((self.starts[i], step), self._gain(i) + step.gain) for i, step in highest]

    def _gain(self, *chosen: int) -> float:
        """Return the gain of log-likelihood of some of the means together, to first order."""
        product, pull, own = self._normal
        at = np.concatenate([own[i] for i in chosen])
        return float(0.5 * pull[at] @ np.linalg.pinv(product[np.ix_(at, at)], rcond=1e-8, hermitian=True) @ pull[at])

    @cached_property
    def _normal(self) -> tuple[np.ndarray, np.ndarray, list[np.ndarray]]:
        """Return products of all unit columns with each other and with the coefficients, and which belong to a mean."""
        rest = self.fit.beyond(np.column_stack(self.columns))
        rest = rest / np.maximum(np.linalg.norm(rest, axis=0), TINY)
        ends = np.cumsum([column.shape[1] for column in self.columns])
        return rest.T @ rest, rest.T @ self.fit.coefficients, np.split(np.arange(ends[-1]), ends[:-1])

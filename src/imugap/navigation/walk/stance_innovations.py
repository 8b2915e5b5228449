"""Estimates of sensor errors from the zero-velocity innovations of one walk, without any other reference.

The innovations of a filter with a correct model are white with known variances. The sum of their normalised squares
over a walk is a parabola in the size of a small sensor error: its minimum estimates the size, its curvature gives the
standard deviation, as for any Gaussian likelihood. If the innovations scatter more than expected, the standard
deviation grows with them.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import pandas as pd
from scipy.special import ndtri

from imugap.effects import GSensitivity, Misalignment, ScaleFactor, StanceMotion, TimeOffset
from imugap.effects.effect import AxisModel
from imugap.filters.zero_velocity import STANCE
from imugap.log import ACCEL, AXES, GYRO, triad
from imugap.model import ErrorModel
from imugap.navigation.walk.pedestrian import AlignedWalk, WalkAssumptions, align, solve

INDISTINGUISHABLE = 2.0
"""Difference of log-likelihoods up to which two candidates are indistinguishable."""


@dataclass(frozen=True)
class CandidateError:
    """Possible sensor error: effect, axes, parameter, a small size of it, and the model of that size.

    ``velocity``: direction in ``n`` of a velocity of the foot at stance instead, shape (3,), or None.
    """

    name: str
    axes: tuple[str, ...]
    parameter: str
    small: float
    model: ErrorModel
    velocity: tuple[float, float, float] | None = None


def candidate_errors() -> Iterator[CandidateError]:
    """Yield the errors that zero velocity observes: scale factor, misalignment, g-sensitivity, delay of a triad.

    A common delay of both triads changes no walk.
    """
    for axis in AXES:
        yield _candidate(ScaleFactor, axis, "error", 2e-3)
        for other in triad(axis):
            if other != axis:
                yield _candidate(Misalignment, axis, other[-1], 2e-3)
    for axis in GYRO:
        for other in ACCEL:
            yield _candidate(GSensitivity, axis, other[-1], 5e-5, dict.fromkeys("xyz", 0.0))
    late = ErrorModel(dict.fromkeys(ACCEL, AxisModel((TimeOffset(1e-3),))))
    yield CandidateError(TimeOffset.name, ACCEL, "offset", 1e-3, late)


def foot_sinkage() -> CandidateError:
    """Return the sinkage of the foot at stance, which changes the height and is no error of the device."""
    return CandidateError(StanceMotion.name, ("down",), "bias", 1e-3, ErrorModel({}), (0.0, 0.0, 1.0))


def _candidate(kind: type, axis: str, parameter: str, small: float, others: dict | None = None) -> CandidateError:
    effect = kind(**((others or {}) | {parameter: small}))
    return CandidateError(kind.name, (axis,), parameter, small, ErrorModel({axis: AxisModel((effect,))}))


def bonferroni_limit(alpha: float, trials: int) -> float:
    """Return the limit that any of ``trials`` standard normal deviates exceeds with probability ``alpha``."""
    return float(-ndtri(alpha / trials / 2))


@dataclass(frozen=True, eq=False)
class StanceTest:
    """Estimates of all candidate errors from a walk.

    Attributes
    ----------
    table
        A row for each candidate, the most significant first: ``name``, ``axis``, ``parameter``, ``value``, ``std``
        (SI), and ``deviate`` = value/std.
    scatter
        Mean normalised squared innovation at stance per degree of freedom: 1 for a consistent filter.
    """

    table: pd.DataFrame
    scatter: float

    def named(self, alpha: float) -> pd.DataFrame:
        """Return the most significant candidate and those indistinguishable from it; no row if it is not significant.

        Log-likelihoods of indistinguishable candidates differ by at most :data:`INDISTINGUISHABLE`.
        """
        squares = self.table["deviate"] ** 2
        sure = squares.iloc[0] > bonferroni_limit(alpha, len(squares)) ** 2
        return self.table[sure & (squares > squares.iloc[0] - 2 * INDISTINGUISHABLE)]


def stance_test(log: pd.DataFrame, model: ErrorModel, assumptions: WalkAssumptions) -> StanceTest:
    """Estimate every candidate error from the innovations of a walk, with the weights of the original log."""
    aligned = align(log, model, assumptions)
    rest, freedom = _squares(aligned), 3 * np.count_nonzero(aligned.phase == STANCE)
    excess = np.sqrt(max(rest / freedom, 1.0))
    rows = []
    for candidate in candidate_errors():
        error = candidate.model.simulate(log, 0) - log
        less, more = (_squares(aligned.with_samples(log - sign * error)) for sign in (1, -1))
        curvature = (less + more - 2 * rest) / candidate.small**2
        value, std = np.nan, np.inf
        if curvature > 0:
            value, std = (more - less) / (2 * candidate.small * curvature), excess * np.sqrt(2 / curvature)
        row = {"name": candidate.name, "axis": candidate.axes[0], "parameter": candidate.parameter}
        rows.append(row | {"value": value, "std": std, "deviate": np.nan_to_num(value / std)})
    table = pd.DataFrame(rows).sort_values("deviate", key=np.abs, ascending=False, ignore_index=True)
    return StanceTest(table, rest / freedom)


def _squares(aligned: AlignedWalk) -> float:
    """Return the sum of the normalised squared innovations at stance."""
    return float(solve(aligned).nis[aligned.phase == STANCE].sum())

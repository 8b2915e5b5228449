"""What zero velocity alone says of an error of the sensors, without any other reference.

The innovations of the filter are white with known variances if its model is right. The sum of their normalised squares
over a walk, less a share of an error, is a parabola over that share: its minimum estimates the size of the error, its
curvature how surely, as in any Gaussian likelihood. Where the innovations scatter more than the filter expects, the
uncertainty grows with them.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd
from scipy.special import ndtri

from imugap.effects import GSensitivity, Misalignment, ScaleFactor, StanceMotion, TimeOffset
from imugap.effects.effect import AxisModel
from imugap.filters.zero_velocity import STANCE
from imugap.log import ACCEL, AXES, GYRO, triad
from imugap.model import ErrorModel
from imugap.navigation.pedestrian import WalkAssumptions, navigate

ALIKE = 2.0
"""Difference of log-likelihoods up to which two suspects are not told apart."""


@dataclass(frozen=True)
class Suspect:
    """An error that may be there: its name, the axes that would have it, its parameter, and a small one of it.

    ``velocity`` is the direction in ``n`` of a small velocity of the foot at stance, shape (3,), or None.
    """

    name: str
    axes: tuple[str, ...]
    parameter: str
    small: float
    model: ErrorModel
    velocity: tuple[float, float, float] | None = None


def suspects() -> Iterator[Suspect]:
    """Yield what zero velocity may know of: scale, misalignment, sensitivity to acceleration, delay of a triad.

    A delay of both triads together leaves every walk as it is.
    """
    for axis in AXES:
        yield _suspect(ScaleFactor, axis, "error", 2e-3)
        for other in triad(axis):
            if other != axis:
                yield _suspect(Misalignment, axis, other[-1], 2e-3)
    for axis in GYRO:
        for other in ACCEL:
            yield _suspect(GSensitivity, axis, other[-1], 5e-5, dict.fromkeys("xyz", 0.0))
    late = ErrorModel(dict.fromkeys(ACCEL, AxisModel((TimeOffset(1e-3),))))
    yield Suspect(TimeOffset.name, ACCEL, "offset", 1e-3, late)


def sinking() -> Suspect:
    """Return a foot that sinks at stance: of all that is no error of the device, what moves the height."""
    return Suspect(StanceMotion.name, ("down",), "bias", 1e-3, ErrorModel({}), (0.0, 0.0, 1.0))


def _suspect(kind: type, axis: str, parameter: str, small: float, others: dict | None = None) -> Suspect:
    effect = kind(**((others or {}) | {parameter: small}))
    return Suspect(kind.name, (axis,), parameter, small, ErrorModel({axis: AxisModel((effect,))}))


def limit(alpha: float, trials: int) -> float:
    """Return the size of a standard normal deviate that any of so many exceed with the probability ``alpha``."""
    return float(-ndtri(alpha / trials / 2))


@dataclass(frozen=True, eq=False)
class Judgement:
    """What the innovations of a walk say.

    Attributes
    ----------
    table
        A row for every suspect, the surest first: ``name``, ``axis``, ``parameter``, ``value``, ``std`` (SI), and
        ``deviate`` = value/std.
    scatter
        Mean normalised square of the innovations at stance per degree of freedom: 1 for a filter that knows them.
    """

    table: pd.DataFrame
    scatter: float

    def named(self, alpha: float) -> pd.DataFrame:
        """Return the suspects that nobody can tell from the surest, if that is beyond chance; else no row.

        Those are alike whose log-likelihoods are within :data:`ALIKE` of one another.
        """
        squares = self.table["deviate"] ** 2
        sure = squares.iloc[0] > limit(alpha, len(squares)) ** 2
        return self.table[sure & (squares > squares.iloc[0] - 2 * ALIKE)]


def judged(log: pd.DataFrame, model: ErrorModel, assumptions: WalkAssumptions) -> Judgement:
    """Return what the innovations of a walk say of every suspect.

    The share of the change from sample to sample that a filter leaves uncertain would change with a scale; it is taken
    for none here.
    """
    assumptions = replace(assumptions, blind_gyro=0.0)
    rest, freedom = _squares(log, model, assumptions)
    excess = np.sqrt(max(rest / freedom, 1.0))
    rows = []
    for suspect in suspects():
        error = suspect.model.simulate(log, 0) - log
        less, more = (_squares(log - sign * error, model, assumptions)[0] for sign in (1, -1))
        curvature = (less + more - 2 * rest) / suspect.small**2
        value, std = np.nan, np.inf
        if curvature > 0:
            value, std = (more - less) / (2 * suspect.small * curvature), excess * np.sqrt(2 / curvature)
        row = {"name": suspect.name, "axis": suspect.axes[0], "parameter": suspect.parameter}
        rows.append(row | {"value": value, "std": std, "deviate": np.nan_to_num(value / std)})
    table = pd.DataFrame(rows).sort_values("deviate", key=np.abs, ascending=False, ignore_index=True)
    return Judgement(table, rest / freedom)


def _squares(log: pd.DataFrame, model: ErrorModel, assumptions: WalkAssumptions) -> tuple[float, int]:
    """Return the sum of the normalised squared innovations and its degrees of freedom."""
    solution = navigate(log, model, assumptions)
    known = solution.phase == STANCE
    return float(solution.nis[known].sum()), 3 * np.count_nonzero(known)

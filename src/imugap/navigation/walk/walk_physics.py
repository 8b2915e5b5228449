"""Physics of a walk, before it is navigated: dead axes, gravity at the stand, rates and stamps that fit the motion.

At the begin of every stance the velocity that a filter predicts for the foot is off by decimetres per second at most,
for any gait. With wrong stamps, rates or forces it is off by metres per second, or the foot climbs at every stride.
Where it does, the log is tried again with each suspect corrected, and the one that explains the motion is named.
Velocities are compared per time of the log, since shorter stamps make any velocity smaller.

A walk that passes may still be one of which the filter states too little: the normalised squares of these velocities
tell, and how often the floor is not level.
"""

from typing import NamedTuple

import numpy as np
import pandas as pd
from scipy.special import chdtri

from imugap.filters.error_state import NAVIGATION
from imugap.filters.zero_velocity import MOVING
from imugap.log import AXES, TIME
from imugap.model import ErrorModel
from imugap.navigation.sample_errors import SAMPLE_ERRORS, SampleError
from imugap.navigation.walk import pedestrian
from imugap.navigation.walk.pedestrian import STEP_M, AlignedWalk, WalkAssumptions

DEAD_SHARE = 1e-6
"""Largest spread of a dead axis, as a share of the largest of its triad."""
GRAVITY_SHARE, STANCE_GRAVITY_SHARE = 0.05, 0.1
"""Largest difference of the specific force from gravity, as a share of it: at a stand, and at the stance of a foot."""
LARGEST_M_PER_S = 0.6
"""Root mean square velocity at the begin of stances from which on the motion does not fit."""
NOTICED_M_PER_S, CLEAR_SHARE = 0.1, 0.2
"""The same from which on suspects are tried, and the share that is left where one is named."""
CLIMBING, LEVEL = 0.5, 0.1
"""Share of stances on another level than the last from which on a floor is not level, and up to which it is."""
FEWEST_STANCES = 8
"""Number of stances from which on a walk is judged."""
CHANCE = 1e-6
"""Probability of velocities as large, over the stated ones, below which they are not chance."""


class StanceFit(NamedTuple):
    """How a foot comes to rest at its stances by the filter.

    Attributes
    ----------
    velocity
        Root mean square velocity that is predicted for their begins [m/s]; inf without any.
    pace
        The same over the time of the log [m/s^2].
    nis
        Mean normalised square of that velocity, 1 for a consistent filter.
    count
        Number of stances.
    climbing
        Share of the stances on another level than the last one, 0 where no floor is assumed level.
    rise
        Mean height over the last stance [m].
    """

    velocity: float
    pace: float
    nis: float
    count: int
    climbing: float
    rise: float

    @classmethod
    def of(cls, aligned: AlignedWalk) -> "StanceFit":
        """Return the fit of an aligned walk."""
        residual, variance = pedestrian.innovations(aligned)
        rest = aligned.phase > MOVING
        begins = rest & ~np.append(True, rest[:-1])
        square = residual[begins, : NAVIGATION - 6] ** 2
        if not len(square):
            return cls(0.0, 0.0, 0.0, 0, 0.0, 0.0)
        height = residual[np.isfinite(residual[:, -1]), -1]
        climbing, rise = (np.mean(np.abs(height) > STEP_M), -np.mean(height)) if len(height) else (0.0, 0.0)
        velocity = float(np.sqrt(np.nanmean(square)))
        return cls(
            velocity, velocity / float(aligned.time[-1] - aligned.time[0]),
            float(np.nanmean(square / variance[begins, : NAVIGATION - 6])), len(square), float(climbing), float(rise),
        )  # fmt: skip

    @property
    def climbs(self) -> bool:
        """Whether the foot climbs or sinks at most strides."""
        return self.count >= FEWEST_STANCES and self.climbing > CLIMBING

    @property
    def factor(self) -> float:
        """Factor on the stated standard deviations, at least 1."""
        chance = self.count == 0 or self.nis < chdtri(3 * self.count, CHANCE) / (3 * self.count)
        return 1.0 if chance else float(np.sqrt(self.nis))

    def explains(self, plain: "StanceFit") -> bool:
        """Return whether this is the fit of the right log, where ``plain`` is that of the given one."""
        if plain.velocity >= NOTICED_M_PER_S:
            return self.pace < CLEAR_SHARE * plain.pace and self.climbing <= plain.climbing
        return plain.climbs and self.count >= FEWEST_STANCES and self.climbing < LEVEL and self.pace <= plain.pace

    def __str__(self) -> str:
        """Return in words what is doubtful; nothing where all is well."""
        found = []
        if self.factor > 1:
            found.append(
                f"The foot comes to rest {self.factor:.2g} times less exactly than stated (knocks, slips, lost "
                "samples, a range that is exceeded (--full-scale), or a device that is off); the stated "
                "deviations are multiplied by that."
            )
        if self.climbs:
            found.append(
                f"At {self.climbing:.0%} of the stances the foot is not on the level of the last one, by "
                f"{self.rise:+.2g} m on average: stairs or a slope (--outdoors), or scale, axes or range of the device "
                "are off."
            )
        return "\n".join(found)


def check_walk(log: pd.DataFrame, model: ErrorModel, assumptions: WalkAssumptions) -> None:
    """Raise a ValueError where a log cannot be that of a foot in motion under gravity."""
    _check_axes(log)
    _check_gravity(log, assumptions)
    plain = stance_fit(log, model, assumptions)
    if plain.velocity < NOTICED_M_PER_S and not plain.climbs:
        return
    left = {one.found: stance_fit(_corrected(log, one), model, assumptions) for one in SAMPLE_ERRORS}
    best = min(left, key=lambda name: (not left[name].explains(plain), left[name].pace))
    if plain.velocity > LARGEST_M_PER_S or left[best].explains(plain):
        named = f", as of {best}" if left[best].explains(plain) else ""
        off = f"{plain.velocity:.2g} m/s off" if plain.velocity >= NOTICED_M_PER_S else (
            f"{plain.rise:+.2g} m off the level of the last one")  # fmt: skip
        raise ValueError(f"walk: expected a foot that comes to rest at each stance; found it {off}{named}")


def _corrected(log: pd.DataFrame, error: SampleError) -> pd.DataFrame:
    """Return a log corrected of an error of its samples."""
    stamp, samples = error.corrected(log.index.to_numpy(dtype=float), log[list(AXES)].to_numpy(dtype=float))
    return log.set_axis(pd.Index(stamp, name=TIME)).assign(**dict(zip(AXES, samples.T, strict=True)))


def stance_fit(log: pd.DataFrame, model: ErrorModel, assumptions: WalkAssumptions) -> StanceFit:
    """Return how a foot comes to rest at its stances; infinitely fast where a log has no stand."""
    try:
        return StanceFit.of(pedestrian.align(log, model, assumptions))
    except ValueError:
        return StanceFit(np.inf, np.inf, np.inf, 0, 1.0, 0.0)


def _check_axes(log: pd.DataFrame) -> None:
    """Raise a ValueError for an axis that is constant."""
    for triad in (AXES[:3], AXES[3:]):
        spread = log[list(triad)].std()
        for name in triad:
            if not spread[name] > DEAD_SHARE * spread.max():
                raise ValueError(f"walk: expected a signal in column {name}; found a constant {log[name].iloc[0]:g}")


def _check_gravity(log: pd.DataFrame, assumptions: WalkAssumptions) -> None:
    """Raise a ValueError where the specific force at the stand is not gravity."""
    stand = pedestrian.align(log, ErrorModel({}), assumptions).stand
    share, where = (GRAVITY_SHARE, "stand") if stand.still else (STANCE_GRAVITY_SHARE, "quietest stance")
    if abs(stand.gravity / assumptions.gravity - 1) > share:
        raise ValueError(
            f"walk: expected a specific force at the {where} near {assumptions.gravity:.4g} m/s^2 (--gravity); found "
            f"{stand.gravity:.3g} m/s^2"
        )

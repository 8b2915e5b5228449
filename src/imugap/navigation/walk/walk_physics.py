"""Physics of a walk, before it is navigated: dead axes, gravity at the stand, rates and stamps that fit the motion.

At the begin of every stance the velocity that a filter predicts for the foot is off by decimetres per second at most,
for any gait. With wrong stamps, rates or forces it is off by metres per second. Where it is, the log is tried
again with stamps of half and of twice the interval and with rates in degrees, and what mends it is named.
"""

from collections.abc import Callable

import numpy as np
import pandas as pd

from imugap.filters.error_state import NAVIGATION
from imugap.filters.zero_velocity import MOVING
from imugap.log import AXES, GYRO, TIME
from imugap.model import ErrorModel
from imugap.navigation.walk import pedestrian
from imugap.navigation.walk.pedestrian import WalkAssumptions

DEAD_SHARE = 1e-6
"""Largest spread of a dead axis, as a share of the largest of its triad."""
GRAVITY_SHARE, STANCE_GRAVITY_SHARE = 0.05, 0.1
"""Largest difference of the specific force from gravity, as a share of it: at a stand, and at the stance of a foot."""
LARGEST_M_PER_S, MENDED_SHARE = 0.6, 0.5
"""Root mean square velocity at the begin of stances from which on the motion does not fit, and the largest share of it
that is left where a suspect is named."""
NOTICED_M_PER_S, CLEAR_SHARE = 0.1, 0.2
"""The same from which on suspects are tried, and the share that is left where one is clear."""
SUSPECTS: dict[str, Callable[[pd.DataFrame], pd.DataFrame]] = {
    "stamps of twice the interval (the rate is twice the nominal one)": lambda log: _stamped(log, 0.5),
    "stamps of half the interval (the rate is half the nominal one)": lambda log: _stamped(log, 2.0),
    "angular rates in deg/s": lambda log: log.assign(**{name: np.radians(log[name]) for name in GYRO}),
    "angular rates 57.3 times too small": lambda log: log.assign(**{name: np.degrees(log[name]) for name in GYRO}),
}
"""What may be wrong with a log, and how it is mended."""


def check_walk(log: pd.DataFrame, model: ErrorModel, assumptions: WalkAssumptions) -> None:
    """Raise a ValueError where a log cannot be that of a foot in motion under gravity."""
    _check_axes(log)
    _check_gravity(log, assumptions)
    plain = stance_velocity(log, model, assumptions)
    if plain < NOTICED_M_PER_S:
        return
    left = {name: stance_velocity(mended(log), model, assumptions) for name, mended in SUSPECTS.items()}
    best = min(left, key=left.get)
    if plain > LARGEST_M_PER_S or left[best] < CLEAR_SHARE * plain:
        named = f", as of {best}" if left[best] < MENDED_SHARE * plain else ""
        raise ValueError(
            f"walk: expected a foot that comes to rest at each stance; found it {plain:.2g} m/s off{named}"
        )


def stance_velocity(log: pd.DataFrame, model: ErrorModel, assumptions: WalkAssumptions) -> float:
    """Return the root mean square velocity that the filter predicts at the begin of stances [m/s]; inf without any."""
    try:
        aligned = pedestrian.align(log, model, assumptions)
        residual, _ = pedestrian.innovations(aligned)
    except ValueError:
        return np.inf
    rest = aligned.phase > MOVING
    begins = rest & ~np.append(True, rest[:-1])
    velocity = residual[begins, : NAVIGATION - 6]
    return float(np.sqrt(np.nanmean(velocity**2))) if len(velocity) else 0.0


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


def _stamped(log: pd.DataFrame, factor: float) -> pd.DataFrame:
    """Return the log with the times since its begin multiplied."""
    time = log.index.to_numpy()
    return log.set_index(pd.Index(time[0] + factor * (time - time[0]), name=TIME))

"""Published protocol of the walks of PyShoe under cameras: error of a trial, two folds, and figures over all trials.

Gao and Deng (2026) compare navigators on the 56 trials by the mean, the median, the 95th percentile and the mean of the
worst tenth (CVaR90) of the 2-D ARMSE, each fold with the settings that have the least mean on the other. We could not
read which trials are in which fold, which settings were tried, and how tracks are aligned. Alignment and ARMSE are
therefore those of the program of the publisher of the trials, from which the name comes (PyShoe,
``ins_tools/util.py``). Both tracks begin at the origin. The navigated one is turned so that its first point
:data:`FIRST_M` away has the direction of the measured one. The ARMSE is the mean of ``sqrt((dx^2 + dy^2)/2)`` over all
samples. No arm to the marker, no delay and no scale is fitted. The folds are the trials at odd and at even places in
the order of time.

Sources: Gao, Deng, Posterior-contact soft-ZUPT for foot-mounted inertial navigation: uncertainty-aware
pseudo-observation modeling, Sensors 26 (2026) 3033; B. Wagstaff, V. Peretroukhin, J. Kelly, Robust data-driven
zero-velocity detection for foot-mounted inertial navigation, IEEE Sens. J. 20 (2020) 957-967.
"""

from collections.abc import Callable, Mapping

import numpy as np
import pandas as pd

FIRST_M = 0.8
"""Distance from the begin at which the headings of both tracks are made equal [m]."""
FIRST_SAMPLE = 300
"""Sample at which they are made equal on a track that never is so far."""
WORST = 0.9
"""Probability beyond which CVaR90 takes the mean."""
FIGURES: Mapping[str, Callable[[np.ndarray], np.ndarray]] = {
    "mean": lambda errors: errors.mean(axis=-1),
    "median": lambda errors: np.median(errors, axis=-1),
    "p95": lambda errors: np.quantile(errors, 0.95, axis=-1),
    "cvar90": lambda errors: cvar(errors, WORST),
}
"""Figures of the errors of trials, along the last axis."""


def errors(found: np.ndarray, seen: np.ndarray) -> np.ndarray:
    """Return the differences of two tracks after the alignment of the publisher [m], shape (n, 2).

    Parameters
    ----------
    found, seen
        Navigated and measured horizontal positions at the same instants [m], shape (n, 2); NaN where not measured.
    """
    found, seen = found - found[0], seen - seen[0]
    far = np.flatnonzero((np.hypot(*found.T) >= FIRST_M) & np.isfinite(seen[:, 0]))
    first = far[0] if len(far) else min(FIRST_SAMPLE, len(found) - 1)
    (x, y), (u, v) = found[first], seen[first]
    turn = np.arctan2(x * v - y * u, x * u + y * v)
    c, s = np.cos(turn), np.sin(turn)
    return found @ [[c, s], [-s, c]] - seen


def armse(found: np.ndarray, seen: np.ndarray) -> float:
    """Return the 2-D ARMSE of the publisher [m]; parameters as for :func:`errors`."""
    return float(np.nanmean(np.sqrt(np.mean(errors(found, seen) ** 2, axis=1))))


def distance_rms(found: np.ndarray, seen: np.ndarray) -> float:
    """Return the root mean square horizontal distance after the same alignment [m]."""
    return float(np.sqrt(np.nanmean(np.sum(errors(found, seen) ** 2, axis=1))))


def cvar(errors: np.ndarray, probability: float) -> np.ndarray:
    """Return the mean of the errors at or above their quantile, along the last axis."""
    limit = np.quantile(errors, probability, axis=-1, keepdims=True)
    worst = errors >= limit
    return np.where(worst, errors, 0.0).sum(axis=-1) / worst.sum(axis=-1)


def held_out(scores: pd.DataFrame) -> pd.DataFrame:
    """Return the rows of each trial with the setting that has the least mean error on the other fold.

    Parameters
    ----------
    scores
        Columns ``trial``, ``setting`` and ``error`` [m], one row for each pair.
    """
    trials = np.sort(scores["trial"].unique())
    kept = []
    for scored in (trials[::2], trials[1::2]):
        inside = scores["trial"].isin(scored)
        best = scores[~inside].groupby("setting", sort=False)["error"].mean().idxmin()
        kept.append(scores[inside & (scores["setting"] == best)])
    return pd.concat(kept).sort_values("trial", ignore_index=True)


def summary(errors: np.ndarray, rng: np.random.Generator, draws: int = 4000) -> dict[str, tuple[float, float, float]]:
    """Return each of :data:`FIGURES` with its 95 % bootstrap interval over trials [m]."""
    drawn = rng.choice(errors, (draws, len(errors)))
    return {
        name: (float(figure(errors)), *map(float, np.quantile(figure(drawn), [0.025, 0.975])))
        for name, figure in FIGURES.items()
    }

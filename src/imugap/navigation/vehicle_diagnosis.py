"""What the innovations of a filter say of what it does not know: whether they are white, and what would explain it.

A filter that is right has innovations that, whitened by their covariance, are independent and standard normal. If
they are not, one of the :data:`CANDIDATES` may be why: fixes that belong to another time, an antenna elsewhere, scale
factors. Each is put to the filter as further states, which the first part of the drive estimates; the estimates are
then taken for known, and the likelihood of the innovations of the rest, which had no part in them, is compared with
that without. Of the candidates whose gain per fix is above zero beyond chance, at a probability ``alpha`` for all of
them together (Bonferroni), that with the largest gain is named, and the others are asked for again beside it. A
candidate that explains nothing loses on what it has not seen, so that nothing is named where nothing is hidden but with
the probability ``alpha``.

Source: G. M. Ljung, G. E. P. Box, On a measure of lack of fit in time series models, Biometrika 65 (1978) 297-303.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd
from scipy.special import chdtr, chdtrc, ndtr

from imugap.filters.innovation_gate import NOTHING, Record
from imugap.kinematics.strapdown import Ellipsoid
from imugap.log import AXES
from imugap.model import ErrorModel
from imugap.navigation.vehicle import LEVER, OFFSET, Assumptions, Solution, navigate
from imugap.navigation.vehicle_alignment import depart

LAGS = 10
"""Lags that the test of whiteness looks at."""
LEARNING = 0.5
"""Share of the fixes, from the first, that estimate a candidate."""
CANDIDATES = ("time offset", "lever arm", "scale factor")
UNKNOWN = {
    "time offset": {"offset_std": 0.3},
    "lever arm": {"lever_std": 1.0},
    "scale factor": {"scale_std": (0.02, 0.02)},
}
"""What a candidate lets the filter not know: standard deviations [s], [m], [1]."""


@dataclass(frozen=True, eq=False)
class Case:
    """A drive as a filter has it."""

    log: pd.DataFrame
    fixes: pd.DataFrame
    model: ErrorModel
    assumptions: Assumptions
    ellipsoid: Ellipsoid

    def solve(self) -> Solution:
        """Navigate it, without quality control."""
        states = self.assumptions.states(self.model)
        start = depart(self.log, self.fixes, states, self.assumptions, self.ellipsoid)
        return navigate(self.log, self.fixes, self.model, self.assumptions, NOTHING, start, self.ellipsoid)

    def knowing(self, candidate: str) -> tuple["Case", dict[str, float]]:
        """Return the case with a candidate taken for known as the first part of the drive estimates it."""
        asked = replace(self, assumptions=replace(self.assumptions, **UNKNOWN[candidate]))
        solution = asked.solve()
        row = solution.fix_row[int(LEARNING * len(solution.fix_row)) - 1]
        found = solution.sensors.iloc[row].to_dict()
        if candidate == "time offset":
            offset = self.assumptions.offset_s + found[OFFSET]
            return replace(self, assumptions=replace(self.assumptions, offset_s=offset)), {OFFSET: offset}
        if candidate == "lever arm":
            arm = tuple(known + found[name] for known, name in zip(self.assumptions.lever_m, LEVER, strict=True))
            known = replace(self.assumptions, lever_m=arm)
            return replace(self, assumptions=known), dict(zip(LEVER, arm, strict=True))
        scale = {axis: found[f"{axis}_scale"] for axis in AXES}
        return replace(self, log=self.log * (1 - pd.Series(scale))), scale


def name(case: Case, alpha: float) -> tuple[list[str], pd.DataFrame]:
    """Name what is hidden from the filter.

    Returns
    -------
    tuple
        Names among :data:`CANDIDATES` in the order in which they were found; and a row for each candidate and round:
        ``round``, ``candidate``, ``gain`` of the log likelihood per fix on the rest of the drive, its standard
        ``error``, ``p``, whether it is ``named``, and the estimates in words.
    """
    names, rows, left = [], [], list(CANDIDATES)
    while left:
        base = case.solve()
        tried = {candidate: case.knowing(candidate) for candidate in left}
        gains = {candidate: _gain(one.solve(), base) for candidate, (one, _) in tried.items()}
        passing = [candidate for candidate in left if gains[candidate][2] < alpha / len(left)]
        best = max(passing, key=lambda candidate: gains[candidate][0], default=None)
        for candidate, (gain, error, p) in gains.items():
            said = ", ".join(f"{key} {value:.3g}" for key, value in tried[candidate][1].items())
            rows.append((len(names) + 1, candidate, gain, error, p, candidate == best, said))
        if best is None:
            break
        names.append(best)
        left.remove(best)
        case = tried[best][0]
    columns = ["round", "candidate", "gain", "error", "p", "named", "estimates"]
    return names, pd.DataFrame(rows, columns=columns)


def whiteness(record: Record) -> Mapping[str, float]:
    """Return how probable innovations like these are for a filter that is right.

    ``mean`` is that of their being zero-mean, ``white`` of their being uncorrelated from fix to fix (Ljung and Box
    1978, over :data:`LAGS` lags, all components together), ``size`` of their being as large as expected, two-sided.
    """
    white = record.whitened[record.freedom == record.freedom.max(), : record.freedom.max()]
    count, components = white.shape
    mean = count * np.sum(white.mean(axis=0) ** 2)
    centred = white - white.mean(axis=0)
    power = np.sum(centred**2, axis=0)
    lags = np.arange(1, LAGS + 1)
    correlations = np.array([np.sum(centred[lag:] * centred[:-lag], axis=0) / power for lag in lags])
    ljung_box = count * (count + 2) * np.sum(correlations**2 / (count - lags)[:, None])
    below = chdtr(white.size, np.sum(white**2))
    return {
        "mean": float(chdtrc(components, mean)),
        "white": float(chdtrc(components * LAGS, ljung_box)),
        "size": float(2 * min(below, 1 - below)),
    }


def _gain(one: Solution, base: Solution) -> tuple[float, float, float]:
    """Return mean gain of the log likelihood per fix behind the learning, its standard error, and its p-value."""
    likelihoods = (
        pd.Series(-0.5 * (solution.record.statistic + solution.record.log_det), index=solution.fix_time)
        for solution in (one, base)
    )
    gains = np.subtract(*likelihoods).dropna().to_numpy()
    gains = gains[int(LEARNING * len(gains)) :]
    mean, error = float(gains.mean()), float(gains.std(ddof=1) / np.sqrt(len(gains)))
    return mean, error, float(ndtr(-mean / error)) if error > 0 else 1.0

"""Diagnosis of a drive by the innovations: whiteness, and candidates for unmodelled errors.

The whitened innovations of a consistent filter are independent and standard normal. If not, one of the
:data:`CANDIDATES` may be the cause: a time offset of the fixes, a lever arm, scale factors. Each is added to the filter
as states, which the first part of the drive estimates; the estimates are then compensated, and the likelihood of the
innovations of the rest of the drive is compared with that without compensation. Of the candidates whose gain per fix is
significant at a level ``alpha`` for all of them together (Bonferroni), the one with the largest gain is named, and the
others are tested again with it compensated. A candidate without effect loses on data that did not estimate it, so that
without a hidden error one is named with probability ``alpha`` at most.

Source: G. M. Ljung, G. E. P. Box, On a measure of lack of fit in time series models, Biometrika 65 (1978) 297-303.
"""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pandas as pd
from scipy.special import chdtr, chdtrc, ndtr

from imugap.filters.innovation_gate import NO_CONTROL, InnovationRecord
from imugap.log import AXES
from imugap.navigation.drive.vehicle import LEVER_ARM, TIME_OFFSET, DriveInputs, DriveSolution, navigate
from imugap.navigation.drive.vehicle_alignment import align

LAGS = 10
"""Number of lags of the whiteness test."""
LEARNING = 0.5
"""Share of the fixes, from the first, that estimate a candidate."""
CANDIDATES = ("time offset", "lever arm", "scale factor")
PRIOR_STD = {
    "time offset": {"time_offset_std": 0.3},
    "lever arm": {"lever_std": 1.0},
    "scale factor": {"scale_std": (0.02, 0.02)},
}
"""Prior standard deviations of the states of a candidate [s], [m], [1]."""


def solve(inputs: DriveInputs) -> DriveSolution:
    """Align and navigate a drive without quality control."""
    inputs = replace(inputs, quality=NO_CONTROL)
    return navigate(inputs, align(inputs))


def compensated(inputs: DriveInputs, candidate: str) -> tuple[DriveInputs, dict[str, float]]:
    """Return the inputs with a candidate compensated by its estimate from the first part of the drive, and that."""
    known = inputs.assumptions
    solution = solve(replace(inputs, assumptions=replace(known, **PRIOR_STD[candidate])))
    row = solution.fix_row[int(LEARNING * len(solution.fix_row)) - 1]
    found = solution.sensors.iloc[row].to_dict()
    if candidate == "time offset":
        offset = known.time_offset_s + found[TIME_OFFSET]
        return replace(inputs, assumptions=replace(known, time_offset_s=offset)), {TIME_OFFSET: offset}
    if candidate == "lever arm":
        arm = tuple(assumed + found[name] for assumed, name in zip(known.lever_m, LEVER_ARM, strict=True))
        return replace(inputs, assumptions=replace(known, lever_m=arm)), dict(zip(LEVER_ARM, arm, strict=True))
    scale = {axis: found[f"{axis}_scale"] for axis in AXES}
    return replace(inputs, log=inputs.log * (1 - pd.Series(scale))), scale


def diagnose(inputs: DriveInputs, alpha: float) -> tuple[list[str], pd.DataFrame]:
    """Name the errors that the filter does not model.

    Returns
    -------
    tuple
        Names among :data:`CANDIDATES`, in the order of detection; and a row for each candidate and round:
        ``round``, ``candidate``, ``gain`` of the log likelihood per fix on the rest of the drive, its standard
        ``error``, ``p``, whether it is ``named``, and the estimates in words.
    """
    names, rows, left = [], [], list(CANDIDATES)
    while left:
        base = solve(inputs)
        tried = {candidate: compensated(inputs, candidate) for candidate in left}
        gains = {candidate: _gain(solve(one), base) for candidate, (one, _) in tried.items()}
        passing = [candidate for candidate in left if gains[candidate][2] < alpha / len(left)]
        best = max(passing, key=lambda candidate: gains[candidate][0], default=None)
        for candidate, (gain, error, p) in gains.items():
            estimates = ", ".join(f"{key} {value:.3g}" for key, value in tried[candidate][1].items())
            rows.append((len(names) + 1, candidate, gain, error, p, candidate == best, estimates))
        if best is None:
            break
        names.append(best)
        left.remove(best)
        inputs = tried[best][0]
    columns = ["round", "candidate", "gain", "error", "p", "named", "estimates"]
    return names, pd.DataFrame(rows, columns=columns)


def whiteness(record: InnovationRecord) -> Mapping[str, float]:
    """Return the p-values of three tests of the whitened innovations.

    ``mean``: zero mean; ``white``: no correlation from fix to fix (Ljung and Box 1978, over :data:`LAGS` lags, all
    components together); ``size``: expected mean square, two-sided.
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


def _gain(one: DriveSolution, base: DriveSolution) -> tuple[float, float, float]:
    """Return the mean log-likelihood gain per fix after the learning part, its standard error, and its p-value."""
    likelihoods = (
        pd.Series(-0.5 * (solution.record.statistic + solution.record.log_det), index=solution.fix_time)
        for solution in (one, base)
    )
    gains = np.subtract(*likelihoods).dropna().to_numpy()
    gains = gains[int(LEARNING * len(gains)) :]
    mean, error = float(gains.mean()), float(gains.std(ddof=1) / np.sqrt(len(gains)))
    return mean, error, float(ndtr(-mean / error)) if error > 0 else 1.0

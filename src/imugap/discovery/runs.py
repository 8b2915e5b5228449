"""Several runs of one device: does its bias differ from run to run, does its sampling clock?"""

from collections.abc import Mapping, Sequence

import numpy as np
from scipy.stats import chi2

from imugap.clock import relative_interval, spectra
from imugap.discovery.axis import AxisFit, offset
from imugap.discovery.finding import Finding, Interval
from imugap.discovery.parameters import NORMAL, axis_unit
from imugap.effects import ClockScale, TurnOnBias
from imugap.log import TIME, from_samples

LEAST = 1e-300


def turn_on(fits: Sequence[Mapping[str, AxisFit]], log_alpha: float) -> tuple[Finding, ...]:
    """Return the axes whose means differ between runs by more than the noise of each run lets them.

    The variance of a mean is that of the lowest cosine coefficient over the number of samples. The scatter of the
    means over it is chi-square distributed with one degree of freedom less than runs.
    """
    axes = [axis for axis in fits[0] if all(axis in one for one in fits)]
    found = (_turn_on(axis, [one[axis] for one in fits], log_alpha) for axis in axes)
    return tuple(finding for finding in found if finding is not None)


def _turn_on(axis: str, runs: Sequence[AxisFit], log_alpha: float) -> Finding | None:
    means = np.array([offset(run.sequence, run.description) for run in runs])
    noise = np.mean([run.variance[0] / len(run.residual) for run in runs])
    squares, free = float(np.sum((means - means.mean()) ** 2)), len(runs) - 1
    log_p = float(chi2.logsf(squares / noise, free))
    if log_p > log_alpha:
        return None
    low, high = (np.sqrt(max(squares / chi2.ppf(share, free) - noise, 0.0)) for share in (0.975, 0.025))
    std = float(np.sqrt(max(squares / free - noise, LEAST)))
    interval = Interval(std, float(low), float(high), axis_unit(axis))
    return Finding({axis: TurnOnBias(std)}, {"std": interval}, log_p)


def clocks(fits: Sequence[Mapping[str, AxisFit]], log_alpha: float) -> tuple[Finding, ...]:
    """Return the runs whose sampling interval differs from that of the first: lines and roll-off have moved."""
    logs = [
        from_samples(
            {axis: fit.sequence.values for axis, fit in one.items()},
            next(iter(one.values())).sequence.conditions.interval,
        )
        for one in fits
    ]
    first, *others = (spectra(log) for log in logs)
    found = []
    for run, other in enumerate(others, start=2):
        clock = relative_interval(first, other)
        known = [one for one in (clock.lines, clock.rolloff) if np.isfinite(one.log_ratio) and one.sd > 0]
        if not known:
            continue
        weights = np.array([one.sd**-2 for one in known])
        mean, sd = np.average([one.log_ratio for one in known], weights=weights), weights.sum() ** -0.5
        log_p = float(chi2.logsf((mean / sd) ** 2, 1) + np.log(len(others)))
        if log_p < log_alpha:
            low, high = (float(np.exp(mean + side * NORMAL * sd)) for side in (-1, 1))
            ratio = float(np.exp(mean))
            found.append(
                Finding({TIME: ClockScale(ratio)}, {f"ratio_run{run}": Interval(ratio, low, high, "1")}, log_p)
            )
    return tuple(found)

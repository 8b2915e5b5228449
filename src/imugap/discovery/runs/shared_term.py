"""Systematic effects that every run of a device repeats: answers to temperature, and to the time since power-on.

Slow noise hides them in one run. Their parameters are those of all runs, fitted to all residuals together, each run
weighted by the inverse of its own spectrum (generalised least squares).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from imugap.discovery.finding import MIN_LOG_P, Finding, Interval, Rival
from imugap.discovery.fit.axis_fit import AxisFit, fit, jacobian
from imugap.discovery.fit.description import Entry
from imugap.discovery.search.intervals import axis_unit
from imugap.discovery.search.search import Trial, entry_of
from imugap.effects.effect import Start
from imugap.numerics.normal_quantile import NORMAL_QUANTILE

MAX_STEPS = 12
"""Maximum number of steps of Gauss and Newton."""
NEAR_LOG_ODDS = 3.0
"""Log-odds, about 20 to 1, within which another effect is given as one that the runs cannot distinguish."""
MIN_STEP_GAIN = 1e-3
"""Gain of log-likelihood below which a step is the last."""


@dataclass(frozen=True, eq=False)
class SharedTerm:
    """Effect that all runs of a device repeat.

    Attributes
    ----------
    entry
        The effect with the values of all runs, and its free parameters.
    covariance
        Covariance of the free parameters, shape (parameters, parameters): the larger of what the spectra give and what
        the scatter of the runs gives (the sandwich of Huber 1967, each run one unit).
    trial
        The likelihood ratio, without the run that gains most.
    rivals
        Other effects in its place.
    """

    entry: Entry
    covariance: np.ndarray
    trial: Trial
    rivals: tuple[Rival, ...] = ()

    @property
    def held(self) -> Entry:
        """Return the effect as an entry whose values stay."""
        return replace(self.entry, free=())

    def finding(self, axis: str) -> Finding:
        """Return the effect on an axis, with its intervals."""
        effect, limits = self.entry.effect, self.entry.effect.limits()
        units = effect.units(axis_unit(axis))
        widths = (NORMAL_QUANTILE * np.sqrt(np.diag(self.covariance))).tolist()
        errors = dict(zip(self.entry.free, widths, strict=True))
        parameters = {}
        for name, value in effect.parameters().items():
            error = errors.get(name, 0.0)
            low, high = np.clip([value - error, value + error], *limits[name]).tolist()
            parameters[name] = Interval(value, low, high, units[name])
        near = tuple((one.name, one.log_bayes_factor) for one in self.rivals if one.log_bayes_factor > -NEAR_LOG_ODDS)
        return Finding(
            {axis: effect},
            parameters,
            max(self.trial.log_p, MIN_LOG_P),
            self.trial.gain,
            alternatives=near,
            rivals=self.rivals,
        )


def fit_to_runs(runs: Sequence[AxisFit], start: Start) -> tuple[Entry, np.ndarray]:
    """Return a proposal with the values at which all runs together are most likely, and their covariance.

    Other terms of each run are free to move; its noise stays.
    """
    entry = entry_of(start)
    rest = _rests(runs, entry)
    for _ in range(MAX_STEPS):
        precision, scores = _normal_equations(runs, entry, rest)
        step, scale = np.linalg.pinv(precision, rcond=1e-12, hermitian=True) @ scores.sum(axis=0), 1.0
        moved = entry.moved(step)
        after = _rests(runs, moved)
        while (gained := 0.5 * (_power(rest) - _power(after))) < 0 and scale > MIN_STEP_GAIN:
            scale /= 3
            moved = entry.moved(scale * step)
            after = _rests(runs, moved)
        if gained <= 0:
            break
        entry, rest = moved, after
        if gained < MIN_STEP_GAIN:
            break
    return entry, _covariance(*_normal_equations(runs, entry, rest))


def _covariance(precision: np.ndarray, scores: np.ndarray) -> np.ndarray:
    """Return the covariance by the information of all runs, and by the scatter of the runs where that is larger."""
    own = np.linalg.pinv(precision, rcond=1e-12, hermitian=True)
    scatter = own @ (np.cov(scores.T, ddof=1).reshape(precision.shape) * len(scores)) @ own
    values, vectors = np.linalg.eigh(scatter - own)
    return own + (vectors * np.maximum(values, 0.0)) @ vectors.T


def with_term(runs: Sequence[AxisFit], entry: Entry) -> tuple[AxisFit, ...]:
    """Return the runs with an effect of given values, the rest of each fitted anew."""
    held = replace(entry, free=())
    return tuple(fit(one.sequence, one.description.adding(held)) for one in runs)


def _rests(runs: Sequence[AxisFit], entry: Entry) -> list[np.ndarray]:
    """Return the whitened residual of each run with an effect, less its own terms, shape (n - 1,)."""
    held = replace(entry, free=())
    left = (replace(one, description=one.description.adding(held)).coefficients for one in runs)
    return [one.beyond(rest[:, None])[:, 0] for one, rest in zip(runs, left, strict=True)]


def _normal_equations(
    runs: Sequence[AxisFit], entry: Entry, rests: Sequence[np.ndarray]
) -> tuple[np.ndarray, np.ndarray]:
    """Return the information of the free parameters, of all runs, and the score of each run, (runs, parameters)."""
    columns = [one.beyond(one.whiten(jacobian([entry], one.sequence))) for one in runs]
    scores = np.array([of_run.T @ rest for of_run, rest in zip(columns, rests, strict=True)])
    return sum(of_run.T @ of_run for of_run in columns), scores


def _power(rests: Sequence[np.ndarray]) -> float:
    return float(sum(rest @ rest for rest in rests))

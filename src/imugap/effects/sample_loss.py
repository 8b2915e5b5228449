"""Lost samples."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pandas as pd
from scipy.special import log_ndtr

from imugap.effects.block import Block, nan
from imugap.effects.conditions import Conditions
from imugap.effects.effect import ClockEffect, Evidence, parameter
from imugap.integrity.report import IMPROBABLE
from imugap.integrity.timestamps import Stamps
from imugap.numerics.random_runs import estimate_from_runs, simulate_runs
from imugap.numerics.runs import runs_of


@dataclass(frozen=True)
class SampleLoss(ClockEffect):
    """Gaps: rows are missing, the stamps of the others are right (:func:`imugap.numerics.random_runs.simulate_runs`).

    Samples that are lost on one axis alone are NaN; the effect is then on that axis.
    """

    name: ClassVar[str] = "sample_loss"
    replaced: ClassVar[bool] = True
    probability: float = parameter("1", "probability that a gap begins at a sample", high=1.0)
    length: float = parameter("1", "mean number of lost samples of a gap", low=1.0)

    def keep(self, log: pd.DataFrame, rng: np.random.Generator) -> pd.DataFrame:
        """Return the rows that are not lost; ValueError if fewer than 2 are left."""
        kept = log[~simulate_runs(len(log), self.probability, self.length, rng)]
        if len(kept) < 2:
            raise ValueError(f"{self.name}: expected at least 2 samples that are left; found {len(kept)}")
        return kept

    def apply(self, sequence: np.ndarray, conditions: Conditions, rng: np.random.Generator) -> np.ndarray:
        """Replace lost samples by NaN."""
        return np.where(simulate_runs(len(sequence), self.probability, self.length, rng), np.nan, sequence)

    def block(self, interval: float, axis: str) -> Block:
        """Return the effect as a step from sample to sample."""
        return Block(_step, {"begin": self.probability, "end": 1 / self.length, "inside": 0.0})

    def check_axis(self, axis: str) -> None:
        """Accept every axis, and the pseudo-axis."""

    @classmethod
    def found(cls, stamps: Stamps) -> Evidence | None:
        """Return the gaps between stamps, or None."""
        if not stamps.even or not stamps.lost.any():
            return None
        spread = np.sqrt(2 * max(stamps.variance, 1e-8 * stamps.interval**2))
        evidence = cls.missing(stamps.lost, float(log_ndtr(-0.5 * stamps.interval / spread)))
        return evidence if evidence.log_p < np.log(IMPROBABLE) else None

    @classmethod
    def missing(cls, lost: np.ndarray, log_p: float = -np.inf) -> Evidence:
        """Estimate the effect from the mask of lost samples, shape (n,), and the log-probability that a gap is none."""
        runs = np.diff(runs_of(lost))[:, 0]
        estimate = estimate_from_runs(runs, max(int(np.count_nonzero(~lost)) - 1, len(runs)))
        intervals = {"probability": estimate.probability[1:], "length": estimate.length[1:]}
        return Evidence(cls(estimate.probability[0], estimate.length[0]), intervals, len(runs) * log_p, lost)


def _step(own, x, now):
    y = nan if own.inside > 0.0 else x
    if own.draw.uniform() < (own.end if own.inside > 0.0 else own.begin):
        own.inside = 1.0 - own.inside
    return y

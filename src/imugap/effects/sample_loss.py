"""Lost samples."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pandas as pd
from scipy.special import log_ndtr

from imugap.effects.block import Block, nan
from imugap.effects.conditions import Conditions, Run
from imugap.effects.effect import ClockEffect, Evidence, Transform, parameter
from imugap.integrity.report import IMPROBABLE
from imugap.integrity.timestamps import Stamps
from imugap.numerics.samples.random_runs import estimate_from_runs, runs_in_parts, simulate_runs
from imugap.numerics.samples.runs import runs_of


@dataclass(frozen=True)
class SampleLoss(ClockEffect):
    """Gaps: rows are missing, the stamps of the others are right.

    The gaps are runs (:func:`imugap.numerics.samples.random_runs.simulate_runs`).

    Samples that are lost on one axis alone are NaN; the effect is then on that axis.
    """

    name: ClassVar[str] = "sample_loss"
    replaced: ClassVar[bool] = True
    probability: float = parameter("1", "probability that a gap begins at a sample", high=1.0)
    length: float = parameter("1", "mean number of lost samples of a gap", low=1.0)

    def keep(self, log: pd.DataFrame, rng: np.random.Generator) -> pd.DataFrame:
        """Return the rows that are not lost; ValueError if fewer than 2 are left."""
        kept = log[~simulate_runs(len(log), self.probability, self.length, rng)]
        self._require_rows(len(kept))
        return kept

    def apply(self, sequence: np.ndarray, conditions: Conditions, rng: np.random.Generator) -> np.ndarray:
        """Replace lost samples by NaN."""
        return np.where(simulate_runs(len(sequence), self.probability, self.length, rng), np.nan, sequence)

    def in_parts(self, run: Run, rng: np.random.Generator) -> Transform:
        """Return a function that does so to one part after the other."""
        following = runs_in_parts(run.count, self.probability, self.length, rng)
        return lambda sequence, conditions: np.where(following(len(sequence)), np.nan, sequence)

    def keep_parts(self, parts: Iterator[pd.DataFrame], count: int, rng: np.random.Generator) -> Iterator[pd.DataFrame]:
        """Yield the rows of each part that are not lost; ValueError if fewer than 2 are left of all."""
        following, left = runs_in_parts(count, self.probability, self.length, rng), 0
        for part in parts:
            kept = part[~following(len(part))]
            left += len(kept)
            yield kept
        self._require_rows(left)

    def block(self, interval: float, axis: str) -> Block:
        """Return the effect as a step from sample to sample."""
        return Block(_step, {"begin": self.probability, "end": 1 / self.length, "inside": 0.0})

    def _require_rows(self, left: int) -> None:
        if left < 2:
            raise ValueError(f"{self.name}: expected at least 2 samples that are left; found {left}")

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

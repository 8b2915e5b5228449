"""The worked example of the tutorial (Farrell et al. 2022, figures 1 and 2): do its printed values follow, and fit?

The printed values are a data frame (``data/published``): columns ``sensor``, ``quantity``, ``value``, ``half_digit``
(half a unit of the last printed digit), ``unit``. Every recomputed value has the range that the digits of what it is
computed from leave.
"""

from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum
from itertools import product

import numpy as np
import pandas as pd
from scipy.optimize import minimize_scalar

from imugap.effects import BiasInstability, GaussMarkov, RandomWalk, WhiteNoise
from imugap.effects.effect import AxisModel
from imugap.study.static.farrell2022 import left, white_and_walk


class Agreement(StrEnum):
    """How a recomputed value compares with the printed one."""

    AGREES = "agrees"
    """It rounds to the printed digits."""
    WITHIN_DIGITS = "within the digits"
    """Some values that round to the printed ones would agree."""
    CONTRADICTS = "contradicts"
    """No values that round to the printed ones agree."""


@dataclass(frozen=True)
class Check:
    """One printed value, recomputed from others: value and range, in the printed unit."""

    quantity: str
    printed: float
    half_digit: float
    unit: str
    recomputed: float
    low: float
    high: float

    @property
    def agreement(self) -> Agreement:
        """Compare the ranges."""
        if abs(self.recomputed - self.printed) <= self.half_digit * (1 + 1e-9):
            return Agreement.AGREES
        overlap = self.low <= self.printed + self.half_digit and self.high >= self.printed - self.half_digit
        return Agreement.WITHIN_DIGITS if overlap else Agreement.CONTRADICTS


def flat_top() -> tuple[float, float]:
    """Return place over T_B and height over sqrt(S_B T_B) of the top of the Gauss-Markov Allan deviation (eq. 37)."""
    unit = GaussMarkov(1.0, 1.0)
    top = minimize_scalar(lambda tau: -unit.allan_variance(tau), bounds=(0.5, 5.0), method="bounded")
    return float(top.x), float(np.sqrt(-top.fun / unit.driving_psd))


def floor_gain() -> float:
    """Return the Allan deviation of flicker noise over B (eq. 32)."""
    return float(np.sqrt(BiasInstability(1.0).allan_variance(1.0)))


def markov(driving_psd: float, time: float) -> GaussMarkov:
    """Return the Gauss-Markov process of S_B and T_B (eqs. 33-35)."""
    return GaussMarkov(float(np.sqrt(driving_psd * time / 2)), time)


@dataclass(frozen=True)
class PrintedExample:
    """The printed values by sensor and quantity."""

    table: pd.DataFrame

    @classmethod
    def of(cls, printed: pd.DataFrame) -> "PrintedExample":
        """Take the printed table."""
        return cls(printed.set_index(["sensor", "quantity"]))

    def __call__(self, sensor: str, *quantities: str) -> list[float]:
        """Return printed values of a sensor."""
        return [float(self.table.loc[(sensor, quantity), "value"]) for quantity in quantities]

    def ranges(self, sensor: str, *quantities: str) -> list[tuple[float, float]]:
        """Return the ranges that the digits of printed values leave."""
        rows = [self.table.loc[(sensor, quantity)] for quantity in quantities]
        return [(row["value"] - row["half_digit"], row["value"] + row["half_digit"]) for row in rows]

    def check(self, title: str, key: tuple[str, str], function: Callable, *inputs: str) -> Check:
        """Recompute the printed value ``key`` as a function, monotonic in each, of other values of its sensor."""
        row = self.table.loc[key]
        corners = [function(*corner) for corner in product(*self.ranges(key[0], *inputs))]
        value = function(*self(key[0], *inputs))
        return Check(title, row["value"], row["half_digit"], row["unit"], value, min(corners), max(corners))

    def digits(self, tau: np.ndarray) -> pd.DataFrame:
        """Return the lowest and the highest Allan deviation of N and K within their digits, index ``tau`` [s]."""
        corners = [
            WhiteNoise(white) + RandomWalk(walk)
            for white, walk in zip(*self.ranges("accelerometer", "N", "K"), strict=True)
        ]
        low, high = (np.sqrt(model.allan_variance(tau)) for model in corners)
        return pd.DataFrame({"low": low, "high": high}, index=tau)

    def white_and_walk(self) -> AxisModel:
        """Return N + K (eqs. 28-30)."""
        white, walk = self("accelerometer", "N", "K")
        return WhiteNoise(white) + RandomWalk(walk)

    def model(self) -> AxisModel:
        """Return N + B + K with one Gauss-Markov state as the tutorial reads it: the whole floor is given to B."""
        return self.white_and_walk() + markov(*self("accelerometer", "S_B", "T_B"))

    def freed(self) -> AxisModel:
        """Return N + B + K with the most that the printed digits leave for B: N and K are as small as they may be."""
        (time,), ((white, _), (walk, _)) = self("accelerometer", "T_B"), self.ranges("accelerometer", "N", "K")
        driving = (self.most_left() / flat_top()[1]) ** 2 / time
        return WhiteNoise(white) + RandomWalk(walk) + markov(driving, time)

    def most_left(self) -> float:
        """Return the largest floor without N and K within the printed digits."""
        corners = product(*self.ranges("accelerometer", "floor", "N", "K", "floor_tau"))
        return max(left(*corner) for corner in corners)


def checks(printed: pd.DataFrame) -> list[Check]:
    """Return every printed value that others determine, recomputed."""
    example = PrintedExample.of(printed)
    place, height = flat_top()
    gain, sensor = floor_gain(), "accelerometer"
    return [
        example.check("place of the flat top over T_B (eq. 37)", ("Gauss-Markov", "flat_top_place"), lambda: place),
        example.check("its height over √(S_B T_B) (eq. 37)", ("Gauss-Markov", "flat_top_height"), lambda: height),
        example.check("flicker floor over B (eq. 32)", ("flicker", "floor_gain"), lambda: gain),
        *(
            example.check(f"B of {name}: floor over 0.664", (name, "B"), lambda floor: floor / gain, "floor")
            for name in (sensor, "gyroscope a", "gyroscope b")
        ),
        example.check("T_B: place of the floor over 1.89", (sensor, "T_B"), lambda tau: tau / place, "floor_tau"),
        example.check(
            "S_B: flat top at the floor (eq. 37)",
            (sensor, "S_B"),
            lambda floor, time: (floor / height) ** 2 / time,
            "floor",
            "T_B",
        ),
        example.check(
            "floor from S_B and T_B (eq. 37)",
            (sensor, "floor"),
            lambda driving, time: height * np.sqrt(driving * time),
            "S_B",
            "T_B",
        ),
        example.check(
            "floor: N and K alone at its place (eq. 30)", (sensor, "floor"), white_and_walk, "N", "K", "floor_tau"
        ),
        example.check(
            "place of the floor: that of N and K, √3 N/K",
            (sensor, "floor_tau"),
            lambda white, walk: np.sqrt(3) * white / walk,
            "N",
            "K",
        ),
        example.check(
            "B: what N and K leave of the floor, over 0.664",
            (sensor, "B"),
            lambda floor, white, walk, tau: left(floor, white, walk, tau) / gain,
            "floor",
            "N",
            "K",
            "floor_tau",
        ),
        example.check(
            "S_B: what N and K leave of the floor",
            (sensor, "S_B"),
            lambda floor, white, walk, tau, time: (left(floor, white, walk, tau) / height) ** 2 / time,
            "floor",
            "N",
            "K",
            "floor_tau",
            "T_B",
        ),
        example.check(
            "floor: N, K and the B that was read on it, together",
            (sensor, "floor"),
            lambda white, walk, driving, time, tau: float(
                np.hypot(white_and_walk(white, walk, tau), np.sqrt(markov(driving, time).allan_variance(tau)))
            ),
            "N",
            "K",
            "S_B",
            "T_B",
            "floor_tau",
        ),
    ]

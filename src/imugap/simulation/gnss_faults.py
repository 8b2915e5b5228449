"""Gross errors of fixes, drawn from a recipe: isolated outliers, biased stretches, slow ramps, and outages.

Outliers and stretches shift the position by one vector, of a log-uniform horizontal size and a uniform direction, and
by at most half that size up or down. The velocity of each such fix has an error of its own, in proportion to the shift.
A ramp moves the position at a constant rate and leaves the velocity correct. An outage removes the fixes. Events that
last keep a distance from all others.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
import yaml

from imugap.io import gnss
from imugap.io.gnss import PLACE_STD, VELOCITY_STD
from imugap.kinematics.strapdown import Ellipsoid
from imugap.stream import stream

OUTLIER, STRETCH, RAMP, OUTAGE = "outlier", "stretch", "ramp", "outage"
NO_INFORMATION_STD = 1e5
"""Standard deviation of a position without information [m]."""
TRIES = 10_000
"""Largest number of draws of a free time for an event."""


@dataclass(frozen=True)
class FaultRange:
    """Number of events of a kind, and limits of their size and duration."""

    number: int
    size: tuple[float, float] = (1.0, 1.0)
    duration_s: tuple[float, float] = (0.0, 0.0)


@dataclass(frozen=True)
class FaultEvent:
    """A gross error: its kind, begin and end [s], and the shift [m], or its rate [m/s], north, east, down."""

    kind: str
    begin: float
    end: float
    shift: tuple[float, float, float]


@dataclass(frozen=True)
class Faults:
    """A recipe of gross errors.

    Attributes
    ----------
    begin_s
        Time before the first event [s].
    gap_s
        Shortest time between two events that last [s].
    velocity_per_s
        Gross error of the velocity over that of the position [1/s].
    outliers, stretches, ramps, outages
        Events of each kind; sizes in metres, of ramps in metres per second.
    """

    begin_s: float
    gap_s: float
    velocity_per_s: float
    outliers: FaultRange
    stretches: FaultRange
    ramps: FaultRange
    outages: FaultRange

    @classmethod
    def read(cls, path: str | Path) -> "Faults":
        """Read the part ``faults`` of a recipe (YAML)."""
        try:
            given = yaml.safe_load(Path(path).read_text())["faults"]
            ranges = {
                name: FaultRange(
                    given[name]["number"],
                    tuple(given[name].get(size, (1.0, 1.0))),
                    tuple(given[name].get("duration_s", (0.0, 0.0))),
                )
                for name, size in (
                    ("outliers", "size_m"), ("stretches", "size_m"), ("ramps", "rate_m_per_s"), ("outages", "size_m"),
                )
            }  # fmt: skip
            return cls(**({name: given[name] for name in ("begin_s", "gap_s", "velocity_per_s")} | ranges))
        except (KeyError, TypeError, ValueError) as error:
            raise ValueError(f"{path}: expected a recipe with faults; found {error}") from error

    def draw(self, time: np.ndarray, seed: int, *labels: object) -> tuple[FaultEvent, ...]:
        """Draw the events of fixes at ``time`` [s], in the order of their begin."""
        rng, lasting = stream(seed, "faults", *labels), []
        for kind, given in ((STRETCH, self.stretches), (RAMP, self.ramps), (OUTAGE, self.outages)):
            for _ in range(given.number):
                duration = rng.uniform(*given.duration_s)
                begin = self._place(time, duration, lasting, rng)
                lasting.append(FaultEvent(kind, begin, begin + duration, _shift(given, rng)))
        alone = [
            t for t in time if t > self.begin_s and all(not one.begin - 2 < t < one.end + self.gap_s for one in lasting)
        ]
        chosen = rng.choice(alone, min(self.outliers.number, len(alone)), replace=False)
        isolated = [FaultEvent(OUTLIER, float(t), float(t), _shift(self.outliers, rng)) for t in chosen]
        return tuple(sorted((*lasting, *isolated), key=lambda one: one.begin))

    def first(self, seed: int, *labels: object) -> FaultEvent:
        """Draw a stretch from the beginning until a drawn duration after ``begin_s``."""
        rng = stream(seed, "faults", *labels, "first")
        return FaultEvent(
            STRETCH, 0.0, self.begin_s + rng.uniform(*self.stretches.duration_s), _shift(self.stretches, rng)
        )

    def _place(self, time: np.ndarray, duration: float, others: list[FaultEvent], rng: np.random.Generator) -> float:
        for _ in range(TRIES):
            begin = rng.uniform(self.begin_s, max(time[-1] - duration - self.gap_s, self.begin_s))
            if all(begin > one.end + self.gap_s or begin + duration < one.begin - self.gap_s for one in others):
                return float(begin)
        raise ValueError(f"faults: expected room for events of {duration:.3g} s, {self.gap_s:g} s apart; found none")

    def apply(
        self, fixes: pd.DataFrame, events: tuple[FaultEvent, ...], ellipsoid: Ellipsoid, seed: int, *labels: object
    ) -> pd.DataFrame:
        """Return the fixes with the gross errors, without those in an outage."""
        measured, kinds = gnss.local(fixes, ellipsoid), event_kinds(fixes.index.to_numpy(), events)
        wild = stream(seed, "faults", *labels, "velocity").standard_normal((len(fixes), 3)) / np.sqrt(3)
        for one in events:
            inside = _inside(fixes.index.to_numpy(), one)
            shift = np.array(one.shift)
            if one.kind == RAMP:
                measured[inside, :3] += (fixes.index.to_numpy()[inside] - one.begin)[:, None] * shift
            elif one.kind != OUTAGE:
                measured[inside, :3] += shift
                measured[inside, 3:] += self.velocity_per_s * np.linalg.norm(shift) * wild[inside]
        std = gnss.deviations(fixes, (1.0, 1.0, 1.0), (1.0, 1.0, 1.0))
        return gnss.from_local(fixes.index.to_numpy(), measured, std, ellipsoid)[kinds != OUTAGE]

    def with_true_deviations(self, spoilt: pd.DataFrame, events: tuple[FaultEvent, ...]) -> pd.DataFrame:
        """Return contaminated fixes with standard deviations that include the gross errors, as an oracle knows them."""
        known, time = spoilt.copy(), spoilt.index.to_numpy()
        for one in (one for one in events if one.kind != OUTAGE):
            inside = _inside(time, one)
            known.loc[inside, list(PLACE_STD)] = NO_INFORMATION_STD
            if one.kind != RAMP:
                wild = self.velocity_per_s * np.linalg.norm(one.shift) / np.sqrt(3)
                known.loc[inside, list(VELOCITY_STD)] = np.hypot(known.loc[inside, list(VELOCITY_STD)], wild)
        return known


def event_kinds(time: np.ndarray, events: tuple[FaultEvent, ...]) -> np.ndarray:
    """Return the kind of the event at each time [s], or an empty text, shape (n,)."""
    kinds = np.full(len(time), "", dtype=object)
    for one in events:
        kinds[_inside(time, one)] = one.kind
    return kinds


def _inside(time: np.ndarray, event: FaultEvent) -> np.ndarray:
    return (time >= event.begin - 1e-6) & (time <= event.end + 1e-6)


def _shift(given: FaultRange, rng: np.random.Generator) -> tuple[float, float, float]:
    size = np.exp(rng.uniform(*np.log(given.size)))
    angle, rise = rng.uniform(0, 2 * np.pi), rng.uniform(-0.5, 0.5)
    return float(size * np.cos(angle)), float(size * np.sin(angle)), float(size * rise)

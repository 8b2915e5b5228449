"""Plan the cases of a benchmark: bases, lengths, effects and sizes drawn from a seed, in random order."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np

from imu_benchmark.sealing.hidden_effect import log_uniform
from imu_benchmark.sealing.motion import MOTIONS
from imu_benchmark.sealing.vocabulary import ALL, NAMED, UNNAMED
from imu_benchmark.stream import stream

BASES = ("white", "flicker", "walk")


class CaseKind(StrEnum):
    """Kind of a case: number and kind of its hidden effects."""

    SINGLE = "single"
    PAIR = "pair"
    TRIPLE = "triple"
    NOTHING = "nothing"
    UNKNOWN = "unknown"


@dataclass(frozen=True)
class PlannedEffect:
    """An effect to hide: its name, and its size in detection limits."""

    name: str
    size: float


@dataclass(frozen=True)
class BlindCase:
    """A planned case; name and seed label its random streams.

    Attributes
    ----------
    name, seed
        Opaque name; seed of the plan.
    kind, effects
        Hidden effects; with ``same_axis`` the second effect of a pair acts on the axis of the first.
    base, motion
        Kind of base device; name of the motion, or ``rest``.
    rate_hz, duration_s, runs
        Rate, length and number of the logs.
    temperature
        Whether the logs have a temperature column.
    """

    name: str
    seed: int
    kind: CaseKind
    effects: tuple[PlannedEffect, ...]
    same_axis: bool
    base: str
    motion: str
    rate_hz: float
    duration_s: float
    runs: int
    temperature: bool


def plan(seed: int, cases: int, recipe: Mapping) -> list[BlindCase]:
    """Return ``cases`` cases whose kinds have the shares of the recipe."""
    rng = stream(seed, "seal", "plan")
    drawn = [
        _case(seed, CaseKind(kind), effects, recipe, stream(seed, "seal", "plan", kind, number))
        for kind, count in _counts(cases, recipe["shares"]).items()
        for number, effects in zip(range(count), _effects(CaseKind(kind), recipe, seed), strict=False)
    ]
    return [replace(drawn[old], name=f"c{new:04}") for new, old in enumerate(rng.permutation(cases), start=1)]


def _counts(cases: int, shares: Mapping[str, float]) -> dict[str, int]:
    """Return whole numbers of cases that differ from the shares by less than one each."""
    edges = np.rint(cases * np.cumsum(list(shares.values())) / sum(shares.values())).astype(int)
    return dict(zip(shares, np.diff(edges, prepend=0).tolist(), strict=True))


def _effects(kind: CaseKind, recipe: Mapping, seed: int) -> Iterator[tuple[PlannedEffect, ...]]:
    """Yield the effects of one case after another, without end."""
    rng = stream(seed, "seal", "effects", kind)
    if kind is CaseKind.NOTHING:
        while True:
            yield ()
    if kind is CaseKind.PAIR:
        yield from _pairs(recipe, rng)
    if kind is CaseKind.TRIPLE:
        while True:
            yield _clear(_any_names(rng, 3), recipe, rng)
    yield from _singles(list(NAMED if kind is CaseKind.SINGLE else UNNAMED), recipe["sizes"], rng)


def _singles(names: list[str], sizes: list[float], rng: np.random.Generator) -> Iterator[tuple[PlannedEffect, ...]]:
    """Yield every name once at some size, then every name at another size, and so on."""
    first = rng.integers(len(sizes), size=len(names))
    turn = 0
    while True:
        for number in rng.permutation(len(names)):
            yield (PlannedEffect(names[number], sizes[(first[number] + turn) % len(sizes)]),)
        turn += 1


def _pairs(recipe: Mapping, rng: np.random.Generator) -> Iterator[tuple[PlannedEffect, ...]]:
    """Yield alternately a confusable pair and a pair of any two names."""
    while True:
        for number in rng.permutation(len(recipe["confusable"])):
            yield _clear(recipe["confusable"][number], recipe, rng)
            yield _clear(_any_names(rng, 2), recipe, rng)


def _clear(names: Sequence[str], recipe: Mapping, rng: np.random.Generator) -> tuple[PlannedEffect, ...]:
    """Draw a size for each effect of a pair or a triple."""
    return tuple(PlannedEffect(name, float(rng.choice(recipe["pair_sizes"]))) for name in names)


def _any_names(rng: np.random.Generator, count: int) -> tuple[str, ...]:
    """Draw ``count`` names of effects that one device can have."""
    while True:
        names = tuple(map(str, rng.choice(list(NAMED), count, replace=False)))
        if _bases(names) and len({(NAMED[name].needs_motion, NAMED[name].runs) for name in names}) == 1:
            return names


def _bases(names: tuple[str, ...]) -> list[str]:
    """Return the base devices from whose noise all of ``names`` can be distinguished."""
    every = [*BASES, "quantization", "line"]
    return [base for base in every if all(base in ALL[name].bases for name in names)]


def _case(
    seed: int, kind: CaseKind, effects: tuple[PlannedEffect, ...], recipe: Mapping, rng: np.random.Generator
) -> BlindCase:
    """Draw base device, motion and log of a case; without effects they are drawn as for a random effect."""
    names = tuple(effect.name for effect in effects) or (str(rng.choice(list(NAMED))),)
    bases = _bases(names)
    weights = np.array([recipe["bases"][base] for base in bases])
    moving = any(ALL[name].needs_motion for name in names)
    span = recipe["motion_duration_s" if moving else "duration_s"]
    needed = any(ALL[name].needs_temperature for name in names)
    return BlindCase(
        name="",
        seed=seed,
        kind=kind,
        effects=effects,
        same_axis=sorted(names) in map(sorted, recipe["confusable"]),
        base=str(rng.choice(bases, p=weights / weights.sum())),
        motion=str(rng.choice(list(MOTIONS))) if moving else "rest",
        rate_hz=float(rng.choice(recipe["rates_hz"])),
        duration_s=round(log_uniform(rng, span)),
        runs=max(ALL[name].runs for name in names),
        temperature=needed or bool(rng.random() < recipe["temperature_share"]),
    )

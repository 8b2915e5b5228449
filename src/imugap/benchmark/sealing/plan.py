"""Which cases there are: a seeded plan of bases, lengths, effects and sizes, in an order that tells nothing."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np

from imugap.benchmark.sealing.catalogue import EVERY, NAMED, UNNAMED
from imugap.benchmark.sealing.hidden_effect import between
from imugap.benchmark.sealing.motion import MOTIONS
from imugap.stream import stream

BASES = ("white", "flicker", "walk")


class Hides(StrEnum):
    """What a case hides."""

    SINGLE = "single"
    PAIR = "pair"
    NOTHING = "nothing"
    UNKNOWN = "unknown"


@dataclass(frozen=True)
class Planned:
    """An effect to hide: its name, and its size in multiples of its detection limit."""

    name: str
    size: float


@dataclass(frozen=True)
class Case:
    """A case to seal; its name and seed are those of its random streams.

    Attributes
    ----------
    name, seed
        Opaque name; seed of the plan.
    kind, effects
        What is hidden; ``same_axis`` where the second effect of a pair hides on the axis of the first.
    base, motion
        Kind of base device; ``rest`` or the motion.
    rate_hz, duration_s, runs
        Rate, length and number of the logs.
    temperature
        Whether the logs have a column of it.
    """

    name: str
    seed: int
    kind: Hides
    effects: tuple[Planned, ...]
    same_axis: bool
    base: str
    motion: str
    rate_hz: float
    duration_s: float
    runs: int
    temperature: bool


def plan(seed: int, cases: int, shares: Mapping[str, float], recipe: Mapping) -> list[Case]:
    """Return ``cases`` cases whose kinds have the ``shares`` (of :class:`Hides`, together one)."""
    rng = stream(seed, "seal", "plan")
    drawn = [
        _case(seed, Hides(kind), effects, recipe, stream(seed, "seal", "plan", kind, number))
        for kind, count in _counts(cases, shares).items()
        for number, effects in zip(range(count), _effects(Hides(kind), recipe, seed), strict=False)
    ]
    return [replace(drawn[old], name=f"c{new:04}") for new, old in enumerate(rng.permutation(cases), start=1)]


def _counts(cases: int, shares: Mapping[str, float]) -> dict[str, int]:
    """Return whole numbers of cases that differ from the shares by less than one each."""
    edges = np.rint(cases * np.cumsum(list(shares.values())) / sum(shares.values())).astype(int)
    return dict(zip(shares, np.diff(edges, prepend=0).tolist(), strict=True))


def _effects(kind: Hides, recipe: Mapping, seed: int) -> Iterator[tuple[Planned, ...]]:
    """Yield what to hide in one case after another, without an end."""
    rng = stream(seed, "seal", "effects", kind)
    if kind is Hides.NOTHING:
        while True:
            yield ()
    if kind is Hides.PAIR:
        yield from _pairs(recipe, rng)
    yield from _singles(list(NAMED if kind is Hides.SINGLE else UNNAMED), recipe["sizes"], rng)


def _singles(names: list[str], sizes: list[float], rng: np.random.Generator) -> Iterator[tuple[Planned, ...]]:
    """Yield every name once at some size, then every name at another; after all sizes, again."""
    first = rng.integers(len(sizes), size=len(names))
    turn = 0
    while True:
        for number in rng.permutation(len(names)):
            yield (Planned(names[number], sizes[(first[number] + turn) % len(sizes)]),)
        turn += 1


def _pairs(recipe: Mapping, rng: np.random.Generator) -> Iterator[tuple[Planned, ...]]:
    """Yield a confusable pair and a pair of any two names by turns."""
    while True:
        for number in rng.permutation(len(recipe["confusable"])):
            yield tuple(Planned(name, float(rng.choice(recipe["pair_sizes"]))) for name in recipe["confusable"][number])
            yield tuple(Planned(name, float(rng.choice(recipe["pair_sizes"]))) for name in _any_two(rng))


def _any_two(rng: np.random.Generator) -> tuple[str, str]:
    """Draw two names that a device can have at once."""
    while True:
        one, other = map(str, rng.choice(list(NAMED), 2, replace=False))
        if _bases((one, other)) and NAMED[one].motion == NAMED[other].motion and NAMED[one].runs == NAMED[other].runs:
            return one, other


def _bases(names: tuple[str, ...]) -> list[str]:
    """Return the base devices on which all of ``names`` can hide."""
    every = [*BASES, "quantization", "line"]
    return [base for base in every if all(base in EVERY[name].bases for name in names)]


def _case(seed: int, kind: Hides, effects: tuple[Planned, ...], recipe: Mapping, rng: np.random.Generator) -> Case:
    """Draw the surroundings of ``effects``; those of a case without any are those of other cases."""
    names = tuple(effect.name for effect in effects) or (str(rng.choice(list(NAMED))),)
    bases = _bases(names)
    weights = np.array([recipe["bases"][base] for base in bases])
    moving = any(EVERY[name].motion for name in names)
    span = recipe["motion_duration_s" if moving else "duration_s"]
    needed = any(EVERY[name].needs_temperature for name in names)
    return Case(
        name="",
        seed=seed,
        kind=kind,
        effects=effects,
        same_axis=sorted(names) in map(sorted, recipe["confusable"]),
        base=str(rng.choice(bases, p=weights / weights.sum())),
        motion=str(rng.choice(list(MOTIONS))) if moving else "rest",
        rate_hz=float(rng.choice(recipe["rates_hz"])),
        duration_s=round(between(rng, span)),
        runs=max(EVERY[name].runs for name in names),
        temperature=needed or bool(rng.random() < recipe["temperature_share"]),
    )

"""Options of the IMU of Genesis, in a script in Python or as a mapping."""

from collections.abc import Mapping
from math import sqrt

from imugap.effects import Bias, RandomWalk, Resolution, WhiteNoise
from imugap.interchange.conventions import GENESIS
from imugap.interchange.start_models.document import Document
from imugap.interchange.start_models.reading import (
    Key,
    Reader,
    Reading,
    level,
    model_of,
    numbers,
    per_sample,
    require_rate,
    walk_density,
)
from imugap.log import TRIADS

PREFIXES = {"gyro": "gyro", "accel": "acc"}
NOISES = tuple(f"{prefix}_{name}" for prefix in PREFIXES.values() for name in ("noise", "random_walk"))
"""Keys of which a file of Genesis has one at least."""
NOT_TAKEN = (
    "acc_axes_skew", "gyro_axes_skew", "acc_cross_axis_coupling", "gyro_cross_axis_coupling", "delay", "jitter",
)  # fmt: skip
"""Keys that the model does not take."""


def _options(document: Document) -> list[Mapping]:
    """Return the options of all IMUs of a document."""
    every = document if isinstance(document, tuple) else [document] if isinstance(document, Mapping) else []
    return [one for one in every if any(name in one for name in NOISES)]


def _read(document: Document, rate: float | None) -> Reading:
    found = _options(document)
    if any(one != found[0] for one in found[1:]):
        raise ValueError(f"{NOISES[0]}: expected options of one IMU, or several alike; found {len(found)} that differ")
    own, axes, keys, root = found[0], {}, {}, sqrt(require_rate(rate, NOISES[0]))
    for kind, prefix in PREFIXES.items():
        names = [f"{prefix}_{name}" for name in ("noise", "random_walk", "bias", "resolution")]
        values = [numbers(own, name, 3, 0.0) for name in names]
        for axis, white, walk, bias, step in zip(TRIADS[kind], *values, strict=True):
            rounded = (Resolution(step),) if step else ()
            axes[axis] = (Bias(bias), WhiteNoise(white / root), RandomWalk(walk * root), *rounded)
        keys[kind] = _keys(names, rate)
    left = [name for name in NOT_TAKEN if own.get(name)]
    remarks = (f"taken as numbers per step at {rate:g} Hz",)
    return Reading(model_of(axes), (*remarks, *((f"not in the model: {', '.join(left)}",) if left else ())), keys)


def _keys(names: list[str], rate: float) -> tuple[Key, ...]:
    """Return the keys of one sensor."""
    noise, walk, bias, resolution = names
    return (
        Key.of(GENESIS, noise, WhiteNoise, per_sample(rate)),
        Key.of(GENESIS, walk, RandomWalk, lambda effect: walk_density(effect) / sqrt(rate)),
        Key.of(GENESIS, bias, Bias, level),
        Key(resolution, GENESIS.unit(bias), Resolution, lambda effect: effect.step),
    )


READER = Reader("Genesis", GENESIS, lambda document: bool(_options(document)), _read)

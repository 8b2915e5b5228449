"""Configuration of VINS-Mono and VINS-Fusion."""

from collections.abc import Mapping
from math import sqrt

from imugap.effects import RandomWalk, WhiteNoise
from imugap.interchange.conventions import VINS
from imugap.interchange.start_models.document import Document
from imugap.interchange.start_models.reading import (
    Key,
    Reader,
    Reading,
    model_of,
    number,
    per_sample,
    require_rate,
    walk_density,
)
from imugap.log import TRIADS

KEYS = ("gyr_n", "gyr_w", "acc_n", "acc_w")


def _recognises(document: Document) -> bool:
    return isinstance(document, Mapping) and all(key in document for key in KEYS)


def _read(document: Document, rate: float | None) -> Reading:
    root = sqrt(require_rate(rate, "gyr_n"))
    axes, keys = {}, {}
    for kind, name in (("gyro", "gyr"), ("accel", "acc")):
        white = number(document, f"{name}_n") / (root * sqrt(2))
        axes |= dict.fromkeys(TRIADS[kind], (WhiteNoise(white), RandomWalk(number(document, f"{name}_w") / root)))
        keys[kind] = (
            Key.of(VINS, f"{name}_n", WhiteNoise, per_sample(2 * rate)),
            Key.of(VINS, f"{name}_w", RandomWalk, lambda walk: walk_density(walk) * root),
        )
    return Reading(model_of(axes), (f"taken as numbers per sample at {rate:g} Hz",), keys)


READER = Reader("VINS", VINS, _recognises, _read)

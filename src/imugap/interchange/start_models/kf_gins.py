"""Configuration of KF-GINS."""

from collections.abc import Mapping

import numpy as np

from imugap.effects import Bias, GaussMarkov, ScaleFactor, TurnOnBias, WhiteNoise
from imugap.interchange.conventions import KF_GINS
from imugap.interchange.start_models.document import Document
from imugap.interchange.start_models.reading import (
    Key,
    Reader,
    Reading,
    correlation_time,
    in_si,
    model_of,
    number,
    numbers,
)
from imugap.interchange.start_models.reading import density as of_density
from imugap.interchange.start_models.reading import level as level_of
from imugap.interchange.start_models.reading import std as of_std
from imugap.log import TRIADS
from imugap.units import to_si

KEYS = {
    "gyro": ("arw", "gbstd", "initbgstd", "initgyrbias", "initgyrscale", "gsstd"),
    "accel": ("vrw", "abstd", "initbastd", "initaccbias", "initaccscale", "asstd"),
}
"""White noise, bias, its standard deviation at the start, the bias there, scale factor error, and its deviation."""


def _recognises(document: Document) -> bool:
    noise = document.get("imunoise") if isinstance(document, Mapping) else None
    return isinstance(noise, Mapping) and "arw" in noise and "vrw" in noise


def _read(document: Document, rate: float | None) -> Reading:
    noise, axes, remarks, keys = document["imunoise"], {}, [], {}
    time = in_si(KF_GINS, "corrtime", number(noise, "corrtime"))
    if time <= 0:
        raise ValueError(f"corrtime: expected a number > 0; found {time:g}")
    for kind, (white, slow, start, bias, scale, scale_std) in KEYS.items():
        keys[kind] = (
            Key.of(KF_GINS, white, WhiteNoise, of_density), Key.of(KF_GINS, slow, GaussMarkov, of_std),
            Key.of(KF_GINS, "corrtime", GaussMarkov, correlation_time), Key.of(KF_GINS, bias, Bias, level_of),
            Key(scale, "ppm", ScaleFactor, lambda one: one.error),
        )  # fmt: skip
        density = in_si(KF_GINS, white, numbers(noise, white, 3))
        std = in_si(KF_GINS, slow, numbers(noise, slow, 3))
        first = in_si(KF_GINS, start, numbers(document, start, 3)) if start in document else std
        level = in_si(KF_GINS, bias, numbers(document, bias, 3, 0.0))
        error = to_si(numbers(document, scale, 3, 0.0), "ppm")
        turn_on = np.sqrt(np.maximum(first**2 - std**2, 0.0))
        for k, axis in enumerate(TRIADS[kind]):
            axes[axis] = (
                Bias(level[k]), TurnOnBias(turn_on[k]), WhiteNoise(density[k]), GaussMarkov(std[k], time),
                ScaleFactor(error[k]),
            )  # fmt: skip
        if numbers(noise, scale_std, 3, 0.0).any():
            remarks.append(f"not in the model: {scale_std}, the spread of a scale factor error")
    return Reading(model_of(axes), tuple(remarks), keys)


READER = Reader("KF-GINS", KF_GINS, _recognises, _read)

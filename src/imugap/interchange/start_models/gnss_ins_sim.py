"""Dictionary of IMU errors of gnss-ins-sim, in a script in Python or as a mapping."""

from collections.abc import Mapping
from math import isinf, sqrt

from imugap.effects import Bias, GaussMarkov, WhiteNoise
from imugap.effects.effect import Effect
from imugap.interchange.conventions import GNSS_INS_SIM
from imugap.interchange.start_models.document import Document
from imugap.interchange.start_models.reading import (
    Key,
    Reader,
    Reading,
    correlation_time,
    in_si,
    model_of,
    numbers,
    require_rate,
)
from imugap.interchange.start_models.reading import density as of_density
from imugap.interchange.start_models.reading import level as level_of
from imugap.interchange.start_models.reading import std as of_std
from imugap.log import TRIADS

WHITE = {"gyro": "gyro_arw", "accel": "accel_vrw"}
KEYS = ("gyro_b", "gyro_arw", "gyro_b_stability", "accel_b", "accel_vrw", "accel_b_stability")
"""Keys that the simulator requires."""


def _errors(document: Document) -> list[Mapping]:
    """Return the dictionaries of IMU errors of a document."""
    every = document if isinstance(document, tuple) else [document] if isinstance(document, Mapping) else []
    return [one for one in every if all(key in one for key in KEYS)]


def _read(document: Document, rate: float | None) -> Reading:
    found = _errors(document)
    if len(found) > 1:
        raise ValueError(f"gyro_arw: expected one dictionary of IMU errors; found {len(found)}")
    own, axes, remarks, keys = found[0], {}, [], {}
    for kind, white in WHITE.items():
        keys[kind] = (
            Key.of(GNSS_INS_SIM, white, WhiteNoise, of_density),
            Key.of(GNSS_INS_SIM, f"{kind}_b", Bias, level_of),
            Key.of(GNSS_INS_SIM, f"{kind}_b_stability", GaussMarkov, of_std),
            Key.of(GNSS_INS_SIM, f"{kind}_b_corr", GaussMarkov, correlation_time),
        )
        density = in_si(GNSS_INS_SIM, white, numbers(own, white, 3))
        level = in_si(GNSS_INS_SIM, f"{kind}_b", numbers(own, f"{kind}_b", 3))
        std = in_si(GNSS_INS_SIM, f"{kind}_b_stability", numbers(own, f"{kind}_b_stability", 3))
        time = numbers(own, f"{kind}_b_corr", 3, float("inf"))
        for k, axis in enumerate(TRIADS[kind]):
            axes[axis] = Bias(level[k]), WhiteNoise(density[k]), _drift(kind, float(std[k]), float(time[k]), rate)
        if any(isinf(one) and size for one, size in zip(time, std, strict=True)):
            remarks.append(
                f"{kind}_b_corr is infinite: gnss-ins-sim draws white noise of {kind}_b_stability per sample"
            )
    left = [name for name in own if name.startswith("mag_")]
    remarks += [f"not in the model: {', '.join(left)}"] if left else []
    return Reading(model_of(axes), tuple(remarks), keys)


def _drift(kind: str, std: float, time: float, rate: float | None) -> Effect:
    """Return the drift of a bias: a Gauss-Markov process, or white noise where its correlation time is infinite."""
    if isinf(time) and std:
        return WhiteNoise(std / sqrt(require_rate(rate, f"{kind}_b_stability")))
    return GaussMarkov(std, 1.0 if isinf(time) else time)


READER = Reader("gnss-ins-sim", GNSS_INS_SIM, lambda document: bool(_errors(document)), _read)

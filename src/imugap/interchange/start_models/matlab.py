"""Sensor parameters of MATLAB's ``imuSensor``, as ``loadparams`` reads them: a JSON file of parts."""

from collections.abc import Iterator, Mapping
from math import log, sqrt
from typing import Any

import numpy as np

from imugap.effects import (
    Bias,
    GaussMarkov,
    Misalignment,
    RandomWalk,
    Resolution,
    Saturation,
    ScaleFactor,
    Temperature,
    WhiteNoise,
)
from imugap.effects.effect import Effect
from imugap.interchange.conventions import MATLAB
from imugap.interchange.start_models.document import Document
from imugap.interchange.start_models.reading import (
    Key,
    Reader,
    Reading,
    density,
    level,
    model_of,
    numbers,
    require_rate,
    walk_density,
)
from imugap.log import TRIADS

SENSORS = {"gyro": "Gyroscope", "accel": "Accelerometer"}
HELD = {
    "MeasurementRange", "Resolution", "ConstantBias", "AxesMisalignment", "NoiseDensity", "BiasInstability",
    "RandomWalk", "TemperatureBias", "NoiseType",
}  # fmt: skip
COEFFICIENTS = "BiasInstabilityCoefficients"
"""Key of a filter of one's own for the bias instability."""
REFERENCE = 25.0
"""Temperature at which the temperature adds no bias [degC]."""
POLE = 0.5
"""Pole of the filter through which white noise of standard deviation BiasInstability passes, by default."""
SIDES = {"double-sided": 1.0, "single-sided": 2.0}
"""Sampling rate over the bandwidth of the noise."""


def _parts(document: Document) -> dict[str, Mapping]:
    every = {"": document, **document}.items() if isinstance(document, Mapping) else ()
    names = set(SENSORS.values())
    return {name: one for name, one in every if isinstance(one, Mapping) and names & set(one)}


def _recognises(document: Document) -> bool:
    sensors = [one.get(name) for one in _parts(document).values() for name in SENSORS.values()]
    return any(isinstance(sensor, Mapping) and HELD & set(sensor) for sensor in sensors)


def _read(document: Document, rate: float | None) -> Reading:
    parts = _parts(document)
    distinct = {repr([part.get(name) for name in SENSORS.values()]): part for part in parts.values()}
    if len(distinct) > 1:
        raise ValueError(f"parts: expected one part, or several alike; found {', '.join(parts)}")
    (part,) = distinct.values()
    axes, remarks, keys = {}, [], {}
    for kind, name in SENSORS.items():
        if not isinstance(part.get(name), Mapping):
            continue
        sensor = {key: value for key, value in part[name].items() if value is not None}  # null: infinite
        for k, axis in enumerate(TRIADS[kind]):
            axes[axis] = tuple(_effects(sensor, k, rate))
        keys[kind] = _keys(name, SIDES[sensor.get("NoiseType", "double-sided")])
        left = [key for key in sensor if key not in HELD and np.any(sensor[key])]
        left += ["BiasInstability"] if COEFFICIENTS in left and "BiasInstability" in sensor else []
        remarks += [f"not in the model: {name} {', '.join(left)}"] if left else []
    return Reading(model_of(axes), tuple(remarks), keys)


def _effects(sensor: Mapping[str, Any], k: int, rate: float | None) -> Iterator[Effect]:
    """Yield the effects of axis k."""
    sides = sensor.get("NoiseType", "double-sided")
    if sides not in SIDES:
        raise ValueError(f"NoiseType: expected {' or '.join(SIDES)}; found {sides!r:.40}")
    yield Bias(numbers(sensor, "ConstantBias", 3, 0.0)[k])
    yield WhiteNoise(numbers(sensor, "NoiseDensity", 3, 0.0)[k] / sqrt(SIDES[sides]))
    yield RandomWalk(numbers(sensor, "RandomWalk", 3, 0.0)[k] * sqrt(SIDES[sides]))
    instability = numbers(sensor, "BiasInstability", 3, 0.0)[k]
    if instability and COEFFICIENTS not in sensor:
        time = -1 / (require_rate(rate, "BiasInstability") * log(POLE))
        yield GaussMarkov(instability / sqrt(1 - POLE**2), time)
    yield Temperature(numbers(sensor, "TemperatureBias", 3, 0.0)[k], REFERENCE)
    shares = _misalignment(sensor.get("AxesMisalignment", 0.0))[k] / 100
    yield ScaleFactor(shares[k] - 1)
    if np.delete(shares, k).any():
        yield Misalignment(**{name: shares[j] for j, name in enumerate("xyz") if j != k})
    full_scale, step = (numbers(sensor, name, 1, 0.0)[0] for name in ("MeasurementRange", "Resolution"))
    if 0 < full_scale < np.inf:
        yield Saturation(full_scale)
    if step:
        yield Resolution(step)


def _keys(sensor: str, sides: float) -> tuple[Key, ...]:
    """Return the keys of a sensor; the sampling rate is ``sides`` times the bandwidth of its noise."""
    root, unit = sqrt(sides), MATLAB.unit(f"{sensor} ConstantBias")
    own = (
        ("MeasurementRange", Saturation, lambda one: one.limit),
        ("Resolution", Resolution, lambda one: one.step),
        ("BiasInstability", GaussMarkov, lambda one: one.std * sqrt(1 - POLE**2)),
    )
    return (
        Key.of(MATLAB, f"{sensor} NoiseDensity", WhiteNoise, lambda one: density(one) * root),
        Key.of(MATLAB, f"{sensor} RandomWalk", RandomWalk, lambda one: walk_density(one) / root),
        Key.of(MATLAB, f"{sensor} ConstantBias", Bias, level),
        *(Key(f"{sensor} {name}", unit, kind, si) for name, kind, si in own),
        Key(f"{sensor} AxesMisalignment, diagonal", "%", ScaleFactor, lambda one: 1 + one.error),
    )


def _misalignment(value: Any) -> np.ndarray:
    """Return the matrix of AxesMisalignment [%]: one number or three are those off the diagonal, by column."""
    if isinstance(value, list) and value and isinstance(value[0], list):
        rows = [numbers({"AxesMisalignment": row}, "AxesMisalignment", 3) for row in value]
        if len(rows) != 3:
            raise ValueError(f"AxesMisalignment: expected 3 rows; found {len(rows)}")
        return np.array(rows)
    off = np.tile(numbers({"AxesMisalignment": value}, "AxesMisalignment", 3), (3, 1))
    return np.where(np.eye(3, dtype=bool), 100.0, off)


READER = Reader("MATLAB imuSensor", MATLAB, _recognises, _read)

"""Configuration of the IMU of the Pegasus Simulator, in a script in Python or as a mapping."""

from collections.abc import Mapping
from math import sqrt

from imugap.effects import GaussMarkov, WhiteNoise
from imugap.interchange.conventions import PEGASUS
from imugap.interchange.start_models.document import Document
from imugap.interchange.start_models.reading import (
    Key,
    Reader,
    Reading,
    correlation_time,
    density,
    driving_density,
    in_si,
    model_of,
    number,
)
from imugap.log import TRIADS

DEFAULTS = {
    "gyroscope": {"noise_density": 0.0003393695767766752, "random_walk": 3.878509448876288e-05,
                  "bias_correlation_time": 1.0e3},
    "accelerometer": {"noise_density": 0.004, "random_walk": 0.006, "bias_correlation_time": 300.0},
}  # fmt: skip
"""Values of the simulator for keys that are not given."""
SENSORS = {"gyro": "gyroscope", "accel": "accelerometer"}
OF_THE_CODE = (
    "read as the configuration means it; the code of Pegasus gives the gyroscopes the correlation time of the "
    "accelerometers, adds no bias to these, and does not use turn_on_bias_sigma"
)


def _own(document: Document) -> Mapping | None:
    every = document if isinstance(document, tuple) else [document] if isinstance(document, Mapping) else []
    found = [one for one in every if _configures(one)]
    return found[0] if found else None


def _configures(one: Mapping) -> bool:
    sensors = [one.get(name) for name in SENSORS.values()]
    return any(isinstance(sensor, Mapping) and {"noise_density", "random_walk"} & set(sensor) for sensor in sensors)


def _read(document: Document, rate: float | None) -> Reading:
    own, axes, keys = _own(document), {}, {}
    for kind, name in SENSORS.items():
        sensor = own.get(name) or {}
        white, walk, time = (
            in_si(PEGASUS, f"{name} {key}", number(sensor, key, DEFAULTS[name][key])) for key in DEFAULTS[name]
        )
        if time <= 0:
            raise ValueError(f"{name}: bias_correlation_time: expected a number > 0; found {time:g}")
        axes |= dict.fromkeys(TRIADS[kind], (WhiteNoise(white), GaussMarkov(walk * sqrt(time / 2), time)))
        keys[kind] = (
            Key.of(PEGASUS, f"{name} noise_density", WhiteNoise, density),
            Key.of(PEGASUS, f"{name} random_walk", GaussMarkov, driving_density),
            Key.of(PEGASUS, f"{name} bias_correlation_time", GaussMarkov, correlation_time),
        )
    return Reading(model_of(axes), (OF_THE_CODE,), keys)


READER = Reader("Pegasus Simulator", PEGASUS, lambda document: _own(document) is not None, _read)

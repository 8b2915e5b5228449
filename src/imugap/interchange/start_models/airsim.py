"""``settings.json`` of AirSim."""

from collections.abc import Callable, Iterator, Mapping
from math import sqrt
from typing import Any

from imugap.effects import RandomWalk, WhiteNoise
from imugap.effects.effect import Effect
from imugap.interchange.conventions import AIRSIM, AIRSIM_TAU
from imugap.interchange.start_models.document import Document
from imugap.interchange.start_models.reading import Key, Reader, Reading, in_si, model_of, number, walk_density
from imugap.interchange.start_models.reading import density as of_density
from imugap.log import TRIADS

IMU = 2
"""``SensorType`` of an IMU."""
DEFAULTS = {"AngularRandomWalk": 0.3, "GyroBiasStability": 4.6, "VelocityRandomWalk": 0.24, "AccelBiasStability": 36.0}
"""Values of AirSim for keys that are not given."""
SENSORS = {"gyro": ("AngularRandomWalk", "Gyro"), "accel": ("VelocityRandomWalk", "Accel")}


def _imus(document: Mapping) -> Iterator[Mapping[str, Any]]:
    """Yield the settings of all IMUs: those of the vehicles, and the default ones."""
    vehicles = document.get("Vehicles")
    of_vehicles = vehicles.values() if isinstance(vehicles, Mapping) else ()
    owners = [one.get("Sensors") for one in of_vehicles if isinstance(one, Mapping)]
    for sensors in (*owners, document.get("DefaultSensors")):
        for one in sensors.values() if isinstance(sensors, Mapping) else ():
            if isinstance(one, Mapping) and one.get("SensorType") == IMU:
                yield one


def _recognises(document: Document) -> bool:
    return isinstance(document, Mapping) and ("SettingsVersion" in document or any(_imus(document)))


def _read(document: Document, rate: float | None) -> Reading:
    distinct = list({tuple(sorted(map(_text, one.items()))): one for one in _imus(document)}.values())
    if len(distinct) > 1:
        raise ValueError(f"Sensors: expected one IMU, or several alike; found {len(distinct)} that differ")
    own, axes, keys = (distinct[0] if distinct else {}), {}, {}
    for kind, (white, sensor) in SENSORS.items():
        slow, tau = f"{sensor}BiasStability", number(own, f"{sensor}BiasStabilityTau", AIRSIM_TAU[sensor])
        if tau <= 0:
            raise ValueError(f"{sensor}BiasStabilityTau: expected a number > 0; found {tau:g}")
        density = in_si(AIRSIM, white, number(own, white, DEFAULTS[white]))
        walk = in_si(AIRSIM, slow, number(own, slow, DEFAULTS[slow])) / sqrt(tau)
        axes |= dict.fromkeys(TRIADS[kind], (WhiteNoise(density), RandomWalk(walk)))
        keys[kind] = (
            Key.of(AIRSIM, white, WhiteNoise, of_density),
            Key.of(AIRSIM, slow, RandomWalk, _stability(tau)),
        )
    absent = [name for name in DEFAULTS if name not in own]
    return Reading(model_of(axes), (f"by default of AirSim: {', '.join(absent)}",) if absent else (), keys)


def _stability(tau: float) -> Callable[[Effect], float]:
    """Return the bias stability of a random walk as a function of it, at a time constant [s]."""
    return lambda walk: walk_density(walk) * sqrt(tau)


def _text(item: tuple[str, Any]) -> tuple[str, str]:
    return item[0], repr(item[1])


READER = Reader("AirSim", AIRSIM, _recognises, _read)

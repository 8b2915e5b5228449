"""``imu.yaml`` of Kalibr, and the IMU file of OpenVINS with the same keys below ``imu0``."""

from collections.abc import Mapping

from imugap.effects import RandomWalk, WhiteNoise
from imugap.interchange.conventions import KALIBR
from imugap.interchange.start_models.document import Document
from imugap.interchange.start_models.reading import (
    Key,
    Reader,
    Reading,
    density,
    in_si,
    model_of,
    number,
    walk_density,
)
from imugap.log import TRIADS

NAMES = {"gyro": "gyroscope", "accel": "accelerometer"}
SILENT = {"rostopic", "update_rate", "model", "T_i_b", "T_cam_imu"}
"""Keys that are no error of the sensor."""


def _own(document: Document) -> Mapping | None:
    """Return the mapping with the noise: the document itself or that of one IMU in it."""
    if not isinstance(document, Mapping):
        return None
    inner = [one for name, one in document.items() if name.startswith("imu") and isinstance(one, Mapping)]
    found = [one for one in (document, *inner) if "gyroscope_noise_density" in one]
    return found[0] if found else None


def _read(document: Document, rate: float | None) -> Reading:
    own = _own(document)
    axes, keys = {}, {}
    for kind, name in NAMES.items():
        white, walk = f"{name}_noise_density", f"{name}_random_walk"
        effects = (
            WhiteNoise(in_si(KALIBR, white, number(own, white))),
            RandomWalk(in_si(KALIBR, walk, number(own, walk))),
        )
        axes |= dict.fromkeys(TRIADS[kind], effects)
        keys[kind] = (
            Key.of(KALIBR, white, WhiteNoise, density), Key.of(KALIBR, walk, RandomWalk, walk_density),
        )  # fmt: skip
    known = {f"{name}_{what}" for name in NAMES.values() for what in ("noise_density", "random_walk")} | SILENT
    left = sorted(set(own) - known)
    return Reading(model_of(axes), (f"not in the model: {', '.join(left)}",) if left else (), keys)


READER = Reader("Kalibr or OpenVINS", KALIBR, lambda document: _own(document) is not None, _read)

"""PX4 logs (``.ulg``): one message with the samples, ``sensor_combined`` unless another is asked for."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from imugap.io.formats.source import Source, extra
from imugap.log import LogError

MAGIC = b"ULog\x01\x12\x35"
PREFERRED = ("sensor_combined", "vehicle_imu")
UNITS = {"sensor_gyro": "rad/s", "sensor_accel": "m/s^2"}
"""Units of the fields x, y and z of messages of one sensor."""
TICK = "us"
"""Unit of all stamps."""


def recognises(path: Path, head: bytes) -> bool:
    """Return whether a file begins as a PX4 log."""
    return head.startswith(MAGIC)


def open_source(path: Path, settings) -> Source:
    """Return the columns of one message, ``name`` or ``name:instance``; LogError where there is none of it."""
    name, found = message_of(path, PREFERRED, settings.topic, "--topic", ("sensor_gyro", "sensor_accel"))
    data = {field: values for field, values in found.items() if values.dtype.kind in "iuf"}
    names = tuple(_name(name.partition(":")[0], field) for field in data)
    columns = list(data.values())

    def batches(chosen):
        yield [columns[k] for k in chosen]

    return Source(path, names, len(columns[0]), batches, notes=(f"message {name}",), heading=name, topic=name)


def message_of(
    path: Path, preferred: Sequence[str], asked: str | None, option: str, others: Sequence[str] = ()
) -> tuple[str, dict[str, np.ndarray]]:
    """Return name and fields of a message: the one that is asked for, or the first of the preferred ones.

    LogError where there is none, with those of the preferred and other names that there are.
    """
    with extra(path, "px4", "pyulog"):
        from pyulog import ULog
    found = {f"{one.name}:{one.multi_id}": one.data for one in ULog(str(path)).data_list}
    wanted = [asked] if asked else preferred
    name = next((name for one in wanted for name in (one, f"{one}:0") if name in found), None)
    if name is None:
        known = [one for one in found if one.startswith((*others, *preferred))]
        expected = f"the message {' or '.join(wanted)} ({option} decides)"
        raise LogError(path, "messages", expected, ", ".join(known or found)[:200] or "none")
    return name, found[name]


def _name(message: str, field: str) -> str:
    """Return the name of a field with the unit that the definition of its message gives."""
    unit = TICK if field.startswith("timestamp") else UNITS.get(message) if field in ("x", "y", "z") else None
    return f"{message}.{field}" if unit is None else f"{message}.{field} [{unit}]"

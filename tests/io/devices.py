"""Samples of devices at rest and in motion, z up, and their files as loggers write them."""

import struct

import numpy as np

from imugap.stream import stream
from imugap.units import STANDARD_GRAVITY

RATE = 100.0
GYRO_N, ACCEL_N = 2e-4, 2e-3
"""Densities of the white noise [rad/s/sqrt(Hz)], [m/s^2/sqrt(Hz)]."""


def at_rest(count=3000, up=(0.0, 0.0, 1.0), seed=1):
    """Angular rates and specific forces of a device at rest, shape (count, 6)."""
    noise = stream(seed, "device at rest").standard_normal((count, 6)) * np.sqrt(RATE)
    samples = noise * np.repeat([GYRO_N, ACCEL_N], 3)
    samples[:, 3:] += STANDARD_GRAVITY * np.asarray(up)
    return samples


def turned(count=3000):
    """The same of a device that is turned by hand about two axes, slowly, by up to a radian."""
    time = np.arange(count) / RATE
    roll, pitch = np.sin(2 * np.pi * 0.2 * time), 0.6 * np.sin(2 * np.pi * 0.13 * time)
    samples = at_rest(count, up=(0.0, 0.0, 0.0))
    rates = np.gradient(roll, 1 / RATE), np.gradient(pitch, 1 / RATE)
    samples[:, 0] += rates[0]
    samples[:, 1] += rates[1] * np.cos(roll)
    samples[:, 2] -= rates[1] * np.sin(roll)
    up = np.column_stack([-np.sin(pitch), np.sin(roll) * np.cos(pitch), np.cos(roll) * np.cos(pitch)])
    samples[:, 3:] += STANDARD_GRAVITY * up
    return samples


def times(count=3000):
    """Stamps [s]."""
    return np.arange(count) / RATE


def write_text(path, header, columns, separator=",", decimal=".", form="{:.9g}", before=(), end="\n"):
    """Write columns as text; lines of ``before`` stand above the header."""
    lines = [*before, *([] if header is None else [separator.join(header)])]
    lines += [separator.join(form.format(value).replace(".", decimal) for value in row) for row in columns]
    path.write_bytes("".join(line + end for line in lines).encode())
    return path


ULOG_TYPES = {"u8": "uint64_t", "i4": "int32_t", "f4": "float", "f8": "double", "u1": "uint8_t", "b1": "bool"}


def write_ulog(path, messages):
    """Write messages, structured arrays by ``name:instance``, as a PX4 log."""

    def framed(kind, content):
        return struct.pack("<HB", len(content), ord(kind)) + content

    body, data = [], []
    for number, (name, rows) in enumerate(messages.items()):
        name, _, instance = name.partition(":")
        fields = ";".join(f"{ULOG_TYPES[rows.dtype[field].str[1:]]} {field}" for field in rows.dtype.names)
        body.append(framed("F", f"{name}:{fields};".encode()))
        data.append(framed("A", struct.pack("<BH", int(instance or 0), number) + name.encode()))
        data += [framed("D", struct.pack("<H", number) + row.tobytes()) for row in rows]
    flags = framed("B", bytes(40))
    path.write_bytes(b"ULog\x01\x12\x35\x01" + struct.pack("<Q", 0) + flags + b"".join([*body, *data]))
    return path


def write_simulated(folder, samples, prefix="", runs=("0",)):
    """Write samples, shape (n, 6), in rad/s and m/s^2 as the three files of each run of gnss-ins-sim."""
    folder.mkdir(exist_ok=True)
    write_text(folder / f"{prefix}time.csv", ["time (sec)"], times(len(samples))[:, None], form="{:.18e}")
    parts = {"gyro": (np.degrees(samples[:, :3]), "deg/s"), "accel": (samples[:, 3:], "m/s^2")}
    for run in runs:
        for name, (values, unit) in parts.items():
            header = [f"{name}_{axis} ({unit})" for axis in "xyz"]
            write_text(folder / f"{prefix}{name}-{run}.csv", header, values, form="{:.18e}")
    return folder

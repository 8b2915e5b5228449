"""Samples of devices at rest and in motion, z up, and their files as loggers write them."""

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

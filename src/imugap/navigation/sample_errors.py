"""Errors of the samples of a device that its motion shows: units, full scales, signs, orders, hands, a wrong rate.

Each says what was expected and found, and how a log is corrected of it. Drives and walks try the same ones.
"""

from dataclasses import dataclass

import numpy as np

from imugap.log import ACCEL, AXES, GYRO

RATES, FORCES = slice(0, 3), slice(3, 6)


@dataclass(frozen=True)
class SampleError:
    """Error of samples, and its correction.

    Attributes
    ----------
    expected, found
        What was expected, and what was found instead, in words.
    factors
        What the samples of each axis are multiplied by.
    order
        Column of the log from which each axis is taken, before that.
    interval
        What the intervals of the stamps are multiplied by.
    """

    expected: str
    found: str
    factors: tuple[float, ...] = (1.0,) * len(AXES)
    order: tuple[int, ...] = tuple(range(len(AXES)))
    interval: float = 1.0

    def corrected(self, stamp: np.ndarray, samples: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return corrected stamps [s], shape (n,), and samples, shape (n, 6)."""
        return stamp[0] + self.interval * (stamp - stamp[0]), samples[:, list(self.order)] * np.array(self.factors)


def _scaled(axes: slice | list[int], factor: float) -> tuple[float, ...]:
    """Return factors with one of some axes, 1 of the others."""
    factors = np.ones(len(AXES))
    factors[axes] = factor
    return tuple(map(float, factors))


UNIT = f"{', '.join(GYRO)} in rad/s"
ALONG = "gyroscopes and accelerometers along the same axes, x, y, z"
STAMPS = "stamps of the samples that go as fast as the motion (--rate, --time-unit)"
ORDERS = {
    (1, 0, 2): "gyro_x and gyro_y exchanged", (2, 1, 0): "gyro_x and gyro_z exchanged",
    (0, 2, 1): "gyro_y and gyro_z exchanged", (1, 2, 0): "the columns of gyro_x, gyro_y, gyro_z in turn",
    (2, 0, 1): "the columns of gyro_x, gyro_y, gyro_z in turn",
}  # fmt: skip
SAMPLE_ERRORS = (
    SampleError(UNIT, "rates 57.3 times those of the turns, as in deg/s (convert them)", _scaled(RATES, np.radians(1))),
    SampleError(UNIT, "rates 57.3 times too small for the turns (converted twice?)", _scaled(RATES, np.degrees(1))),
    SampleError(UNIT, "rates of twice the turns (a wrong full scale?)", _scaled(RATES, 0.5)),
    SampleError(UNIT, "rates of half the turns (a wrong full scale?)", _scaled(RATES, 2.0)),
    SampleError(STAMPS, "stamps of half the true interval (the rate is half the stated one)", interval=2.0),
    SampleError(STAMPS, "stamps of twice the true interval (the rate is twice the stated one)", interval=0.5),
    SampleError(
        f"{', '.join(GYRO)} right-handed about the axes of the accelerometers",
        "all three of the opposite sign of the turns", _scaled(RATES, -1.0),
    ),
    *(
        SampleError(f"a right-handed {name}", f"{name} of the opposite sign of the turns", _scaled([k], -1.0))
        for k, name in enumerate(GYRO)
    ),
    *(
        SampleError(
            f"{name} along the axis of {GYRO[k]}", f"{name} of the opposite sign of the changes of velocity",
            _scaled([3 + k], -1.0),
        )
        for k, name in enumerate(ACCEL[:2])
    ),
    *(SampleError(ALONG, words, order=(*order, 3, 4, 5)) for order, words in ORDERS.items()),
    SampleError(ALONG, "accel_x and accel_y exchanged", order=(0, 1, 2, 4, 3, 5)),
    SampleError(
        "right-handed axes of the device",
        "left-handed ones: x and y are exchanged, or one of them has the opposite sign, of gyroscopes and "
        "accelerometers",
        _scaled([1, 4], -1.0),
    ),
)  # fmt: skip
"""Errors that are tried; of several that explain the motion equally, the first is named."""

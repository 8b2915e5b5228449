"""Errors of samples: each correction undoes the error that its words name, and no two are the same."""

import numpy as np
import pytest

from imugap.log import AXES
from imugap.navigation.sample_errors import SAMPLE_ERRORS

STAMP = 5.0 + np.arange(10) / 100
SAMPLES = np.arange(60.0).reshape(10, 6) + 1
GX, GY, GZ, AX, AY, AZ = range(6)


def spoilt(factors=None, order=range(6)):
    return SAMPLES[:, list(order)] * (np.ones(6) if factors is None else np.array(factors))


SPOILT = {
    "as in deg/s": (STAMP, spoilt([180 / np.pi] * 3 + [1] * 3)),
    "twice the turns": (STAMP, spoilt([2] * 3 + [1] * 3)),
    "the rate is half the stated one": (5.0 + np.arange(10) / 200, SAMPLES),
    "gyro_y of the opposite sign": (STAMP, spoilt([1, -1, 1, 1, 1, 1])),
    "accel_x of the opposite sign": (STAMP, spoilt([1, 1, 1, -1, 1, 1])),
    "accel_x and accel_y exchanged": (STAMP, spoilt(order=[GX, GY, GZ, AY, AX, AZ])),
    "gyro_x and gyro_z exchanged": (STAMP, spoilt(order=[GZ, GY, GX, AX, AY, AZ])),
    "left-handed ones": (STAMP, spoilt([1, -1, 1, 1, -1, 1])),
}


@pytest.mark.parametrize(("words", "log"), SPOILT.items(), ids=SPOILT)
def test_a_correction_undoes_what_it_names(words, log):
    (error,) = (one for one in SAMPLE_ERRORS if words in one.found)
    stamp, samples = error.corrected(*log)
    np.testing.assert_allclose(stamp, STAMP)
    np.testing.assert_allclose(samples, SAMPLES)


def test_no_two_errors_are_the_same_and_each_changes_something():
    changes = {(one.factors, one.order, one.interval) for one in SAMPLE_ERRORS}
    assert len(changes) == len(SAMPLE_ERRORS)
    assert ((1.0,) * len(AXES), tuple(range(len(AXES))), 1.0) not in changes

"""An estimate of a log in motion says so before any number."""

import re

import numpy as np
import pandas as pd
import pytest

from imugap import estimate
from imugap.log import AXES, TIME
from imugap.stream import stream

RATE = 100.0


def moved(begin, end, count=6000):
    values = stream(9, "moved").standard_normal((count, 6)) * np.repeat([2e-4, 2e-3], 3) * np.sqrt(RATE)
    values[:, 5] -= 9.80665
    time = np.arange(count) / RATE
    part = (time >= begin) & (time < end)
    values[part] += np.sin(2 * np.pi * 1.5 * time[part, None] + np.arange(6))
    return pd.DataFrame(values, columns=list(AXES), index=pd.Index(time, name=TIME))


@pytest.mark.parametrize(
    ("begin", "end", "share", "step"),
    [(0, 60, 1.0, "record at rest"), (0, 30, 0.5, "cut the log to its rest from 30 to 60 s")],
)
def test_motion_is_the_first_line_of_the_verdict(begin, end, share, step):
    first, *others = estimate(moved(begin, end), axes=["gyro_x"], terms=["white_noise"]).verdict.splitlines()
    said = re.match(r"THE DEVICE WAS IN MOTION for (\d+)% of the log: ", first)
    assert int(said[1]) == pytest.approx(100 * share, abs=4)
    assert first.endswith(f"next: {step}")
    assert others


def test_a_device_at_rest_gets_no_such_line():
    assert "MOTION" not in estimate(moved(0, 0), axes=["gyro_x"], terms=["white_noise"]).verdict

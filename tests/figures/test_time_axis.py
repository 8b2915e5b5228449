"""Time in figures: from the begin of a log whose stamps are far from zero."""

import numpy as np
import pandas as pd
import pytest

from imugap.figures.log import samples
from imugap.figures.style import time_axis
from imugap.log import AXES, TIME


@pytest.mark.parametrize(
    ("begin", "end", "origin", "label"),
    [
        (0.0, 600.0, 0.0, "time [s]"),
        (0.01, 180.0, 0.0, "time [s]"),
        (456_300.0, 456_900.0, 456_300.0, "time since 456300 s [s]"),
        (1_683_000_000.25, 1_683_000_600.0, 1_683_000_000.25, "time since 1683000000 s [s]"),
    ],
)
def test_time_is_drawn_from_the_begin_where_that_is_later_than_the_log_is_long(begin, end, origin, label):
    assert time_axis(begin, end) == (origin, label)


def test_the_axis_of_time_has_no_offset_beside_it():
    time = pd.Index(1_683_000_000 + np.arange(1000) / 10, name=TIME)
    log = pd.DataFrame(np.random.default_rng(1).normal(size=(1000, 6)), index=time, columns=list(AXES))
    figure = samples(log)
    figure.draw_without_rendering()
    lowest = figure.axes[-1]
    assert lowest.get_xlabel() == "time since 1683000000 s [s]"
    assert lowest.xaxis.get_offset_text().get_text() == ""
    assert lowest.lines[0].get_xdata()[[0, -1]].tolist() == pytest.approx([0, 99.9])

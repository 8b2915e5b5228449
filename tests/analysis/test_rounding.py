"""What is said of values that are rounded."""

import numpy as np
import pandas as pd

from imugap.analysis.check import COMMANDS, check
from imugap.effects.resolution import Resolution
from imugap.effects.saturation import Saturation
from imugap.io.recording import of_table
from imugap.log import AXES, TIME
from imugap.pages.discover import in_filter
from imugap.stream import stream

COUNT, STEP = 6000, 1e-3


def log():
    """Log of a device at rest of which one gyroscope has a noise far below its resolution."""
    samples = stream(1, "rounded").standard_normal((COUNT, 6)) * np.repeat([2e-3, 2e-2], 3)
    samples[:, 5] -= 9.80665
    samples[:, 0] = np.rint(0.35 * stream(2, "rounded").standard_normal(COUNT) + 0.1) * STEP
    return pd.DataFrame(samples, index=pd.Index(np.arange(COUNT) / 100, name=TIME), columns=list(AXES))


def test_the_check_says_what_rounding_means_and_leaves_no_sample_out():
    (found,) = (one for one in check(of_table(log())).findings if "noise below one count" in one.text)
    assert found.text.startswith("gyro_x: noise below one count, 0.001; keep all samples")
    said = dict(zip(COMMANDS, found.consequences, strict=True))
    assert said == {"indices": "rounded", "estimate": "rounded", "discover": "an effect", "walk": "", "drive": ""}


def test_the_page_keeps_samples_that_are_rounded_and_leaves_out_those_that_are_clipped():
    assert in_filter(Resolution(STEP)).startswith("keep all samples")
    assert "leave out the samples that it spoils" in in_filter(Saturation(1.0))

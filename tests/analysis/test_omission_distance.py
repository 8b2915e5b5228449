"""Distance that an effect makes: one where it makes no difference, large where it does."""

import numpy as np
import pytest

from imugap.analysis.omission_distance import distance
from imugap.effects import RandomTelegraph, RandomWalk, Resolution, Sinusoid, WhiteNoise
from imugap.effects.conditions import Conditions
from imugap.effects.effect import AxisModel

AT_REST = Conditions(0.01 * np.arange(4096), 0.01, None, "gyro_x")
WHITE = WhiteNoise(1e-3)


@pytest.mark.parametrize("negligible", [RandomWalk(1e-8), Sinusoid(5.0, 1e-7)])
def test_an_effect_that_no_log_shows_makes_the_distance_of_two_logs(negligible):
    assert distance(AxisModel((WHITE, negligible)), AxisModel((WHITE,)), AT_REST) == pytest.approx(1.0, abs=0.35)


def test_the_distance_grows_with_the_effect():
    sizes = (0.01, 0.1, 1.0)
    far = [distance(AxisModel((WHITE, Sinusoid(5.0, size))), AxisModel((WHITE,)), AT_REST) for size in sizes]
    assert 1.5 < far[0] < far[1] < far[2]


@pytest.mark.parametrize("without", [(), (RandomTelegraph(1.0, 1e-9),), (Sinusoid(3.0, 1.0), Resolution(100.0))])
def test_without_noise_the_distance_has_no_scale(without):
    assert distance(AxisModel((*without, Sinusoid(5.0, 1e4))), AxisModel(without), AT_REST) == np.inf

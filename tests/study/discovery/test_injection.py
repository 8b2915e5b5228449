"""Known effects added to a log: of the size that is asked for, and found again beside what the log has itself."""

import numpy as np
import pandas as pd
import pytest

from imu_benchmark.sealing.detection_limits import Z
from imugap.discovery.device import Settings
from imugap.effects import GaussMarkov, WhiteNoise
from imugap.effects.effect import AxisModel
from imugap.model import ErrorModel
from imugap.study.discovery.injection import KINDS, inject, untouched

SETTINGS = Settings(seed=3, replicates=39, simulations=4)
COUNT, INTERVAL = 6000, 0.1


@pytest.fixture(scope="module")
def base():
    rest = pd.DataFrame({"gyro_x": np.zeros(COUNT)}, index=pd.Index(INTERVAL * np.arange(COUNT), name="time"))
    device = ErrorModel({"gyro_x": AxisModel((WhiteNoise(1e-4), GaussMarkov(5e-4, 5.0)))})
    return untouched("1", "gyro_x", device.simulate(rest, 3), SETTINGS)


@pytest.mark.parametrize("kind", KINDS)
def test_an_effect_has_the_size_that_is_asked_for(base, kind):
    (effect,) = inject(base, [kind], 4.0, SETTINGS).injected
    waveform = base.fit.whiten(effect.sample(base.fit.sequence.conditions, None)[:, None])
    assert np.linalg.norm(waveform) == pytest.approx(4.0 * Z)


def test_clear_effects_are_named_beside_those_of_the_log_and_have_their_sizes(base):
    rows = inject(base, ["sinusoid", "bias_step"], 10.0, SETTINGS).rows()
    assert [one["named"] for one in rows] == [True, True]
    assert all(one["inside"] for one in rows)
    assert {one["others"] for one in rows} == {0}


def test_an_effect_far_below_the_limit_is_not_named(base):
    (row,) = inject(base, ["sinusoid"], 0.1, SETTINGS).rows()
    assert not row["named"]
    assert np.isnan(row["ratio"])

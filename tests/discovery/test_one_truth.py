"""What the findings say of an effect is what the final model has, also where other effects were withheld."""

import numpy as np
import pytest

from imugap.discovery.device import Settings, discover
from imugap.effects import GaussMarkov, PowerLaw, Sinusoid, WhiteNoise
from imugap.effects.effect import AxisModel
from imugap.log import from_samples
from imugap.model import ErrorModel

INTERVAL, COUNT = 0.04, 12_000
LINE = Sinusoid(9.3, 3e-3, 1.0)


@pytest.mark.parametrize(
    ("hidden", "withheld"),
    [
        ((LINE, GaussMarkov(1e-3, 6.0)), False),
        pytest.param((LINE, PowerLaw(4e-3, 1.5)), True, marks=pytest.mark.slow),
    ],
    ids=["all named", "unnamed noise beside it"],
)
def test_findings_and_final_model_have_the_same_parameters(hidden, withheld):
    truth = ErrorModel({"gyro_x": AxisModel((WhiteNoise(1e-3), *hidden))})
    still = from_samples({"gyro_x": np.zeros(COUNT)}, INTERVAL)
    found = discover([truth.simulate(still, 1, "one truth")], Settings(replicates=20, simulations=10))
    assert bool(found.withheld) == withheld
    assert found.findings
    for one in found.findings:
        for axis, effect in one.effects.items():
            assert effect in tuple(found.final[axis])
            values = {name: interval.value for name, interval in one.parameters.items()}
            assert values == effect.parameters()

import pytest
from tests.effects.simulated import conditions

from imugap.effects import DeadZone, Saturation, StuckSamples
from imugap.stream import stream


@pytest.mark.parametrize("limited", [Saturation(1.5), DeadZone(1.0)], ids=lambda one: one.name)
def test_repeats_at_one_value_are_of_another_cause(limited):
    at = conditions(20_000)
    values = limited.apply(stream(6, limited.name).standard_normal(20_000), at, stream(1))
    assert StuckSamples.found(values, at) is None

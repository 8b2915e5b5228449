"""A final model that is farther from held-out data than the start model is not handed out."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pytest

from imugap import log
from imugap.discovery.device import Settings, discover
from imugap.discovery.verdict import verdict
from imugap.effects.effect import SystematicEffect, parameter
from imugap.stream import stream

RATE, COUNT = 20.0, 6000
TIME = np.arange(COUNT) / RATE
END = 0.8 * TIME[-1]


@dataclass(frozen=True)
class Wave(SystematicEffect):
    """A slow wave over time."""

    name: ClassVar[str] = "wave"
    of_time: ClassVar[bool] = True
    amplitude: float = parameter("{u}", "amplitude", low=-np.inf)

    @staticmethod
    def shape(time):
        """The wave of amplitude one."""
        return np.sin(2 * np.pi * time / 20)

    def sample(self, conditions, rng):
        return self.amplitude * self.shape(conditions.time)

    def slopes(self, conditions):
        return {"amplitude": self.shape(conditions.time)}

    @classmethod
    def starts(cls, fit):
        if not fit.has(cls):
            yield from cls(0.0).proposed(fit, ("amplitude",))


@dataclass(frozen=True)
class FalseWave(Wave):
    """A wave that is right as long as the log is fitted, and wrong after."""

    name: ClassVar[str] = "false_wave"

    @staticmethod
    def shape(time):
        return np.sin(2 * np.pi * time / 20) * np.where(time < END, 1.0, -1.0)


def found_with(kind):
    """What is found in a log with a wave, where one kind of effects may be missing."""
    values = 1e-3 * stream(1, "wave").normal(size=COUNT) + 1e-3 * Wave.shape(TIME)
    return discover([log.from_samples({"gyro_x": values}, 1 / RATE)], Settings(catalogue=(kind,)))


@pytest.fixture(scope="module")
def withdrawn():
    return found_with(FalseWave)


def test_an_effect_that_holds_on_held_out_data_is_added():
    found = found_with(Wave)
    assert [one.name for one in found.findings] == ["wave"]
    assert found.distances["distribution"].after.value < found.distances["distribution"].before.low


def test_an_effect_that_takes_the_model_farther_from_held_out_data_is_withdrawn(withdrawn):
    assert not withdrawn.findings
    assert "wave" not in str(withdrawn.final.to_mapping())
    assert not withdrawn.distances["distribution"].farther
    assert [(one.axis, one.name, one.reason) for one in withdrawn.withheld] == [
        ("gyro_x", "false_wave", "the model with it is farther from data that no fit has seen"),
    ]


def test_the_verdict_says_what_was_withdrawn_and_why(withdrawn):
    assert "false wave, but the model with it is farther from data that no fit has seen; not named" in verdict(
        withdrawn
    )

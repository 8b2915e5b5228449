"""Noise that is not normal is named by its tails; normal noise, white or not, rounded or not, passes without a word."""

from dataclasses import replace

import numpy as np
import pytest
from tests.chance import as_often_as
from tests.discovery.simulated import TIME, WHITE, fitted, moved, sequence

from imugap.discovery.checks import distribution
from imugap.discovery.checks.distribution import noise_shape, shape_of
from imugap.effects import GaussMarkov, Outliers, RandomTelegraph
from imugap.stream import stream

LOG_ALPHA = np.log(0.01 / 6 / 28)


def uniform_beside(*effects):
    """The log of uniform numbers of the standard deviation of the white noise, and effects."""
    std = WHITE.density / np.sqrt(TIME[1])
    rng = stream(1, "uniform")
    return moved(sequence(*effects, white=type(WHITE)(1e-9)), rng.uniform(-1, 1, len(TIME)) * np.sqrt(3) * std)


@pytest.mark.parametrize("effects", [(), (GaussMarkov(2e-3, 30.0),)])
def test_uniform_numbers_are_named(effects):
    found = noise_shape(fitted(uniform_beside(*effects), *effects), LOG_ALPHA)
    assert found.law == "uniform numbers"
    assert found.kurtosis == pytest.approx(1.8, abs=0.05)
    assert found.low < found.kurtosis < found.high < 2
    assert (
        "gyro_x: the noise is not normally distributed, its tails are lighter, as those of uniform" in found.sentence()
    )


@pytest.mark.parametrize("effects", [(), (GaussMarkov(2e-3, 30.0),)])
def test_normal_noise_is_not_named(effects):
    assert noise_shape(fitted(sequence(*effects), *effects), LOG_ALPHA) is None


def test_other_laws():
    rng = stream(1, "laws")
    draws = {
        "a sine": np.sin(rng.uniform(0, 2 * np.pi, 5000)),
        "a sum of two uniform numbers": rng.uniform(size=5000) + rng.uniform(size=5000),
        "": rng.standard_t(3, 5000),
    }
    for law, values in draws.items():
        assert shape_of(values, "gyro_x", LOG_ALPHA).law == law


def test_outliers_are_another_finding():
    outliers = Outliers(0.01, 0.1)
    assert noise_shape(fitted(sequence(outliers), outliers), LOG_ALPHA) is None


def test_steps_of_the_output_are_another_finding():
    walk = GaussMarkov(0.1, 30.0)
    data = sequence(walk)
    step = 3 * WHITE.density / np.sqrt(TIME[1])
    rounded = replace(data, values=np.rint(data.values / step) * step, step=step)
    assert noise_shape(fitted(rounded, walk), LOG_ALPHA) is None


def test_a_telegraph_is_another_finding():
    telegraph = RandomTelegraph(2e-2, 1.0)
    assert noise_shape(fitted(sequence(telegraph), telegraph), LOG_ALPHA) is None


def test_normal_values_are_rejected_no_more_often_than_stated(monkeypatch):
    monkeypatch.setattr(distribution, "TOLERATED", (distribution.NORMAL, distribution.NORMAL))
    rng = stream(1, "normal")
    for count in (500, 3000):
        rejected = [shape_of(rng.standard_normal(count), "gyro_x", np.log(0.05)) is not None for _ in range(400)]
        assert as_often_as(rejected, 0.05)

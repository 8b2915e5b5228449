"""What has no name is described: simulations with the description are as like the log as two runs of one model."""

import numpy as np
import pytest
from scipy.signal import lfilter

import imugap as ig
from imugap.discovery.device import Settings, discover
from imugap.discovery.report import to_mapping
from imugap.discovery.verdict import verdict
from imugap.effects import CATALOGUE, BandNoise, NoiseDistribution, Sinusoid, SkewedNoise
from imugap.log import from_samples
from imugap.model import ErrorModel
from imugap.stream import stream

RATE, COUNT, STD = 40.0, 20_000, 1.5e-3
KINDS = tuple(kind for kind in CATALOGUE.values() if kind is not SkewedNoise)
QUICK = Settings(replicates=39, simulations=30, catalogue=KINDS)
"""Settings without a name for skewed noise."""


def differenced(rng):
    return lfilter([1, -2, 1], 1, rng.standard_normal(COUNT)) / np.sqrt(6)


def swelling(rng):
    time = np.arange(COUNT) / RATE
    line = np.sin(2 * np.pi * 7.3 * time) * (1 + 0.9 * np.sin(2 * np.pi * time / 55))
    return rng.standard_normal(COUNT) + 0.5 * line


def two_humps(rng):
    return 0.5 * rng.standard_normal(COUNT) + rng.choice([-0.85, 0.85], COUNT)


def skewed(rng):
    return (rng.gamma(2.0, size=COUNT) - 2) / np.sqrt(2)


HIDDEN = {
    "spectrum that rises as no quantization": (differenced, BandNoise),
    "line that swells": (swelling, BandNoise),
    "two humps": (two_humps, NoiseDistribution),
    "skewed": (skewed, NoiseDistribution),
}


def found_in(values):
    return discover([from_samples({"gyro_y": STD * values}, 1 / RATE)], QUICK)


@pytest.mark.parametrize(
    "name",
    [
        one if number % 2 == 0 else pytest.param(one, marks=(pytest.mark.slow, pytest.mark.each))
        for number, one in enumerate(HIDDEN)
    ],
)
def test_what_has_no_name_is_described_to_the_floor(name):
    make, kind = HIDDEN[name]
    found = found_in(make(stream(7, name)))
    assert not found.findings
    assert {type(one) for one in found.nameless.effects["gyro_y"]} == {kind}
    apart = found.nameless.distances
    assert apart.before.value == pytest.approx(found.distances["distribution"].after.value, rel=0.3)
    assert apart.after.value < apart.before.value
    assert apart.after.value < apart.floor.high
    assert "Described without a name" in verdict(found)
    report = to_mapping(found, [])["nameless_noise"]
    assert report["axes"] == ["gyro_y"]
    assert ErrorModel.from_mapping(report["model"]) == found.nameless.model
    # the model of named effects stays free of descriptions
    assert not any(isinstance(one, (BandNoise, NoiseDistribution)) for one in found.final["gyro_y"])


def test_where_nothing_is_missing_nothing_is_described():
    found = found_in(stream(7, "nothing").standard_normal(COUNT))
    assert found.nameless is None
    assert to_mapping(found, [])["nameless_noise"] is None


def test_a_named_effect_stays_beside_the_description():
    line = Sinusoid(3.7, 0.5, 0.4)
    time = np.arange(COUNT) / RATE
    found = found_in(skewed(stream(7, "both")) + line.amplitude * np.sin(2 * np.pi * line.frequency * time))
    assert [one.name for one in found.findings] == ["sinusoid"]
    kinds = {type(one) for one in found.nameless.model["gyro_y"]}
    assert {Sinusoid, NoiseDistribution} < kinds


def test_a_described_model_is_simulated_and_navigated_with():
    model = ErrorModel.from_mapping(
        {"gyro_y": [{"band_noise": {"density": 1e-3, "frequency": 5.0, "width": 4.0}},
                    {"noise_distribution": {"std": 1e-3}}, {"white_noise": {"density": 1e-4}}]}
    )  # fmt: skip
    log = ig.simulate(model, duration=100, rate=40, seed=1)
    assert log.table["gyro_y"].std() == pytest.approx(np.sqrt(2 * 1e-6 * 4 + 1e-8 * 40), rel=0.1)

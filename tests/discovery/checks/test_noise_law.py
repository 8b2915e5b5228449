"""White noise is named by the law of its samples, beside other effects too, and its intervals hold the truth."""

import numpy as np
import pytest
from tests.chance import as_often_as
from tests.discovery.simulated import KINDS, LOG_ALPHA, fitted, names, result_of, sequence

from imugap.discovery.checks.noise_law import noise_law
from imugap.discovery.device import Settings, discover
from imugap.discovery.verdict import verdict
from imugap.effects import GaussMarkov, Outliers, RandomWalk, Sinusoid, SkewedNoise, UniformNoise, WhiteNoise
from imugap.log import from_samples
from imugap.stream import stream

LAWS = UniformNoise(1e-3, 0.8), UniformNoise(1e-3), SkewedNoise(1e-3, 0.8), SkewedNoise(1e-3, -1.8)
RUNS = 60


def of_runs(white, *effects, runs=RUNS):
    """What each of some logs shows."""
    data = (sequence(*effects, white=white, label=f"{white} {run}") for run in range(runs))
    return [noise_law(fitted(one, *effects), KINDS, LOG_ALPHA) for one in data]


@pytest.mark.parametrize("white", LAWS, ids=str)
def test_each_law_is_named_and_its_intervals_hold_the_truth(white):
    found = [law.finding() for law in of_runs(white)]
    assert {one.name for one in found} == {white.name}
    for name, truth in white.parameters().items():
        inside = [one.parameters[name].low <= truth <= one.parameters[name].high for one in found]
        # at the end of its range a share is within an interval that reaches it, one-sided
        assert as_often_as(inside, 0.975 if truth == white.limits()[name][1] else 0.95), name


@pytest.mark.parametrize("slow", [GaussMarkov(2e-3, 30.0), RandomWalk(1e-4)], ids=lambda one: one.name)
def test_slow_noise_beside_it_changes_nothing(slow):
    found = of_runs(UniformNoise(1e-3), slow, runs=5)
    assert all(law.distribution.intervals["share"][1] == 1 for law in found)


def test_normal_noise_is_neither():
    assert of_runs(WhiteNoise(1e-3), runs=40) == [None] * 40


@pytest.mark.parametrize("white", [UniformNoise(1e-3), SkewedNoise(1e-3, 0.5), SkewedNoise(1e-3, -2.0)], ids=str)
def test_a_search_names_the_law_and_no_outliers(white):
    assert names(result_of(sequence(white=white))) == [white.name]


def test_a_line_beside_it_keeps_its_name():
    assert names(result_of(sequence(Sinusoid(3.0, 2e-3), white=UniformNoise(1e-3)))) == ["sinusoid", "uniform_noise"]


def test_outliers_of_normal_noise_stay_outliers():
    assert names(result_of(sequence(Outliers(0.002, 0.05)))) == ["outliers"]


@pytest.mark.parametrize("white", [UniformNoise(1e-3), SkewedNoise(1e-3, 0.8)], ids=lambda one: one.name)
def test_without_its_kind_it_has_no_name(white):
    kinds = [kind for kind in KINDS if kind is not type(white)]
    assert not names(result_of(sequence(white=white), *kinds))


def test_simulations_with_the_law_are_as_like_the_log_as_two_runs_of_the_model():
    values = 1e-3 * stream(2, "uniform").uniform(-1, 1, 20_000)
    found = discover([from_samples({"gyro_z": values}, 0.02)], Settings(replicates=39, simulations=30))
    assert [one.name for one in found.findings] == ["uniform_noise"]
    assert any(place.view == "marginal" for place in found.discrepancies)
    assert not found.unexplained
    assert not found.shapes
    assert found.nameless is None
    apart = found.distances["distribution"]
    assert apart.after.value < apart.floor.high < apart.before.value
    (white,) = [one for one in found.final["gyro_z"] if one.white]
    assert type(white) is UniformNoise
    assert white.density == pytest.approx(1e-3 / np.sqrt(3) * np.sqrt(0.02), rel=0.02)
    assert "uniform_noise" in verdict(found)

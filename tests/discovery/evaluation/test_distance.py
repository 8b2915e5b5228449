"""Distances on held-out data: far without what is missing, within the floor with the right model."""

import numpy as np
import pytest
from scipy.stats import binomtest

from imugap import log
from imugap.discovery.evaluation.distance import HeldOutComparison, combined
from imugap.discovery.evaluation.parameter_ensemble import UncertainModel
from imugap.discovery.fit.axis_fit import fit
from imugap.discovery.fit.description import Description, Entry
from imugap.discovery.preparation.sequence import AxisSequence
from imugap.effects import (
    Bias,
    BiasStep,
    GaussMarkov,
    OutputFilter,
    RandomWalk,
    RateRamp,
    Resolution,
    ScaleFactor,
    Sinusoid,
    WhiteNoise,
)
from imugap.effects.conditions import Conditions
from imugap.effects.effect import AxisModel
from imugap.model import ErrorModel
from imugap.stream import stream

INTERVAL = 0.02
WHITE = WhiteNoise(1e-3)


def rest(count=4000, axes=log.AXES):
    level = {axis: np.full(count, -9.8 if axis == "accel_z" else 0.0) for axis in axes}
    return log.from_samples(level, INTERVAL)


def model(*effects, axes=log.AXES):
    return ErrorModel({axis: AxisModel((WHITE, *effects)) for axis in axes})


def distances(measured, split, before, after, reference=None, seed=1):
    """Distances of the distribution of the held-out part from those of two models."""
    return combined([HeldOutComparison(measured, split, before, after, reference).distribution(seed=seed)])


def gyro(*effects):
    """An error model of one gyroscope, and the log of it at rest."""
    one = model(*effects, axes=("gyro_x",))
    return one, one.simulate(rest(axes=("gyro_x",)), 1)


@pytest.mark.parametrize(
    "hidden", [GaussMarkov(3e-3, 2.0), Sinusoid(3.0, 6e-3), RateRamp(3e-4), Resolution(0.02), RandomWalk(2e-3)]
)
def test_the_right_model_is_at_the_floor_and_the_poor_one_is_not(hidden):
    axes = ("gyro_x", "accel_z")
    measured = model(hidden, axes=axes).simulate(rest(axes=axes), 1)
    found = distances(measured, 50.0, model(axes=axes), model(hidden, axes=axes))
    assert found.before.low > found.floor.high
    assert found.before.value > 1.5 * found.after.value
    assert found.floor.low * 0.95 < found.after.value < found.floor.high * 1.05
    for item in (found.before, found.after, found.floor):
        assert item.low < item.value < item.high


def test_an_effect_that_is_not_there_does_no_good():
    true, measured = gyro()
    found = distances(measured, 50.0, true, model(Sinusoid(3.0, 3e-3), axes=("gyro_x",)))
    assert found.after.value > max(found.before.high, found.floor.high)


@pytest.mark.slow
def test_navigation_sees_what_drifts():
    measured = model(RandomWalk(1e-3)).simulate(rest(), 2)
    found = combined([HeldOutComparison(measured, 40.0, model(), model(RandomWalk(1e-3))).drifts(seed=1).distances()])
    assert found.before.low > found.floor.high
    assert found.floor.low * 0.9 < found.after.value < found.floor.high * 1.1


def test_the_level_of_a_device_at_rest_and_its_biases_do_not_matter():
    true, measured = gyro()
    biased = ErrorModel({"gyro_x": AxisModel((Bias(3.0), WHITE))})
    one, other = distances(measured, 50.0, true, true), distances(measured + 5.0, 50.0, true, biased)
    for name in ("before", "after", "floor"):
        assert getattr(other, name).value == pytest.approx(getattr(one, name).value, rel=1e-6)


@pytest.mark.parametrize("moved", [BiasStep(25.0, 6e-3), RateRamp(2e-4)])
def test_the_place_of_a_level_on_a_coarse_lattice_is_that_without_the_terms_of_the_mean(moved):
    true, measured = gyro(moved, Resolution(0.0127))
    found = distances(measured, 50.0, model(axes=("gyro_x",)), true)
    assert found.floor.low * 0.95 < found.after.value < found.floor.high * 1.05


def test_motion_is_compared_with_its_reference():
    count = 4000
    swing = 2 * np.sin(2 * np.pi * 0.7 * INTERVAL * np.arange(count))
    reference = log.from_samples({"gyro_x": swing}, INTERVAL)
    hidden = model(ScaleFactor(5e-3), axes=("gyro_x",))
    measured = hidden.simulate(reference, 1)
    found = distances(measured, 50.0, model(axes=("gyro_x",)), hidden, reference)
    assert found.before.low > found.floor.high
    assert found.floor.low * 0.9 < found.after.value < found.floor.high * 1.1


@pytest.mark.parametrize("split", [0.5, 79.9, 100.0])
def test_a_split_that_leaves_nothing_is_refused(split):
    true, measured = gyro()
    with pytest.raises(ValueError, match=r"split: expected 64 samples on either side"):
        distances(measured, split, true, true)


def fitted(measured, training, description):
    conditions = Conditions(measured.index.to_numpy()[:training], INTERVAL, axis="gyro_x")
    values = measured["gyro_x"].to_numpy()[:training]
    return fit(AxisSequence(values, conditions), description)


def test_drawn_models_scatter_as_their_fit_says():
    described = Description.known(WHITE).adding(Entry(RateRamp(1e-4), ("slope",)), GaussMarkov(3e-3, 2.0))
    _, measured = gyro(GaussMarkov(3e-3, 2.0), RateRamp(1e-4))
    found = fitted(measured, 4000, described)
    fixed = Resolution(1e-4)
    uncertain = UncertainModel.of(
        ErrorModel({"gyro_x": AxisModel((*found.description.effects(), fixed)), "gyro_y": AxisModel((WHITE,))}),
        {"gyro_x": found},
    )
    rng = stream(1, "draws")
    drawn = [uncertain.draw(rng) for _ in range(400)]
    values = {type(effect): [] for effect in drawn[0]["gyro_x"]}
    for one in drawn:
        for effect in one["gyro_x"]:
            values[type(effect)].append(next(iter(effect.parameters().values())))
        assert one["gyro_y"] == AxisModel((WHITE,))
    assert set(values[Resolution]) == {1e-4}
    error = np.sqrt(found.covariance[0, 0])
    ramp = found.description.terms[0].effect.slope
    assert np.std(values[RateRamp]) == pytest.approx(error, rel=0.15)
    assert abs(np.mean(values[RateRamp]) - ramp) < 5 * error / 20
    information = found.noise.information
    expected = np.sqrt(np.diag(np.linalg.inv(information + np.eye(len(information)))))
    assert np.std(np.log(values[WhiteNoise])) == pytest.approx(expected[0], rel=0.15)
    assert np.std(np.log(values[GaussMarkov])) == pytest.approx(expected[1], rel=0.15)


def test_a_drawn_filter_ends_below_half_the_rate():
    """A filter that is not there, and of which the data say little: its cutoff scatters widely."""
    measured = model(axes=("gyro_x",)).simulate(rest(400, ("gyro_x",)), 1)
    described = Description.known(WHITE).adding(OutputFilter(0.4 / INTERVAL, 1))
    found = fitted(measured, 400, described)
    uncertain = UncertainModel.of(ErrorModel({"gyro_x": AxisModel(found.description.effects())}), {"gyro_x": found})
    rng = stream(1, "draws")
    drawn = [uncertain.draw(rng)["gyro_x"].effects[-1] for _ in range(300)]
    cutoffs = np.array([effect.cutoff for effect in drawn if isinstance(effect, OutputFilter)])
    assert len(cutoffs) == 300
    assert cutoffs.max() < 0.5 / INTERVAL
    assert np.ptp(np.log(cutoffs)) > 0.05


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["known", "estimated", "navigation"])
def test_the_right_model_lands_in_the_floor_in_95_percent_of_cases(kind):
    axes, count, logs = (log.AXES if kind == "navigation" else ("gyro_x",)), 1200, 60
    true = model(RandomWalk(5e-3), axes=axes)
    described = Description.known(WHITE).adding(RandomWalk(5e-3))
    inside = 0
    for seed in range(logs):
        measured = true.simulate(rest(count, axes), 7, seed)
        after = true
        if kind == "estimated":
            found = fitted(measured, 720, described)
            after = UncertainModel.of(ErrorModel({"gyro_x": AxisModel(found.description.effects())}), {"gyro_x": found})
        asked = HeldOutComparison(measured, 14.4, true, after)
        seen = asked.drifts(seed, 39).distances() if kind == "navigation" else asked.distribution(seed, 39)
        found = combined([seen])
        inside += found.floor.low <= found.after.value <= found.floor.high
    assert binomtest(inside, logs, 0.95).pvalue > 0.002


def test_a_model_is_as_far_as_its_equal_however_far_it_is():
    """Both models are simulated with the same random numbers: where nothing was added, nothing changes."""
    poor, _ = gyro()
    _, measured = gyro(Sinusoid(3.0, 6e-3))
    found = distances(measured, 50.0, poor, poor)
    assert found.before == found.after

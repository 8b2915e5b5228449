from dataclasses import FrozenInstanceError, fields, replace
from pathlib import Path

import numpy as np
import pytest
from tests.effects.simulated import EXAMPLES, SAMPLED, SAMPLED_NAMES, conditions, moving

import imugap.effects
from imugap.effects import (
    CATALOGUE,
    AdditiveEffect,
    Bias,
    ClockScale,
    GaussMarkov,
    RateRamp,
    Resolution,
    Saturation,
    StochasticEffect,
    StuckSamples,
    TimestampJitter,
    WhiteNoise,
)
from imugap.effects.effect import AxisModel, SystematicEffect
from imugap.stream import stream


def test_catalogue_has_one_effect_per_file():
    files = {path.stem for path in Path(imugap.effects.__file__).parent.glob("*.py")}
    assert set(CATALOGUE) == files - {
        "__init__",
        "effect",
        "conditions",
        "residual",
        "block",
        "coloured_block",
        "cross_axis",
    }
    assert all(name == effect.name for name, effect in CATALOGUE.items())
    assert set(EXAMPLES) == set(CATALOGUE)


@pytest.mark.parametrize("effect", CATALOGUE.values(), ids=CATALOGUE)
def test_every_parameter_says_its_unit_and_meaning(effect):
    units = effect.units("rad/s")
    assert set(units) == {item.name for item in fields(effect)}
    assert all(item.metadata["meaning"] for item in fields(effect))
    assert not any("{" in unit for unit in units.values())


@pytest.mark.parametrize("effect", CATALOGUE.values(), ids=CATALOGUE)
def test_every_parameter_refuses_what_is_no_number_within_its_limits(effect):
    valid = {item.name: 1.0 for item in fields(effect)}
    for item in fields(effect):
        low, high = item.metadata["low"], item.metadata["high"]
        outside = [low - 1, high + 1, *([1.5] if item.metadata["whole"] else [])]
        for bad in (np.nan, np.inf, -np.inf, *filter(np.isfinite, outside)):
            with pytest.raises(ValueError, match=rf"{effect.name}\.{item.name}: expected .* found {bad}"):
                effect(**valid | {item.name: bad})


@pytest.mark.parametrize("effect", CATALOGUE.values(), ids=CATALOGUE)
def test_an_effect_is_a_frozen_value(effect):
    values = {item.name: 1.0 for item in fields(effect)}
    assert effect(**values) == effect(**values)
    assert len({effect(**values), effect(**values)}) == 1
    with pytest.raises(FrozenInstanceError):
        setattr(effect(**values), fields(effect)[0].name, 2.0)


@pytest.mark.parametrize(
    "effect", [e for e in EXAMPLES.values() if isinstance(e, AdditiveEffect)], ids=lambda e: e.name
)
def test_an_additive_effect_adds_what_it_samples(effect):
    at = moving(40, "accel_z" if effect.name == "lever_arm" else "gyro_z")
    before = stream(2, "before").standard_normal(40)
    added = effect.apply(before, at, stream(2, "effect")) - before
    np.testing.assert_allclose(added, effect.sample(at, stream(2, "effect")), atol=1e-12)


def test_units_follow_the_axis():
    assert WhiteNoise.units("rad/s") == {"density": "rad/s/sqrt(Hz)"}
    assert GaussMarkov.units("m/s^2") == {"std": "m/s^2", "correlation_time": "s"}


def test_text_in_place_of_a_number_names_the_parameter():
    with pytest.raises(ValueError, match=r"white_noise\.density"):
        WhiteNoise("1e-4")


@pytest.mark.parametrize("process", [e for e in CATALOGUE.values() if issubclass(e, StochasticEffect)])
def test_stochastic_effects_are_all_put_to_the_test(process):
    assert process.name in SAMPLED_NAMES


def test_a_model_sums_what_its_effects_say_of_their_samples():
    ramp = RateRamp(0.1)
    model = AxisModel((*SAMPLED, ramp, Bias(1.0), Resolution(0.1)))
    averaging, frequency = np.array([1, 8, 64]), np.array([0.1, 1.0, 50.0])
    expected = sum(effect.sampled_allan_variance(averaging, 0.01) for effect in (*SAMPLED, ramp))
    np.testing.assert_allclose(model.sampled_allan_variance(averaging, 0.01), expected, rtol=1e-13)
    expected = sum(effect.sampled_psd(frequency, 0.01) for effect in SAMPLED)
    np.testing.assert_allclose(model.sampled_psd(frequency, 0.01), expected, rtol=1e-13)


@pytest.mark.parametrize("effect", [TimestampJitter(0.1), ClockScale(1.1)], ids=lambda e: e.name)
def test_an_effect_of_the_clock_refuses_a_sequence(effect):
    with pytest.raises(ValueError, match=rf"{effect.name}: expected a whole log"):
        AxisModel((effect,)).simulate(np.zeros(9), conditions(9), 1)


SYSTEMATIC = [effect for effect in EXAMPLES.values() if isinstance(effect, SystematicEffect)]


STEP_SHARE = 1e-5


@pytest.mark.parametrize("effect", SYSTEMATIC, ids=lambda effect: effect.name)
def test_slopes_are_the_limits_of_difference_quotients(effect):
    at = moving(400, "accel_z" if effect.name == "lever_arm" else "gyro_z")
    for name, slope in effect.slopes(at).items():
        value = getattr(effect, name)
        step = STEP_SHARE * abs(value)
        ends = [replace(effect, **{name: value + side * step}).sample(at, None) for side in (1, -1)]
        quotient = (ends[0] - ends[1]) / (2 * step)
        np.testing.assert_allclose(slope, quotient, rtol=1e-6, atol=1e-6 * np.abs(slope).max(), err_msg=name)


def test_systematic_effects_are_all_put_to_the_test():
    kinds = {kind for kind in CATALOGUE.values() if issubclass(kind, SystematicEffect)}
    assert {type(effect) for effect in SYSTEMATIC} == kinds


def test_no_effect_is_found_in_plain_noise_and_each_in_its_own():
    noise, at = stream(8, "noise").standard_normal(5000), conditions(5000)
    for effect in (Resolution(0.2), Saturation(2.0), StuckSamples(0.01, 3.0)):
        assert type(effect).found(noise, at) is None
        found = type(effect).found(effect.apply(noise, at, stream(8, effect.name)), at)
        for name, value in effect.parameters().items():
            low, high = found.intervals[name]
            assert low < value < high, (effect, name)

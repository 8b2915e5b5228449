from dataclasses import fields
from math import isfinite

import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from imugap import log
from imugap.effects import (
    CATALOGUE,
    Bias,
    BiasInstability,
    Conditions,
    GaussMarkov,
    Misalignment,
    RandomWalk,
    Resolution,
    StabilityRestoration,
    Temperature,
    TurnOnBias,
    VarianceChange,
    WhiteNoise,
)
from imugap.model import AxisModel, ErrorModel
from imugap.stability import bias_stability

AT = Conditions(0.01 * np.arange(600), 0.01, np.linspace(20, 30, 600))
IDEAL = np.full(600, 0.5)
ADDITIVE = (Bias(0.1), TurnOnBias(0.1), WhiteNoise(0.02), RandomWalk(0.01), GaussMarkov(0.1, 3.0), Temperature(0.02))


def numbers(item):
    low, high = item.metadata["low"], item.metadata["high"]
    if item.metadata["whole"]:
        return st.integers(int(low), int(high))
    limits = {"min_value": low} if isfinite(low) else {}
    limits |= {"max_value": high} if isfinite(high) else {}
    return st.floats(**limits, allow_nan=False, allow_infinity=False)


def homely(effect, axis):
    """Values of an effect that has a place on the axis."""
    drawn = {item.name: numbers(item) for item in fields(effect)}
    if effect is VarianceChange:
        times = st.tuples(drawn["start"], drawn["stop"]).map(sorted)
        return st.builds(lambda times, ratio: VarianceChange(*times, ratio), times, drawn["ratio"])
    return st.builds(effect, **drawn | ({axis[-1]: st.just(0.0)} if effect is Misalignment else {}))


def place(effect, axis):
    """Whether an effect has a place on the axis."""
    least = effect(**{item.name: max(item.metadata["low"], 0.0) for item in fields(effect)})
    try:
        least.check_axis(axis)
    except ValueError:
        return False
    return True


def axis_models(axis):
    """Any model of the axis from effects of the catalogue that have a place there."""
    made = [homely(effect, axis) for effect in CATALOGUE.values() if place(effect, axis)]
    return st.lists(st.one_of(made), max_size=6).map(lambda items: AxisModel(tuple(items)))


models = st.fixed_dictionaries({}, optional={axis: axis_models(axis) for axis in (*log.AXES, log.TIME)}).map(ErrorModel)


def still(axes=log.AXES, count=400):
    """The log of an error-free device."""
    return log.from_samples({axis: np.full(count, float(k)) for k, axis in enumerate(axes)}, 0.01)


@given(models)
def test_yaml_gives_the_model_back(tmp_path_factory, model):
    path = tmp_path_factory.mktemp("model") / "model.yaml"
    model.write(path)
    assert ErrorModel.read(path) == model


@given(models)
def test_plain_data_gives_the_model_back_and_is_plain(model):
    mapping = model.to_mapping()
    assert ErrorModel.from_mapping(mapping) == model
    assert yaml.safe_load(yaml.safe_dump(mapping)) == mapping


@pytest.mark.parametrize(
    ("mapping", "message"),
    [
        ({"giro_x": []}, "axis: expected gyro_x; found 'giro_x'"),
        ({"gyro_x": [{"white_nois": {"density": 1.0}}]}, "gyro_x: effect: expected white_noise; found 'white_nois'"),
        (
            {"accel_z": [{"random_walk": {"density": 1.0}}]},
            "accel_z: parameter of random_walk: expected density_k; found 'density'",
        ),
        ({"qqqq": []}, "axis: expected gyro_x, gyro_y, gyro_z, accel_x, accel_y, accel_z, time; found 'qqqq'"),
    ],
)
def test_a_misspelt_name_meets_the_nearest(mapping, message):
    with pytest.raises(ValueError, match=f"^{message}$"):
        ErrorModel.from_mapping(mapping)


def test_a_name_in_the_wrong_case_meets_itself():
    with pytest.raises(ValueError, match="expected gyro_x; found 'gyro_X'"):
        ErrorModel.from_mapping({"gyro_X": []})


@pytest.mark.parametrize(
    "text", ["gyro_x: [{white_noise: {density: -1.0}}]", "gyro_x: [white_noise]", "gyro_x: [", "3"]
)
def test_a_broken_file_names_itself(tmp_path, text):
    path = tmp_path / "model.yaml"
    path.write_text(text)
    with pytest.raises(ValueError, match=r"model\.yaml: "):
        ErrorModel.read(path)


def test_a_missing_parameter_is_named_with_its_axis():
    with pytest.raises(ValueError, match=r"gyro_x: .*density"):
        ErrorModel.from_mapping({"gyro_x": [{"white_noise": {}}]})


@pytest.mark.parametrize("text", ["1e-4", "1E-4", "+1e-4", "'1e-4'", "1.0e-4", "0.0001"])
def test_a_number_is_a_number_however_yaml_reads_it(tmp_path, text):
    path = tmp_path / "model.yaml"
    path.write_text(f"gyro_x: [{{white_noise: {{density: {text}}}}}]")
    assert ErrorModel.read(path) == ErrorModel({"gyro_x": AxisModel((WhiteNoise(1e-4),))})


@pytest.mark.parametrize("text", ["much", "1e-4x", "[1.0]", "null", "nan", "''"])
def test_what_is_no_number_is_named_with_file_axis_and_parameter(tmp_path, text):
    path = tmp_path / "model.yaml"
    path.write_text(f"gyro_x: [{{white_noise: {{density: {text}}}}}]")
    with pytest.raises(ValueError, match=r"model\.yaml: gyro_x: white_noise: white_noise\.density: expected a finite"):
        ErrorModel.read(path)


def test_effects_compose_with_plus():
    composed = WhiteNoise(1e-4) + RandomWalk(2e-6) + GaussMarkov(3e-5, 100.0)
    assert composed == AxisModel((WhiteNoise(1e-4), RandomWalk(2e-6), GaussMarkov(3e-5, 100.0)))
    assert WhiteNoise(1.0) + (Bias(1.0) + RandomWalk(1.0)) == AxisModel((WhiteNoise(1.0), Bias(1.0), RandomWalk(1.0)))
    assert sum(composed, AxisModel()) == composed


def test_composing_leaves_the_parts_alone():
    first = WhiteNoise(1.0) + Bias(1.0)
    assert first + RandomWalk(1.0) != first
    assert tuple(first) == (WhiteNoise(1.0), Bias(1.0))


@given(st.permutations([Resolution(1e-3), StabilityRestoration(0.01, 0.1), *ADDITIVE]))
@settings(max_examples=40)
def test_the_order_of_addition_does_not_matter(order):
    reference = AxisModel((*ADDITIVE, StabilityRestoration(0.01, 0.1), Resolution(1e-3)))
    found = AxisModel(tuple(order)).simulate(IDEAL, AT, 1, "order")
    expected = reference.simulate(IDEAL, AT, 1, "order")
    assert np.mean(np.abs(found - expected) > 1e-9) < 0.01  # but for the sum of floats that falls on a rounding limit


def test_stages_follow_the_chain_from_error_to_sequence_to_output():
    model = Resolution(1e-3) + StabilityRestoration(0.01, 0.1) + WhiteNoise(0.1)
    output = model.simulate(IDEAL, AT, 1)
    np.testing.assert_allclose(output / 1e-3, np.rint(output / 1e-3), atol=1e-9)
    assert bias_stability(output, 0.01, 0.1) == pytest.approx(0.01, rel=0.01)


def test_restoration_acts_on_the_error_and_not_on_the_signal():
    signal = np.sin(AT.time)
    model = WhiteNoise(0.1) + StabilityRestoration(0.01, 0.1)
    assert bias_stability(model.simulate(signal, AT, 1) - signal, 0.01, 0.1) == pytest.approx(0.01, rel=1e-9)


def test_errors_add_up():
    parts = [AxisModel((effect,)).simulate(0 * IDEAL, AT, 1, "sum") for effect in ADDITIVE]
    whole = AxisModel(ADDITIVE).simulate(IDEAL, AT, 1, "sum")
    np.testing.assert_allclose(whole, IDEAL + sum(parts), atol=1e-12)


def test_the_same_seed_and_labels_give_the_same_numbers_and_others_differ():
    model = WhiteNoise(1.0) + RandomWalk(1.0)
    first = model.simulate(IDEAL, AT, 1, "run", 1)
    np.testing.assert_array_equal(model.simulate(IDEAL, AT, 1, "run", 1), first)
    for seed, labels in ((2, ("run", 1)), (1, ("run", 2)), (1, ("run",))):
        assert abs(np.corrcoef(np.diff(model.simulate(IDEAL, AT, seed, *labels)), np.diff(first))[0, 1]) < 0.2


@pytest.mark.parametrize(
    "added", [Bias(0.1), TurnOnBias(0.1), GaussMarkov(0.1, 3.0), BiasInstability(0.1)], ids=lambda effect: effect.name
)
def test_adding_an_effect_disturbs_no_other(added):
    alone = WhiteNoise(0.3) + RandomWalk(0.2)
    share = (alone + added).simulate(IDEAL, AT, 1) - alone.simulate(IDEAL, AT, 1)
    own = AxisModel((added,)).simulate(0 * IDEAL, AT, 1)
    assert own.any()
    np.testing.assert_allclose(share, own, atol=1e-12)


def test_two_effects_of_a_kind_draw_from_streams_of_their_own():
    twice = (WhiteNoise(1.0) + WhiteNoise(1.0)).simulate(0 * IDEAL, AT, 1)
    once = AxisModel((WhiteNoise(1.0),)).simulate(0 * IDEAL, AT, 1)
    assert abs(np.corrcoef(twice - once, once)[0, 1]) < 0.2
    assert np.std(twice) / np.std(once) == pytest.approx(np.sqrt(2), rel=0.15)


def test_adding_an_axis_disturbs_no_other():
    one = ErrorModel({"gyro_z": WhiteNoise(1.0) + RandomWalk(1.0)})
    two = ErrorModel({"gyro_x": AxisModel((WhiteNoise(1.0),)), **one.axes})
    first, second = (model.simulate(still(), 1, "run") for model in (one, two))
    np.testing.assert_array_equal(first["gyro_z"], second["gyro_z"])
    narrow = one.simulate(still(axes=("gyro_z",)), 1, "run")
    np.testing.assert_allclose(narrow["gyro_z"], first["gyro_z"] - 2, rtol=0, atol=1e-12)


def test_axes_of_one_model_are_independent():
    measured = ErrorModel({axis: AxisModel((WhiteNoise(1.0),)) for axis in log.AXES}).simulate(still(count=4000), 1)
    correlation = np.corrcoef(measured.to_numpy().T) - np.eye(6)
    assert np.abs(correlation).max() < 5 / np.sqrt(4000)


def test_axes_without_a_model_and_the_temperature_pass_unchanged():
    ideal = still().assign(temperature=30.0)
    measured = ErrorModel({"gyro_x": AxisModel((Temperature(2.0, 25.0),))}).simulate(ideal, 1)
    np.testing.assert_allclose(measured["gyro_x"], 10.0)
    assert measured.drop(columns="gyro_x").equals(ideal.drop(columns="gyro_x"))
    assert list(measured.columns) == list(ideal.columns)


def test_a_model_without_effects_is_no_error():
    np.testing.assert_array_equal(AxisModel().simulate(IDEAL, AT, 1), IDEAL)
    np.testing.assert_array_equal(AxisModel().psd(np.ones(3)), np.zeros(3))
    np.testing.assert_array_equal(AxisModel().allan_variance(np.ones(3)), np.zeros(3))


def test_spectra_and_allan_variances_of_the_effects_add():
    stochastic = (WhiteNoise(0.02), RandomWalk(0.01), GaussMarkov(0.1, 3.0))
    model, at = AxisModel((*stochastic, Bias(1.0), Resolution(1e-3))), np.logspace(-2, 2, 9)
    assert model.stochastic() == stochastic
    np.testing.assert_allclose(model.psd(at), sum(effect.psd(at) for effect in stochastic), rtol=1e-14)
    np.testing.assert_allclose(model.state_space().psd(at), model.psd(at), rtol=1e-10)
    variances = sum(effect.allan_variance(at) for effect in stochastic)
    np.testing.assert_allclose(model.allan_variance(at), variances, rtol=1e-14)

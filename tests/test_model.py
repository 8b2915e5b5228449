import pickle
import re
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
    ClockScale,
    CommonMode,
    Conditions,
    GaussMarkov,
    LeverArm,
    Misalignment,
    NoiseDistribution,
    OutputFilter,
    RandomTelegraph,
    RandomWalk,
    Resolution,
    SampleLoss,
    Saturation,
    ScaleFactor,
    StabilityRestoration,
    Stage,
    StanceMotion,
    StuckSamples,
    Temperature,
    TimestampJitter,
    TurnOnBias,
    VarianceChange,
    WhiteNoise,
)
from imugap.effects.effect import AxisModel
from imugap.model import LARGEST, SMALLEST, ErrorModel
from imugap.numerics.samples.bias_stability import bias_stability
from imugap.stream import stream

AT = Conditions(0.01 * np.arange(600), 0.01, np.linspace(20, 30, 600))
IDEAL = np.full(600, 0.5)
ADDITIVE = (Bias(0.1), TurnOnBias(0.1), WhiteNoise(0.02), RandomWalk(0.01), GaussMarkov(0.1, 3.0), Temperature(0.02))


def numbers(item):
    low, high = item.metadata["low"], item.metadata["high"]
    if item.metadata["whole"]:
        return st.integers(int(low), int(min(high, LARGEST, 2**53)))
    above = st.floats(max(low, SMALLEST), min(high, LARGEST))
    below = st.floats(-LARGEST, -SMALLEST) if low < 0 and not isfinite(low) else st.nothing()
    return above | below | (st.just(0.0) if low <= 0 else st.nothing())


def homely(effect, axis):
    """Values of an effect that has a place on the axis."""
    drawn = {item.name: numbers(item) for item in fields(effect)}
    if effect is VarianceChange:
        times = st.tuples(drawn["start"], drawn["stop"]).map(sorted)
        return st.builds(lambda times, ratio: VarianceChange(*times, ratio), times, drawn["ratio"])
    if effect is NoiseDistribution:
        quantiles = st.tuples(*(drawn[item.name] for item in fields(effect)[1:])).map(sorted)
        return st.builds(lambda std, quantiles: NoiseDistribution(std, *quantiles), drawn["std"], quantiles)
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


@given(models.filter(lambda model: model.axes))
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
        ({"giro_x": []}, "axis: expected a known name (did you mean gyro_x?); found 'giro_x'"),
        (
            {"gyro_x": [{"white_nois": {"density": 1.0}}]},
            "gyro_x: effect: expected a known name (did you mean white_noise?); found 'white_nois'",
        ),
        (
            {"accel_z": [{"random_walk": {"density": 1.0}}]},
            "accel_z: parameter of random_walk: expected a known name (did you mean density_k?); found 'density'",
        ),
        ({"gyro_X": []}, "axis: expected a known name (did you mean gyro_x?); found 'gyro_X'"),
        ({"qqqq": []}, "axis: expected one of gyro_x, gyro_y, gyro_z, accel_x, accel_y, accel_z, time; found 'qqqq'"),
    ],
)
def test_a_misspelt_name_meets_the_nearest(mapping, message):
    with pytest.raises(ValueError, match=f"^{re.escape(message)}$"):
        ErrorModel.from_mapping(mapping)


@pytest.fixture
def read(tmp_path):
    """Read a model from a text."""

    def from_text(text):
        path = tmp_path / "model.yaml"
        path.write_text(text)
        return ErrorModel.read(path)

    return from_text


@pytest.mark.parametrize(
    ("text", "place"),
    [
        ("gyro_x: [{white_noise: {density: -1.0}}]", "gyro_x: "),
        ("gyro_x: [{white_noise: {}}]", "gyro_x: .*density"),
        ("gyro_x: [white_noise]", ""),
        ("gyro_x: [", "line 2, column 1: expected YAML"),
        ("3", "model: expected a mapping of axes; found 3"),
        ("", "expected a model of at least one axis; found none"),
        ("{}", "expected a model of at least one axis; found none"),
        ("gyro_x: 3", "gyro_x: expected a list of effects; found 3"),
        ("gyro_x: [[1]]", "gyro_x: expected an effect, .*; found a list of 1"),
        ("gyro_x: [{bias: [1]}]", "gyro_x: bias: expected a mapping of parameters; found a list of 1"),
        ("gyro_x: []\ngyro_x: []", "line 2, column 1: expected every key once"),
        ("gyro_x: [{white_noise: {density: 1e160}}]", "gyro_x: white_noise: .* in .1e-30, 1e.12.; found 1e.160"),
        ("gyro_x: [{white_noise: {density: 0100}}]", "line 1, column 34: expected a decimal number"),
        (f"gyro_x: [{', '.join(101 * ['{bias: {value: 1}}'])}]", "gyro_x: expected at most 100 effects; found 101"),
    ],
)
def test_a_broken_file_names_itself_and_the_axis(read, text, place):
    with pytest.raises(ValueError, match=rf"model\.yaml: {place}"):
        read(text)


@pytest.mark.parametrize("text", ["1e-4", "1E-4", "+1e-4", "'1e-4'", "1.0e-4", "0.0001"])
def test_a_number_is_a_number_however_yaml_reads_it(read, text):
    found = read(f"gyro_x: [{{white_noise: {{density: {text}}}}}]")
    assert found == ErrorModel({"gyro_x": AxisModel((WhiteNoise(1e-4),))})


@pytest.mark.parametrize("text", ["much", "1e-4x", "[1.0]", "null", "nan", "''", "true", "'0100'"])
def test_what_is_no_number_is_named_with_file_axis_and_parameter(read, text):
    with pytest.raises(ValueError, match=r"model\.yaml: gyro_x: white_noise: white_noise\.density: expected a finite"):
        read(f"gyro_x: [{{white_noise: {{density: {text}}}}}]")


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


SHUFFLED = (
    StuckSamples(0.3, 2.0),
    Resolution(0.1),
    Saturation(0.72),
    OutputFilter(5.0, 2),
    StabilityRestoration(0.01, 0.1),
    Bias(0.1),
    VarianceChange(1.0, 2.0, 4.0),
    WhiteNoise(0.1),
)


def test_effects_act_in_the_order_of_the_signal_chain():
    stages = [effect.stage for effect in AxisModel(SHUFFLED)]
    assert stages == list(Stage)[: len(stages)]
    output = AxisModel(SHUFFLED).simulate(IDEAL, AT, 1)
    expected = IDEAL.copy()
    error = np.zeros(len(AT))
    for effect in reversed(SHUFFLED):
        rng = stream(1, effect.name, 1)
        if effect.stage <= Stage.SEQUENCE:
            error = effect.apply(error, AT, rng)
            expected = IDEAL + error
        else:
            expected = effect.apply(expected, AT, rng)
    np.testing.assert_array_equal(output, expected)


def test_a_word_beyond_the_limit_is_the_rounded_limit():
    output = (Bias(5.0) + Resolution(0.1) + Saturation(0.72)).simulate(IDEAL, AT, 1)
    np.testing.assert_allclose(output, 0.7, rtol=1e-12)


def test_the_filter_smooths_the_signal_and_not_the_word():
    signal = np.where(AT.time < 3, 0.0, 1.0)
    output = (OutputFilter(1.0) + Resolution(0.25)).simulate(signal, AT, 1)
    assert set(output) == {0.0, 0.25, 0.5, 0.75, 1.0}


def common(loadings, own=None):
    extra = () if own is None else (WhiteNoise(own),)
    return ErrorModel({axis: AxisModel((CommonMode(0.3, loading), *extra)) for axis, loading in loadings.items()})


def test_axes_with_common_noise_differ_by_their_loading_only():
    measured = common({"gyro_x": 1.0, "gyro_z": -2.0, "accel_y": 0.0}).simulate(still(), 1, "run") - still()
    assert measured["gyro_x"].std() > 1
    np.testing.assert_allclose(measured["gyro_z"], -2 * measured["gyro_x"], rtol=1e-9, atol=1e-12)
    np.testing.assert_array_equal(measured["accel_y"], np.zeros(400))


def test_axes_with_common_and_own_noise_are_coherent_by_the_share_of_the_common():
    measured = common({"gyro_x": 1.0, "gyro_z": -2.0}, own=0.3).simulate(still(count=20_000), 1)
    found = np.corrcoef(measured["gyro_x"], measured["gyro_z"])[0, 1]
    expected = -2 / np.sqrt(2 * 5)
    assert abs(np.arctanh(found) - np.arctanh(expected)) < 4 / np.sqrt(20_000)
    for axis, loading in (("gyro_x", 1.0), ("gyro_z", -2.0)):
        power = 0.09 * (1 + loading**2) / 0.01
        assert abs(measured[axis].var() / power - 1) < 4 * np.sqrt(2 / 20_000)


def test_common_noise_of_other_runs_and_seeds_is_another():
    model = common({"gyro_x": 1.0})
    first = model.simulate(still(count=4000), 1, "run", 1)["gyro_x"]
    for seed, labels in ((2, ("run", 1)), (1, ("run", 2))):
        other = model.simulate(still(count=4000), seed, *labels)["gyro_x"]
        assert abs(np.corrcoef(first, other)[0, 1]) < 5 / np.sqrt(4000)


def test_common_noise_does_not_depend_on_which_axes_share_it():
    alone = common({"gyro_z": 1.5}).simulate(still(), 1)["gyro_z"]
    among = common({"gyro_x": 1.0, "gyro_z": 1.5, "accel_x": 2.0}).simulate(still(), 1)["gyro_z"]
    np.testing.assert_array_equal(alone, among)


def test_two_common_noises_of_an_axis_are_independent():
    twice = ErrorModel({"gyro_x": CommonMode(1.0) + CommonMode(1.0), "gyro_y": AxisModel((CommonMode(1.0),))})
    measured = twice.simulate(still(count=4000), 1) - still(count=4000)
    second = measured["gyro_x"] - measured["gyro_y"]
    assert abs(np.corrcoef(second, measured["gyro_y"])[0, 1]) < 5 / np.sqrt(4000)
    assert second.std() / measured["gyro_y"].std() == pytest.approx(1, rel=5 / np.sqrt(4000))


CLOCK = AxisModel((SampleLoss(0.05, 3.0), TimestampJitter(1e-4), ClockScale(1.02)))


def test_errors_of_the_clock_come_last_and_disturb_no_axis():
    noise = {"gyro_x": WhiteNoise(1.0) + RandomTelegraph(1.0, 2.0) + StuckSamples(0.1, 2.0)}
    plain = ErrorModel(noise).simulate(still(count=4000), 1, "run")
    measured = ErrorModel(noise | {"time": CLOCK}).simulate(still(count=4000), 1, "run")
    rows = np.rint(measured.index.to_numpy() / 0.01 / 1.02).astype(int)
    assert 0.5 < len(measured) / 4000 < 0.95
    np.testing.assert_array_equal(measured.to_numpy(), plain.to_numpy()[rows])
    assert np.abs(measured.index - 1.02 * 0.01 * rows).max() < 1e-3
    assert log.check(measured) is measured


def test_errors_of_the_clock_have_streams_of_their_own():
    one = ErrorModel({"time": AxisModel((TimestampJitter(1e-4),))}).simulate(still(count=4000), 1).index
    both = ErrorModel({"time": TimestampJitter(1e-4) + ClockScale(2.0)}).simulate(still(count=4000), 1).index
    twice = ErrorModel({"time": TimestampJitter(1e-4) + TimestampJitter(1e-4)}).simulate(still(count=4000), 1).index
    np.testing.assert_allclose(both, 2 * one, rtol=1e-14)
    first, second = one - still(count=4000).index, twice - one
    assert abs(np.corrcoef(first, second)[0, 1]) < 5 / np.sqrt(4000)


@pytest.mark.parametrize(
    ("axis", "effect", "message"),
    [
        ("gyro_x", ClockScale(1.1), "gyro_x: clock_scale: expected the pseudo-axis time; found gyro_x"),
        ("time", WhiteNoise(1.0), "time: white_noise: expected a sensor axis; found the pseudo-axis time"),
        ("time", StanceMotion(1.0, 0.0), "time: stance_motion: expected a sensor axis; found the pseudo-axis time"),
        ("gyro_x", LeverArm(0.1, 0.0, 0.0), "gyro_x: lever_arm: expected one of accel_x, .*; found gyro_x"),
        ("accel_y", Misalignment(y=0.1), "accel_y: misalignment.y: expected 0 on its own axis accel_y; found 0.1"),
    ],
)
def test_an_effect_away_from_home_is_refused(read, axis, effect, message):
    with pytest.raises(ValueError, match=f"^{message}$"):
        ErrorModel({axis: AxisModel((effect,))})
    with pytest.raises(ValueError, match=rf"model\.yaml: {message}$"):
        read(yaml.safe_dump({axis: [{effect.name: effect.parameters()}]}))


def test_a_model_fills_the_conditions_of_its_effects():
    ideal = still() + 1
    model = ErrorModel({"gyro_y": AxisModel((ScaleFactor(0.1),)), "accel_x": AxisModel((Misalignment(z=0.01),))})
    measured = model.simulate(ideal, 1)
    np.testing.assert_allclose(measured["gyro_y"], 2 * 1.1, rtol=1e-12)
    np.testing.assert_allclose(measured["accel_x"], 4 + 0.06, rtol=1e-12)


def test_errors_of_the_input_see_the_ideal_one_whatever_the_other_axes_have():
    ideal, lean = still() + 1, AxisModel((Misalignment(x=0.01),))
    alone = ErrorModel({"gyro_z": lean}).simulate(ideal, 1)["gyro_z"]
    among = ErrorModel({"gyro_x": AxisModel((Bias(5.0),)), "gyro_z": lean}).simulate(ideal, 1)["gyro_z"]
    np.testing.assert_array_equal(alone, among)


def test_the_sensors_of_a_model_are_all_but_its_clock():
    model = ErrorModel({"gyro_x": AxisModel((Bias(1.0),)), "time": CLOCK})
    assert model.sensors == {"gyro_x": model["gyro_x"]}


def test_a_model_survives_its_way_to_another_process():
    model = ErrorModel({"gyro_x": WhiteNoise(1e-3) + Bias(1e-4)})
    assert pickle.loads(pickle.dumps(model)) == model

import json
import re
import xml.etree.ElementTree as ET
from dataclasses import replace

import numpy as np
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from imugap import log
from imugap.analysis.omission_distance import distance
from imugap.effects import (
    Bias,
    BiasInstability,
    GaussMarkov,
    Misalignment,
    Quantization,
    RandomWalk,
    Resolution,
    SampleLoss,
    Saturation,
    ScaleFactor,
    Sinusoid,
    Temperature,
    TurnOnBias,
    WhiteNoise,
)
from imugap.effects.effect import AxisModel
from imugap.interchange.conventions import Rule, Triad
from imugap.interchange.export import PROGRAMS, Target, also_kept, export, notes, omitted
from imugap.interchange.omissions import cost
from imugap.model import ErrorModel
from imugap.units import to_si

RULE = Rule(rate=100.0)
FOREIGN = [target for target in Target if target is not Target.IMUGAP and target not in PROGRAMS]
YAML = [Target.KALIBR, Target.VINS, Target.ROS, Target.KF_GINS]
WALKING = [Target.KALIBR, Target.VINS, Target.AIRSIM, Target.GENESIS, Target.MATLAB]
"""Targets whose slow process is a random walk."""
STILL = [Target.ROS, Target.ISAAC_LAB]
"""Targets without a slow process."""
densities = st.floats(1e-7, 1e1)


def device(*effects, axes=log.AXES):
    return ErrorModel(dict.fromkeys(axes, AxisModel(effects)))


SLOW = RandomWalk(1e-4) + GaussMarkov(5e-4, 60.0) + TurnOnBias(2e-3)
FITTED = ErrorModel(
    {axis: Bias((-1) ** k * 0.01) + WhiteNoise(1e-3 * (k + 1)) + SLOW for k, axis in enumerate(log.AXES)}
)


def written(model, target, rule=RULE):
    """The file for a target, and the notes beside it where it has no comments."""
    return "\n".join([export(model, target, rule), *notes(model, target, rule)])


def numbers(text):
    """The numbers of a file: all but the topic."""
    return {name: value for name, value in yaml.safe_load(text).items() if name != "rostopic"}


@pytest.mark.parametrize("target", Target)
def test_every_file_is_plain_ascii_and_names_its_conventions(target):
    text = export(FITTED, target, RULE)
    assert text.isascii()
    assert text.endswith("\n")
    if target in FOREIGN:
        assert "Conventions: " in written(FITTED, target)


@pytest.mark.parametrize("target", [*YAML, Target.IMUGAP])
def test_every_yaml_holds_numbers_not_text(target):
    def leaves(value):
        if isinstance(value, dict):
            return [leaf for item in value.values() for leaf in leaves(item)]
        return [leaf for item in value for leaf in leaves(item)] if isinstance(value, list) else [value]

    found = numbers(export(device(WhiteNoise(1e-20), RandomWalk(1e-9)), target, RULE))
    assert all(isinstance(leaf, float) for leaf in leaves(found))


def test_kalibr_of_a_data_sheet():
    """0.1 deg/sqrt(h) and 0.01 m/s/sqrt(h)."""
    gyro, accel = WhiteNoise(to_si(0.1, "deg/sqrt(h)")), WhiteNoise(to_si(0.01, "m/s/sqrt(h)"))
    axes = {axis: (gyro if axis in log.GYRO else accel) + RandomWalk(1e-6) for axis in log.AXES}
    found = numbers(export(ErrorModel(axes), Target.KALIBR, RULE))
    assert found["gyroscope_noise_density"] == pytest.approx(2.908882e-5, rel=1e-6)
    assert found["accelerometer_noise_density"] == pytest.approx(1.666667e-4, rel=1e-6)
    assert found["gyroscope_random_walk"] == found["accelerometer_random_walk"] == pytest.approx(1e-6)
    assert found["update_rate"] == 100.0
    measured = export(ErrorModel(axes), Target.KALIBR, Rule(199.999997))
    assert "update_rate: 200.0  # Hz" in measured


@given(densities, densities)
def test_what_kalibr_is_told_is_a_model_that_tells_kalibr_the_same(white, walk):
    first = numbers(export(device(WhiteNoise(white), GaussMarkov(walk, 30.0), RandomWalk(walk)), Target.KALIBR, RULE))
    read = {
        axis: WhiteNoise(first[f"{name}_noise_density"]) + RandomWalk(first[f"{name}_random_walk"])
        for name, own in (("gyroscope", log.GYRO), ("accelerometer", log.ACCEL))
        for axis in own
    }
    assert numbers(export(ErrorModel(read), Target.KALIBR, RULE)) == pytest.approx(first, rel=1e-5)


def test_vins_needs_the_rate_and_kalibr_does_not():
    slow, fast = (numbers(export(FITTED, Target.VINS, replace(RULE, rate=rate))) for rate in (100.0, 400.0))
    assert {name: fast[name] / slow[name] for name in slow} == pytest.approx(dict.fromkeys(slow, 2.0), rel=1e-5)
    texts = [numbers(export(FITTED, Target.KALIBR, replace(RULE, rate=rate))) for rate in (100.0, 400.0)]
    for name in ("gyroscope_noise_density", "accelerometer_random_walk"):
        assert texts[0][name] == texts[1][name]


def test_the_worst_axis_is_at_least_the_mean_square():
    mean, worst = (numbers(export(FITTED, Target.KALIBR, replace(RULE, triad=triad))) for triad in Triad)
    assert worst["gyroscope_noise_density"] == pytest.approx(3e-3)
    assert mean["gyroscope_noise_density"] < worst["gyroscope_noise_density"]


def test_ros_has_a_diagonal_per_triad_and_no_orientation():
    found = numbers(export(FITTED, Target.ROS, RULE))
    assert found["orientation_covariance"] == [-1, *8 * [0]]
    gyro = np.reshape(found["angular_velocity_covariance"], (3, 3))
    accel = np.reshape(found["linear_acceleration_covariance"], (3, 3))
    np.testing.assert_allclose(gyro, np.diag([1e-4, 4e-4, 9e-4]), rtol=1e-5)
    np.testing.assert_allclose(accel, np.diag([16e-4, 25e-4, 36e-4]), rtol=1e-5)


def test_gazebo_is_well_formed_and_keeps_a_process_that_it_has():
    tree = ET.fromstring(export(device(WhiteNoise(1e-3), GaussMarkov(5e-4, 60.0)), Target.GAZEBO, RULE))
    for kind in ("angular_velocity", "linear_acceleration"):
        for axis in "xyz":
            noise = tree.find(f"{kind}/{axis}/noise")
            value = {item.tag: float(item.text) for item in noise}
            assert value["stddev"] == pytest.approx(1e-2)
            assert value["dynamic_bias_correlation_time"] == 60
            assert value["dynamic_bias_stddev"] * np.sqrt(60 / 2) == pytest.approx(5e-4, rel=1e-5)


def test_kf_gins_has_what_its_loader_asks_for():
    """The keys of loadConfig in src/kf_gins.cpp that concern the noise, and three axes each."""
    found = numbers(export(FITTED, Target.KF_GINS, RULE))
    assert set(found["imunoise"]) == {"arw", "vrw", "gbstd", "abstd", "gsstd", "asstd", "corrtime"}
    assert set(found) == {"imunoise", "initgyrbias", "initaccbias", "initbgstd", "initbastd"}
    assert found["imunoise"]["corrtime"] == 1
    assert all(len(found["imunoise"][name]) == 3 for name in ("arw", "vrw", "gbstd", "abstd", "gsstd", "asstd"))
    assert to_si(np.array(found["imunoise"]["vrw"]), "m/s/sqrt(h)") == pytest.approx([4e-3, 5e-3, 6e-3], rel=1e-5)
    assert to_si(np.array(found["initgyrbias"]), "deg/h") == pytest.approx([0.01, -0.01, 0.01], rel=1e-5)
    asked = numbers(export(FITTED, Target.KF_GINS, replace(RULE, correlation_time=7200.0)))
    assert asked["imunoise"]["corrtime"] == 2


def test_own_file_gives_the_model_back_and_its_state_space():
    model = device(Bias(0.1), WhiteNoise(0.2), GaussMarkov(0.3, 10.0), axes=("gyro_x", "accel_z"))
    found = numbers(export(model, Target.IMUGAP, RULE))
    assert ErrorModel.from_mapping(found["model"]) == model
    axis = {name: np.array(value) for name, value in found["axes"]["accel_z"].items()}
    np.testing.assert_allclose(axis["Phi"] @ axis["P0"] @ axis["Phi"].T + axis["Qd"], axis["P0"], rtol=1e-9)
    assert axis["Rd"] == pytest.approx(0.2**2 * 100)
    assert axis["H"] @ axis["P0"] @ axis["H"] == pytest.approx(0.09)


def test_own_file_of_white_noise_alone_has_no_states():
    found = numbers(export(device(WhiteNoise(0.2), axes=("gyro_x",)), Target.IMUGAP, RULE))
    assert found["axes"]["gyro_x"]["H"] == found["axes"]["gyro_x"]["Phi"] == []


@pytest.mark.parametrize("target", FOREIGN)
def test_what_is_left_out_is_said(target):
    model = device(WhiteNoise(1e-3), RandomWalk(1e-5), Quantization(2e-6), Resolution(1e-4))
    text, said = written(model, target), "\n".join(omitted(model, target, RULE))
    for one in (text, said):
        assert "gyro_x quantization (q 2.000000e-06): no Allan deviation at rest changes by more than 1%" in one
        assert ("accel_z resolution (step 1.000000e-04)" in one) == (not also_kept(target))
    assert text.count("Left out: ") == len(said.splitlines())


def test_what_an_omission_costs_is_the_ratio_of_allan_deviations():
    white, quantized, line = WhiteNoise(1e-4), Quantization(1e-5), Sinusoid(5.0, 5e-3)
    costs = {}
    for more in (quantized, line):
        said = omitted(device(white, RandomWalk(1e-6), more, ScaleFactor(0.01)), Target.KALIBR, RULE)
        found = re.findall(r"gyro_x (\w+) .*: without it the Allan deviation is (\S+) times", "\n".join(said))
        costs |= {name: float(ratio) for name, ratio in found}
        assert any("gyro_x scale_factor" in one and "with motion" in one for one in said)
    assert costs["sinusoid"] < 0.3
    of_white, of_steps = (one.allan_variance(0.01) for one in (white, quantized))
    assert costs["quantization"] == pytest.approx(np.sqrt(of_white / (of_white + of_steps)), rel=0.05)


def test_what_an_omission_costs_is_said_of_sizes_without_measure_and_of_models_without_noise():
    at = 0.01, 10.0
    sizes = AxisModel((WhiteNoise(1e-30), RandomWalk(1e30)))
    assert "Allan deviation is 1.7e-61 times" in cost("gyro_x", sizes, sizes.effects[1], *at).sentence()
    alone = AxisModel((Sinusoid(5.0, 1.0),))
    assert "no noise that a distance" in cost("gyro_x", alone, alone.effects[0], *at, distance).sentence()


def test_matlab_and_gazebo_hold_more_than_noise():
    extra = Resolution(1e-3), Saturation(20.0), Temperature(1e-3), ScaleFactor(0.01), Misalignment(y=0.002)
    own = {axis: AxisModel((WhiteNoise(1e-3), *extra[: None if axis == "gyro_x" else -1])) for axis in log.AXES}
    model = ErrorModel(own)
    part = json.loads(export(model, Target.MATLAB, RULE))["imugap"]["Gyroscope"]
    assert part["Resolution"] == 1e-3
    assert part["MeasurementRange"] == 20.0
    assert part["TemperatureBias"] == [1e-3, 1e-3, 1e-3]
    assert part["AxesMisalignment"] == [[101.0, 0.2, 0.0], [0.0, 101.0, 0.0], [0.0, 0.0, 101.0]]
    assert not omitted(model, Target.MATLAB, RULE)
    sdf = export(model, Target.GAZEBO, RULE)
    assert '<noise type="gaussian_quantized">' in sdf
    assert "<precision>1.000000e-03</precision>" in sdf


@pytest.mark.parametrize("target", [Target.AIRSIM, Target.MATLAB])
def test_a_format_without_comments_has_its_notes_beside_it(target):
    assert json.loads(export(FITTED, target, RULE))
    assert any("Conventions: " in note for note in notes(FITTED, target, RULE))
    assert not notes(FITTED, Target.KALIBR, RULE)


def ratios(text, axis):
    (line,) = (line for line in text.splitlines() if f" {axis}: " in line and " to " in line)
    low, high = line.replace("-->", "").split(": ")[1].partition(", farthest")[0].split(" to ")
    return float(low), float(high)


@pytest.mark.parametrize("target", [t for t in FOREIGN if t not in STILL])
def test_a_model_that_the_target_holds_is_told_exactly(target):
    slow = RandomWalk(1e-5) if target in WALKING else GaussMarkov(1e-4, 600.0)
    text = written(device(WhiteNoise(1e-3), slow), target, replace(RULE, correlation_time=600.0))
    assert ratios(text, "gyro_y") == (1.0, 1.0)


def test_a_file_says_at_which_time_it_is_farthest_from_the_model():
    """A random walk in place of flicker that agrees at 10 s is sqrt(10) off at 100 s."""
    text = export(device(WhiteNoise(1e-2), BiasInstability(1e-3)), Target.KALIBR, RULE)
    (line,) = (line for line in text.splitlines() if " gyro_y: " in line and " to " in line)
    assert line.endswith(", farthest from 1 at 100 s")


def test_what_ros_leaves_out_is_measured():
    low, high = ratios(export(FITTED, Target.ROS, RULE), "gyro_x")
    assert low < 0.7
    assert high == 1


@pytest.mark.parametrize("target", FOREIGN)
def test_a_model_that_lacks_an_axis_or_white_noise_is_refused(target):
    with pytest.raises(ValueError, match=r"model: .*; found none of accel_x, accel_y, accel_z"):
        export(device(WhiteNoise(1.0), RandomWalk(1.0), axes=log.GYRO), target, RULE)
    with pytest.raises(ValueError, match="gyro_x: expected white noise; found random_walk"):
        export(device(RandomWalk(1.0)), target, RULE)


@pytest.mark.parametrize("target", [Target.KALIBR, Target.VINS])
def test_tools_that_need_a_random_walk_say_so(target):
    with pytest.raises(
        ValueError,
        match=rf"gyro: expected a slow process; found white noise alone.*`imugap estimate LOG --to {target} FILE`",
    ):
        export(device(WhiteNoise(1.0)), target, RULE)


def test_flicker_has_no_filter_of_its_own_but_goes_to_a_tool():
    model = device(WhiteNoise(1e-3), BiasInstability(1e-4))
    with pytest.raises(ValueError, match="gyro_x: bias_instability: expected a process with a state space"):
        export(model, Target.IMUGAP, RULE)
    assert numbers(export(model, Target.KALIBR, RULE))["gyroscope_random_walk"] > 0


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("kalibre", r"a known name \(did you mean kalibr\?\)"),
        ("KF_GINS", r"a known name \(did you mean kf-gins\?\)"),
        (
            "zzz",
            "one of kalibr, vins, ros, gazebo, kf-gins, airsim, genesis, gnss-ins-sim, isaac-lab, matlab, pegasus, .*",
        ),
    ],
)
def test_an_unknown_target_meets_the_nearest(name, expected):
    with pytest.raises(ValueError, match=f"target: expected {expected}; found '{name}'"):
        Target.of(name)


def test_errors_of_the_clock_are_named_as_left_out():
    text = export(ErrorModel({**FITTED.axes, "time": AxisModel((SampleLoss(0.1, 2.0),))}), Target.IMUGAP, RULE)
    assert "# Not in the state space: time sample_loss" in text
    assert list(numbers(text)["axes"]) == list(log.AXES)
    assert ErrorModel.from_mapping(numbers(text)["model"])["time"] == AxisModel((SampleLoss(0.1, 2.0),))

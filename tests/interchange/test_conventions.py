"""Each tool's own propagation, restated from the file that its convention names, has to give the model's variance."""

from dataclasses import fields
from math import pi, sqrt

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from imugap.effects import (
    Bias,
    BiasInstability,
    Conditions,
    GaussMarkov,
    PowerLaw,
    Quantization,
    RandomWalk,
    RateRamp,
    TurnOnBias,
    WhiteNoise,
)
from imugap.effects.bias_instability import FLOOR
from imugap.effects.effect import AxisModel
from imugap.interchange.conventions import (
    CONVENTIONS,
    GAZEBO,
    HECTOR,
    HOUR,
    IMU_UTILS,
    KALIBR,
    KF_GINS,
    ORB_SLAM3,
    ROS,
    VINS,
    Reduced,
    Rule,
    Triad,
    combined,
    left_out,
    reduced,
)
from imugap.stream import stream
from imugap.units import FACTORS, from_si, to_si

N, K, STD, TIME, RATE = 3e-3, 2e-4, 5e-3, 40.0, 50.0
DT = 1 / RATE
STEPS = 500
RULE = Rule(RATE)
WALK = WhiteNoise(N) + RandomWalk(K)
MARKOV = WhiteNoise(N) + GaussMarkov(STD, TIME)
densities = st.floats(1e-8, 1e2)


def numbers(convention, model, rule=RULE, kind="gyro"):
    """What a tool is told of an axis, by name, in the unit of the tool."""
    of = reduced("gyro_x", model, rule)
    return {one.name.split()[-1]: from_si(one.value(of, rule), one.unit) for one in getattr(convention, kind)}


def test_openvins_propagates_the_variance_of_the_model():
    """G = dt, Qc = sigma^2/dt (Propagator.cpp)."""
    told = numbers(KALIBR, WALK)
    white = STEPS * DT**2 * told["gyroscope_noise_density"] ** 2 / DT
    walk = STEPS * DT**2 * told["gyroscope_random_walk"] ** 2 / DT
    assert white == pytest.approx(N**2 * STEPS * DT)
    assert walk == pytest.approx(K**2 * STEPS * DT)


def test_kalibr_weighs_a_sample_by_its_standard_deviation():
    """noise_density/sqrt(1/update_rate) (ConfigReader.py)."""
    told = numbers(KALIBR, WALK)
    assert told["gyroscope_noise_density"] / sqrt(1 / RATE) == pytest.approx(N / sqrt(DT))


def test_orb_slam3_propagates_the_variance_of_the_model():
    """Calib(Ng sf, .., Ngw/sf), sf = sqrt(frequency) (Tracking.cc); B = dt, and the walk added (ImuTypes.cc)."""
    told, sf = numbers(ORB_SLAM3, WALK), sqrt(RATE)
    assert STEPS * (DT * told["IMU.NoiseGyro"] * sf) ** 2 == pytest.approx(N**2 * STEPS * DT)
    assert STEPS * (told["IMU.GyroWalk"] / sf) ** 2 == pytest.approx(K**2 * STEPS * DT)


def test_vins_propagates_the_variance_of_the_model():
    """Two samples of weight dt/2 per step, independent of the next step's, and dt for the bias (integration_base.h)."""
    told = numbers(VINS, WALK)
    noise = np.diag([told["gyr_n"] ** 2, told["gyr_n"] ** 2, told["gyr_w"] ** 2])
    entry = np.array([[DT / 2, DT / 2, 0.0], [0.0, 0.0, DT]])
    covariance = sum(entry @ noise @ entry.T for _ in range(STEPS))
    assert covariance[0, 0] == pytest.approx(N**2 * STEPS * DT)
    assert covariance[1, 1] == pytest.approx(K**2 * STEPS * DT)


def test_midpoints_of_real_samples_have_the_variance_that_vins_propagates():
    """Neighbouring steps share a sample: the sum has N^2 t although each step has half of N^2 dt."""
    runs, at = 2000, Conditions(DT * np.arange(51), DT)
    samples = np.array([WhiteNoise(N).sample(at, stream(1, "vins", run)) for run in range(runs)])
    angle = (DT * (samples[:, 1:] + samples[:, :-1]) / 2).sum(axis=1)
    told = numbers(VINS, WALK)
    propagated = 50 * 2 * (DT / 2 * told["gyr_n"]) ** 2
    assert abs(np.log(angle.var() / propagated)) < 4 * sqrt(2 / runs) + 0.5 / 50  # half a sample less at the ends


def test_kf_gins_propagates_the_variance_of_the_model():
    """Units of kf_gins.cpp; Qc = 2 std^2/T, Qd = (Phi Q Phi' + Q)/2 dt (gi_engine.cpp)."""
    told = numbers(KF_GINS, MARKOV, Rule(RATE, correlation_time=TIME))
    arw, gbstd = told["arw"] * pi / 180 / 60, told["gbstd"] * pi / 180 / 3600
    phi, covariance = 1 - DT / TIME, 0.0
    for _ in range(round(10 * TIME * RATE)):
        covariance = phi**2 * covariance + (phi**2 + 1) / 2 * 2 / TIME * gbstd**2 * DT
    assert arw**2 == pytest.approx(N**2)
    assert covariance == pytest.approx(STD**2, rel=2 * DT / TIME)


def test_kf_gins_takes_milligal_and_hours():
    told = numbers(KF_GINS, MARKOV, Rule(RATE, correlation_time=TIME), "accel")
    assert told["vrw"] / 60 == pytest.approx(N)
    assert told["abstd"] * 1e-5 == pytest.approx(STD)
    assert told["corrtime"] * 3600 == pytest.approx(TIME)


@pytest.mark.parametrize(
    ("slow", "expected"),
    [((RandomWalk(K),), 3e-4), ((GaussMarkov(STD, TIME),), np.hypot(3e-4, STD)), ((BiasInstability(1e-4),), 3e-4)],
)
def test_the_spread_at_the_start_is_that_of_the_model_and_not_of_what_replaces_its_slow_part(slow, expected):
    model = AxisModel((WhiteNoise(N), TurnOnBias(3e-4), Bias(-0.01), *slow))
    told = numbers(GAZEBO, model)
    assert told["bias_stddev"] == pytest.approx(expected)
    assert told["mean"] == -0.01


def test_gazebo_draws_the_process_of_the_model():
    """sigma_b sqrt(tau/2 (1 - exp(-2 dt/tau))), phi = exp(-dt/tau) (GaussianNoiseModel.cc)."""
    told = numbers(GAZEBO, MARKOV)
    tau = told["dynamic_bias_correlation_time"]
    step = told["dynamic_bias_stddev"] ** 2 * tau / 2 * (1 - np.exp(-2 * DT / tau))
    assert step / (1 - np.exp(-2 * DT / tau)) == pytest.approx(STD**2)
    assert tau == TIME
    assert told["stddev"] == pytest.approx(N / sqrt(DT))


def test_hector_draws_the_process_of_the_model():
    """drift -= dt (drift f + N(0, sqrt(2 f) sigma)) (sensor_model.h)."""
    told = numbers(HECTOR, MARKOV)
    frequency = told["rateDriftFrequency"]
    hold, driving = 1 - DT * frequency, (DT * told["rateDrift"]) ** 2 * 2 * frequency
    assert driving / (1 - hold**2) == pytest.approx(STD**2, rel=DT * frequency)


def test_ros_has_the_variance_of_a_sample():
    (variance,) = numbers(ROS, WALK).values()
    samples = WhiteNoise(N).sample(Conditions(DT * np.arange(20_000), DT), stream(2, "ros"))
    assert abs(np.log(samples.var() / variance)) < 4 * sqrt(2 / 20_000)


def test_imu_utils_prints_a_sample_and_the_floor():
    """sqrt(freq) sigma(1 s) of the white noise, and the minimum of the fitted curve (fitallan_gyr.cpp)."""
    told = numbers(IMU_UTILS, WALK)
    assert told["gyr_n"] == pytest.approx(sqrt(RATE) * sqrt(WhiteNoise(N).allan_variance(1.0)))
    best = sqrt(3) * N / K
    assert told["gyr_w"] == pytest.approx(np.sqrt(WALK.allan_variance(best)), rel=1e-3)


@pytest.mark.parametrize(
    ("value", "unit", "per_root_second"),
    [
        (0.19983, "m/s/sqrt(h)", 0.00333),
        (0.47215, "deg/sqrt(h)", 0.00787 * pi / 180),
        (0.1, "deg/sqrt(h)", 2.908882e-5),
    ],
)
def test_random_walks_per_root_hour_are_densities(value, unit, per_root_second):
    """The first two pairs are printed by allan_variance_ros (README.md)."""
    assert to_si(value, unit) == pytest.approx(per_root_second, rel=1.5e-3)


def test_milligal_is_a_thousandth_of_a_centimetre_per_second_squared():
    assert from_si(to_si(1.0, "mg"), "mGal") == pytest.approx(980.665)


@given(densities, st.floats(1e-3, 1e3))
def test_a_random_walk_keeps_its_density_whatever_the_horizon(density, horizon):
    found = reduced("gyro_x", WhiteNoise(1.0) + RandomWalk(density), Rule(RATE, horizon))
    assert found.walk == pytest.approx(density, rel=1e-9)
    assert found.correlation_time == HOUR


@given(densities, st.floats(1.0, 1e4), st.floats(1e-3, 1e-1))
def test_a_slow_gauss_markov_process_is_a_random_walk_of_its_driving_density(std, time, share):
    found = reduced("gyro_x", WhiteNoise(1.0) + GaussMarkov(std, time), Rule(RATE, share * time))
    assert found.walk**2 == pytest.approx(GaussMarkov(std, time).driving_psd, rel=share)


@given(densities, st.floats(1e-2, 1e4), st.floats(1e-2, 1e3))
def test_a_gauss_markov_process_alone_keeps_itself(std, time, horizon):
    found = reduced("gyro_x", WhiteNoise(1.0) + GaussMarkov(std, time) + RandomWalk(0.0), Rule(RATE, horizon))
    assert (found.markov, found.correlation_time) == (pytest.approx(std, rel=1e-9), time)


@given(densities, st.floats(1e-2, 1e3))
def test_flicker_becomes_the_walk_that_crosses_its_floor_at_the_horizon(flicker, horizon):
    found = reduced("gyro_x", WhiteNoise(1.0) + BiasInstability(flicker), Rule(RATE, horizon))
    assert RandomWalk(found.walk).allan_variance(horizon) == pytest.approx((FLOOR * flicker) ** 2, rel=1e-9)


@pytest.mark.parametrize("exponent", [0.6, 1.0, 2.0, 2.9])
def test_noise_of_any_slope_becomes_the_walk_that_crosses_it_at_the_horizon(exponent):
    law = PowerLaw(1e-3, exponent)
    found = reduced("gyro_x", WhiteNoise(1.0) + law, Rule(RATE, 20.0))
    assert RandomWalk(found.walk).allan_variance(20.0) == pytest.approx(float(law.allan_variance(20.0)), rel=1e-9)
    assert not left_out(WhiteNoise(1.0) + law)


def test_a_trend_is_refused():
    with pytest.raises(ValueError, match="expected an exponent below 3"):
        reduced("gyro_x", WhiteNoise(1.0) + PowerLaw(1e-3, 3.2), Rule(RATE))


@given(st.floats(1e-3, 1e3))
def test_every_number_scales_as_its_unit(scale):
    """Errors ``scale`` times as large: each number ``scale`` times, variances its square, times the same."""
    one = Bias(0.1) + TurnOnBias(0.2) + WhiteNoise(N) + RandomWalk(K) + GaussMarkov(STD, TIME)
    other = Bias(0.1 * scale) + TurnOnBias(0.2 * scale) + WhiteNoise(N * scale)
    other += RandomWalk(K * scale) + GaussMarkov(STD * scale, TIME)
    for convention in CONVENTIONS:
        for kind in ("gyro", "accel"):
            before, after = numbers(convention, one, kind=kind), numbers(convention, other, kind=kind)
            for parameter in getattr(convention, kind):
                name = parameter.name.split()[-1]
                power = {"s": 0, "h": 0, "1/s": 0}.get(parameter.unit, 1 + (parameter.formula == "N²/Δt"))
                assert after[name] == pytest.approx(before[name] * scale**power, rel=1e-9)


@pytest.mark.parametrize("convention", [KALIBR, ORB_SLAM3, KF_GINS], ids=lambda one: one.tool)
def test_densities_do_not_depend_on_the_rate(convention):
    assert numbers(convention, WALK, Rule(10.0)) == numbers(convention, WALK, Rule(1000.0))


def test_white_noises_add_in_power():
    assert reduced("gyro_x", WhiteNoise(3.0) + WhiteNoise(4.0), Rule(RATE)).white == pytest.approx(5.0)


@given(st.lists(st.floats(1e-3, 1e3), min_size=3, max_size=3))
def test_mean_square_keeps_the_power_of_the_triad_and_the_worst_covers_each_axis(values):
    axes = [reduced("gyro_x", WhiteNoise(value) + RandomWalk(value), Rule(RATE)) for value in values]
    mean, worst = (combined(axes, triad) for triad in Triad)
    assert 3 * mean.white**2 == pytest.approx(sum(value**2 for value in values))
    for item in ("white", "walk", "markov"):
        assert getattr(worst, item) == max(getattr(one, item) for one in axes) >= getattr(mean, item) * (1 - 1e-12)


def test_three_equal_axes_are_one():
    one = reduced("gyro_x", Bias(-0.3) + TurnOnBias(0.1) + MARKOV, Rule(RATE))
    for triad in Triad:
        both = combined([one] * 3, triad)
        for item in fields(Reduced):
            assert getattr(both, item.name) == pytest.approx(getattr(one, item.name))


@pytest.mark.parametrize("model", [AxisModel(), AxisModel((RandomWalk(1.0),)), WhiteNoise(0.0) + Bias(1.0)])
def test_a_model_without_white_noise_is_refused(model):
    with pytest.raises(ValueError, match="accel_y: expected white noise; found"):
        reduced("accel_y", model, Rule(RATE))


@pytest.mark.parametrize("name", ["rate", "horizon", "correlation_time"])
@pytest.mark.parametrize("value", [0.0, -1.0, np.inf, np.nan])
def test_a_rule_takes_positive_numbers(name, value):
    with pytest.raises(ValueError, match=f"{name}: expected a finite number > 0; found {value}"):
        Rule(**({"rate": 1.0} | {name: value}))


def test_what_no_tool_holds_is_named():
    ramp, steps = RateRamp(1e-6), Quantization(1e-5)
    assert left_out(WALK + ramp + steps + TurnOnBias(1.0) + Bias(1.0)) == [ramp, steps]


def test_units_are_known_and_names_are_not_used_twice():
    for convention in CONVENTIONS:
        names = [one.name for one in convention.parameters()]
        assert len(set(names)) == len(names)
        assert {one.unit for one in convention.parameters()} <= set(FACTORS)

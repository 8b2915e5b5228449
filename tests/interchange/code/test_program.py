"""The programs of a model have its law: they are compared with its simulation, and with each other."""

import numpy as np
import pytest
from scipy.stats import chi2
from tests.chance import as_often_as, mean_is
from tests.interchange.code.running import at_rest, module, moving, run, run_cpp

from imugap import log
from imugap.discovery.device import Settings, discover
from imugap.effects import (
    CATALOGUE,
    BandNoise,
    Bias,
    BiasInstability,
    BiasStep,
    Chirp,
    ClockScale,
    Comb,
    CommonMode,
    DeadZone,
    Echo,
    GaussMarkov,
    GSensitivity,
    HeldSamples,
    LeverArm,
    Misalignment,
    NoiseDistribution,
    Outliers,
    OutputFilter,
    PowerLaw,
    Quantization,
    RandomTelegraph,
    RandomWalk,
    RateRamp,
    Resolution,
    SampleLoss,
    Saturation,
    ScaleFactor,
    Sinusoid,
    SkewedNoise,
    StabilityRestoration,
    StanceMotion,
    StuckSamples,
    Temperature,
    TimeOffset,
    TimestampJitter,
    TornWords,
    TurnOnBias,
    UniformNoise,
    VarianceChange,
    VibrationRectification,
    WarmUp,
    WhiteNoise,
)
from imugap.effects.effect import AxisModel
from imugap.estimation.variances import allan
from imugap.interchange.code.program import Language, left_out, program
from imugap.model import ErrorModel
from imugap.numerics.spectra.band_limited import REACH

RATE = 100.0
SEEDS = range(3)
NO_STEP = {BandNoise.name, StabilityRestoration.name, StanceMotion.name}
"""Kinds without a form as a step: a band has edges, one scales the run as a whole, one is no error of a log."""


def model(effects, axes=log.AXES, clock=()):
    sensors = dict.fromkeys(axes, AxisModel(tuple(effects)))
    return ErrorModel(sensors | ({log.TIME: AxisModel(tuple(clock))} if clock else {}))


EVERY = ErrorModel(
    {
        "gyro_x": AxisModel(
            (
                WhiteNoise(1e-3), GaussMarkov(5e-4, 20.0), Bias(0.01), BiasInstability(3e-4), PowerLaw(1e-4, 1.6),
                RandomWalk(2e-5), TurnOnBias(0.01), GSensitivity(1e-3, 2e-3, 3e-3), OutputFilter(20.0, 2),
                Resolution(1e-4), StuckSamples(0.01, 3.0),
            )
        ),
        "gyro_y": AxisModel(
            (
                CommonMode(1e-3, 0.5), Outliers(0.01, 0.1), RandomTelegraph(0.01, 0.2), Quantization(1e-5),
                WhiteNoise(1e-3), VarianceChange(1.0, 3.0, 2.0, 0.3, 0.5), TimeOffset(0.0034),
                NoiseDistribution(0.01, q_001=-2.4, q_999=4.0),
                ScaleFactor(0.01, 2e-3, 3e-3), Misalignment(0.01, 0.0, -0.02), OutputFilter(20.0, 2, 2),
            )
        ),
        "gyro_z": AxisModel((CommonMode(1e-3, -0.5), DeadZone(2e-3), Saturation(0.5), SampleLoss(0.01, 2.0),
                             UniformNoise(1e-3, 0.7), SkewedNoise(1e-3, -0.9))),
        "accel_x": AxisModel((LeverArm(0.1, -0.2, 0.3), Temperature(0.01, 25.0, 1e-3, 0.1), TornWords(0.2, 1e-4))),
        "accel_y": AxisModel((WarmUp(0.1, 2.0), Sinusoid(7.0, 0.1, 1.0), RateRamp(0.01), BiasStep(2.0, 0.3),
                              Chirp(3.0, 0.2, 0.1, 0.4), Comb(2.0, 0.1, 0.2, 0.4, phase_3=0.1, amplitude_3=0.3))),
        "accel_z": AxisModel((VibrationRectification(0.3, 0.1), OutputFilter(30.0, 3, 1), OutputFilter(35.0, 1, 3),
                              Echo(0.3, 7, 1), HeldSamples(4.0, 2.0))),
        log.TIME: AxisModel((ClockScale(1.0001), SampleLoss(0.01, 2.0), TimestampJitter(0.004))),
    }
)  # fmt: skip
"""A model with every kind that has a form as a step."""


def test_every_kind_of_the_catalogue_has_a_step():
    assert {one.name for axis in EVERY.axes.values() for one in axis} == set(CATALOGUE) - NO_STEP


def test_the_header_equals_the_module_bit_by_bit(tmp_path):
    ideal = moving(RATE, 400)
    for seed in (0, 2**63 + 11):
        ours, theirs = run(EVERY, RATE, ideal, seed), run_cpp(EVERY, RATE, ideal, f"{seed}ULL", tmp_path)
        np.testing.assert_array_equal(ours.astype(float), theirs)
        assert len(ours) == len(ideal)


@pytest.mark.parametrize(
    "effects",
    [
        (Bias(0.3),), (BiasStep(1.234, -0.2),), (RateRamp(0.02),), (Sinusoid(12.3, 0.5, 0.7),), (WarmUp(0.3, 1.7),),
        (ScaleFactor(0.01, 0.02, 0.03),), (Temperature(0.01, 20.0, 0.02),), (Saturation(0.7),), (Resolution(0.01),),
        (OutputFilter(17.0, 1),), (OutputFilter(17.0, 4),), (OutputFilter(60.0, 2, 1),), (OutputFilter(3.0, 3, 1),),
        (Echo(0.4, 12),), (Bias(0.1), ScaleFactor(0.1), OutputFilter(9.0, 2), Saturation(0.9), Resolution(0.003)),
    ],
)  # fmt: skip
def test_effects_without_chance_equal_the_simulation_everywhere(effects):
    ideal = moving(RATE, 400)
    expected = model(effects).simulate(ideal, 0)
    found = run(model(effects), RATE, ideal, 0)
    np.testing.assert_allclose(found[list(log.AXES)], expected[list(log.AXES)], rtol=0, atol=1e-9)
    np.testing.assert_allclose(found[log.TIME], expected.index, rtol=0, atol=1e-9)


@pytest.mark.parametrize(
    ("effects", "axes"),
    [
        ((TimeOffset(0.02),), log.AXES), ((TimeOffset(0.0137),), log.AXES), ((TimeOffset(-0.0042),), log.AXES),
        ((Misalignment(0.0, 0.02, -0.03),), ("gyro_x", "accel_x")), ((GSensitivity(0.1, 0.2, 0.3),), log.GYRO),
        ((LeverArm(0.1, -0.2, 0.3),), log.ACCEL), ((Temperature(0.01, 20.0, 0.0, 0.4),), log.AXES),
        ((VibrationRectification(0.3, 2.0),), ("gyro_y",)), ((VibrationRectification(0.3, 0.1, 1),), ("accel_y",)),
    ],
)  # fmt: skip
def test_effects_of_the_motion_equal_the_simulation_far_from_the_ends(effects, axes):
    ideal = moving(RATE, 500)
    expected, found = model(effects, axes).simulate(ideal, 0), run(model(effects, axes), RATE, ideal, 0)
    inside = slice(REACH, -REACH)
    apart = found[list(axes)].to_numpy()[inside] - expected[list(axes)].to_numpy()[inside]
    assert np.abs(apart).max() < 1e-9
    assert np.abs(expected[list(axes)] - ideal[list(axes)]).to_numpy().max() > 1e-3  # or nothing is compared
    np.testing.assert_array_equal(found[log.TIME], ideal.index)


@pytest.mark.parametrize("effect", [VibrationRectification(0.3, 2.0), Temperature(0.01, 20.0, 0.0, 0.4)])
def test_windows_end_with_the_stream(effect):
    ideal, single = moving(RATE, 150), model([effect], axes=("gyro_z",))
    expected, found = single.simulate(ideal, 0), run(single, RATE, ideal, 0)
    np.testing.assert_allclose(found["gyro_z"], expected["gyro_z"], rtol=0, atol=1e-9)


@pytest.mark.parametrize(("cutoff", "order", "form"), [(8.0, 1, 3), (25.0, 2, 2), (60.0, 3, 3)])
def test_a_filter_ahead_of_the_sampling_passes_motion_and_noise_as_the_simulation(cutoff, order, form):
    one = OutputFilter(cutoff, order, form)
    ideal, single = moving(RATE, 600), model([one], axes=("gyro_z",))
    expected, found = single.simulate(ideal, 0), run(single, RATE, ideal, 0)
    apart = found["gyro_z"].to_numpy() - expected["gyro_z"].to_numpy()
    assert np.abs(apart[200:-200]).max() < 1e-4
    noisy = [one_run(model([WhiteNoise(1.0), one]), seed, 750) for seed in range(2)]
    frequency = np.fft.rfftfreq(750, 1 / RATE)[1:]
    power = np.mean([np.abs(np.fft.rfft(drawn, axis=1)[:, 1:]) ** 2 for drawn in noisy], axis=(0, 1)) / 750 / RATE
    ratio = power / one.gain(frequency, 1 / RATE)
    bands = np.array([band.mean() for band in np.array_split(ratio, 10)])
    assert np.all(np.abs(bands - 1) < 4.5 / np.sqrt(len(noisy) * 6 * len(ratio) / 10))


def one_run(of, seed, count):
    """The errors of the six axes of a device at rest, shape (6, count)."""
    return run(of, RATE, at_rest(RATE, count), seed)[list(log.AXES)].to_numpy().T


@pytest.mark.parametrize(
    "effect",
    [
        WhiteNoise(1e-3), GaussMarkov(0.1, 0.3), GaussMarkov(0.1, 200.0), RandomWalk(0.01), Quantization(0.01),
        RandomTelegraph(0.1, 3.0), CommonMode(0.1, -0.3), BiasInstability(0.1), PowerLaw(0.1, 0.5), PowerLaw(0.1, 1.0),
        PowerLaw(0.1, 1.6), PowerLaw(0.1, 2.0), PowerLaw(0.1, 2.7),
    ],
)  # fmt: skip
def test_random_processes_have_the_allan_variance_of_their_samples(effect):
    """Two-sided, with the variance of the estimates over independent axes and seeds."""
    count, factors = 1024, np.array([1, 2, 4, 16, 64, 256])
    seeds, axes = (range(6 * len(SEEDS)), 1) if effect.shared else (SEEDS, 6)
    runs = np.concatenate([one_run(model([effect]), seed, count)[:axes] for seed in seeds])
    found = np.array([[allan.variance(one, np.array([n])).item() for n in factors] for one in runs])
    assert mean_is(found / effect.sampled_allan_variance(factors, 1 / RATE), np.ones(len(factors)), sigmas=4.5)


@pytest.mark.parametrize("exponent", [1.6, 2.0, 2.7])
def test_noise_that_begins_with_its_run_begins_at_zero(exponent):
    assert not one_run(model([PowerLaw(0.1, exponent)]), 1, 3)[:, 0].any()
    assert not one_run(model([RandomWalk(0.1)]), 1, 3)[:, 0].any()


def test_a_bias_of_the_run_has_its_spread():
    drawn = np.concatenate([one_run(model([TurnOnBias(0.2)]), seed, 3) for seed in range(40)])
    assert np.ptp(drawn, axis=1).max() == 0
    low, high = chi2.ppf([5e-5, 1 - 5e-5], len(drawn))
    assert low < np.sum(drawn[:, 0] ** 2) / 0.04 < high


def test_outliers_come_as_often_and_as_large_as_they_are_to():
    drawn = one_run(model([Outliers(0.05, 2.0)]), 3, 3000)
    assert as_often_as((drawn != 0).ravel(), 0.05)
    assert mean_is(drawn[drawn != 0] ** 2, 4.0)


def test_the_variance_changes_when_it_is_to():
    change = VarianceChange(5.0, 15.0, 4.0, 0.5, 0.2)
    drawn = np.concatenate([one_run(model([WhiteNoise(0.1), change]), seed, 2000) for seed in SEEDS])
    time = np.arange(2000) / RATE
    scaled = drawn**2 / change.factor(time)
    for part in np.split(scaled, 8, axis=1):
        assert mean_is(part.ravel(), 1.0)


def test_stuck_and_lost_samples_are_as_many_as_the_runs_of_the_simulation():
    stuck = one_run(model([WhiteNoise(0.1), StuckSamples(0.02, 4.0)]), 5, 6000)
    repeated = np.diff(stuck, axis=1) == 0
    begun = repeated[:, 1:] & ~repeated[:, :-1]
    assert as_often_as(begun[~repeated[:, :-1]], 0.02)
    assert as_often_as(~repeated[:, 1:][repeated[:, :-1]], 0.25)
    lost = np.isnan(one_run(model([WhiteNoise(0.1), SampleLoss(0.02, 4.0)]), 5, 6000))
    assert as_often_as((lost[:, 1:] & ~lost[:, :-1])[~lost[:, :-1]], 0.02)
    assert as_often_as(~lost[:, 1:][lost[:, :-1]], 0.25)


@pytest.mark.parametrize("std", [0.0005, 0.008])
def test_stamps_jitter_and_lose_rows_of_all_axes(std):
    clock = (ClockScale(1.001), SampleLoss(0.02, 3.0), TimestampJitter(std))
    found = run(model([WhiteNoise(0.1)], clock=clock), RATE, at_rest(RATE, 8000), 2)
    kept = found[~found["lost"].to_numpy(bool)]
    assert as_often_as((found["lost"].to_numpy(bool)[1:])[~found["lost"].to_numpy(bool)[:-1]], 0.02)
    assert np.all(np.diff(kept[log.TIME]) > 0)
    off = kept[log.TIME] - 1.001 * np.arange(8000)[kept.index] / RATE
    if std < 0.1 / RATE:
        assert mean_is(off**2, std**2)
    else:
        twin = model([], clock=(TimestampJitter(std),)).simulate(at_rest(RATE, 8000), 1).index - np.arange(8000) / RATE
        assert np.var(off) == pytest.approx(np.var(twin), rel=0.1)


def test_axes_seeds_and_like_effects_are_independent_and_common_noise_is_one():
    twice = one_run(model([GaussMarkov(1.0, 0.1), GaussMarkov(1.0, 0.1)]), 1, 2)
    assert len(np.unique(twice)) == twice.size
    first, again, other = (one_run(model([WhiteNoise(1.0)]), seed, 50) for seed in (1, 1, 2))
    np.testing.assert_array_equal(first, again)
    assert not np.intersect1d(first, other).size
    common = one_run(model([CommonMode(1.0, 2.0)]), 1, 50)
    assert np.ptp(common, axis=0).max() == 0


def test_a_step_that_is_no_interval_is_refused():
    imu = module(model([WhiteNoise(1.0)]), RATE).Imu()
    imu.step(0.0, (0, 0, 0), (0, 0, 0))
    with pytest.raises(ValueError, match=r"time: expected a step of 0.01 s, .*; found 0.02 s"):
        imu.step(0.02, (0, 0, 0), (0, 0, 0))


def test_axes_without_a_model_pass():
    ideal = moving(RATE, 20)
    found = run(model([Bias(1.0)], axes=("accel_y",)), RATE, ideal, 0)
    np.testing.assert_array_equal(found["accel_y"], ideal["accel_y"] + 1.0)
    others = [axis for axis in log.AXES if axis != "accel_y"]
    np.testing.assert_array_equal(found[others], ideal[others])


def test_what_has_no_step_is_named():
    of = model([WhiteNoise(1.0), StabilityRestoration(0.1, 1.0)], axes=("gyro_x",))
    assert left_out(of, 0.01) == ["gyro_x stability_restoration (stability 0.1, period 1)"]
    for language in Language:
        assert "Left out: gyro_x stability_restoration" in program(of, language, RATE)


@pytest.mark.parametrize(
    ("effects", "clock", "named"),
    [
        ([OutputFilter(60.0, 2)], (), "output_filter.cutoff"), ([TimeOffset(1e4)], (), "time_offset"),
        ([VibrationRectification(1.0, 1e5)], (), "vibration_rectification"),
        ([OutputFilter(1e-9, 2, 2)], (), "output_filter"), ([], (TimestampJitter(1e6),), "timestamp_jitter"),
    ],
)  # fmt: skip
def test_what_the_rate_does_not_allow_is_refused(effects, clock, named):
    with pytest.raises(ValueError, match=rf"{named}: expected .*; found"):
        program(model(effects, clock=clock), Language.CPP, RATE)


@pytest.mark.long
@pytest.mark.slow
def test_discovery_of_a_stream_finds_nothing_beyond_its_model(tmp_path):
    """Of a log that the header made, with the model that it was made of."""
    rate, count = 50.0, 30_000
    of = model(
        [
            Bias(0.02), WhiteNoise(1e-3), GaussMarkov(5e-4, 30.0), BiasInstability(2e-4), Sinusoid(7.3, 4e-4, 0.3),
            OutputFilter(12.0, 2), Resolution(1e-4),
        ],
        axes=("gyro_x", "accel_y"),
    )  # fmt: skip
    found = run_cpp(of, rate, at_rest(rate, count), 3, tmp_path).set_index(log.TIME)[["gyro_x", "accel_y"]]
    result = discover([found], Settings(start=of, seed=1, workers=1, gravity=9.8))
    assert not result.findings
    assert not result.unexplained
    assert not result.discrepancies

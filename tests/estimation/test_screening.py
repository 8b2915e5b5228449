"""What is no noise of the sensor is found, counted and left out; what is noise stays as it is."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from imugap.effects import BiasInstability, Conditions, GaussMarkov, Quantization, RandomWalk, Sinusoid, WhiteNoise
from imugap.effects.effect import AxisModel
from imugap.estimation.screening import screen
from imugap.stream import stream

COUNT, INTERVAL, STD = 30_000, 0.01, 0.01
WHITE = WhiteNoise(STD * np.sqrt(INTERVAL))
MODELS = {
    "white": AxisModel((WHITE,)),
    "walk": WHITE + RandomWalk(1e-3),
    "strong walk": WHITE + RandomWalk(1e-1),
    "flicker": WHITE + BiasInstability(1e-2),
    "gauss-markov": WHITE + GaussMarkov(2e-2, 0.1),
    "filtered": AxisModel((GaussMarkov(1.0, 0.05),)),
    "quantization": WHITE + Quantization(1e-4),
    "fast line": WHITE + Sinusoid(5.0, 0.03),
    "slow line": WHITE + Sinusoid(0.03, 5.0),
}
models = pytest.mark.parametrize("name", MODELS)


def simulate(name, *labels):
    conditions = Conditions(INTERVAL * np.arange(COUNT), INTERVAL)
    return MODELS[name].simulate(np.zeros(COUNT), conditions, 41, name, *labels)


def screened(values):
    return screen(values, stream(1, "screened"))


def found(values):
    return {one.kind: one for one in screened(values).disturbances}


@models
@pytest.mark.parametrize("run", range(3))
def test_sound_log_is_returned_unchanged(name, run):
    values = simulate(name, "sound", run)
    result = screened(values)
    assert result.disturbances == ()
    assert result.share == 1
    np.testing.assert_array_equal(result.values, values)


@pytest.mark.parametrize("freedom", [3, 5, 8])
def test_heavy_tails_are_noise(freedom):
    values = stream(2, "tails", freedom).standard_t(freedom, COUNT)
    assert screened(values).disturbances == ()


@pytest.mark.parametrize("std", [0.2, 0.35, 0.5, 1.0, 3.0])
@pytest.mark.parametrize("level", [0.0, 0.2, 0.5, "drift"])
def test_rounded_noise_is_noise(std, level):
    """A drift over several steps makes long runs of repeats, and is not stuck."""
    rng = stream(3, "rounded", std, level)
    levels = np.linspace(0, 5, COUNT) if level == "drift" else level
    assert screened(np.round(rng.normal(0, std, COUNT) + levels)).disturbances == ()


def test_louder_half_of_a_log_is_no_knock():
    values = stream(4, "loud").standard_normal(COUNT) * np.where(np.arange(COUNT) < COUNT // 2, 2, 1)
    assert screened(values).disturbances == ()


@settings(max_examples=12)
@given(
    share=st.sampled_from([0.002, 0.01, 0.05]),
    burst=st.sampled_from([1, 20]),
    size=st.sampled_from([(10, 10), (10, 1000), (1000, 1000)]),
)
def test_outliers_change_the_noise_by_less_than_3_per_cent(share, burst, size):
    rng = stream(5, "outliers", share, burst, size)
    sound = simulate("white", "outliers")
    hit = rng.choice(COUNT - burst, int(share * COUNT / burst), replace=False)
    outliers = np.zeros(COUNT)
    for first, scale in zip(hit, np.exp(rng.uniform(*np.log(size), len(hit))), strict=True):
        outliers[first : first + burst] += scale * STD * rng.choice([-1, 1], burst)
    result = screened(sound + outliers)
    assert result.values.std() / sound.std() == pytest.approx(1, abs=0.03)
    assert np.mean(result.replaced[outliers != 0]) > 0.97
    if burst == 1:
        (one,) = result.disturbances
        assert one.kind == "outlier"
        assert one.samples == pytest.approx(np.count_nonzero(outliers), rel=0.05, abs=3)


@pytest.mark.parametrize("name", ["white", "walk"])
@pytest.mark.parametrize("size", [30.0, 1e3, 1e6])
def test_knock_of_any_size_is_placed(name, size):
    after = np.arange(COUNT) - 12_000
    knock = np.where(after >= 0, size * STD * np.exp(-np.maximum(after, 0) / 30) * np.cos(0.7 * after), 0.0)
    sound = simulate(name, "knock")
    result = screened(sound + knock)
    (one,) = (one for one in result.disturbances if one.kind == "knock")
    assert one.stretches[0][0] == pytest.approx(12_000, abs=40)
    assert one.stretches[-1][1] < 12_000 + 700
    assert np.std(np.diff(result.values)) / np.std(np.diff(sound)) == pytest.approx(1, abs=0.01)


@pytest.mark.parametrize("name", ["white", "walk"])
def test_spike_is_one_sample(name):
    values = simulate(name, "spike")
    values[777] += 1e3 * STD
    (one,) = screened(values).disturbances
    assert (one.kind, one.samples, one.stretches) == ("outlier", 1, ((777, 778),))


@pytest.mark.parametrize("name", ["white", "walk"])
def test_step_of_the_level_at_a_knock_is_taken_out(name):
    rng, values = stream(6, "step"), simulate(name, "step")
    tilted = values + np.where(np.arange(COUNT) >= 15_000, 200 * STD, 0.0)
    tilted[14_970:15_000] += 500 * STD * rng.standard_normal(30)
    result = screened(tilted)
    assert {one.kind for one in result.disturbances} >= {"knock", "level step"}
    before, after = (np.median(part) for part in np.split(result.values - values, 2))
    assert abs(after - before) < 5 * STD


@pytest.mark.parametrize("name", ["white", "walk", "gauss-markov"])
@pytest.mark.parametrize("level", [None, 0.0])
def test_stuck_stretch_is_left_out(name, level):
    """The output keeps its last value, or that of a device without power."""
    values = simulate(name, "stuck")
    values[9000:18_000] = values[9000] if level is None else level
    one = found(values)["stuck stretch"]
    assert one.samples == pytest.approx(9000, abs=2)
    assert one.stretches[0] == (9001, 18_000)


def test_single_losses_are_drawn():
    values = simulate("white", "gap")
    values[[100, 5000]] = np.nan
    result = screened(values)
    assert np.isfinite(result.values).all()
    assert result.disturbances[0].stretches == ((100, 101), (5000, 5001))


def test_long_gaps_are_counted_and_left_to_the_model_of_the_log():
    values = simulate("white", "gap")
    values[100:200] = values[5000] = np.nan
    result = screened(values)
    assert np.array_equal(np.isnan(result.values), np.isnan(values))
    assert result.disturbances[0].stretches == ((100, 200), (5000, 5001))
    assert result.share == pytest.approx(1 - 101 / COUNT)


def test_log_without_an_undisturbed_part_is_refused():
    values = simulate("white", "lost")
    values[: int(0.9 * COUNT) + 1] = np.nan
    with pytest.raises(ValueError, match=r"samples: expected at least 10% that are undisturbed; found 10\.0%"):
        screened(values)


def test_units_do_not_matter():
    values = simulate("white", "units")
    values[1000:1020] += 50 * STD
    one, other = screened(values), screened(1e6 * values)
    np.testing.assert_array_equal(one.replaced, other.replaced)
    np.testing.assert_allclose(other.values, 1e6 * one.values)

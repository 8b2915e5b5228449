"""Another scale of an axis or a run is found, and distinguished from coarse words and from noise, two-sided."""

import numpy as np
import pandas as pd
import pytest

from imugap.integrity.regular import Fault, regular
from imugap.integrity.scales import Scale, loud_axis, odd_axis, odd_run
from imugap.log import AXES, GYRO, TIME
from imugap.stream import stream

COUNT = 6000
STEP = np.radians(1 / 131)
FACTORS = [16.0, 24.0, 256.0, 65536.0, 1 / 16, 1 / 256, 1 / 65536]


def counts(noise, *labels):
    """Rounded samples of white noise about a level, in counts."""
    rng = stream(51, "scales", *labels)
    return np.rint(rng.normal(0, 50) + noise * rng.standard_normal(COUNT))


def sensor(noises=(6.0, 5.0, 9.0), factors=(1.0, 1.0, 1.0), seed=0):
    """Scales of three axes of some noise [counts], each times a factor."""
    parts = zip(GYRO, noises, factors, strict=True)
    return {axis: Scale.of(STEP * factor * counts(noise, axis, seed)) for axis, noise, factor in parts}


def at_rest(scaled=None, by=1.0):
    """A log of continuous values of which one axis is times a factor."""
    values = stream(51, "rest").standard_normal((COUNT, 6)) * np.repeat([1e-3, 1e-2], 3)
    values[:, 5] -= 9.80665
    log = pd.DataFrame(values, columns=list(AXES), index=pd.Index(0.02 * np.arange(COUNT), name=TIME))
    return log if scaled is None else log.assign(**{scaled: by * log[scaled]})


@pytest.mark.parametrize("noise", [0.5, 1.0, 3.0, 30.0])
def test_the_noise_is_that_before_the_rounding(noise):
    found = Scale.of(STEP * counts(noise, "before"))
    assert found.lattice == pytest.approx(STEP)
    assert found.noise == pytest.approx(STEP * noise, rel=0.1)


def test_noise_that_the_lattice_hides_is_not_known():
    assert np.isnan(Scale.of(STEP * counts(0.2, "hidden")).noise)


def test_knocks_and_lost_samples_do_not_change_the_scale():
    values = STEP * counts(6.0, "knocked")
    knocked = values.copy()
    knocked[1000:1010] += 1e4 * STEP
    knocked[2000:2100] = np.nan
    assert Scale.of(knocked).noise == pytest.approx(Scale.of(values).noise, rel=0.02)


@pytest.mark.parametrize("factor", FACTORS)
@pytest.mark.parametrize("place", range(3))
def test_an_axis_of_another_scale_is_found_with_its_factor(factor, place):
    factors = [1.0, 1.0, 1.0]
    factors[place] = factor
    odd = odd_axis(sensor(factors=factors))
    assert (odd.name, odd.factor) == (GYRO[place], pytest.approx(factor, rel=1e-6))


@pytest.mark.parametrize("noises", [(6.0, 5.0, 9.0), (1.0, 10.0, 1.2), (16.0, 1.0, 1.0), (3.0, 3.0, 48.0)])
def test_noise_alone_makes_no_other_scale(noises):
    assert odd_axis(sensor(noises)) is None


@pytest.mark.parametrize("factor", [2.0, 16.0, 256.0, 1 / 16])
def test_a_coarser_word_of_the_same_scale_is_none(factor):
    """The step is another, the noise is not."""
    scales = sensor((500.0, 400.0, 600.0))
    scales["gyro_y"] = Scale.of(STEP * factor * np.rint(stream(51, "coarse").normal(0, 500 / factor, COUNT)))
    assert odd_axis(scales) is None


@pytest.mark.parametrize("factor", [2.0, 4.0, 0.25])
def test_ranges_that_devices_mix_are_none(factor):
    assert odd_axis(sensor(factors=(1.0, 1.0, factor))) is None


def test_two_axes_show_no_odd_one():
    scales = sensor(factors=(1.0, 256.0, 1.0))
    assert odd_axis({axis: scales[axis] for axis in GYRO[:2]}) is None


@pytest.mark.parametrize(("ratio", "loud"), [(10.0, False), (0.1, False), (16.0, True), (1 / 16, True), (256.0, True)])
def test_noise_far_from_that_of_both_others_is_remarked(ratio, loud):
    found = loud_axis(sensor((20.0, 20.0 * ratio, 24.0) if ratio > 1 else (200.0, 200.0 * ratio, 180.0)))
    assert (found is not None and found.name == "gyro_y") == loud


@pytest.mark.parametrize("by", [16.0, 256.0, 1 / 16])
def test_a_log_at_rest_says_so(by):
    (remark,) = [one for one in regular(at_rest("gyro_y", by)).remarks if one.fault is Fault.LOUD]
    assert str(remark).startswith("gyro_y: noise ")


def test_a_log_of_equal_noise_or_in_motion_does_not():
    moved = at_rest("gyro_y", 16.0)
    moved["gyro_z"] += np.sin(moved.index.to_numpy())
    moved["accel_x"] += 3 * np.sin(moved.index.to_numpy())
    for log in (at_rest(), at_rest("gyro_x", 5.0), moved):
        assert not [one for one in regular(log).remarks if one.fault is Fault.LOUD]


@pytest.mark.parametrize("factor", FACTORS)
@pytest.mark.parametrize("place", range(3))
def test_a_run_of_another_scale_is_found(factor, place):
    runs = {run: Scale.of(STEP * counts(6.0, run) * (factor if run == place else 1.0)) for run in range(3)}
    odd, middle = odd_run(runs)
    assert (odd.name, odd.factor) == (place, pytest.approx(factor, rel=1e-6))
    assert middle != place


@pytest.mark.parametrize(
    ("factor", "found"), [(16.0, True), (1 / 256, True), (4.0, False), (11.3, False), (1.3, False)]
)
def test_without_a_lattice_a_power_of_two_shows_it(factor, found):
    noise = {run: stream(51, "smooth", run).standard_normal(COUNT) * (factor if run == 1 else 1.0) for run in range(3)}
    odd = odd_run({run: Scale.of(values) for run, values in noise.items()})
    assert (odd is not None and odd[0].name == 1) == found


def test_runs_of_axes_without_noise_are_none():
    assert odd_run({run: Scale.of(np.zeros(COUNT)) for run in range(3)}) is None
    assert odd_run({}) is None

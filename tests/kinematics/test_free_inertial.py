from math import radians

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import norm

from imugap import log
from imugap.kinematics import strapdown
from imugap.kinematics.free_inertial import QUANTITIES, STARTS, StaticNavigation, crps, differences, errors
from imugap.kinematics.site import Site
from imugap.stream import stream

RAW, CALIBRATED = map(STARTS.index, ("raw", "calibrated"))
KNOWN = Site(radians(40.0), 50.0, radians(30.0))
UNKNOWN = Site(radians(40.0), 50.0)


def course(site=UNKNOWN, full=False, calibration_s=10.0, length_s=60.0, epoch_s=1.0):
    return StaticNavigation(site, full, calibration_s, length_s, epoch_s)


def column(name):
    return strapdown.COLUMNS.index(name)


def gaussian_crps(y, mean, std):
    """CRPS of a normal forecast (Gneiting and Raftery 2007, J. Amer. Statist. Assoc. 102, eq. 21 ff.)."""
    z = (y - mean) / std
    return std * (z * (2 * norm.cdf(z) - 1) + 2 * norm.pdf(z) - 1 / np.sqrt(np.pi))


def test_quantities_are_columns_of_the_navigation():
    assert {name: strapdown.COLUMNS[index] for name, index in QUANTITIES.items()} == {
        name: name for name in ("east", "north", "heading")
    }


@pytest.mark.parametrize(("site", "full"), [(UNKNOWN, False), (KNOWN, True)], ids=["local", "ellipsoid"])
@pytest.mark.parametrize("length_s", [60.0, 600.0])
def test_an_error_free_log_does_not_drift(site, full, length_s):
    navigated = course(site, full, length_s=length_s)
    path = navigated.drift(navigated.ideal(0.01))
    assert path.shape == (2, length_s + 1, 9)
    limit = np.repeat([1e-4, 1e-6, 1e-9], 3) * (length_s / 60) ** 2
    assert np.all(np.abs(path) < limit)


@pytest.mark.parametrize(
    ("site", "full"),
    [
        pytest.param(KNOWN, False, id="heading known, Earth rate not in the mechanisation"),
        pytest.param(UNKNOWN, True, id="heading unknown, Earth rate in the mechanisation"),
    ],
)
def test_a_calibrated_error_free_log_does_not_drift_whatever_the_site_and_mechanisation(site, full):
    navigated = course(site, full)
    path = navigated.drift(navigated.ideal(0.01))[CALIBRATED]
    assert np.abs(path[-1, column("east")]) < 1e-3


@pytest.mark.parametrize(("site", "full"), [(UNKNOWN, False), (KNOWN, True)], ids=["local", "ellipsoid"])
def test_calibration_takes_a_constant_bias_off(site, full):
    navigated = course(site, full)
    biased = navigated.ideal(0.01).add([1e-3, -2e-3, 5e-3, 0.02, 0.01, -0.03])
    path = navigated.drift(biased)
    assert np.abs(path[RAW, -1, :3]).max() > 10
    assert np.abs(path[CALIBRATED]).max() < 1e-3


def test_raw_drift_of_a_bias_is_what_kinematics_says():
    navigated, rate, force = course(), 5e-3, 0.01
    turned = navigated.drift(navigated.ideal(0.01).assign(gyro_z=rate))
    pushed = navigated.drift(navigated.ideal(0.01).assign(accel_x=force))
    time = navigated.epochs()
    np.testing.assert_allclose(turned[RAW, :, column("heading")], rate * time, atol=1e-9)
    np.testing.assert_allclose(pushed[RAW, :, column("north")], force * time**2 / 2, atol=1e-5)
    np.testing.assert_allclose(pushed[RAW, :, column("east")], 0, atol=1e-9)


def test_drift_is_counted_from_the_true_heading():
    navigated = course(KNOWN, full=True, length_s=10.0)  # before Coriolis bends the track
    path = navigated.drift(navigated.ideal(0.01).add([0, 0, 0, 0.01, 0, 0]))
    north, east = path[RAW, -1, column("north")], path[RAW, -1, column("east")]
    assert np.arctan2(east, north) == pytest.approx(radians(30.0), abs=1e-3)
    assert abs(path[RAW, 0, column("heading")]) < 1e-12


def test_heading_is_unwrapped():
    navigated = course(length_s=100.0)
    path = navigated.drift(navigated.ideal(0.01).assign(gyro_z=0.1))
    assert path[RAW, -1, column("heading")] == pytest.approx(10.0, abs=1e-6)


def test_only_the_calibration_time_calibrates():
    navigated = course()
    stepped = navigated.ideal(0.01)
    stepped.loc[stepped.index > 10.0 - 1e-9, "gyro_z"] += 1e-3
    path = navigated.drift(stepped)
    np.testing.assert_allclose(path[CALIBRATED], path[RAW], atol=1e-9)


def test_a_longer_log_is_navigated_over_the_length_only_and_a_shorter_one_is_refused():
    navigated = course()
    ideal = course(length_s=90.0).ideal(0.01)
    assert len(navigated.drift(ideal)[RAW]) == len(navigated.epochs()) == 61
    with pytest.raises(log.LogError, match=r"expected 7001 samples to navigate; found 6999"):
        navigated.drift(ideal.iloc[:6999])


@pytest.mark.parametrize("interval", [1 / 128, 1 / 100, 1 / 8])
def test_epochs_belong_to_the_stored_drift_at_any_rate(interval):
    navigated, force = course(epoch_s=0.5), 0.01
    path = navigated.drift(navigated.ideal(interval).assign(accel_x=force))[RAW]
    assert len(path) == len(navigated.epochs())
    np.testing.assert_allclose(path[:, column("north")], force * navigated.epochs() ** 2 / 2, atol=1e-5)


@pytest.mark.parametrize(("interval", "epoch_s"), [(1 / 128, 0.1), (0.01, 0.015), (0.3, 1.0), (0.01, 0.004)])
def test_an_epoch_that_is_no_multiple_of_the_interval_is_refused(interval, epoch_s):
    navigated = course(epoch_s=epoch_s)
    with pytest.raises(ValueError, match=f"epoch_s: expected a multiple of the interval .*; found {epoch_s} s"):
        navigated.drift(navigated.ideal(interval))


@pytest.mark.parametrize("lost", [slice(3000, 3001), slice(3000, 3100), slice(500, 502)])
def test_a_log_with_a_gap_is_refused(lost):
    navigated = course()
    ideal = course(length_s=90.0).ideal(0.01)
    with pytest.raises(log.LogError, match=r"expected steps of 0\.01 s to navigate; found one of"):
        navigated.drift(ideal.drop(ideal.index[lost]))


def test_stamps_that_jitter_are_no_gap():
    navigated = course()
    ideal = navigated.ideal(0.01)
    inner = np.clip(stream(75).normal(0.0, 5e-4, len(ideal)), -2e-3, 2e-3) * (
        np.arange(len(ideal)) % (len(ideal) - 1) > 0
    )
    jittered = ideal.set_axis(pd.Index(ideal.index + inner, name="time"))
    np.testing.assert_allclose(navigated.drift(jittered), navigated.drift(ideal), atol=1e-9)


def test_a_gap_behind_the_navigation_does_not_matter():
    navigated = course()
    ideal = course(length_s=90.0).ideal(0.01)
    assert len(navigated.drift(ideal.drop(ideal.index[8000:8010]))[RAW]) == len(navigated.epochs())


@pytest.mark.parametrize("ppm", [20, -50])
def test_a_clock_as_good_as_quartz_is_good_enough(ppm):
    navigated = course()
    ideal = course(length_s=61.0).ideal(0.01)
    off = ideal.set_axis(pd.Index(ideal.index * (1 + ppm * 1e-6), name="time"))
    assert len(navigated.drift(off)[RAW]) == len(navigated.epochs())


def test_a_log_one_sample_short_is_not_said_to_be_long_enough():
    navigated = course()
    with pytest.raises(log.LogError) as caught:
        navigated.drift(navigated.ideal(0.01).iloc[:7000])
    assert f"expected {caught.value.found}" not in str(caught.value)


@pytest.mark.parametrize("site", [KNOWN, UNKNOWN], ids=["heading known", "heading unknown"])
@pytest.mark.parametrize("full", [True, False], ids=["ellipsoid", "local"])
def test_rest_is_the_input_that_leaves_the_mechanisation_at_rest(site, full):
    navigated = course(site, full)
    samples = log.from_samples({axis: np.full(7001, value) for axis, value in navigated.rest().items()}, 0.01)
    start = navigated.drift(samples)
    assert list(navigated.rest().index) == list(log.AXES)
    assert np.abs(start[CALIBRATED]).max() < 1e-3
    np.testing.assert_allclose(start[RAW], start[CALIBRATED], atol=1e-9)


def test_rest_has_the_earth_rate_only_where_the_mechanisation_has_it():
    local, full = course(KNOWN, False).rest(), course(KNOWN, True).rest()
    assert (local[list(log.GYRO)] == 0).all()
    assert np.linalg.norm(full[list(log.GYRO)]) == pytest.approx(7.292115e-5, rel=1e-9)
    assert local["accel_z"] == full["accel_z"] == -KNOWN.gravity
    north = course(UNKNOWN, True).rest()
    assert north["gyro_y"] == 0
    assert north["gyro_x"] > 0 > north["gyro_z"]


def test_course_reads_the_configuration():
    navigation = {"mechanisation": "ellipsoid", "calibration_s": 30, "horizons_s": [60, 10], "epoch_s": 2}
    found = StaticNavigation.from_mapping({"latitude_deg": 40.0, "height_m": 50.0}, navigation, 60)
    assert found == StaticNavigation(UNKNOWN, True, 30, 60, 2)
    np.testing.assert_array_equal(found.epochs(), np.arange(0, 61, 2))


# Two runs, two trials, four epochs, one quantity.
MEASURED = np.array([[0.0, 1, 2, 4], [0, -1, -2, -5]])[..., None]
SIMULATED = np.array([[0.0, 1, 5, 4], [0, 0, 0, 0]])[..., None]


def test_differences_of_a_known_example():
    found = differences(MEASURED, SIMULATED)[..., 0]
    np.testing.assert_array_equal(found[0], [[0, 0, -3, 0], [0, 1, 2, 4]])
    np.testing.assert_array_equal(found[1], [[0, -2, -7, -9], [0, -1, -2, -5]])


def test_errors_of_a_known_example():
    absolute, relative = errors(MEASURED, SIMULATED, np.array([1, 3]))
    np.testing.assert_array_equal(absolute[..., 0], [[[0, 3], [1, 4]], [[2, 9], [1, 5]]])
    np.testing.assert_allclose(relative[..., 0], [[[0, 0.75], [1, 1]], [[2, 1.8], [1, 1]]], rtol=1e-15)


def test_errors_agree_with_the_differences():
    rng = stream(71)
    measured, simulated = rng.standard_normal((3, 20, 2)), rng.standard_normal((4, 20, 2))
    absolute, relative = errors(measured, simulated, np.array([5, 19]))
    d = np.abs(differences(measured, simulated))
    np.testing.assert_array_equal(absolute[:, :, 0], d[:, :, :6].max(axis=2))
    np.testing.assert_array_equal(absolute[:, :, 1], d.max(axis=2))
    np.testing.assert_allclose(relative[:, :, 1] * np.abs(measured[:, None, -1]), absolute[:, :, 1], rtol=1e-14)


def test_crps_of_a_known_example():
    """|0 - 1|, |3 - 1|, |4 - 1| average 2; distinct pairs differ by 3, 4, 1, on average 8/3."""
    assert crps(np.array([1.0]), np.array([0.0, 4.0, 3.0])) == pytest.approx(2 - 8 / 3 / 2, rel=1e-14)


@pytest.mark.parametrize("size", [2, 5, 50])
@pytest.mark.parametrize("y", [-1.0, 0.3, 2.5])
def test_crps_is_unbiased_whatever_the_size_of_the_ensemble(size, y):
    ensembles = stream(72, size, y).normal(0.5, 1.3, (size, 20_000))
    scores = crps(np.full((1, 20_000), y), ensembles)[0]
    assert abs(scores.mean() - gaussian_crps(y, 0.5, 1.3)) < 4 * scores.std() / np.sqrt(len(scores))


@pytest.mark.parametrize(("mean", "std"), [(0.5, 1.0), (-0.5, 1.0), (0.0, 0.5), (0.0, 2.0), (1.0, 2.0)])
def test_no_ensemble_does_better_than_the_law_of_the_observations(mean, std):
    rng, cases = stream(73, mean, std), 20_000
    observed, drawn = rng.standard_normal((1, cases)), rng.standard_normal((8, cases))
    loss = crps(observed, mean + std * drawn)[0] - crps(observed, rng.standard_normal((8, cases)))[0]
    assert loss.mean() > 4 * loss.std() / np.sqrt(cases)


@given(st.integers(2, 30), st.floats(-10, 10), st.floats(0.01, 100))
@settings(max_examples=40)
def test_crps_moves_with_the_data_and_has_its_unit(trials, offset, scale):
    rng = stream(74, trials)
    observed, ensemble = rng.standard_normal((3, 4)), rng.standard_normal((trials, 4))
    moved = crps(scale * (offset + observed), scale * (offset + ensemble))
    assert moved.shape == (3, 4)
    np.testing.assert_allclose(moved, scale * crps(observed, ensemble), atol=1e-9 * scale)
    np.testing.assert_allclose(crps(observed, ensemble[::-1]), crps(observed, ensemble), atol=1e-12)


def test_crps_of_a_sharp_ensemble_is_the_absolute_error():
    np.testing.assert_allclose(crps(np.array([[1.0], [-2.0]]), np.full((6, 1), 3.0)), [[2.0], [5.0]], rtol=1e-14)

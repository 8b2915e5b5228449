from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter
from tests.discovery.simulated import COUNT, INTERVAL, LOG_ALPHA, WHITE, fitted, moved, sequence

from imugap.discovery.noise.common_noise import find_common_noise, loading_errors
from imugap.effects import CommonMode, GaussMarkov, OutputFilter
from imugap.stream import stream


def correlated(run, colour, size, own=()):
    """Fit two axes with independent and common noise, the latter filtered by the coefficients ``colour``."""
    fits, common = {}, lfilter([1.0], colour, stream(run, "common").standard_normal(COUNT))
    for axis in ("gyro_x", "gyro_y"):
        data = sequence(*own, axis=axis, label=f"own {run}")
        values = data.values + size * WHITE.density / np.sqrt(INTERVAL) * common / common.std()
        fits[axis] = fitted(replace(data, values=values), *own)
    return fits


@pytest.mark.parametrize(("size", "own"), [(0.2, ()), (0.5, (GaussMarkov(2e-3, 2.0),)), (2.0, ())])
def test_common_white_noise_is_named(size, own):
    for run in range(5):
        (found,) = find_common_noise(correlated(run, [1.0], size, own), LOG_ALPHA)
        assert found.axes == ("gyro_x", "gyro_y")


@pytest.mark.parametrize("colour", [[1.0, -0.5], [1.0, -0.99], [1.0, 0.5]])
def test_common_noise_that_is_not_white_is_not_named(colour):
    for run in range(5):
        assert find_common_noise(correlated(run, colour, 0.5), LOG_ALPHA) == ()


def test_a_short_common_event_is_not_named():
    """As of a shock, for a hundredth of the log."""
    shock = 3 * WHITE.density / np.sqrt(INTERVAL) * stream(1, "shock").standard_normal(COUNT)
    shock[np.abs(np.arange(COUNT) - 0.6 * COUNT) > COUNT / 200] = 0.0
    data = {axis: sequence(axis=axis) for axis in ("gyro_x", "gyro_y")}
    shaken = {axis: fitted(moved(one, shock)) for axis, one in data.items()}
    assert find_common_noise(shaken, LOG_ALPHA) == ()


@pytest.mark.slow
@pytest.mark.parametrize("loading", [0.6, 3.0])
@pytest.mark.parametrize("count", [2, 3])
def test_loading_errors_match_the_scatter_over_many_logs(loading, count):
    axes, whole, errors = ("gyro_x", "gyro_y", "gyro_z")[:count], [], []
    for number in range(100):
        own = CommonMode(1e-3, loading)
        data = {axis: sequence(own, count=2000, axis=axis, label=f"shared {number}") for axis in axes}
        (found,) = find_common_noise({axis: fitted(one) for axis, one in data.items()}, LOG_ALPHA)
        whole.append(found.densities[0])
        errors.append(found.errors[0])
    assert np.mean(whole) == pytest.approx(1e-3 * loading, abs=4 * np.std(whole) / 10)
    assert np.std(whole, ddof=1) == pytest.approx(np.mean(errors), rel=4 / np.sqrt(200))


def test_the_error_is_large_where_an_axis_without_loading_leaves_it_undetermined():
    sure, open_ended = (loading_errors(np.array([0.5, 0.5, last]), 1000) for last in (0.5, 0.0))
    assert np.all(sure < 0.1)
    assert np.all(np.isfinite(open_ended))
    assert np.all(open_ended[:2] > 10)


def test_common_noise_has_its_sign_and_density_where_one_axis_is_filtered():
    common, smooth = CommonMode(1e-3, 1.0), OutputFilter(3.0, 2)
    data = {axis: sequence(common, axis=axis) for axis in ("gyro_x", "gyro_y")}
    output = smooth.apply(data["gyro_x"].values, data["gyro_x"].conditions, stream(1))
    filtered = fitted(replace(data["gyro_x"], values=output), smooth)
    (found,) = find_common_noise({"gyro_x": filtered, "gyro_y": fitted(data["gyro_y"])}, LOG_ALPHA)
    np.testing.assert_array_less(np.abs(found.densities - 1e-3), 4 * found.errors)


def test_loadings_and_density_of_common_noise():
    sharing = ("gyro_x", "gyro_y", "accel_z")
    effects = {axis: [CommonMode(5e-4, loading)] for axis, loading in zip(sharing, (1.0, -0.8, 0.6), strict=True)}
    fits = {
        axis: fitted(sequence(*effects.get(axis, []), axis=axis)) for axis in ("gyro_x", "gyro_y", "gyro_z", "accel_z")
    }
    (found,) = find_common_noise(fits, LOG_ALPHA)
    assert found.axes == sharing
    np.testing.assert_array_less(np.abs(found.densities - [5e-4, -4e-4, 3e-4]), 4 * found.errors)
    assert find_common_noise({axis: fitted(sequence(axis=axis, label="alone")) for axis in sharing}, LOG_ALPHA) == ()


@pytest.mark.parametrize("loadings", [(1.0, 0.6), (0.5, -1.0)])
def test_two_axes_leave_the_loadings_open(loadings):
    pairs = zip(("gyro_x", "gyro_y"), loadings, strict=True)
    data = {axis: sequence(CommonMode(1e-3, own), axis=axis, label="open") for axis, own in pairs}
    (found,) = find_common_noise({axis: fitted(one) for axis, one in data.items()}, LOG_ALPHA)
    told = found.finding("rad/s/sqrt(Hz)").parameters
    assert told["density"].low < 1e-3 * loadings[0] < told["density"].high
    assert told["loading_gyro_y"].low < loadings[1] / loadings[0] < told["loading_gyro_y"].high

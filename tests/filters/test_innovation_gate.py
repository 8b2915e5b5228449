"""The tests of the quality control against their laws, and what each makes of a component."""

import numpy as np
import pytest
from scipy.stats import chi2

from imugap.filters.innovation_gate import (
    FAILED,
    REMOVED,
    RESET,
    SCHEMES,
    WEIGHED,
    InnovationRecord,
    KernelControl,
    QualityControl,
    chi_square,
    noise_after_test,
)
from imugap.stream import stream

COUNT = 4


def spd(size, *labels):
    root = stream(5, *labels).standard_normal((size, size))
    return root @ root.T + np.eye(size)


@pytest.mark.parametrize("count", [1, 3, 6])
def test_the_statistic_is_that_of_the_whole_covariance(count):
    rng = stream(5, "statistic", count)
    covariance, innovation = spd(6, "covariance"), rng.standard_normal(6)
    whitened = np.empty(6)
    statistic, log_det = chi_square(innovation, covariance, count, np.empty((6, 6)), whitened)
    part, inner = innovation[:count], covariance[:count, :count]
    assert statistic == pytest.approx(part @ np.linalg.solve(inner, part))
    assert log_det == pytest.approx(np.linalg.slogdet(inner)[1])
    np.testing.assert_allclose(np.linalg.cholesky(inner) @ whitened[:count], part)


@pytest.mark.parametrize("false_alarm", [0.001, 0.05])
def test_the_limits_are_quantiles_of_chi_square(false_alarm):
    limits = QualityControl(false_alarm=false_alarm).limits(6)
    assert limits[0] == np.inf
    np.testing.assert_allclose(chi2.sf(limits[1:], np.arange(1, 7)), false_alarm)


def test_the_global_test_fails_as_often_as_it_says():
    covariance, draws, alarm = spd(4, "false alarm"), 20_000, 0.02
    seen = stream(5, "draws").multivariate_normal(np.zeros(4), covariance, draws)
    limit = QualityControl(false_alarm=alarm).limits(4)[4]
    room = np.empty((4, 4)), np.empty(4)
    share = np.mean([chi_square(one, covariance, 4, *room)[0] > limit for one in seen])
    assert abs(share - alarm) < 4 * np.sqrt(alarm / draws)


@pytest.mark.parametrize("steepness", [1.0, 2.0])
def test_a_component_that_is_weighed_down_pulls_the_less_the_farther_it_is_off(steepness):
    """Beyond all limits; and the noise grows by the power that is told, whatever the sign."""
    variance, noise, c = 2.0, 0.8, 3.0
    sizes = np.array([3.2, 6.4, 12.8, 102.4])
    trusted = np.array(
        [noise_after_test(size * np.sqrt(variance), variance, noise, c, True, steepness) for size in sizes]
    )
    np.testing.assert_allclose(trusted[1:] / trusted[:-1], (sizes[1:] / sizes[:-1]) ** (2 * steepness))
    assert noise_after_test(-6.4 * np.sqrt(variance), variance, noise, c, True, steepness) == pytest.approx(trusted[1])
    pulls = (variance - noise) * sizes / (variance - noise + trusted)
    assert (np.diff(pulls) < 0).all()
    assert pulls[-1] < 0.1 * pulls[0]
    assert noise_after_test(3.2 * np.sqrt(variance), variance, noise, c, False, steepness) == np.inf


@pytest.mark.parametrize("robust", [True, False])
@pytest.mark.parametrize(("size", "component"), [(2.9, 3.0), (1e6, np.inf)])
def test_what_passes_is_taken_as_it_is(size, component, robust):
    assert noise_after_test(size, 1.0, 0.4, component, robust, 2.0) == 0.4


def test_weights_are_continuous_at_the_limit():
    inside, outside = (noise_after_test(3.0 * (1 + step), 1.0, 0.4, 3.0, True, 2.0) for step in (-1e-9, 1e-9))
    assert inside == pytest.approx(outside, rel=1e-6)


@pytest.mark.parametrize(
    "wrong",
    [{"component": 0.0}, {"steepness": 0.0}, {"component": -1.0}, {"false_alarm": 0.0}, {"false_alarm": 1.0},
     {"reset_s": 0.0}, {"separation_s": 0.0}, {"reset_std": (1.0, 1.0)}, {"reset_std": (1.0, -1.0, 0.0)}],
)  # fmt: skip
def test_what_is_no_test_is_refused(wrong):
    with pytest.raises(ValueError, match="expected"):
        QualityControl(**wrong)


def test_what_is_left_out_never_acts():
    control = KernelControl.of(SCHEMES["none"], 6)
    assert np.isinf([control.component, control.reset_s, control.separation_s]).all()
    assert not control.gated


def test_every_event_is_logged_with_time_statistic_and_threshold():
    quality, record = QualityControl(), InnovationRecord.empty(4, 2)
    record.innovation[:], record.variance[:], record.share[:] = [1.0, 8.0], 4.0, 1.0
    record.statistic[:], record.freedom[:] = 30.0, 2
    record.passed[:] = [True, False, False, True]
    record.share[1], record.share[2, 1], record.reset[2] = [1.0, 0.25], 0.0, True
    found = record.events(np.array([5.0, 6.0, 99.0, 100.0]), ("north", "east"), quality)
    assert list(zip(found["time"], found["event"], found["component"], strict=True)) == [
        (6.0, FAILED, "all"), (6.0, WEIGHED, "east"), (99.0, FAILED, "all"), (99.0, RESET, "all"),
        (99.0, REMOVED, "east"),
    ]  # fmt: skip
    failed = found[found["event"] == FAILED]
    assert (failed["statistic"] == 30.0).all()
    np.testing.assert_allclose(failed["threshold"], chi2.isf(1e-3, 2))
    reset = found[found["event"] == RESET].iloc[0]
    assert (reset["statistic"], reset["threshold"]) == (93.0, quality.reset_s)
    assert found.iloc[1][["statistic", "threshold", "share"]].tolist() == [4.0, 3.0, 0.25]

"""Runs whose true interval is known: sums of waves and noise of known covariance, evaluated at the true times."""

import numpy as np
import pandas as pd
import pytest

from imugap.integrity import sampling_clock as clock
from imugap.log import LogError, from_samples
from imugap.stream import stream

NOMINAL_S = 0.01
LENGTH = 6000  # of a block
LINES_HZ = (3.1, 5.7, 9.3, 13.9, 17.3)
WANDER = 1e-3  # of the lines, relative: as much from run to run as from block to block


def averaging(lag_s, width_s=9.8e-3):
    """Covariance of white noise averaged twice over ``width_s``: a cubic B-spline, not of the families fitted."""
    u = np.abs(lag_s) / width_s
    return np.where(u < 1, 1 - 1.5 * u**2 + 0.75 * u**3, 0.25 * np.maximum(2 - u, 0) ** 3)


def two_poles(lag_s, rate_per_s=250.0):
    """Covariance of white noise behind two equal real poles."""
    u = np.abs(lag_s) * rate_per_s
    return (1 + u) * np.exp(-u)


def butterworth(lag_s, corner_hz=30.0):
    """Covariance of white noise behind a Butterworth filter of second order."""
    u = np.abs(lag_s) * np.pi * np.sqrt(2) * corner_hz
    return np.exp(-u) * (np.cos(u) + np.sin(u))


def retuned(lag_s, ratio=0.83):
    """Covariance of the noise of :func:`averaging` behind a filter of ``ratio`` times the bandwidth."""
    return ratio * averaging(ratio * lag_s)


def white(lag_s):
    """Covariance of noise that no filter shaped."""
    return (lag_s == 0).astype(float)


def noise(rng, intervals_s, covariance):
    """Draw Gaussian blocks with exactly this covariance at the true lags (circulant embedding)."""
    lags = np.minimum(np.arange(LENGTH), LENGTH - np.arange(LENGTH))
    spectrum = np.fft.fft(covariance(lags * intervals_s[:, None])).real.clip(0)
    draws = rng.normal(size=spectrum.shape) + 1j * rng.normal(size=spectrum.shape)
    return np.fft.fft(np.sqrt(spectrum / LENGTH) * draws).real.ravel()


def waves(rng, intervals_s, lines_hz):
    """Return unit waves that wander together, by steps from block to block and from run to run."""
    wander = 1 + WANDER * (rng.normal() + rng.normal(size=clock.BLOCKS))
    cycles = np.cumsum(np.repeat(intervals_s * wander, LENGTH))
    return sum(np.sin(2 * np.pi * (line * cycles + rng.uniform())) for line in lines_hz)


def run(seed, label, ratio=1.0, filter_ratio=None, drift=0.0, lines_hz=LINES_HZ, covariance=averaging):
    """Return the spectra of a run; ``filter_ratio`` is the stretch of the filter where it is not that of the lines."""
    rng = stream(seed, "clock", label)
    intervals_s = NOMINAL_S * (1 + drift * np.linspace(-0.5, 0.5, clock.BLOCKS))
    inside_s = intervals_s * (ratio if filter_ratio is None else filter_ratio)
    samples = {f"gyro_{axis}": noise(rng, inside_s, covariance) for axis in "xy"}
    samples["accel_z"] = noise(rng, inside_s, white) + 0.3 * waves(rng, ratio * intervals_s, lines_hz)
    return clock.spectra(from_samples(samples, NOMINAL_S))


def compare(seed, **options):
    """Compare a run with a reference that has the same lines and filter."""
    shared = {name: options[name] for name in ("lines_hz", "covariance") if name in options}
    return clock.relative_interval(run(seed, "reference", **shared), run(seed, "run", **options))


@pytest.mark.parametrize("covariance", [averaging, two_poles, butterworth])
@pytest.mark.parametrize("ratio", [0.83, 1.12])
def test_both_kinds_of_evidence_recover_the_ratio(ratio, covariance):
    found = compare(1, ratio=ratio, covariance=covariance)
    assert found.lines.log_ratio == pytest.approx(np.log(ratio), abs=0.005)
    assert found.rolloff.log_ratio == pytest.approx(np.log(ratio), abs=4 * found.rolloff.sd)
    assert found.rolloff.sd < 0.02
    assert found.power == pytest.approx(1, abs=0.03)


def test_errors_are_as_large_as_they_are_said_to_be():
    found = [compare(seed, ratio=0.93) for seed in range(12)]
    for kind in ("lines", "rolloff"):
        scores = np.array([(getattr(c, kind).log_ratio - np.log(0.93)) / getattr(c, kind).sd for c in found])
        assert 0.6 < np.sqrt(np.mean(scores**2)) < 1.5, kind
        intervals = np.array([getattr(c, kind).interval for c in found])
        assert ((intervals[:, 1] < 0.93) & (intervals[:, 2] > 0.93)).sum() >= 10, kind
    assert sum(c.verdict == "different clock" for c in found) >= 10
    assert 0.2 < np.mean([c.agreement for c in found]) < 0.8


def test_one_clock_is_called_the_same():
    found = compare(2)
    assert found.verdict == "same clock"
    assert found.lines.contains_one
    assert found.rolloff.contains_one


@pytest.mark.parametrize("seed", range(3))
def test_nothing_to_match_gives_no_number(seed):
    row = compare(seed, ratio=0.83, lines_hz=(), covariance=white).row()
    assert row.pop("verdict") == "no evidence"
    assert row.isna().all()


@pytest.mark.parametrize("lines_hz", [(7.0,), (4.4, 7.9, 11.6, 15.1, 21.0)])
def test_one_line_or_the_lines_of_other_machines_prove_nothing(lines_hz):
    reference = run(3, "reference", lines_hz=LINES_HZ if len(lines_hz) > 1 else lines_hz)
    assert not clock.relative_interval(reference, run(3, "run", lines_hz=lines_hz)).lines


def test_lines_alone_do_not_confirm_a_clock():
    found = compare(4, ratio=0.9, covariance=white)
    assert found.verdict == "unconfirmed"
    assert found.combined.log_ratio == pytest.approx(found.lines.log_ratio)
    assert np.isnan(found.power)
    assert np.isnan(found.agreement)


def test_a_machine_that_changed_its_speed_is_a_conflict():
    found = compare(5, ratio=0.83, filter_ratio=1.0)
    assert found.verdict == "conflict"
    assert found.agreement < 1e-6
    assert not found.combined
    assert found.rolloff.contains_one


def test_power_tells_a_retuned_filter_from_a_clock():
    found = clock.relative_interval(run(6, "reference"), run(6, "run", covariance=retuned))
    assert found.rolloff.log_ratio == pytest.approx(np.log(0.83), abs=4 * found.rolloff.sd)
    assert found.power == pytest.approx(0.83, abs=0.02)
    assert found.verdict == "conflict"


@pytest.mark.parametrize(("kind", "drift"), [("lines", 0.01), ("rolloff", 0.12)])
def test_drift_within_a_run_is_seen(kind, drift):
    change, p_value = getattr(compare(7, drift=drift), kind).drift
    assert change == pytest.approx(drift, rel=0.4)
    assert p_value < 0.01
    assert getattr(compare(7), kind).drift[1] > 0.01


def test_order_of_the_runs_inverts_the_ratio():
    first, second = run(8, "a"), run(8, "b", ratio=0.9)
    there, back = clock.relative_interval(first, second), clock.relative_interval(second, first)
    for kind in ("lines", "rolloff"):
        assert getattr(there, kind).log_ratio == pytest.approx(-getattr(back, kind).log_ratio, abs=1e-4)


def test_too_short_a_log_is_refused():
    with pytest.raises(LogError, match="at least 16000 samples; found 100"):
        clock.spectra(pd.DataFrame({"gyro_x": np.zeros(100)}, index=pd.Index(np.arange(100) * NOMINAL_S, name="time")))

import json

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from imugap.integrity.report import gravity_unit, lattice, report, timing
from imugap.io.catalogue.readers import read_raw
from imugap.log import AXES
from imugap.stream import stream
from imugap.units import STANDARD_GRAVITY, to_si

COUNT = 20_000


def noise(*labels, count=COUNT):
    return stream(5, "integrity", *labels).standard_normal(count)


def table(samples, interval_s=0.01):
    """Make an unchecked table of axis to samples."""
    count = len(next(iter(samples.values())))
    return pd.DataFrame(samples, index=pd.Index(interval_s * np.arange(count), name="time"))


def axis(values, name="gyro_x"):
    return report(table({name: values})).axes[0]


def rounded(values, step):
    return step * np.rint(values / step)


def test_a_healthy_log_raises_no_flag_on_any_axis():
    healthy = table({name: noise(name) for name in AXES})
    healthy["accel_z"] -= STANDARD_GRAVITY
    found = report(healthy)
    frame = found.to_frame()
    assert list(frame.index) == list(AXES)
    assert not frame[["stuck", "saturated"]].any(axis=None)
    assert not frame[["nan", "outliers"]].any(axis=None)
    assert frame["lattice"].isna().all()
    assert found.events == ()
    assert found.timing.rate_hz == pytest.approx(100.0)
    assert found.timing.duration_s == pytest.approx(COUNT / 100)


def test_stamps_are_counted_as_they_are():
    time = 0.01 * np.arange(1000)
    time[500:] += 0.2  # one gap of 0.21 s, after 4.99 s
    time[800:] += 0.03
    time[100] = time[99]
    time[301] = time[299]
    time[900] = np.nan
    found = timing(time)
    assert (found.samples, found.missing, found.duplicated, found.reversed) == (1000, 1, 1, 1)
    assert found.gaps == 5  # the two above, and one after each of the three spoilt stamps
    assert found.largest_gap_s == pytest.approx(0.21)
    assert found.first_gap_s == pytest.approx(time[100])
    assert found.interval_s == pytest.approx(0.01)


def test_the_scatter_of_the_steps_is_that_of_the_stamps():
    jitter = 1e-4 * noise("jitter")
    found = timing(0.01 * np.arange(COUNT) + jitter)
    assert found.rate_hz == pytest.approx(100.0, rel=1e-5)
    assert found.step_sd_s == pytest.approx(np.sqrt(2) * 1e-4, rel=0.05)
    assert found.gaps == 0


def test_stamps_that_never_advance_have_no_rate():
    found = timing(np.zeros(10))
    assert (found.rate_hz, found.interval_s, found.duplicated, found.duration_s) == (None, None, 9, 0.0)


@pytest.mark.parametrize(("unit", "step"), [("deg/s", 0.05), ("g", 0.00333), ("rad/s", 1.0), ("mg", 0.25)])
@pytest.mark.parametrize("number", [np.float64, np.float32])
def test_the_lattice_survives_unit_conversion_and_single_precision(unit, step, number):
    values = to_si(rounded(7 * step * noise(unit), step).astype(number), unit).astype(float)
    assert axis(values).lattice == pytest.approx(to_si(step, unit), rel=1e-6)


@settings(deadline=None)
@given(
    st.floats(1e-6, 1e3),
    st.lists(st.integers(-1000, 1000), min_size=3, max_size=50, unique=True),
)
def test_the_lattice_is_the_greatest_common_divisor(step, multiples):
    multiples = np.sort(multiples)
    expected = step * np.gcd.reduce(np.diff(multiples))
    assert lattice(step * multiples, samples=1000) == pytest.approx(expected, rel=1e-6)


def test_one_value_off_by_round_off_does_not_hide_the_lattice():
    values = rounded(noise("off"), 0.05)
    values[77] += 1e-7
    assert axis(values).lattice == pytest.approx(0.05)


def test_values_that_hardly_recur_are_continuous():
    assert axis(np.round(noise("decimals"), 9)).lattice is None


def test_missing_samples_are_counted_and_do_no_other_harm():
    values = noise("nan")
    values[[5, 6, 700]] = np.nan, np.inf, np.nan
    found = axis(values)
    assert found.nan == 3
    assert (found.stuck, found.saturated, found.outliers) == (False, False, 0)
    assert axis(np.full(100, np.nan)).minimum is None


@pytest.mark.parametrize("step", [0.01, 0.3, 1.0, 3.0])
def test_a_coarse_lattice_repeats_and_is_not_stuck(step):
    for run in range(10):
        found = axis(rounded(noise("coarse", step, run), step))
        assert not found.stuck
        assert not found.saturated
        assert found.longest_repeat == pytest.approx(found.expected_repeat, rel=0.8, abs=3)


@pytest.mark.parametrize(("step", "length"), [(None, 12), (0.3, 20), (1.0, 60)])
def test_a_stuck_stretch_is_found_where_it_is(step, length):
    values = noise("stuck", step)
    values = values if step is None else rounded(values, step)
    values[4000 : 4000 + length] = values[4000]
    found = axis(values)
    assert found.stuck
    assert found.repeat_s == pytest.approx(40.0, abs=0.03)
    assert found.longest_repeat >= length - 1


def test_an_axis_that_never_changes_is_stuck():
    assert axis(np.zeros(1000)).stuck


@pytest.mark.parametrize("step", [None, 0.05])
@pytest.mark.parametrize("limits", [(-2.0, 9.0), (-9.0, 2.0), (-2.0, 2.0)])
def test_clipping_is_found_at_either_end(limits, step):
    values = np.clip(noise("clip"), *limits)
    values = values if step is None else rounded(values, step)
    found = axis(values)
    assert found.saturated
    assert (found.minimum_count > 100, found.maximum_count > 100) == (limits[0] == -2, limits[1] == 2)


def test_a_sinusoid_dwells_at_its_extremes_but_is_not_clipped():
    swing = np.sin(np.arange(COUNT) * 0.0123)
    assert not axis(rounded(swing, 0.05)).saturated
    assert axis(rounded(np.clip(1.5 * swing, -1, 1), 0.05)).saturated


@pytest.mark.parametrize("sign", [1, -1])
def test_clipping_of_rare_peaks_is_found_where_few_values_are_near(sign):
    """As of a foot that swings for a second and strikes for a moment."""
    strikes = np.arange(40) * 100
    values = np.rint(2000 * noise("swing")[:4000])
    values[strikes] = np.rint(30_000 + 20_000 * np.abs(noise("strike")[:40]))
    assert not axis(sign * values).saturated
    assert axis(sign * np.minimum(values, 32_767)).saturated


def test_a_knock_is_one_event_of_all_axes_and_drift_is_none():
    samples = {name: noise("knock", name) + 1e-3 * np.arange(COUNT) for name in ("gyro_x", "accel_z")}
    ring = np.exp(-np.arange(30) / 10) * np.cos(np.arange(30))
    samples["gyro_x"][5000:5030] += 20 * ring
    samples["accel_z"][5010:5040] += 60 * ring
    samples["gyro_x"][15_000] += 40
    found = report(table(samples))
    first, second = found.events
    assert (first.axis, second.axis) == ("accel_z", "gyro_x")
    assert first.start_s == pytest.approx(50.0, abs=0.01)
    assert 50.1 <= first.end_s < 50.4
    assert first.size == pytest.approx(60, rel=0.1)
    assert (second.start_s, second.end_s) == (150.0, 150.0)


@pytest.mark.parametrize("freedom", [5, 100])
def test_the_ordinary_tail_of_a_device_is_no_event(freedom):
    values = stream(6, "tail", freedom).standard_t(freedom, 200_000)
    assert len(report(table({"accel_y": values})).events) <= 3


def test_a_rare_flip_between_two_levels_is_no_event():
    values = 0.01 * (noise("flip") > 3.3)
    assert axis(values).outliers == 0


@pytest.mark.parametrize("unit", ["m/s^2", "g", "mg", "ug"])
def test_gravity_tells_its_unit(unit):
    force = {"accel_x": 0 * noise(), "accel_y": 0.01 * noise("y"), "accel_z": -9.81 + 0 * noise()}
    found = report(table(force) / to_si(1.0, unit)).gravity
    assert found.unit == unit
    assert found.norm == pytest.approx(9.81 / to_si(1.0, unit), rel=1e-3)
    assert gravity_unit(4.0) is None


def test_gravity_needs_three_axes():
    assert report(table({"accel_z": noise()})).gravity is None
    assert report(table(dict.fromkeys(AXES, np.full(9, np.nan)))).gravity is None


def test_a_table_without_axes_or_samples_is_refused():
    with pytest.raises(ValueError, match="expected an inertial axis and 2 samples or more; found 0, 9"):
        report(table({"temperature": np.zeros(9)}))
    with pytest.raises(ValueError, match="found 1, 1"):
        report(table({"gyro_x": np.zeros(1)}))


number = st.floats(allow_nan=True, allow_infinity=True, min_value=None, max_value=None, width=32)


@settings(deadline=None, max_examples=200)
@given(st.lists(st.tuples(number, number, number, number), min_size=2, max_size=60))
def test_the_worst_table_still_gets_a_report_fit_for_json(rows):
    cells = np.array(rows, dtype=float)
    spoilt = pd.DataFrame(cells[:, 1:], columns=["accel_x", "accel_y", "accel_z"], index=pd.Index(cells[:, 0]))
    found = report(spoilt)
    json.dumps(found.facts(), allow_nan=False)
    json.dumps(found.to_frame().to_json())


def test_the_knocks_of_the_real_run_4_are_found(sets, mirror):
    dataset = sets["adis16405"]
    found = report(read_raw(dataset.file(4).place(mirror), dataset, 4))
    strongest = sorted(sorted(found.events, key=lambda event: -event.size)[:2], key=lambda event: event.start_s)
    assert [event.start_s for event in strongest] == pytest.approx([4045, 5146], abs=1)
    assert len(found.events) < 10
    frame = found.to_frame()
    assert not frame[["stuck", "saturated"]].any(axis=None)
    np.testing.assert_allclose(frame["lattice"][:3], np.radians(0.05), rtol=1e-6)
    np.testing.assert_allclose(frame["lattice"][3:], to_si(0.00333, "g"), rtol=1e-6)
    assert found.gravity.norm / STANDARD_GRAVITY == pytest.approx(1.0168, abs=1e-3)


def test_the_real_turn_on_logs_are_continuous_and_whole(sets, mirror):
    dataset = sets["memsense_turnon"]
    found = report(read_raw(dataset.files[0].place(mirror), dataset, 7))
    assert found.timing.rate_hz == pytest.approx(250.0)
    assert found.to_frame()["lattice"].isna().all()
    assert not found.to_frame()[["nan", "outliers", "stuck", "saturated"]].any(axis=None)

import pickle

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from imugap import log
from imugap.log import LogError, check, duration, from_samples, interval, rate
from imugap.stream import stream


def table(count=5, **changed):
    columns = {"gyro_x": np.arange(float(count)), "accel_z": np.full(count, -9.8), "temperature": np.full(count, 25.0)}
    return pd.DataFrame(columns | changed, index=pd.Index(0.1 * np.arange(count), name="time"))


def stamped(time):
    time = np.asarray(time, float)
    return check(pd.DataFrame({"gyro_x": np.zeros(len(time))}, index=pd.Index(time, name="time")))


def spoilt(row, column, value):
    bad = table()
    bad.iloc[row, bad.columns.get_loc(column)] = value
    return bad


def at(*time):
    """The table with other times."""
    return table().set_axis(pd.Index(time, name="time"))


FAULTS = {
    "unknown column": (table().assign(mag_x=0.0), "columns", "a subset of gyro_x, .*, temperature", "mag_x"),
    "no axis": (table()[["temperature"]], "columns", "at least one of gyro_x", "none of them"),
    "wrong order": (table()[["accel_z", "gyro_x"]], "columns", "the order gyro_x", "accel_z, gyro_x"),
    "a column twice": (table()[["gyro_x", "gyro_x"]], "columns", "the order gyro_x", "gyro_x, gyro_x"),
    "unnamed index": (table().rename_axis("t"), "index", r"time \[s\]", "'t'"),
    "one sample": (table(1), "rows", "at least 2 samples", "1"),
    "time stands": (at(0, 1, 1, 2, 3.0), "row 2", "time that increases", "1.0 s"),
    "time goes back": (at(0, 1, 2, 3, 2.5), "row 4", "time that", "2.5 s after 3"),
    "time is no number": (at(0, 1, np.nan, 3, 4), "row 2", "a finite time", "nan"),
    "time is infinite": (at(0, 1, 2, 3, np.inf), "row 4", "a finite time", "inf"),
    "time is infinite before it goes back": (at(0, 2, 1, np.nan, 4), "row 3", "a finite time", "nan"),
    "text": (table(gyro_x=list("abcde")), "column gyro_x", "numbers", "text"),
    "time is text": (at(*"abcde"), "column time", "numbers", "text"),
    "nan": (spoilt(3, "gyro_x", np.nan), "row 3, column gyro_x", "a finite number", r"nan \(1 such rows\)"),
    "infinity": (spoilt(1, "accel_z", -np.inf), "row 1, column accel_z", "a finite number", "-inf"),
    "temperature": (spoilt(0, "temperature", np.nan), "row 0, column temperature", "a finite number", "nan"),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_is_named_with_its_place(fault):
    bad, place, expected, found = FAULTS[fault]
    with pytest.raises(LogError, match=f"^run7.csv: {place}: expected {expected}.*; found .*{found}"):
        check(bad, "run7.csv")


def test_a_sound_log_passes_as_it_is():
    sound = table()
    assert check(sound) is sound


def test_the_error_keeps_its_parts_between_processes():
    error = LogError("run7.csv", "row 3", "a number", "a word")
    again = pickle.loads(pickle.dumps(error))
    assert str(again) == str(error) == "run7.csv: row 3: expected a number; found a word"
    assert (again.source, again.place, again.expected, again.found) == ("run7.csv", "row 3", "a number", "a word")


def test_samples_become_a_log_in_canonical_order():
    made = from_samples({"temperature": np.ones(3), "accel_x": np.ones(3), "gyro_y": np.ones(3)}, 0.5, start_s=2.0)
    assert list(made.columns) == ["gyro_y", "accel_x", "temperature"]
    assert made.index.tolist() == [2.0, 2.5, 3.0]
    assert log.axes(made) == ("gyro_y", "accel_x")


@given(st.floats(1e-4, 10), st.integers(2, 500), st.floats(-1e3, 1e3))
def test_interval_rate_and_duration_of_even_stamps(step, count, start):
    made = stamped(start + step * np.arange(count))
    assert interval(made) == pytest.approx(step, rel=1e-6)
    assert rate(made) * interval(made) == pytest.approx(1.0)
    assert duration(made) == pytest.approx(count * step, rel=1e-6)


@given(st.floats(0.003, 0.02), st.floats(0.05, 0.33), st.integers(0, 100))
def test_quantised_stamps_average_out(step, quantum, phase):
    tick = quantum * step
    time = np.floor((phase * 0.01 + np.arange(2000)) * step / tick) * tick
    assert interval(stamped(time)) == pytest.approx(step, rel=1.5 * quantum / 1999)


@given(st.integers(0, 1000), st.floats(0.0, 0.3))
def test_lost_samples_do_not_stretch_the_interval(label, lost):
    kept = stream(91, label).random(2000) >= lost
    made = stamped(0.01 * np.flatnonzero(kept))
    assert interval(made) == pytest.approx(0.01, rel=1e-9)


def test_a_long_gap_does_not_stretch_the_interval():
    assert interval(stamped(np.r_[0:1:0.01, 5000:5001:0.01])) == pytest.approx(0.01, rel=1e-9)


@given(st.permutations(range(3)), st.integers(2, 40))
def test_writing_and_loading_gives_the_log_back(tmp_path_factory, order, count):
    path = tmp_path_factory.mktemp("log") / "deep" / "run.parquet"
    values = stream(92, count).standard_normal((3, count))[order]
    made = from_samples(dict(zip(("gyro_x", "accel_y", "temperature"), values, strict=True)), 0.01)
    log.write(made, path)
    pd.testing.assert_frame_equal(log.load(path), made, check_exact=True)
    assert [item.name for item in path.parent.iterdir()] == ["run.parquet"]


def test_loading_some_columns_keeps_the_time(tmp_path):
    log.write(table(), tmp_path / "run.parquet")
    some = log.load(tmp_path / "run.parquet", columns=["accel_z"])
    assert check(some).equals(table()[["accel_z"]])


@pytest.mark.parametrize(("name", "found"), [("run.txt", ".txt"), ("run", "no ending"), ("run.CSV", ".CSV")])
def test_an_ending_that_is_neither_parquet_nor_csv_is_refused_and_nothing_written(tmp_path, name, found):
    with pytest.raises(LogError, match=rf"expected one that ends in \.parquet or \.csv; found {found}"):
        log.write(table(), tmp_path / "deep" / name)
    assert not list(tmp_path.iterdir())


def test_block_means_leave_out_the_rest_and_never_raise_the_rate():
    ten = log.from_samples({"gyro_x": np.arange(10.0), "accel_z": np.ones(10)}, 0.1)
    means, step = log.block_means(ten, 2.5)
    assert step == pytest.approx(0.4)
    assert {name: one.tolist() for name, one in means.items()} == {"gyro_x": [1.5, 5.5], "accel_z": [1.0, 1.0]}
    means, step = log.block_means(ten, 100.0)
    assert step == pytest.approx(0.1)
    assert len(means["gyro_x"]) == 10


def test_the_interval_of_steps_that_are_all_unlike_is_the_median_one():
    assert interval(stamped([0.0, 0.04, 5.0])) == pytest.approx(2.5)

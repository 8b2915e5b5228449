import tempfile
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from imugap.io.recording import RecordingSettings, of_table, read
from imugap.io.rows import SMALLEST_SAMPLE
from imugap.log import COLUMNS, LogError, check, from_samples, write
from imugap.stream import stream
from imugap.units import to_si

HEADER = "time,gyro_x,accel_z"
ROWS = ["0.00,0.1,-9.8", "0.01,0.2,-9.7", "0.02,0.3,-9.9", "0.03,0.4,-9.8"]


@pytest.fixture
def path(tmp_path):
    return tmp_path / "log.csv"


def lines(path, *rows, header=HEADER):
    path.write_text("".join(f"{row}\n" for row in (header, *rows)), encoding="utf-8")
    return path


def at_rest(count=200, gravity=9.81, rate=0.01):
    rng = stream(1, "at rest")
    samples = {name: rate * rng.standard_normal(count) for name in COLUMNS[:6]}
    samples["accel_z"] = samples["accel_z"] - gravity
    return from_samples(samples, 0.01)


def log_of(path):
    return read(path).log


def attempt(path, repair=False):
    """Read; None where the file is refused. Any other exception passes."""
    try:
        return read(path).repaired if repair else log_of(path)
    except LogError:
        return None


finite = st.floats(-30, 30, width=64).map(lambda value: value if abs(value) >= 1e3 * SMALLEST_SAMPLE else 0.0)


@st.composite
def logs(draw):
    names = [name for name in COLUMNS if draw(st.booleans())]
    names = names if set(names) & set(COLUMNS[:6]) else ["gyro_y", *names]
    steps = draw(st.lists(st.floats(1e-4, 10), min_size=2, max_size=12))
    log = pd.DataFrame(index=pd.Index(np.cumsum(steps), name="time"))
    for name in (name for name in COLUMNS if name in names):
        # at rest, so that the units are what they seem
        log[name] = -9.81 if name == "accel_z" else np.array([draw(finite) for _ in steps]) * 0.01
    return log


@settings(deadline=None)
@given(logs(), st.randoms())
def test_csv_and_parquet_give_back_the_log_whatever_the_order_of_columns(log, random):
    with tempfile.TemporaryDirectory() as folder:
        csv_path, parquet_path = Path(folder) / "log.csv", Path(folder) / "log.parquet"
        names = list(log.columns)
        random.shuffle(names)
        log[names].to_csv(csv_path)
        write(log, parquet_path)
        pd.testing.assert_frame_equal(log_of(csv_path), log, check_exact=True)
        pd.testing.assert_frame_equal(log_of(parquet_path), log, check_exact=True)


@settings(deadline=None, max_examples=300)
@given(logs(), st.data())
def test_a_truncated_csv_is_an_error_or_the_first_rows(log, data):
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "log.csv"
        log.to_csv(path)
        content = path.read_bytes()
        path.write_bytes(content[: data.draw(st.integers(0, len(content)))])
        found = attempt(path)
        if found is not None:
            pd.testing.assert_frame_equal(found, log.iloc[: len(found)], check_exact=True)


@settings(deadline=None, max_examples=300)
@given(logs(), st.sampled_from(["csv", "parquet"]), st.booleans(), st.data())
def test_a_corrupt_file_is_an_error_or_a_sound_log(log, suffix, repair, data):
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"log.{suffix}"
        log.to_csv(path) if suffix == "csv" else write(log, path)
        content = bytearray(path.read_bytes())
        for _ in range(data.draw(st.integers(1, 4))):
            content[data.draw(st.integers(0, len(content) - 1))] = data.draw(st.integers(0, 255))
        path.write_bytes(content)
        found = attempt(path, repair)
        if found is not None:
            check(found)


@settings(deadline=None)
@example(b"header:", ".csv")
@given(st.binary(max_size=300), st.sampled_from([".csv", ".parquet", ".rda", ".npy", ".mat"]))
def test_noise_is_an_error_and_nothing_else(content, suffix):
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"log{suffix}"
        path.write_bytes(content)
        with pytest.raises(LogError):
            log_of(path)


@pytest.mark.parametrize(
    ("rows", "place", "found"),
    [
        (["0.00,0.1,-9.8", "0.01,0.2,-9.7", "0.02,0.3"], "line 4", "2: '0.02,0.3'"),
        (["0.00,0.1,-9.8", "0.01,0.2,-9.7,5", "0.02,0.3,-9.9"], "line 3", "4: '0.01,0.2,-9.7,5'"),
        (["0.00,0.1,-9.8", "0.01,o.2,-9.7"], "line 3, column gyro_x", "'o.2'"),
        (["0.00,0.1,-9.8", "", "0.01,0.2,1_0"], "line 4, column accel_z", "'1_0'"),
        (["0.00,0.1,-9.8", "0.01,nan,-9.7"], "line 3, column gyro_x", "nan (1 such row)"),
        (["0.00,0.1,-9.8", "", "0.01,,-9.7", "0.02,,-9.7"], "line 4, column gyro_x", "nan (2 such rows)"),
        (["0.00,0.1,-9.8", "0.01,0.1,-9.8", "0.01,0.2,-9.7"], "line 4, column time", "0.01 after 0.01 (1 such row)"),
        (["0.00,0.1,-9.8", "0.02,0.1,-9.8", "0.01,0.2,-9.7"], "line 4, column time", "0.01 after 0.02 (1 such row)"),
        (["0.00,0.1,-9.8", "nan,0.1,-9.8", "0.01,0.2,-9.7"], "line 3, column time", "nan after 0.0 (1 such row)"),
        (["0.00,0.1,-9.8", "0.01,0.1,1e999"], "line 3, column accel_z", "inf (1 such row)"),
        (["0.00,0.1,-9.8"], "rows", "1"),
        ([], "rows", "0"),
    ],
)
def test_a_bad_row_is_named_by_line_and_column(path, rows, place, found):
    with pytest.raises(LogError) as failure:
        log_of(lines(path, *rows))
    assert (failure.value.place, failure.value.found) == (place, found)
    assert failure.value.source == str(path)


@pytest.mark.parametrize(
    ("header", "found"),
    [
        ("time,giro_x,acel_z", "'giro_x' (did you mean gyro_x?)"),
        ("time,a,b", "time, a, b"),
        ("time;gyro_x;accel_z", "3 columns without names"),
        ("gyro_y,gyro_x,accel_z", "gyro_x, gyro_y, accel_z"),
        ("time,gyro_x,gyro_x", "gyro_x more than once"),
        ("0.00,0.1,-9.8", "3 columns without names"),
    ],
)
def test_a_bad_header_is_line_1_with_the_nearest_known_name(path, header, found):
    with pytest.raises(LogError) as failure:
        read(lines(path, *ROWS, header=header))
    assert failure.value.place == "line 1"
    assert failure.value.found.startswith(found)


def test_an_empty_file_is_said_to_be_empty(path):
    path.touch()
    with pytest.raises(LogError, match="found an empty file"):
        log_of(path)


@pytest.mark.parametrize("cut", [1, 2, 9, 12])
@pytest.mark.parametrize("separator", [",", " "])
def test_a_last_line_without_end_may_be_cut_off_and_is_left_out(path, cut, separator):
    lines(path, *ROWS)
    path.write_bytes(path.read_bytes()[:-cut].replace(b",", separator.encode()))
    found = read(path)
    assert found.recognised[-1] == "left out the last line, which has no end"
    assert found.log["accel_z"].tolist() == [-9.8, -9.7, -9.9]


def test_blanks_and_an_end_of_file_mark_behind_the_last_line_are_fine(path):
    path = lines(path, *ROWS)
    path.write_bytes(path.read_bytes() + b"  \x1a")
    found = read(path)
    assert len(found.log) == len(ROWS)
    assert found.recognised == ()


def test_windows_line_ends_quotes_spaces_and_a_byte_order_mark_are_fine(path):
    log = log_of(lines(path, *ROWS))
    text = "\ufeff" + '"time", "gyro_x", "accel_z"\r\n' + "\r\n".join(ROWS).replace(",", " , ") + "\r\n\r\n"
    path.write_bytes(text.encode())
    pd.testing.assert_frame_equal(log_of(path), log)


def test_repair_drops_repeated_and_reversed_rows_and_nothing_else(path):
    lines(path, *ROWS[:2], ROWS[1], ROWS[0], "nan,1,-9.8", *ROWS[2:])
    pd.testing.assert_frame_equal(read(path).repaired, log_of(lines(path.with_name("good.csv"), *ROWS)))
    with pytest.raises(LogError, match="line 4, column time"):
        log_of(path)


def test_the_table_shows_the_stamps_and_gaps_before_repair(path):
    table = read(lines(path, *ROWS[:2], ROWS[1], "0.015,,-9.8")).table
    assert list(table.index) == [0.0, 0.01, 0.01, 0.015]
    assert table["gyro_x"].isna().sum() == 1


@pytest.mark.parametrize("unit", ["g", "mg", "ug"])
def test_a_specific_force_in_another_unit_is_found_by_gravity(path, unit):
    log = at_rest()
    log[["accel_x", "accel_y", "accel_z"]] /= to_si(1.0, unit)
    log.to_csv(path)
    with pytest.raises(LogError, match=f"which would be gravity in {unit}$"):
        log_of(path)


@pytest.mark.parametrize("gravity", [9.76, 9.84, 9.965, 11.0])
def test_any_motion_keeps_its_units(path, gravity):
    log = at_rest(gravity=gravity)
    log["accel_x"] += 30 * (np.arange(len(log)) % 10 == 0)
    log.to_csv(path)
    assert len(log_of(path)) == len(log)


def test_a_specific_force_without_gravity_is_said_where_it_scatters_and_refused_where_it_does_not(path):
    log = at_rest(gravity=0.0)
    log.to_csv(path)
    assert read(path).weightless
    log["accel_z"] -= 4.0
    log.to_csv(path)
    with pytest.raises(LogError, match=r"a median norm of .*, which would be gravity in no known unit"):
        read(path)


def test_a_rate_beyond_any_gyroscope_is_taken_for_degrees(path):
    at_rest(rate=200.0)[["gyro_x", "gyro_y"]].to_csv(path)
    with pytest.raises(LogError, match=r"gyro_x to gyro_z: expected angular rate in rad/s .* is it in deg/s\?"):
        log_of(path)


@pytest.mark.parametrize(
    ("frame", "place", "found"),
    [
        (pd.DataFrame({"time": [0.0, 0.01], "gyro_x": ["a", "b"]}), "column gyro_x", "str"),
        (pd.DataFrame({"time": [0.0, 0.01], "gyro": [1.0, 2.0]}), "columns", "'gyro' (did you mean gyro_z?)"),
        (pd.DataFrame({"time": [0.0, 0.01, 0.01], "gyro_x": 0.0}), "row 2, column time", "0.01 after 0.01"),
        (pd.DataFrame({"time": [0.0, 0.01], "gyro_x": [0.0, np.nan]}), "row 1, column gyro_x", "nan"),
    ],
)
def test_a_bad_parquet_is_named_by_row_and_column(tmp_path, frame, place, found):
    frame.to_parquet(tmp_path / "log.parquet")
    with pytest.raises(LogError) as failure:
        log_of(tmp_path / "log.parquet")
    assert failure.value.place == place
    assert found[:12] in failure.value.found


@pytest.mark.parametrize("name", ["log.txt", "log", "none.csv"])
def test_unknown_formats_and_absent_files_are_log_errors(tmp_path, name):
    with pytest.raises(LogError, match=r"no such file|one that ends in \.csv, \.parquet"):
        log_of(tmp_path / name)


def test_samples_that_vanish_are_zero():
    """What a digital filter leaves that runs on behind its input; the powers of it leave the range of a float."""
    fading = 1e-2 * 0.5 ** np.arange(400.0)
    table = pd.DataFrame({"time": 0.01 * np.arange(400), "gyro_x": fading})
    found = of_table(table).table["gyro_x"].to_numpy()
    np.testing.assert_array_equal(found, np.where(fading >= SMALLEST_SAMPLE, fading, 0.0))


def test_rates_beside_forces_that_never_change_have_no_unit_by_gravity():
    rng = stream(3, "unchanging forces")
    rates = {f"w{axis}": rng.normal(0, 1, 2000).cumsum() * 0.01 for axis in "xyz"}
    forces = {"ax": np.zeros(2000), "ay": np.zeros(2000), "az": np.full(2000, 9.80665)}
    table = pd.DataFrame({"time": 0.01 * np.arange(2000)} | rates | forces)
    with pytest.raises(LogError, match="unit"):
        of_table(table)


def test_the_column_of_the_stamps_alone_may_be_named(tmp_path):
    """The axes are those of the names in the file; another column that may be stamps gives way."""
    rng = stream(4, "stamps by name")
    table = pd.DataFrame({"utc_s": 1.7e9 + 0.01 * np.arange(300), "ts": np.arange(300) * 7})
    table = table.assign(**{f"g{axis}_dps": rng.normal(0, 0.1, 300) for axis in "xyz"})
    table.to_csv(tmp_path / "log.csv", index=False)
    found = read(tmp_path / "log.csv", RecordingSettings(columns=("time=utc_s",)))
    assert list(found.table) == list(COLUMNS[:3])
    np.testing.assert_allclose(found.table.index, table["utc_s"])

import numpy as np
import pytest
from tests.io.devices import RATE, at_rest, times, write_text

from imugap.io.recording import RecordingSettings, read
from imugap.log import AXES, LogError

NAMES = ["time", *AXES]
COUNT = 500


def samples():
    return np.column_stack([times(COUNT), at_rest(COUNT, up=(0, 0, -1))])


DIALECTS = {
    "comma": {},
    "semicolon and decimal comma": {"separator": ";", "decimal": ","},
    "semicolon and point": {"separator": ";"},
    "tab": {"separator": "\t"},
    "tab and decimal comma": {"separator": "\t", "decimal": ","},
    "blank": {"separator": " "},
    "blanks": {"separator": "   "},
    "blank and decimal comma": {"separator": "  ", "decimal": ","},
    "bar": {"separator": "|"},
    "windows": {"end": "\r\n"},
    "comments": {"before": ["# logger 1.2", "# 3 sensors, 100 Hz"]},
    "lines before": {"before": ["sep=,", "DeviceTag:, 7", "", "Recorded 2024-05-01"]},
    "exponents": {"form": "{:.9e}"},
}


@pytest.mark.parametrize("dialect", DIALECTS)
def test_every_dialect_gives_the_same_log_without_a_word(tmp_path, dialect):
    table = samples()
    found = read(write_text(tmp_path / "run.csv", NAMES, table, **DIALECTS[dialect]))
    assert found.recognised == ()
    np.testing.assert_allclose(found.log.to_numpy(), table[:, 1:], rtol=1e-8)
    np.testing.assert_allclose(found.log.index, table[:, 0], rtol=1e-8)


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16", "latin-1"])
def test_every_encoding_is_read(tmp_path, encoding):
    header = ["Zeit t (s)", *(f"Gyro {a} (°/s)" for a in "xyz"), *(f"Accel {a} (m/s²)" for a in "xyz")]
    path = write_text(tmp_path / "run.txt", header, samples())
    path.write_bytes(path.read_bytes().decode().encode(encoding))
    found = read(path)
    np.testing.assert_allclose(found.log["gyro_x"], np.radians(samples()[:, 1]), rtol=1e-8)


def test_a_text_that_ends_within_a_character_is_refused(tmp_path):
    path = write_text(tmp_path / "run.csv", NAMES, samples())
    path.write_bytes(path.read_bytes().decode().encode("utf-16")[:-1])
    with pytest.raises(LogError, match=r"run\.csv: bytes: expected text in utf-16; found truncated data"):
        read(path)


def test_a_line_of_units_below_the_names_is_read(tmp_path):
    names = ["Stamp," + ",".join(f"{k}_{a}" for k in ("Gyro", "Accel") for a in "XYZ")]
    table = samples() * [1e3, *[1] * 3, *[1 / 9.80665] * 3]
    path = write_text(tmp_path / "run.csv", ["ms", *["deg/s"] * 3, *["g"] * 3], table, before=names)
    found = read(path)
    assert 1 / np.diff(found.log.index).mean() == pytest.approx(RATE)
    np.testing.assert_allclose(found.log["accel_z"], samples()[:, 6], rtol=1e-6)


def test_texts_flags_and_comments_between_the_rows_are_left_out(tmp_path):
    path = tmp_path / "run.csv"
    rows = [",".join([*(f"{value:.9g}" for value in row), "ok", "3"]) for row in samples()]
    rows.insert(7, "# marker")
    path.write_text("\n".join([",".join([*NAMES, "state", "flag"]), *rows]) + "\n")
    found = read(path)
    assert len(found.log) == COUNT
    assert found.recognised[-1] == "left out state, flag"


def test_a_trailing_separator_is_no_column(tmp_path):
    path = tmp_path / "run.csv"
    rows = [",".join(f"{value:.9g}" for value in row) + ", " for row in samples()]
    path.write_text("\n".join([",".join(NAMES) + ",", *rows]) + "\n")
    assert read(path).recognised == ()


def test_a_file_without_a_header_needs_the_names(tmp_path):
    table = samples()
    path = write_text(tmp_path / "imu.txt", None, table, separator=" ")
    with pytest.raises(
        LogError, match=r"line 1: expected a header, or a name for each column .*; found 7 columns without names"
    ):
        read(path)
    found = read(path, RecordingSettings(columns=tuple(NAMES)))
    np.testing.assert_allclose(found.log.to_numpy(), table[:, 1:], rtol=1e-8)


def test_nanoseconds_of_1970_keep_all_digits(tmp_path):
    stamps = 1403715273262142976 + np.arange(COUNT) * 5_000_000
    path = tmp_path / "data.csv"
    cells = [[f"{value:.9g}" for value in row] for row in samples()[:, 1:]]
    names = [f"{k}_RS_S_{a} [{u}]" for k, u in (("w", "rad s^-1"), ("a", "m s^-2")) for a in "xyz"]
    rows = [[str(stamp), *row] for stamp, row in zip(stamps, cells, strict=True)]
    path.write_text("".join(",".join(row) + "\n" for row in [["#timestamp [ns]", *names], *rows]))
    found = read(path)
    assert found.recognised[:3] == ("200 Hz", "500 samples", "stamps ns -> s from the header")
    assert np.abs(np.diff(found.log.index) - 0.005).max() < 5e-7


@pytest.mark.parametrize(
    ("row", "message"),
    [
        ("1;2;3", r"line 3: expected 7 values .*; found 3: '1;2;3'"),
        ("0,01;1;2;3;x;5;6", r"line 3, column accel_x: expected a number; found 'x'"),
    ],
)
def test_a_bad_row_of_any_dialect_is_named(tmp_path, row, message):
    path = write_text(tmp_path / "run.csv", NAMES, samples(), separator=";", decimal=",")
    lines = path.read_text().splitlines()
    path.write_text("\n".join([*lines[:2], row, *lines[2:]]) + "\n")
    with pytest.raises(LogError, match=message):
        read(path)


def test_a_header_in_a_comment_between_blanks_has_no_name_more(tmp_path):
    table = samples()
    found = read(write_text(tmp_path / "run.txt", ["# time", *AXES], table, separator=" "))
    np.testing.assert_allclose(found.log.to_numpy(), table[:, 1:], rtol=1e-8)


@pytest.mark.parametrize("between", [".", "_", " "])
def test_the_columns_of_one_of_two_devices_are_taken_by_the_word_before_their_names(tmp_path, between):
    left, right = at_rest(), at_rest(seed=2)
    header = ["time [s]", *(f"{device}{between}{axis}" for device in ("imu1", "imu2") for axis in AXES)]
    header[0] = f"imu2.{header[0]}" if between == "." else header[0]
    path = write_text(tmp_path / "two.csv", header, np.column_stack([times(), left, right]))
    with pytest.raises(LogError, match="--topic what stands before the dot, or begins them"):
        read(path)
    found = read(path, RecordingSettings(topic="imu2", frame="as-is"))
    np.testing.assert_allclose(found.log[list(AXES)], right, atol=1e-9)
    with pytest.raises(LogError, match="expected a group of columns that there is"):
        read(path, RecordingSettings(topic="imu"))


def test_names_that_repeat_are_told_by_those_of_groups_above_them(tmp_path):
    table = np.column_stack([np.arange(COUNT), np.repeat(samples()[:, 1:], 2, axis=1)])
    groups = ",".join(["sensor", *["left", "right"] * len(AXES)])
    path = write_text(tmp_path / "feet.csv", ["axis", *np.repeat(AXES, 2)], table, before=[groups])
    with pytest.raises(LogError, match="--topic what stands before the dot"):
        read(path, RecordingSettings(rate_hz=RATE))
    found = read(path, RecordingSettings(rate_hz=RATE, topic="left"))
    np.testing.assert_allclose(found.log.to_numpy(), samples()[:, 1:], rtol=1e-8)
    assert "columns of left" in found.recognised


def test_a_header_that_stands_again_is_no_row(tmp_path):
    table = samples()
    for separator in (",", " "):
        path = write_text(tmp_path / "run.csv", NAMES, table, separator=separator)
        lines = path.read_text().splitlines()
        path.write_text("\n".join([*lines[:200], lines[0], *lines[200:]]) + "\n")
        found = read(path)
        np.testing.assert_allclose(found.log.to_numpy(), table[:, 1:], rtol=1e-8)
        assert found.place(198) == "line 200"
        assert found.place(199) == "line 202"


def test_a_second_run_below_its_own_header_is_named(tmp_path):
    path = write_text(tmp_path / "run.csv", NAMES, samples())
    lines = path.read_text().splitlines()
    later = [f"{float(line.partition(',')[0]) / 2:.9g},{line.partition(',')[2]}" for line in lines[1:]]
    path.write_text("\n".join([*lines, lines[0], *later]) + "\n")
    with pytest.raises(LogError, match=r"line 503, column time: .*another run begins there"):
        _ = read(path).regular


@pytest.mark.parametrize("line", ["// Update Rate: 100.0Hz", "OutputRate:,100Hz", "Sampling frequency = 0.1 kHz"])
def test_a_rate_in_the_head_stands_for_stamps(tmp_path, line):
    path = write_text(tmp_path / "run.csv", AXES, samples()[:, 1:], before=[line, "// Firmware Version: 2.5.1"])
    found = read(path)
    assert any(sentence.startswith("no stamps, 100 Hz from ") for sentence in found.recognised)
    np.testing.assert_allclose(found.log.index, times(COUNT))


def test_empty_stamps_are_none_where_the_head_has_a_rate(tmp_path):
    path = write_text(tmp_path / "run.csv", NAMES, samples(), before=["# Sample rate: 100 Hz"])
    lines = path.read_text().splitlines()
    path.write_text("\n".join([*lines[:2], *("," + line.partition(",")[2] for line in lines[2:])]) + "\n")
    np.testing.assert_allclose(read(path).log.index, times(COUNT))


def test_lines_of_numbers_in_the_head_are_no_rows(tmp_path):
    before = [
        "LabVIEW Measurement",
        "Samples\t500\t500\t500",
        "Date\t2024/05/01",
        "Delta_X\t0.01\t0.01",
        "***End***",
        "",
    ]
    path = write_text(tmp_path / "run.lvm", ["X_Value", *AXES, "Comment"], samples(), separator="\t", before=before)
    log = read(path).log
    np.testing.assert_allclose(log.to_numpy(), samples()[:, 1:], rtol=1e-8)
    np.testing.assert_allclose(log.index, times(COUNT), atol=1e-9)


def test_the_number_of_a_row_without_a_name_is_no_time(tmp_path):
    table = np.column_stack([1 + np.arange(COUNT), samples()])
    found = read(write_text(tmp_path / "r.txt", NAMES, table, separator=" "))
    np.testing.assert_allclose(found.log.to_numpy(), samples()[:, 1:], rtol=1e-8)
    np.testing.assert_allclose(found.log.index, times(COUNT), atol=1e-9)


@pytest.mark.parametrize("missing", ["-1.#IND", "1.#QNAN", "nan(ind)", "--", "n/a"])
def test_a_missing_value_is_one_in_the_words_of_any_program(tmp_path, missing):
    path = write_text(tmp_path / "run.csv", NAMES, samples())
    lines = path.read_text().splitlines()
    lines[100] = ",".join([*lines[100].split(",")[:-1], missing])
    path.write_text("\n".join(lines) + "\n")
    assert read(path).table["accel_z"].isna().sum() == 1


def test_a_time_in_words_that_are_none_gives_way_to_another(tmp_path):
    rows = [",".join(["now", *(f"{value:.9g}" for value in row)]) for row in samples()]
    (tmp_path / "run.csv").write_text("\n".join([",".join(["timestamp", "elapsed (s)", *AXES]), *rows]) + "\n")
    np.testing.assert_allclose(read(tmp_path / "run.csv").log.index, times(COUNT))


def test_decimal_commas_in_quotes_between_commas_are_read(tmp_path):
    table = samples()
    path = tmp_path / "run.csv"
    rows = [",".join(f'"{value:.9f}"'.replace(".", ",") for value in row) for row in table.tolist()]
    path.write_text("\n".join([",".join(NAMES), *rows, ""]))
    np.testing.assert_allclose(read(path).log.to_numpy(), table[:, 1:], atol=1e-9)


def test_commas_between_thousands_are_refused_with_their_line(tmp_path):
    rows = [f'{k / 100:.2f},{k % 7}.5,0.1,0.2,0.3,0.4,"1,00{k % 7}.25"' for k in range(COUNT)]
    path = tmp_path / "run.csv"
    path.write_text("\n".join([",".join(NAMES), *rows, ""]))
    with pytest.raises(LogError, match=r"line 2, column accel_z: expected a number; found '1,000.25'"):
        read(path)


def test_lines_of_one_word_between_names_and_units_are_no_names(tmp_path):
    names = ["Time", *(f"{sensor} {axis}" for sensor in ("Gyro", "Accel") for axis in "XYZ")]
    above = ["sep=,", ",".join(["Device"] * 7), ",".join(names), ",".join(["CAL"] * 7)]
    units = ["mSecs", *["deg/sec"] * 3, *["m/(sec^2)"] * 3]
    table = samples() * [1e3, *[1] * 6]
    found = read(write_text(tmp_path / "run.csv", units, table, before=above), RecordingSettings(frame="as-is"))
    np.testing.assert_allclose(found.log["gyro_x"], np.radians(table[:, 1]), rtol=1e-8)


def test_a_line_with_bytes_that_are_no_text_is_refused_with_its_number(tmp_path, capfd):
    path = write_text(tmp_path / "run.csv", NAMES, samples())
    lines = path.read_bytes().split(b"\n")
    path.write_bytes(b"\n".join([*lines[:300], b"0.01,0.0\x80\x92\xff", *lines[300:]]))
    with pytest.raises(LogError, match=r"line 301: expected 7 values"):
        read(path)
    assert "Exception ignored" not in capfd.readouterr().err


@pytest.mark.parametrize("filler", ["-999", "9999.0"])
def test_rows_of_one_number_on_all_axes_are_lost_and_that_is_said(tmp_path, filler):
    path = write_text(tmp_path / "run.csv", NAMES, samples())
    lines = path.read_text().splitlines()
    for k in (40, 41, 300):
        lines[k] = ",".join([lines[k].partition(",")[0], *[filler] * 6])
    path.write_text("\n".join([*lines, ""]))
    found = read(path)
    assert found.recognised[-1] == "3 rows of one number on all axes, first at line 41: lost"
    assert found.table["accel_z"].isna().sum() == 3
    assert found.table["accel_z"].abs().max() < 11


def test_decimal_commas_between_commas_without_quotes_are_refused(tmp_path):
    path = write_text(tmp_path / "run.csv", NAMES, samples(), decimal=",", form="{:.6f}")
    with pytest.raises(LogError, match=r"line 2: expected another separator than the decimal comma.*14 values below 7"):
        read(path)


def odd_lines(path, inserted, count=3000):
    rows = [
        ",".join(f"{value:.9g}" for value in row) for row in np.column_stack([times(count), at_rest(count)]).tolist()
    ]
    for place, text in inserted:
        rows.insert(count if place is None else place, text)
    path.write_text("\n".join([",".join(["time", *AXES]), *rows]) + "\n")
    return path


EVENTS = {
    "events": ([(50, "EVENT: button"), (2000, "EVENT: button")], "2 lines that are no rows, the first at line 52"),
    "footer": ([(None, "End, of log"), (None, "Samples: 3000"), (None, "")], "2 lines that are no rows"),
    "one": ([(1000, "# battery"), (1500, "RESET")], "1 line that is no row at line 1502: 'RESET'"),
}


@pytest.mark.parametrize("kind", EVENTS)
def test_few_lines_that_are_no_rows_are_left_out_and_that_is_said(tmp_path, kind):
    inserted, said = EVENTS[kind]
    found = read(odd_lines(tmp_path / "run.csv", inserted), RecordingSettings(frame="as-is"))
    np.testing.assert_allclose(found.log.to_numpy(), at_rest(3000), rtol=1e-6, atol=1e-9)
    assert sum(said in one for one in found.recognised) == 1


def test_the_line_of_a_row_counts_those_that_are_left_out(tmp_path):
    found = read(odd_lines(tmp_path / "run.csv", [(50, "EVENT: button")]))
    assert [found.place(row) for row in (49, 50)] == ["line 51", "line 53"]


@pytest.mark.parametrize(
    ("inserted", "count"), [([(k, "EVENT: button") for k in range(50, 58)], 3000), ([(None, "29.99,0,0")], 500)]
)
def test_many_lines_that_are_no_rows_and_rows_that_are_cut_off_are_refused(tmp_path, inserted, count):
    with pytest.raises(LogError, match=r"line \d+: expected 7 values .*\(remove the lines that are no rows\)"):
        read(odd_lines(tmp_path / "run.csv", inserted, count))


@pytest.mark.parametrize(
    ("row", "said"),
    [
        ("1000,0x004B,0x0002,0x3F01,0x0001,0x0002,0x4000", "line 2: .*hexadecimal words.*'0x004B'"),
        ("1.0D+00,2.0D-03,1.0D-03,2.0D-03,0.0D+00,1.0D-02,-9.8D+00", "line 2: .*write E in place of D.*'1.0D"),
        ('0.0,"[0.1, 0.2, 9.8]","[0.01, 0.02, 0.01]"', "line 2: .*a column for each axis.*0.1, 0.2, 9.8"),
    ],
)
def test_rows_without_decimal_numbers_are_refused_with_the_first_cell(tmp_path, row, said):
    path = tmp_path / "run.csv"
    path.write_text("\n".join(["time,gyro,accel", *[row] * 100]) + "\n")
    with pytest.raises(LogError, match=said):
        read(path)


def test_a_text_of_one_long_line_is_refused(tmp_path):
    (tmp_path / "run.csv").write_text("time gyro_x" + " 0.0" * 200_000)
    with pytest.raises(LogError, match=r"line 1: expected a header and rows of numbers; found 'time gyro_x 0.0"):
        read(tmp_path / "run.csv")

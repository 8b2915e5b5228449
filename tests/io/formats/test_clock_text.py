"""Stamps as texts."""

import numpy as np
import pyarrow as pa
import pytest
from tests.io.devices import at_rest

from imugap.io.formats.clock_text import is_time, nanoseconds
from imugap.io.recording import read
from imugap.log import AXES, LogError

SECOND = 10**9
AT = int(np.datetime64("2024-05-01T10:02:03.25", "ns").astype(int))
OF_DAY = ((10 * 60 + 2) * 60 + 3) * SECOND + SECOND // 4
TIMES = {
    "2024-05-01T10:02:03.25Z": AT,
    "2024-05-01 12:02:03,250+02:00": AT,
    "2024/05/01 10:02:03.250000000123": AT,
    "2024-05-01 10-02-03_250": AT,
    "01-May-2024 10:02:03.250": AT,
    "1 May 2024 10:02:03.250": AT,
    "01.05.2024 10:02:03,250": OF_DAY,
    "5/1/2024 10:02:03.250 AM": OF_DAY,
    "5/1/24, 10:2:3.25 PM": OF_DAY + 12 * 3600 * SECOND,
    "12:00:00 AM": 0,
    "12:00:00 PM": 12 * 3600 * SECOND,
    "10:02:03:250": OF_DAY,
    "02:03.25": (2 * 60 + 3) * SECOND + SECOND // 4,
    "0.25 sec": SECOND // 4,
    "1.5 ms": 1_500_000,
}


@pytest.mark.parametrize("text", TIMES)
def test_a_time_in_words_is_its_nanoseconds(text):
    assert is_time(text)
    np.testing.assert_array_equal(nanoseconds(pa.array([text, text])), [TIMES[text]] * 2)


@pytest.mark.parametrize("text", ["", "1.5", "10:02", "2024-05-01", "10:61:00", "rest", "1.5 m", "1:2:3:4:5"])
def test_other_texts_are_no_times(text):
    assert not is_time(text)
    with pytest.raises(pa.ArrowInvalid):
        nanoseconds(pa.array([text]))


@pytest.mark.parametrize("form", ["{}:{:02d}:{:02d}.{:03d}", "31.12.2023 {}:{:02d}:{:02d},{:03d}"])
def test_a_log_over_midnight_goes_on(tmp_path, form):
    table, path = at_rest(1000, up=(0, 0, -1)), tmp_path / "night.csv"
    of_day = (86395_000 + 10 * np.arange(len(table))) % 86400_000
    clock = [form.format(ms // 3600_000, ms // 60_000 % 60, ms // 1000 % 60, ms % 1000) for ms in of_day]
    rows = [";".join([stamp, *(f"{value:.9g}" for value in row)]) for stamp, row in zip(clock, table, strict=True)]
    path.write_text("\n".join([";".join(["time", *AXES]), *rows]) + "\n")
    found = read(path).regular
    assert found.interval == pytest.approx(0.01)
    said = "a time of day wraps every 86400 s, once, first at line 502: unwrapped"
    assert said in [remark.text for remark in found.remarks]
    np.testing.assert_allclose(found.log.to_numpy(), table, rtol=1e-8)


def test_a_leap_second_is_named(tmp_path):
    path, seconds = tmp_path / "leap.csv", [f"2016-12-31T23:59:{second:02d}Z" for second in range(61)]
    rows = [
        f"{stamp},0,0,0,0,0,-9.8"
        for stamp in [*[f"2016-12-31T23:5{k // 60}:{k % 60:02d}Z" for k in range(500)], *seconds]
    ]
    path.write_text("\n".join([",".join(["time", *AXES]), *rows]) + "\n")
    with pytest.raises(LogError, match="line 562, column time: expected a value as in the rows above; found '2016"):
        read(path)


def test_minutes_and_seconds_go_on_over_the_hour(tmp_path):
    samples = at_rest(3000, up=(0, 0, -1))
    path = tmp_path / "run.csv"
    hundredths = 359_000 + np.arange(len(samples))
    rows = [f"{k // 6000 % 60:02d}:{k // 100 % 60:02d}.{k % 100:02d}," for k in hundredths.tolist()]
    lines = [row + ",".join(map(str, values)) for row, values in zip(rows, samples.tolist(), strict=True)]
    path.write_text("\n".join([",".join(["time", *AXES]), *lines, ""]))
    found = read(path).regular
    assert found.interval == pytest.approx(0.01)
    assert str(found.remarks[0]) == "a time of the hour wraps every 3600 s, once, first at line 1002: unwrapped"

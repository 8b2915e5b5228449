"""Stamps as texts."""

import re
from datetime import datetime, timedelta

import numpy as np
import pyarrow as pa
import pytest
from tests.io.devices import at_rest

from imugap.io.formats.clock_text import is_time, nanoseconds, order_of
from imugap.io.recording import RecordingSettings, read
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
    "1. Mai 2024 10:02:03,250": AT,
    "01.05.2024 10:02:03,250": AT,
    "01/05/2024 10:02:03.250": AT,
    "01-05-24 10:02:03.250": AT,
    "5/1/2024 10:02:03.250 AM": AT,
    "5/1/24, 10:2:3.25 PM": AT + 12 * 3600 * SECOND,
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


@pytest.mark.parametrize(
    ("dates", "year", "month", "day"),
    [
        (["25.11.2026", "27.11.2026"], 2026, 11, 25), (["11/25/2026", "11/27/2026"], 2026, 11, 25),
        (["25/11/26", "27/11/26"], 2026, 11, 25), (["26/11/25", "26/11/27"], 2026, 11, 25),
        (["04/03/2026", "05/03/2026"], 2026, 3, 4), (["03/04/2026", "03/05/2026"], 2026, 3, 4),
        (["11/12/2026", "12/12/2026", "13/12/2026"], 2026, 12, 11), (["31/12/2026", "01/01/2027"], 2026, 12, 31),
        (["28.02.26", "01.03.26"], 2026, 2, 28),
    ],
)  # fmt: skip
def test_what_goes_on_from_date_to_date_tells_day_from_month(dates, year, month, day):
    order = order_of([pa.array([f"{one} 10:02:03" for one in dates])])
    numbers = [int(one) for one in re.split("[./]", dates[0])]
    assert [numbers[place] % 100 for place in order.places] == [year % 100, month, day]
    assert order.same is None


def test_one_date_is_read_as_usual_and_that_is_said():
    assert order_of([pa.array(["04/03/2026 1:00:00"])]).sentence("time") == (
        "dates of time taken as day/month/year (the differences are the same as month/day/year)"
    )
    assert order_of([pa.array(["04/03/2026 1:00:00 PM"])]).name == "month/day/year"
    assert order_of([pa.array(["2026/03/04 1:00:00"])]) is None


@pytest.mark.parametrize("dates", [["03/05/2026", "05/03/2026"], ["25/11/2026", "11/25/2026"]])
def test_dates_in_no_order_are_refused(dates):
    with pytest.raises(ValueError, match="dates in one order of day, month and year"):
        order_of([pa.array(dates)])


@pytest.mark.parametrize("form", ["%d.%m.%Y", "%m/%d/%Y", "%d/%m/%Y", "%d/%m/%y", "%Y-%m-%d", "%Y/%m/%d", "%d-%b-%Y"])
def test_two_days_without_a_log_are_not_closed_up(tmp_path, form):
    table, path = at_rest(1000, up=(0, 0, -1)), tmp_path / "days.csv"
    begins = [datetime(2026, 11, 25, 12), datetime(2026, 11, 27, 12)]
    times = [begins[k // 500] + timedelta(seconds=0.01 * k) for k in range(len(table))]
    clock = [f"{time:{form} %H:%M:%S}.{time.microsecond // 1000:03d}" for time in times]
    rows = [",".join([stamp, *(f"{value:.9g}" for value in row)]) for stamp, row in zip(clock, table, strict=True)]
    path.write_text("\n".join([",".join(["time", *AXES]), *rows]) + "\n")
    found = read(path)
    assert found.table.index[500] - found.table.index[499] == pytest.approx(2 * 86400 + 0.01)
    with pytest.raises(LogError, match=r"from \d+"):
        found.regular  # noqa: B018


@pytest.mark.parametrize("setting", [{}, {"time_unit": "s"}])
@pytest.mark.parametrize("name", ["time [s]", "Date Time", "stamp"])
def test_times_as_texts_need_no_unit_and_no_name(tmp_path, name, setting):
    table, path = at_rest(1000, up=(0, 0, -1)), tmp_path / "named.csv"
    clock = [f"04/03/2026 10:00:{k // 100:02d}.{k % 100:02d}" for k in range(len(table))]
    rows = [",".join([stamp, *(f"{value:.9g}" for value in row)]) for stamp, row in zip(clock, table, strict=True)]
    path.write_text("\n".join([",".join([name, *AXES]), *rows]) + "\n")
    found = read(path, RecordingSettings(**setting))
    assert found.regular.interval == pytest.approx(0.01)
    assert any("times as texts" in one for one in found.recognised)


@pytest.mark.parametrize("name", ["Date", "Excel date", "HHMMSS.sss"])
def test_a_column_that_may_be_the_stamps_is_named(tmp_path, name):
    table, path = at_rest(100), tmp_path / "days.csv"
    rows = [",".join(map(str, [46351.5 + k / 8640000, *row])) for k, row in enumerate(table.tolist())]
    path.write_text("\n".join([",".join([name, *AXES]), *rows]) + "\n")
    with pytest.raises(LogError, match=f"{name!r} may be the stamps"):
        read(path)


def test_a_rate_of_no_sensor_is_refused_though_an_option_asks_for_it(tmp_path):
    path = tmp_path / "slow.csv"
    rows = [",".join(map(str, [20_000_000 * k, *row])) for k, row in enumerate(at_rest(100).tolist())]
    path.write_text("\n".join([",".join(["time", *AXES]), *rows]) + "\n")
    with pytest.raises(LogError, match=r"0.1 to 1e\+06 Hz.*found 5e-08 Hz in s"):
        read(path, RecordingSettings(time_unit="s"))
    assert read(path, RecordingSettings(time_unit="ns")).regular.interval == pytest.approx(0.02)


@pytest.mark.parametrize("form", ["{}:{:02d}:{:02d}.{:03d}"])
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

"""Logs of fixes: what is read comes back, what is wrong is refused with its place, and nothing else is raised."""

import numpy as np
import pandas as pd
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from imugap.io import gnss
from imugap.io.fixes.reading import read
from imugap.kinematics import earth
from imugap.kinematics.strapdown import VELOCITY, Ellipsoid
from imugap.log import LogError

HEADER = "time,latitude,longitude,height"
ROWS = ["0,48.0,11.0,500", "1,48.0001,11.0001,501", "2,48.0002,11.0002,502"]


def fixes_of(path):
    return read(path).fixes


@pytest.fixture
def path(tmp_path):
    return tmp_path / "gnss.csv"


def lines(path, *rows, header=HEADER):
    path.write_text("".join(f"{row}\n" for row in (header, *rows)))
    return path


def test_degrees_become_radians_and_columns_their_order(path):
    found = fixes_of(lines(path, "3,10,-45,90", "4,11,45,-180", header="time,height,latitude,longitude"))
    assert list(found.columns) == ["latitude", "longitude", "height"]
    np.testing.assert_allclose(found["latitude"], [-np.pi / 4, np.pi / 4])
    np.testing.assert_allclose(found["longitude"], [np.pi / 2, -np.pi])
    assert found["height"].tolist() == [10, 11]


def test_csv_and_parquet_are_one(path, tmp_path):
    table = pd.read_csv(lines(path, *ROWS)).set_index("time")
    table.to_parquet(tmp_path / "gnss.parquet")
    pd.testing.assert_frame_equal(fixes_of(path), fixes_of(tmp_path / "gnss.parquet"), check_index_type=False)


def test_what_is_optional_may_be_empty(path):
    found = fixes_of(lines(path, f"{ROWS[0]},1,2,3", f"{ROWS[1]},,,", header=f"{HEADER},{','.join(VELOCITY)}"))
    assert found[list(VELOCITY)].isna().to_numpy().tolist() == [[False] * 3, [True] * 3]
    measured = gnss.local(found, gnss.origin(found))
    assert np.isnan(measured[1, 3:]).all()
    assert measured[0].tolist() == [0, 0, 0, 1, 2, 3]


@pytest.mark.parametrize(
    ("rows", "header", "message"),
    [
        (ROWS, HEADER.replace("latitude", "lattitude"), r"did you mean latitude\?"),
        (["0,48,11", "1,48,11"], "time,latitude,longitude", "expected all of latitude, longitude, height"),
        ([*ROWS[:2], "1,48,11,5"], HEADER, "line 4, column time: expected a time that increases; found 1.0 after 1.0"),
        ([ROWS[0], "1,91,11,5"], HEADER, "line 3, column latitude: expected less than pi/2 rad"),
        ([ROWS[0], "1,48,400,5"], HEADER, "line 3, column longitude"),
        ([ROWS[0], "1,48,,5"], HEADER, "line 3, column longitude: expected a finite number; found nan"),
        ([ROWS[0], "1,48,11,high"], HEADER, "line 3, column height: expected a number; found 'high'"),
        ([f"{ROWS[0]},1", f"{ROWS[1]},1"], f"{HEADER},vel_n", "expected all of vel_n, vel_e, vel_d or none"),
        ([f"{ROWS[0]},1,1,1", f"{ROWS[1]},1,0,1"], f"{HEADER},sd_n,sd_e,sd_d", "line 3, column sd_e: expected"),
        ([f"{ROWS[0]},1,1,1", f"{ROWS[1]},1,1e9,1"], f"{HEADER},{','.join(VELOCITY)}", "line 3, column vel_e"),
        (ROWS[:1], HEADER, "rows: expected at least 2 fixes; found 1"),
        ([], "", "expected"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_told_with_its_place(path, rows, header, message):
    with pytest.raises(LogError, match=message):
        fixes_of(lines(path, *rows, header=header))


@given(st.text(max_size=200))
def test_any_text_is_a_log_or_a_log_error(tmp_path_factory, text):
    path = tmp_path_factory.mktemp("any") / "gnss.csv"
    path.write_text(f"{HEADER}\n{text}", encoding="utf-8", errors="replace")
    try:
        found = fixes_of(path)
    except LogError:
        return
    gnss.check(found)


places = st.tuples(st.floats(-89.9, 89.9), st.floats(-180, 180), st.floats(-400, 9000))


@given(st.lists(places, min_size=2, max_size=20))
def test_what_is_written_is_read_to_the_bit_of_its_conversion(tmp_path_factory, rows):
    path = tmp_path_factory.mktemp("round") / "gnss.csv"
    table = pd.DataFrame(rows, columns=list(gnss.PLACE), index=pd.Index(np.arange(len(rows), dtype=float), name="time"))
    assume((table["latitude"].abs() > np.pi / 2).any() or (table["longitude"].abs() > np.pi).any())  # no radians
    table.to_csv(path)
    found = fixes_of(path)
    for name in ("latitude", "longitude"):
        np.testing.assert_allclose(np.degrees(found[name]), table[name], atol=1e-12)
    np.testing.assert_array_equal(found["height"], table["height"])


@given(places, st.tuples(*[st.floats(-3000, 3000)] * 3))
def test_metres_from_the_origin_are_those_of_the_ellipsoid(place, apart):
    """There and back, and against the radii of curvature for a way that is short."""
    latitude, longitude, height = np.radians(place[0] * 0.95), np.radians(place[1]), place[2]
    ellipsoid = Ellipsoid(latitude, longitude, height)
    measured = np.array([[*apart, 1, 2, 3], [0, 0, 0, 4, 5, 6]])
    fixes = gnss.from_local(np.arange(2.0), measured, np.ones((2, 6)), ellipsoid)
    np.testing.assert_allclose(gnss.local(fixes, ellipsoid), measured, atol=1e-6)
    north, east = earth.metres_per_radian(latitude, height)
    assert fixes["latitude"].iloc[0] - latitude == pytest.approx(apart[0] / north, abs=1e-12)
    assert fixes["longitude"].iloc[0] - longitude == pytest.approx(apart[1] / east, abs=1e-12)


def test_the_date_line_is_no_way_round_the_earth():
    fixes = gnss.check(pd.DataFrame(
        {"latitude": [0.5, 0.5], "longitude": [np.pi - 1e-6, -np.pi + 1e-6], "height": [0.0, 0.0]},
        index=pd.Index([0.0, 1.0], name="time"),
    ))  # fmt: skip
    assert 0 < gnss.local(fixes, gnss.origin(fixes))[1, 1] < 20


def test_deviations_are_those_of_the_log_where_it_has_them(path):
    found = fixes_of(lines(path, f"{ROWS[0]},1,2,3", f"{ROWS[1]},4,,6", header=f"{HEADER},sd_n,sd_e,sd_d"))
    std = gnss.deviations(found, (9.0, 8.0, 7.0), (0.1, 0.2, 0.3))
    assert std.tolist() == [[1, 2, 3, 0.1, 0.2, 0.3], [4, 8, 6, 0.1, 0.2, 0.3]]

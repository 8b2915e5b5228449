"""One drive, written as receivers and programs write it, is the same log of fixes."""

from datetime import UTC, datetime
from functools import reduce
from operator import xor

import numpy as np
import pytest
from scipy.io import savemat
from tests.io.devices import write_ulog

from imugap.io.fixes.reading import read
from imugap.io.fixes.receiver_settings import ReceiverSettings
from imugap.log import LogError
from imugap.stream import stream

COUNT = 8
START_S = 1_700_000_000.0
TIME = START_S + 0.5 * np.arange(COUNT)
LATITUDE = 48.1 + 1e-5 * np.arange(COUNT)
LONGITUDE = -11.3 - 2e-5 * np.arange(COUNT)
HEIGHT = 520 + 0.25 * np.arange(COUNT)
NORTH, EAST, UP = (np.full(COUNT, value) for value in (2.2, -3.0, 0.5))
SD = (0.5, 0.6, 1.1)
GPS_EPOCH_S, WEEK_S = 315_964_800, 604_800


def text(path, *lines):
    path.write_text("".join(line + "\n" for line in lines))
    return path


LEAP_S = 18.0
"""GPS time less UTC since 2017 [s]."""


def rtklib(path, date=True, system="GPST", ahead_s=LEAP_S):
    names = (
        "latitude(deg) longitude(deg) height(m) Q ns sdn(m) sde(m) sdu(m) sdne(m) sdeu(m) sdun(m) age(s) ratio "
        "vn(m/s) ve(m/s) vu(m/s)"
    )
    rows = []
    for t, *place in zip(TIME + ahead_s, LATITUDE, LONGITUDE, HEIGHT, strict=True):
        week, rest = divmod(t - GPS_EPOCH_S, WEEK_S)
        when = (
            datetime.fromtimestamp(t, UTC).strftime("%Y/%m/%d %H:%M:%S.%f")[:-3] if date else f"{week:.0f} {rest:.3f}"
        )
        rows.append(
            f"{when} {place[0]:.9f} {place[1]:.9f} {place[2]:.4f} 1 12 {SD[0]} {SD[1]} {SD[2]} 0 0 0 0 0 2.2 -3.0 0.5"
        )
    return text(path, "% program   : RTKLIB", f"%  {system}          {names}", *rows)


def sentence(body):
    return f"${body}*{reduce(xor, map(ord, body)):02X}"


def minutes(value, width):
    whole, rest = divmod(abs(value), 1)
    return f"{int(whole):0{width}d}{rest * 60:010.7f}"


def nmea(path):
    rows = []
    for t, lat, lon, height in zip(TIME, LATITUDE, LONGITUDE, HEIGHT, strict=True):
        clock = datetime.fromtimestamp(t, UTC)
        when, day = clock.strftime("%H%M%S.%f")[:-4], clock.strftime("%d%m%y")
        place = f"{minutes(lat, 2)},N,{minutes(lon, 3)},W"
        speed, course = np.hypot(2.2, 3.0) * 3600 / 1852, np.degrees(np.arctan2(-3.0, 2.2)) % 360
        rows += [
            sentence(f"GPRMC,{when},A,{place},{speed:.6f},{course:.6f},{day},,,A"),
            sentence(f"GPGGA,{when},{place},1,12,0.8,{height - 47.5:.3f},M,47.5,M,,"),
            sentence(f"GPGST,{when},1.0,,,,{SD[0]},{SD[1]},{SD[2]}"),
        ]
    rows.append(sentence(f"GPGGA,{when},,,,,0,00,,,M,,M,,"))
    rows.append("$GPGGA,120000.00,1234.5,N,01234.5,E,1,12,0.8,1,M,1,M,,*00")
    return text(path, *rows)


def gpx(path):
    points = [
        f'<trkpt lat="{lat:.9f}" lon="{lon:.9f}"><ele>{h}</ele>'
        f"<time>{datetime.fromtimestamp(t, UTC).isoformat()}</time></trkpt>"
        for t, lat, lon, h in zip(TIME, LATITUDE, LONGITUDE, HEIGHT, strict=True)
    ]
    head = '<?xml version="1.0"?><gpx version="1.1" xmlns="http://www.topografix.com/GPX/1/1"><trk><trkseg>'
    return text(path, head, *points, "</trkseg></trk></gpx>")


def kf_gins(path):
    rows = zip(TIME, LATITUDE, LONGITUDE, HEIGHT, strict=True)
    return text(path, *(f"{t:.3f}  {a:.9f}  {b:.9f}  {c:.3f}  {SD[0]} {SD[1]} {SD[2]} " for t, a, b, c in rows))


def table(path, header, separator=",", up=False):
    velocities = NORTH, EAST, UP if up else -UP
    rows = np.column_stack([TIME, LATITUDE, LONGITUDE, HEIGHT, *velocities])
    return text(path, header, *(separator.join(f"{value:.9f}" for value in row) for row in rows))


def px4(path, fields):
    """A PX4 log with the fields of the position of either generation, as values and their types."""
    types = {"timestamp": "<u8", "fix_type": "<u1", "eph": "<f4", "epv": "<f4", "s_variance_m_s": "<f4",
             **{f"vel_{axis}_m_s": "<f4" for axis in "ned"}, "vel_ned_valid": "?"}  # fmt: skip
    rows = np.zeros(COUNT + 1, [*types.items(), *((name, kind) for name, (_, kind) in fields.items())])
    rows["timestamp"][:COUNT] = np.round(TIME * 1e6)
    rows["timestamp"][COUNT] = rows["timestamp"][COUNT - 1] + 500_000
    rows["fix_type"][:COUNT] = 3
    values = {"eph": 0.5, "epv": 1.1, "s_variance_m_s": 0.2, "vel_n_m_s": 2.2, "vel_e_m_s": -3.0, "vel_d_m_s": -0.5,
              "vel_ned_valid": True} | {name: one for name, (one, _) in fields.items()}  # fmt: skip
    for name, value in values.items():
        rows[name][:COUNT] = value
    return write_ulog(path, {"vehicle_gps_position": rows})


DEGREES = {
    "latitude_deg": (LATITUDE, "<f8"), "longitude_deg": (LONGITUDE, "<f8"),
    "altitude_msl_m": (HEIGHT - 47.5, "<f8"), "altitude_ellipsoid_m": (HEIGHT, "<f8"),
}  # fmt: skip
INTEGERS = {
    "lat": (np.round(LATITUDE * 1e7), "<i4"), "lon": (np.round(LONGITUDE * 1e7), "<i4"),
    "alt": (HEIGHT * 1e3 - 47_500, "<i4"), "alt_ellipsoid": (HEIGHT * 1e3, "<i4"),
}  # fmt: skip


def simulated(path):
    """The folder of gnss-ins-sim with the fixes of a run."""
    path.mkdir()
    text(path / "gps_time.csv", "gps_time (sec)", *map(repr, TIME.tolist()))
    names = "gps_lat (deg),gps_lon (deg),gps_alt (m),gps_vN (m/s),gps_vE (m/s),gps_vD (m/s)"
    rows = np.column_stack([LATITUDE, LONGITUDE, HEIGHT, NORTH, EAST, -UP])
    text(path / "gps-0.csv", names, *(",".join(f"{value:.18e}" for value in row) for row in rows))
    return path


UNITS = "Time (s);Latitude (deg);Longitude (deg);Altitude (m);Vn (m/s);Ve (m/s);Vu (m/s)"
WRITERS = {
    "RTKLIB": (rtklib, True, True),
    "RTKLIB, UTC": (lambda path: rtklib(path, system="UTC", ahead_s=0.0), True, True),
    "RTKLIB, JST": (lambda path: rtklib(path, system="JST", ahead_s=9 * 3600.0), True, True),
    "RTKLIB, week": (lambda path: rtklib(path, date=False), True, True),
    "NMEA": (nmea, True, None),
    "GPX": (gpx, False, False),
    "KF-GINS": (kf_gins, True, False),
    "gnss-ins-sim": (simulated, False, True),
    "canonical": (lambda path: table(path, "time,latitude,longitude,height,vel_n,vel_e,vel_d"), False, True),
    "pyins": (lambda path: table(path, "time,lat,lon,alt,VN,VE,VD"), False, True),
    "units": (
        lambda path: table(path, UNITS, ";", up=True),
        False, True,
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", WRITERS)
def test_every_format_gives_the_same_fixes(tmp_path, name):
    write, deviations, velocities = WRITERS[name]
    fixes = read(write(tmp_path / "fixes.txt")).fixes
    np.testing.assert_allclose(fixes.index, TIME, atol=2e-3, rtol=0)
    np.testing.assert_allclose(np.degrees(fixes["latitude"]), LATITUDE, atol=1e-8, rtol=0)
    np.testing.assert_allclose(np.degrees(fixes["longitude"]), LONGITUDE, atol=1e-8, rtol=0)
    np.testing.assert_allclose(fixes["height"], HEIGHT, atol=1e-3)
    assert ("sd_n" in fixes) == deviations
    if deviations:
        np.testing.assert_allclose(fixes[["sd_n", "sd_e", "sd_d"]], np.tile(SD, (COUNT, 1)))
    if velocities is not False:
        np.testing.assert_allclose(fixes[["vel_n", "vel_e"]], np.column_stack([NORTH, EAST]), atol=1e-5)
        assert fixes["vel_d"].isna().all() if velocities is None else np.allclose(fixes["vel_d"], -UP)


@pytest.mark.parametrize("begin_s", [0.0, 5000.0, 1.7e9])
@pytest.mark.parametrize(("unit", "per_second"), [("s", 1), ("ms", 1e3), ("us", 1e6), ("ns", 1e9)])
def test_stamps_of_fixes_in_any_unit_are_converted_and_said(tmp_path, unit, per_second, begin_s):
    time = begin_s + np.arange(COUNT)
    stamps = time.astype(np.int64) * int(per_second)
    rows = (f"{stamp},{48 + k * 1e-5},11.5,500" for k, stamp in enumerate(stamps))
    found = read(text(tmp_path / "fixes.csv", "time,latitude,longitude,height", *rows))
    np.testing.assert_allclose(found.fixes.index, time)
    assert found.recognised[1:] == (() if unit == "s" else (f"stamps {unit} -> s from the rate",))


RADIAN = np.radians(1.0)
PLACES = np.column_stack([48 + np.arange(COUNT) * 1e-5, 11.5 + np.arange(COUNT) * 1e-5, 500 + np.arange(COUNT)])


@pytest.mark.parametrize(
    ("names", "scale", "said"),
    [
        ("latitude,longitude,height", np.radians([1, 1, 57.29577951308232]), {"latitude rad -> deg from the places"}),
        (
            "lat (rad),lon (rad),alt (ft)",
            [np.radians(1), np.radians(1), 1 / 0.3048],
            {"height ft -> m from the header"},
        ),
        (
            "lat,lon,alt",
            [1e7, 1e7, 1e3],
            {"latitude 1e-7 deg -> deg from the places", "height mm -> m from the places"},
        ),
        ("Latitude (deg),Longitude [deg],Height [km]", [1, 1, 1e-3], {"height km -> m from the header"}),
    ],
)
def test_units_of_places_are_converted_and_said(tmp_path, names, scale, said):
    values = PLACES * scale
    values = np.rint(values).astype(int) if max(scale) == 1e7 else values
    rows = [f"{k}," + ",".join(map(repr, row)) for k, row in enumerate(values.tolist())]
    found = read(text(tmp_path / "fixes.csv", f"time,{names}", *rows))
    degrees = np.degrees(found.fixes[["latitude", "longitude"]])
    np.testing.assert_allclose(degrees, PLACES[:, :2], atol=2e-7, rtol=0)
    np.testing.assert_allclose(found.fixes["height"], PLACES[:, 2], atol=1e-3)
    assert said <= set(found.recognised)


def test_places_at_sea_in_degrees_stay_degrees(tmp_path):
    rows = [f"{k},{1e-3 + k * 1e-5},{2e-3},0" for k in range(COUNT)]
    found = read(text(tmp_path / "fixes.csv", "time,latitude,longitude,height", *rows))
    np.testing.assert_allclose(np.degrees(found.fixes["longitude"]), 2e-3)


def near_zero(path, per_s, noise=0.0, speed=None):
    """Fixes off Africa, if in degrees, moving so much a second [deg or rad], with a stated speed [m/s]."""
    scatter = noise * stream(1, "scatter").standard_normal(200)
    rows = (
        f"{k},{0.7 + k * per_s + scatter[k]:.12f},0.2,0" + ("" if speed is None else f",{speed},0,0")
        for k in range(200)
    )
    names = "time,latitude,longitude,height" + ("" if speed is None else ",vn,ve,vd")
    return text(path / "fixes.csv", names, *rows)


def test_places_near_zero_have_the_unit_of_their_speed(tmp_path):
    metre = 1 / 6.37e6
    assert np.degrees(read(near_zero(tmp_path, 20 * metre)).fixes["latitude"].iloc[0]) == pytest.approx(np.degrees(0.7))
    degrees = near_zero(tmp_path, np.degrees(20 * metre))
    assert np.degrees(read(degrees).fixes["latitude"].iloc[0]) == pytest.approx(0.7)
    slow = np.degrees(2 * metre)
    assert np.degrees(read(near_zero(tmp_path, slow, speed=2.0)).fixes["latitude"].iloc[0]) == pytest.approx(0.7)
    fast = near_zero(tmp_path, slow, speed=np.degrees(2.0))
    assert np.degrees(read(fast).fixes["latitude"].iloc[0]) == pytest.approx(np.degrees(0.7))


@pytest.mark.parametrize(("metres", "noise"), [(2.0, 0.0), (0.0, 1.0), (0.0, 0.0)])
def test_places_near_zero_that_may_be_in_both_units_are_refused_and_read_by_the_option(tmp_path, metres, noise):
    path = near_zero(tmp_path, np.degrees(metres / 6.37e6), np.degrees(noise / 6.37e6))
    with pytest.raises(LogError, match=r"\(--fixes-angles deg or rad decides\); found .* m/s in deg or .* m/s in rad"):
        read(path)
    for unit, size in (("deg", 1.0), ("rad", np.degrees(1.0))):
        found = read(path, ReceiverSettings(angles=unit))
        assert np.degrees(found.fixes["latitude"]).median() == pytest.approx(0.7 * size, rel=0.01)


def test_velocities_in_other_units_are_converted(tmp_path):
    names = "time,latitude,longitude,height,Vn (km/h),Ve (kn),Vd (cm/s)"
    found = read(text(tmp_path / "fixes.csv", names, *(f"{k},48,11,0,36,{3600 / 1852!r},100" for k in range(COUNT))))
    np.testing.assert_allclose(found.fixes[["vel_n", "vel_e", "vel_d"]], [[10.0, 1.0, 1.0]] * COUNT)


def matlab(path, contents):
    savemat(path, contents)
    return path


def test_fixes_in_arrays_of_matlab_are_read_from_the_structure_that_has_them(tmp_path):
    angles = np.radians(PLACES)
    gnss = {"t": np.arange(COUNT) * 1.0, "lat": angles[:, 0], "lon": angles[:, 1], "h": PLACES[:, 2], "freq": 1.0}
    found = read(matlab(tmp_path / "one.mat", {"gnss": gnss}))
    np.testing.assert_allclose(np.degrees(found.fixes["latitude"]), PLACES[:, 0])
    two = matlab(tmp_path / "two.mat", {"gnss": gnss, "rtk": gnss | {"h": PLACES[:, 2] + 1}})
    with pytest.raises(LogError, match=r"one column of latitude \(--topic .*\); found gnss.lat, rtk.lat"):
        read(two)
    np.testing.assert_allclose(read(two, ReceiverSettings("rtk")).fixes["height"], PLACES[:, 2] + 1)


@pytest.mark.parametrize("interval", [1e-12, 1e-15, 1e-4])
def test_fixes_at_a_rate_of_no_receiver_are_refused(tmp_path, interval):
    rows = (f"{k * interval!r},{48 + k * 1e-5},11.5,500" for k in range(COUNT))
    with pytest.raises(LogError, match=r"column time: expected stamps in seconds, at most 1000 Hz; found .* Hz"):
        read(text(tmp_path / "fixes.csv", "time,latitude,longitude,height", *rows))


@pytest.mark.parametrize("fields", [DEGREES, INTEGERS], ids=["degrees", "integers"])
def test_messages_of_a_receiver_in_a_px4_log_are_fixes_on_its_clock(tmp_path, fields):
    pytest.importorskip("pyulog")
    found = read(px4(tmp_path / "flight.ulg", fields))
    np.testing.assert_allclose(found.fixes.index, TIME, atol=1e-6, rtol=0)
    np.testing.assert_allclose(np.degrees(found.fixes["latitude"]), LATITUDE, atol=1e-7, rtol=0)
    np.testing.assert_allclose(np.degrees(found.fixes["longitude"]), LONGITUDE, atol=1e-7, rtol=0)
    np.testing.assert_allclose(found.fixes["height"], HEIGHT, atol=1e-3)
    np.testing.assert_allclose(found.fixes[["vel_n", "vel_e", "vel_d"]], np.column_stack([NORTH, EAST, -UP]), rtol=1e-6)
    np.testing.assert_allclose(
        found.fixes[["sd_n", "sd_d", "sd_vel_e"]], np.tile([0.5, 1.1, 0.2], (COUNT, 1)), rtol=1e-6
    )
    assert "message vehicle_gps_position:0, time since boot" in found.recognised
    assert "left out 1 without a fix in three dimensions" in found.recognised


def test_heights_above_the_sea_of_a_px4_log_are_said_to_be_that(tmp_path):
    pytest.importorskip("pyulog")
    found = read(px4(tmp_path / "flight.ulg", DEGREES | {"altitude_ellipsoid_m": (0 * HEIGHT, "<f8")}))
    np.testing.assert_allclose(found.fixes["height"], HEIGHT - 47.5)
    assert found.recognised[-1] == "heights above sea level"


def test_a_px4_log_without_a_receiver_is_refused_with_its_messages(tmp_path):
    pytest.importorskip("pyulog")
    path = write_ulog(tmp_path / "flight.ulg", {"sensor_baro": np.ones(3, [("timestamp", "<u8"), ("pressure", "<f4")])})
    with pytest.raises(LogError, match=r"the message vehicle_gps_position or sensor_gps .*; found sensor_baro:0"):
        read(path)


def test_sentences_without_a_fix_and_with_a_wrong_checksum_are_left_out(tmp_path):
    found = read(nmea(tmp_path / "log.nmea"))
    assert len(found.fixes) == COUNT
    assert found.recognised[-1] == "left out 1 sentences with a wrong checksum"


def test_what_is_no_log_of_fixes_is_refused_with_what_it_lacks(tmp_path):
    with pytest.raises(LogError, match="expected a header, or the 7 or 13 columns of KF-GINS; found 3 columns"):
        read(text(tmp_path / "a.txt", *["1 2 3"] * 4))
    with pytest.raises(LogError, match=r"expected positions as latitude\(deg\)"):
        read(text(tmp_path / "a.pos", "%  GPST x-ecef(m) y-ecef(m) z-ecef(m)", "2024/01/01 00:00:00.000 1 2 3"))
    with pytest.raises(LogError, match="point 0: expected a time and a height"):
        read(
            text(
                tmp_path / "a.gpx", '<gpx><trk><trkseg><trkpt lat="1" lon="2"><ele>3</ele></trkpt></trkseg></trk></gpx>'
            )
        )


@pytest.mark.parametrize(("names", "letters", "signs"), [
    (("LATITUDE", "N/S", "LONGITUDE", "E/W"), ("N", "W"), (1, -1)), (("lat", "ns", "lon", "ew"), ("S", "E"), (-1, 1)),
])  # fmt: skip
def test_letters_of_the_hemisphere_are_the_sign_of_the_places(tmp_path, names, letters, signs):
    path = tmp_path / "fixes.csv"
    places = (f"{k},{48.1 + 1e-5 * k},{letters[0]},{11.3 - 1e-5 * k},{letters[1]},520.0" for k in range(50))
    path.write_text("\n".join([f"time,{','.join(names)},height", *places, ""]))
    found = read(path)
    assert np.degrees(found.fixes["latitude"].iloc[1]) == pytest.approx(signs[0] * 48.10001, abs=1e-9)
    assert np.degrees(found.fixes["longitude"].iloc[1]) == pytest.approx(signs[1] * 11.29999, abs=1e-9)
    assert f"sign of longitude from {names[3]}" in found.recognised


def test_a_solution_that_ends_within_its_first_row_is_refused(tmp_path):
    path = rtklib(tmp_path / "rover.pos")
    head, first = path.read_text().splitlines()[1:3]
    path.write_text("\n".join([head, first[:23]]))
    with pytest.raises(LogError, match="columns: expected all of latitude, longitude, height; found none"):
        read(path)


def test_times_of_day_as_numbers_are_no_stamps_of_fixes(tmp_path):
    rows = [f"{100_000 + 100 * (k // 60) + k % 60},{k},48.1,{11 + 1e-5 * k},500" for k in range(200)]
    with pytest.raises(LogError, match=r"column time: expected seconds, or times of day .* found numbers HHMMSS"):
        read(text(tmp_path / "fixes.csv", "time,fix,latitude,longitude,height", *rows))
    found = read(text(tmp_path / "beside.csv", "time,elapsed_s,latitude,longitude,height", *rows))
    np.testing.assert_allclose(found.fixes.index, np.arange(200))


PHONE = {
    "Sensor Logger": "time,speedAccuracy,verticalAccuracy,horizontalAccuracy,speed,bearing,altitude,longitude,latitude",
    "SensorLog": "locationTimestamp_since1970(s),locationSpeedAccuracy(m/s),locationVerticalAccuracy(m),"
    "locationHorizontalAccuracy(m),locationSpeed(m/s),locationCourse(°),locationAltitude(m),"
    "locationLongitude(WGS84),locationLatitude(WGS84)",
}


def phone(path, header, speeds=1.0, held=1, unknown=()):
    """Fixes of a phone to the north-east at 10 m/s, each ``held`` for so many rows."""
    lines = [header]
    for k in range(60):
        way = 10 * k / np.sqrt(2) / 6.37e6
        place = np.degrees([11.0 / 57.3 + way / np.cos(np.radians(48.0)), np.radians(48.0) + way])
        speed, course = (-1, -1) if k in unknown else (10 * speeds, 45)
        lines += [f"{1.7e9 + k},0.5,6,4.53,{speed},{course},500,{place[0]:.9f},{place[1]:.9f}"] * held
    path.write_text("\n".join([*lines, ""]), encoding="utf-8")
    return path


@pytest.mark.parametrize("header", PHONE.values(), ids=PHONE)
@pytest.mark.parametrize(("speeds", "unit"), [(1.0, ""), (3.6, "km/h -> m/s"), (3600 / 1852, "kn -> m/s")])
def test_speed_course_and_radii_of_a_phone_are_components(tmp_path, header, speeds, unit):
    if unit and "m/s" in header:
        pytest.skip("the header states the unit")
    found = read(phone(tmp_path / "phone.csv", header, speeds, unknown=(30,)))
    known = found.fixes.drop(index=1.7e9 + 30)
    assert known["vel_n"].to_numpy() == pytest.approx(10 / np.sqrt(2), rel=1e-3)
    assert known["vel_e"].to_numpy() == pytest.approx(10 / np.sqrt(2), rel=1e-3)
    assert found.fixes["vel_d"].isna().all()
    assert found.fixes.loc[1.7e9 + 30, ["vel_n", "vel_e"]].isna().all()
    assert found.fixes["sd_n"].to_numpy() == pytest.approx(3.0, rel=1e-3)
    assert found.fixes["sd_d"].to_numpy() == pytest.approx(6.0)
    assert found.fixes["sd_vel_e"].to_numpy() == pytest.approx(0.5)
    assert unit in " ".join(found.recognised)


def test_a_speed_in_no_unit_of_the_places_is_left_out(tmp_path):
    found = read(phone(tmp_path / "phone.csv", PHONE["Sensor Logger"], 1.5))
    assert "vel_n" not in found.fixes
    assert "in no unit" in " ".join(found.recognised)


def test_rows_that_hold_a_fix_of_a_phone_are_one(tmp_path):
    found = read(phone(tmp_path / "phone.csv", PHONE["SensorLog"], held=5))
    assert len(found.fixes) == 60

from math import atan2, degrees, pi, radians

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from imugap.kinematics.site import Site
from imugap.log import ACCEL, AXES, GYRO
from imugap.units import from_si

latitudes, headings = st.floats(-1.5, 1.5), st.floats(-pi + 1e-6, pi - 1e-6)


@given(latitudes, headings)
@settings(deadline=None)  # the first call compiles
def test_a_device_at_rest_turns_with_the_earth(latitude, heading):
    rate = Site(latitude, 0.0, heading).ideal()[list(GYRO)]
    assert np.linalg.norm(rate) == pytest.approx(7.292115e-5, rel=1e-12)


@given(latitudes, headings)
@settings(deadline=None)  # the first call compiles
def test_gyrocompassing_finds_heading_and_latitude(latitude, heading):
    x, y, z = Site(latitude, 0.0, heading).ideal()[list(GYRO)]
    assert atan2(-y, x) == pytest.approx(heading, abs=1e-9)
    assert atan2(-z, np.hypot(x, y)) == pytest.approx(latitude, abs=1e-9)


def test_heading_east_puts_the_earth_rate_on_minus_y():
    x, y, z = from_si(Site(radians(60.0), 0.0, pi / 2).ideal()[list(GYRO)].to_numpy(), "deg/h")
    assert (x, y, z) == pytest.approx((0.0, -7.5205, -13.0259), abs=1e-3)  # of 15.041 deg/h


def test_without_a_heading_the_earth_rate_is_left_in_the_bias():
    assert (Site(0.7, 50.0).ideal()[list(GYRO)] == 0).all()


@pytest.mark.parametrize(("latitude", "gravity"), [(0.0, 9.7803253), (90.0, 9.8321849), (45.0, 9.80620)])
def test_accelerometers_read_minus_normal_gravity_down(latitude, gravity):
    reading = Site(radians(latitude), 0.0).ideal()
    assert reading[list(ACCEL)].tolist() == pytest.approx([0.0, 0.0, -gravity], abs=5e-6)


def test_gravity_falls_by_its_free_air_gradient():
    assert Site(0.8, 1000.0).gravity - Site(0.8, 0.0).gravity == pytest.approx(-3.086e-3, rel=2e-3)  # 0.3086 mGal/m


def test_reading_has_the_axes_of_a_log():
    assert tuple(Site(0.7, 50.0).ideal().index) == AXES


@given(st.floats(-89, 89), st.floats(-100, 9000), st.none() | st.floats(-180, 180))
def test_configuration_is_in_degrees(latitude, height, heading):
    mapping = {"latitude_deg": latitude, "height_m": height} | ({} if heading is None else {"heading_deg": heading})
    site = Site.from_mapping(mapping)
    assert degrees(site.latitude) == pytest.approx(latitude)
    assert site.height == height
    assert site.heading is None if heading is None else degrees(site.heading) == pytest.approx(heading)


def test_a_heading_of_zero_is_known():
    assert Site.from_mapping({"latitude_deg": 40, "height_m": 0, "heading_deg": 0}).ideal()["gyro_x"] > 5e-5


@pytest.mark.parametrize(("heading", "words"), [(None, "unknown"), (radians(30), "30 deg")])
def test_a_site_says_where_it_is(heading, words):
    assert str(Site(radians(51.08), 1100.0, heading)) == f"latitude 51.08 deg, height 1100 m, heading {words}"

"""The Earth model against published numbers and against the geometry of the ellipsoid itself."""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.spatial.transform import Rotation

from imugap.kinematics import earth

LATITUDES = [-1.2, -0.3, 0.0, 0.7, 1.4]


def ecef(latitude, longitude, height):
    """Cartesian coordinates [m] from the parametric ellipse, which needs no radius of curvature."""
    reduced = np.arctan2(earth.SEMI_MINOR_AXIS * np.sin(latitude), earth.SEMI_MAJOR_AXIS * np.cos(latitude))
    equatorial = earth.SEMI_MAJOR_AXIS * np.cos(reduced) + height * np.cos(latitude)
    polar = earth.SEMI_MINOR_AXIS * np.sin(reduced) + height * np.sin(latitude)
    return np.array([equatorial * np.cos(longitude), equatorial * np.sin(longitude), polar])


def mat_en(latitude, longitude):
    """North, east, down as rotations of the axes of ``e``: about z by longitude, about the new y by -(90 deg + lat)."""
    return Rotation.from_euler("ZY", [longitude, -(np.pi / 2 + latitude)])


@pytest.mark.parametrize(
    ("name", "published", "digits"),
    [
        ("SEMI_MINOR_AXIS", 6356752.3142, 1e-4),
        ("ECCENTRICITY_SQUARED", 6.69437999014e-3, 1e-14),
        ("SOMIGLIANA_K", 0.00193185265241, 1e-11),
        ("CENTRIFUGAL_RATIO", 0.00344978650684, 1e-14),
    ],
)
def test_derived_constants_are_the_published_ones(name, published, digits):
    """TR8350.2, tables 3.3 and 3.4, to the last printed digit (k: of the gravities that it is derived from)."""
    assert getattr(earth, name) == pytest.approx(published, rel=0, abs=digits)


@pytest.mark.parametrize(("latitude", "published"), [(0.0, 9.7803253359), (np.pi / 2, 9.8321849378)])
def test_gravity_at_equator_and_poles(latitude, published):
    assert earth.normal_gravity(latitude, 0.0) == pytest.approx(published, rel=0, abs=2e-11)
    assert earth.normal_gravity(-latitude, 0.0) == pytest.approx(published, rel=0, abs=2e-11)


def test_gravity_at_45_degrees():
    """Moritz, Geodetic Reference System 1980: 9.806199203; WGS-84 gravity is smaller by 1.4e-6 all over."""
    shift = 9.7803253359 - 9.7803267715
    assert earth.normal_gravity(np.pi / 4, 0.0) == pytest.approx(9.806199203 + shift, rel=0, abs=5e-9)


def _mean_over_ellipsoid(function):
    def area(latitude):
        meridian, transverse = earth.curvature_radii(latitude)
        return meridian * transverse * np.cos(latitude)

    weighted = quad(lambda latitude: function(latitude) * area(latitude), 0, np.pi / 2, epsrel=1e-13)[0]
    return weighted / quad(area, 0, np.pi / 2, epsrel=1e-13)[0], quad(area, 0, np.pi / 2, epsrel=1e-13)[0]


def test_mean_gravity_and_area_are_the_published_ones():
    """TR8350.2: mean normal gravity 9.7976432222 m/s^2; radius of the sphere of equal area 6371007.1809 m."""
    gravity, area = _mean_over_ellipsoid(lambda latitude: earth.normal_gravity(latitude, 0.0))
    assert gravity == pytest.approx(9.7976432222, rel=0, abs=2e-10)
    assert np.sqrt(area) == pytest.approx(6371007.1809, rel=0, abs=1e-3)


@pytest.mark.parametrize("latitude", LATITUDES)
def test_gravity_falls_with_height_as_bruns_says(latitude):
    """On an equipotential surface dg/dh = -g (1/M + 1/N) - 2 w^2: geometry, which the gravity formula does not use."""
    gravity = earth.normal_gravity(latitude, 0.0)
    gradient = (earth.normal_gravity(latitude, 10.0) - earth.normal_gravity(latitude, -10.0)) / 20
    bruns = -gravity * sum(1 / np.array(earth.curvature_radii(latitude))) - 2 * earth.ROTATION_RATE**2
    assert gradient == pytest.approx(bruns, rel=1e-4)


def test_gravity_high_up_approaches_that_of_a_point_mass():
    """At the pole, 100 km up, the attraction of the mass and of its published J2 = 1.0826298e-3 (no rotation there)."""
    height = 100e3
    radius = earth.SEMI_MINOR_AXIS + height
    point = earth.GRAVITATIONAL_CONSTANT / radius**2
    oblate = point * (1 - 3 * 1.0826298e-3 * (earth.SEMI_MAJOR_AXIS / radius) ** 2)
    assert earth.normal_gravity(np.pi / 2, height) == pytest.approx(oblate, rel=3e-5)
    assert earth.normal_gravity(np.pi / 2, height) != pytest.approx(earth.normal_gravity(np.pi / 2, 0.0), rel=2e-2)


def test_radii_are_the_published_ones():
    """Quarter of the meridian 10001965.7293 m and polar radius of curvature 6399593.6258 m (TR8350.2 table 3.3)."""
    quarter = quad(lambda latitude: earth.curvature_radii(latitude)[0], 0, np.pi / 2, epsrel=1e-13)[0]
    assert quarter == pytest.approx(10001965.7293, rel=0, abs=1e-3)
    assert earth.curvature_radii(np.pi / 2) == pytest.approx((6399593.6258, 6399593.6258), rel=0, abs=1e-4)


@pytest.mark.parametrize("latitude", LATITUDES)
def test_metres_per_radian_are_those_of_the_ellipsoid(latitude):
    longitude, height, step = 0.4, 3000.0, 1e-4
    along_lat = ecef(latitude + step, longitude, height) - ecef(latitude - step, longitude, height)
    along_lon = ecef(latitude, longitude + step, height) - ecef(latitude, longitude - step, height)
    found = np.linalg.norm([along_lat, along_lon], axis=1) / (2 * step)
    assert earth.metres_per_radian(latitude, height) == pytest.approx(found, rel=1e-8)


@pytest.mark.parametrize("latitude", LATITUDES)
def test_earth_rate_is_the_polar_axis_seen_from_the_ground(latitude):
    expected = mat_en(latitude, 1.1).inv().apply([0, 0, earth.ROTATION_RATE])
    assert earth.earth_rate_n(latitude) == pytest.approx(expected, rel=1e-14, abs=1e-19)


@pytest.mark.parametrize("latitude", LATITUDES)
def test_transport_rate_is_the_turn_of_north_east_down(latitude):
    vel_n, vel_e, height, longitude, step = 130.0, -210.0, 5000.0, -2.0, 10.0
    per_north, per_east = earth.metres_per_radian(latitude, height)
    move = 0.5 * step * np.array([vel_n / per_north, vel_e / per_east])
    before, after = mat_en(latitude - move[0], longitude - move[1]), mat_en(latitude + move[0], longitude + move[1])
    expected = (before.inv() * after).as_rotvec() / step
    assert earth.transport_rate_n(latitude, height, vel_n, vel_e) == pytest.approx(expected, rel=1e-6)


def test_arrays_broadcast():
    latitude, height = np.array(LATITUDES)[:, None], np.array([0.0, 1e3, 1e4])
    table = earth.normal_gravity(latitude, height)
    assert table.shape == (5, 3)
    assert table[3, 2] == pytest.approx(earth.normal_gravity(0.7, 1e4), rel=1e-15)
    assert np.shape(earth.earth_rate_n(latitude[:, 0])) == (3, 5)

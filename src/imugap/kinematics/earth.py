"""Earth model for navigation: WGS-84 ellipsoid, normal gravity, rates of the navigation frame.

Every function is compiled and takes floats or arrays that broadcast, for the kernels of
:mod:`imugap.kinematics.strapdown` and for tables alike. Latitude [rad] is geodetic, height [m] is ellipsoidal, vectors
are (north, east, down).

Sources: NIMA TR8350.2, Department of Defense World Geodetic System 1984, 3rd ed., amended (tables 3.1-3.4, section 4);
P. D. Groves, Principles of GNSS, Inertial, and Multisensor Integrated Navigation Systems, 2nd ed., 2013.
"""

import numpy as np
from numba import njit

SEMI_MAJOR_AXIS = 6378137.0
"""Equatorial radius [m] (TR8350.2 table 3.1)."""
FLATTENING = 1 / 298.257223563
"""(a - b)/a [1] (TR8350.2 table 3.1)."""
GRAVITATIONAL_CONSTANT = 3.986004418e14
"""GM of the Earth with its atmosphere [m^3/s^2] (TR8350.2 table 3.1)."""
ROTATION_RATE = 7.292115e-5
"""Rate of the Earth relative to inertial space [rad/s] (TR8350.2 table 3.1)."""
EQUATORIAL_GRAVITY = 9.7803253359
"""Normal gravity on the ellipsoid at the equator [m/s^2] (TR8350.2 table 3.4)."""
POLAR_GRAVITY = 9.8321849378
"""Normal gravity on the ellipsoid at the poles [m/s^2] (TR8350.2 table 3.4)."""

SEMI_MINOR_AXIS = SEMI_MAJOR_AXIS * (1 - FLATTENING)
ECCENTRICITY_SQUARED = FLATTENING * (2 - FLATTENING)
SOMIGLIANA_K = SEMI_MINOR_AXIS * POLAR_GRAVITY / (SEMI_MAJOR_AXIS * EQUATORIAL_GRAVITY) - 1
CENTRIFUGAL_RATIO = ROTATION_RATE**2 * SEMI_MAJOR_AXIS**2 * SEMI_MINOR_AXIS / GRAVITATIONAL_CONSTANT


@njit(cache=True, forceinline=True)
def normal_gravity(latitude, height):
    """Return normal gravity [m/s^2], along the ellipsoid's normal, positive down.

    Somigliana's closed form on the ellipsoid (TR8350.2 eq. 4-1, Groves eq. 2.134), continued upwards to the second
    order in height (TR8350.2 eq. 4-3, Groves eq. 2.139). The north component above the ellipsoid, at most
    8.1e-9 m/s^2 per metre of height (Groves eq. 2.140), is left out.
    """
    sine_squared = np.sin(latitude) ** 2
    surface = EQUATORIAL_GRAVITY * (1 + SOMIGLIANA_K * sine_squared) / np.sqrt(1 - ECCENTRICITY_SQUARED * sine_squared)
    ratio = height * (1 / SEMI_MAJOR_AXIS)
    decrease = 2 * (1 + FLATTENING + CENTRIFUGAL_RATIO - 2 * FLATTENING * sine_squared)
    return surface * (1 - ratio * (decrease - 3 * ratio))


@njit(cache=True, forceinline=True)
def curvature_radii(latitude):
    """Return the radii of curvature of the ellipsoid [m]: meridian, transverse (Groves eqs. 2.105 and 2.106)."""
    inverse_square = 1 / (1 - ECCENTRICITY_SQUARED * np.sin(latitude) ** 2)
    transverse = SEMI_MAJOR_AXIS * np.sqrt(inverse_square)
    return transverse * (1 - ECCENTRICITY_SQUARED) * inverse_square, transverse


@njit(cache=True, forceinline=True)
def metres_per_radian(latitude, height):
    """Return the metres north per radian of latitude, and east per radian of longitude (Groves eq. 2.111)."""
    meridian, transverse = curvature_radii(latitude)
    return meridian + height, (transverse + height) * np.cos(latitude)


@njit(cache=True, forceinline=True)
def earth_rate_n(latitude):
    """Return the rate of ``e`` relative to inertial space in ``n`` [rad/s]: north, east, down (Groves eq. 2.123)."""
    return ROTATION_RATE * np.cos(latitude), 0.0 * latitude, -ROTATION_RATE * np.sin(latitude)


@njit(cache=True, forceinline=True)
def transport_rate_n(latitude, height, vel_n, vel_e):
    """Return the rate of ``n`` relative to ``e`` in ``n`` [rad/s]: north, east, down (Groves eq. 5.44).

    ``vel_n`` and ``vel_e`` are the velocity relative to the Earth [m/s]. The down component has a pole at the poles.
    """
    meridian, transverse = curvature_radii(latitude)
    north = vel_e * (1 / (transverse + height))
    return north, -vel_n * (1 / (meridian + height)), -north * (np.sin(latitude) / np.cos(latitude))

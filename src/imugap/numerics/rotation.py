"""Rotations: compiled scalar kernels for the navigation loops, and SciPy's ``Rotation`` for everything else.

Inside a kernel a vector is a tuple of 3 floats, a quaternion a tuple ``(x, y, z, w)``, scalar last as in SciPy, and a
matrix a tuple of 3 rows. Arguments may be any
indexable, also arrays; tuples are returned, because they are kept in registers.
``quat_nb`` and ``mat_nb`` turn a vector given in ``b`` into ``n``; quaternions multiply in Hamilton's convention, in
the order of matrices. Euler angles are (roll, pitch, heading) [rad]: ``n`` turned by heading about down, then by pitch
about the new y, then by roll about the new x, gives ``b`` (ZYX; Groves 2013, section 2.2.1).
"""

from math import factorial

import numpy as np
from numba import njit
from scipy.spatial.transform import Rotation

kernel = njit(cache=True, fastmath={"contract"}, forceinline=True)
"""Compile a kernel and inline it wherever a kernel calls it: a call would pass its tuples through memory.

Contraction to fused multiply-add is the only relaxation of the arithmetic: it rounds less, and it keeps NaN.
"""

SERIES_LIMIT = 1.0
"""Square of the largest rotation angle [rad^2] for which the power series below are summed.

An alternating series with falling terms errs by less than its first omitted term. At 1 rad that is, relative to the
sum, 5e-17 for ``HALF_SINE`` (7 terms), 8e-19 for ``HALF_COSINE`` (8) and 5e-17 for ``SINE_DEFECT`` (8): below the unit
roundoff of 1.1e-16, which one term fewer would exceed in each. Above 1 rad the closed form of the last one,
(x - sin x)/x^3, loses less than 3 bits by cancellation.
"""
HALF_SINE = tuple((-1) ** k / (2 ** (2 * k + 1) * factorial(2 * k + 1)) for k in range(7))
HALF_COSINE = tuple((-1) ** k / (4**k * factorial(2 * k)) for k in range(8))
SINE_DEFECT = tuple((-1) ** k / factorial(2 * k + 3) for k in range(8))


@kernel
def polynomial(coefficients, x):
    """Return the sum of ``coefficients[k] x^k`` by Horner's rule."""
    total = coefficients[-1]
    for k in range(len(coefficients) - 2, -1, -1):
        total = coefficients[k] + x * total
    return total


@kernel
def dot(a, b):
    """Return the scalar product of two 3-vectors."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@kernel
def cross(a, b):
    """Return the vector product of two 3-vectors."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@kernel
def add_scaled(a, scale, b):
    """Return ``a + scale b`` of two 3-vectors."""
    return a[0] + scale * b[0], a[1] + scale * b[1], a[2] + scale * b[2]


@kernel
def multiply(p, q):
    """Return the product of two quaternions: first the rotation ``q``, then ``p``."""
    return (
        p[3] * q[0] + p[0] * q[3] + p[1] * q[2] - p[2] * q[1],
        p[3] * q[1] + p[1] * q[3] + p[2] * q[0] - p[0] * q[2],
        p[3] * q[2] + p[2] * q[3] + p[0] * q[1] - p[1] * q[0],
        p[3] * q[3] - p[0] * q[0] - p[1] * q[1] - p[2] * q[2],
    )


@kernel
def renormalise(q):
    """Return ``q`` scaled to unit length to first order in ``|q|^2 - 1``, without division or root.

    One Newton step for the inverse root: a deviation of d leaves one of d^2 (times 3/8), which removes the effect of
    rounding.
    """
    scale = 1.5 - 0.5 * ((q[0] * q[0] + q[1] * q[1]) + (q[2] * q[2] + q[3] * q[3]))
    return q[0] * scale, q[1] * scale, q[2] * scale, q[3] * scale


@kernel
def half_angle(square):
    """Return ``sin(x/2)/x`` and ``cos(x/2)`` of the angle x [rad] from its square, to machine precision for any x."""
    if square <= SERIES_LIMIT:
        return polynomial(HALF_SINE, square), polynomial(HALF_COSINE, square)
    angle = np.sqrt(square)
    return np.sin(0.5 * angle) / angle, np.cos(0.5 * angle)


@kernel
def sine_defect(square):
    """Return ``(x - sin x)/x^3`` of the angle x [rad] from its square, to machine precision for any x."""
    if square <= SERIES_LIMIT:
        return polynomial(SINE_DEFECT, square)
    angle = np.sqrt(square)
    return (angle - np.sin(angle)) / (square * angle)


@kernel
def quat_from_rotvec(rotvec):
    """Return the quaternion of a rotation vector [rad]."""
    sine, cosine = half_angle(dot(rotvec, rotvec))
    return rotvec[0] * sine, rotvec[1] * sine, rotvec[2] * sine, cosine


@kernel
def mean_over_turn(rotvec, vector):
    """Return the mean of ``vector`` while it turns at a constant rate from its given direction through ``rotvec``.

    It is ``v + (1 - cos x)/x^2 r x v + (x - sin x)/x^3 r x (r x v)`` with ``x = |r|``, the integral of Rodrigues'
    formula; ``(1 - cos x)/x^2`` is twice the square of ``sin(x/2)/x`` and needs no series of its own.
    """
    square = dot(rotvec, rotvec)
    sine, _ = half_angle(square)
    once = cross(rotvec, vector)
    mean = add_scaled(vector, 2 * sine * sine, once)
    return add_scaled(mean, sine_defect(square), cross(rotvec, once))


@kernel
def mat_from_quat(q):
    """Return the rotation matrix of a unit quaternion as 3 rows."""
    x, y, z = 2 * q[0], 2 * q[1], 2 * q[2]
    xx, yy, zz = q[0] * x, q[1] * y, q[2] * z
    xy, xz, yz = q[0] * y, q[0] * z, q[1] * z
    wx, wy, wz = q[3] * x, q[3] * y, q[3] * z
    return (
        (1 - (yy + zz), xy - wz, xz + wy),
        (xy + wz, 1 - (xx + zz), yz - wx),
        (xz - wy, yz + wx, 1 - (xx + yy)),
    )


@kernel
def rotate(quat, vector):
    """Return ``vector`` turned by the unit quaternion."""
    mat = mat_from_quat(quat)
    return dot(mat[0], vector), dot(mat[1], vector), dot(mat[2], vector)


@kernel
def wrap(angle):
    """Return an angle [rad] in (-pi, pi]; an angle in this range is returned unchanged to the bit."""
    return angle - 2 * np.pi * np.ceil((angle - np.pi) / (2 * np.pi))


@kernel
def euler_from_quat(quat_nb):
    """Return roll, pitch, heading [rad] of a unit quaternion; roll and heading in (-pi, pi], pitch in [-pi/2, pi/2].

    From the half sum and the half difference of roll and heading, which stay defined one at a time when the pitch
    reaches +-90 deg: the three angles always make the rotation again (Bernardes and Viollet, PLoS ONE 17 (2022)
    e0276302; for ZYX the pairs are (w - y, x + z) and (w + y, x - z)).
    """
    x, y, z, w = quat_nb[0], quat_nb[1], quat_nb[2], quat_nb[3]
    half_sum, half_difference = np.arctan2(x + z, w - y), np.arctan2(x - z, w + y)
    rising = np.sqrt((w + y) * (w + y) + (x - z) * (x - z))
    falling = np.sqrt((w - y) * (w - y) + (x + z) * (x + z))
    pitch = 2 * np.arctan2(rising, falling) - 0.5 * np.pi
    return wrap(half_sum + half_difference), pitch, wrap(half_sum - half_difference)


def from_euler(euler: np.ndarray) -> Rotation:
    """Return the rotations ``b`` to ``n`` of angles (roll, pitch, heading) [rad], shape (3,) or (n, 3)."""
    return Rotation.from_euler("ZYX", np.asarray(euler)[..., ::-1])


def to_euler(rotation_nb: Rotation) -> np.ndarray:
    """Return the angles (roll, pitch, heading) [rad], shape (3,) or (n, 3), of rotations ``b`` to ``n``."""
    return rotation_nb.as_euler("ZYX")[..., ::-1]


def rate_from_euler(euler: np.ndarray, derivative: np.ndarray) -> np.ndarray:
    """Return the rate of ``b`` relative to ``n`` in ``b`` [rad/s] (Groves 2013, eq. 2.58), shape (..., 3).

    ``euler`` are roll, pitch, heading [rad], ``derivative`` their derivatives [rad/s].
    """
    roll, pitch = euler[..., 0], euler[..., 1]
    droll, dpitch, dheading = np.moveaxis(derivative, -1, 0)
    level = dheading * np.cos(pitch)
    return np.stack(
        [
            droll - dheading * np.sin(pitch),
            dpitch * np.cos(roll) + level * np.sin(roll),
            -dpitch * np.sin(roll) + level * np.cos(roll),
        ],
        axis=-1,
    )

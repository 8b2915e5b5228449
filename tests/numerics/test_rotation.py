"""Rotation kernels: algebra for any rotation, and SciPy as an independent implementation."""

from fractions import Fraction
from math import factorial

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from imugap.numerics import rotation

EPS = np.finfo(float).eps
PI = 3.14159
compiling = settings(deadline=None)  # the first example compiles the kernel

coordinate = st.floats(-10, 10)
vectors = st.tuples(coordinate, coordinate, coordinate)
quats = (
    st.tuples(*[st.floats(-1, 1)] * 4)
    .filter(lambda q: np.linalg.norm(q) > 0.1)
    .map(lambda q: tuple(float(x) for x in np.array(q) / np.linalg.norm(q)))
)
angles = st.floats(1e-9, 6.0)


def angle_between(p, q) -> float:
    """Angle [rad] of the rotation from one quaternion to the other; both signs of a quaternion are the same."""
    return (Rotation.from_quat(p).inv() * Rotation.from_quat(q)).magnitude()


def quat_by_hand(euler) -> tuple[float, ...]:
    """Heading, then pitch, then roll, each a rotation vector along its axis."""
    roll, pitch, heading = euler
    turn = rotation.multiply(rotation.quat_from_rotvec((0, 0, heading)), rotation.quat_from_rotvec((0, pitch, 0)))
    return rotation.multiply(turn, rotation.quat_from_rotvec((roll, 0, 0)))


@compiling
@given(quats, quats)
def test_product_is_that_of_scipy(p, q):
    expected = (Rotation.from_quat(p) * Rotation.from_quat(q)).as_quat()
    assert angle_between(rotation.multiply(p, q), expected) < 1e-14
    assert np.linalg.norm(rotation.multiply(p, q)) == pytest.approx(1, rel=4 * EPS)


@compiling
@given(quats, vectors, vectors)
def test_turning_keeps_products(q, a, b):
    turned_a, turned_b = rotation.rotate(q, a), rotation.rotate(q, b)
    assert rotation.dot(turned_a, turned_b) == pytest.approx(rotation.dot(a, b), rel=0, abs=1e-12)
    turned_cross = rotation.rotate(q, rotation.cross(a, b))
    assert rotation.cross(turned_a, turned_b) == pytest.approx(turned_cross, rel=0, abs=1e-12)


@compiling
@given(quats, quats, vectors)
def test_turning_twice_is_turning_by_the_product(p, q, a):
    twice = rotation.rotate(p, rotation.rotate(q, a))
    assert rotation.rotate(rotation.multiply(p, q), a) == pytest.approx(twice, rel=0, abs=1e-13)


@compiling
@given(quats)
def test_matrix_is_that_of_scipy(q):
    mat = np.array(rotation.mat_from_quat(q))
    np.testing.assert_allclose(mat, Rotation.from_quat(q).as_matrix(), rtol=0, atol=8 * EPS)


@compiling
@given(quats)
def test_euler_angles_are_those_of_scipy(q):
    euler = rotation.euler_from_quat(q)
    assert abs(euler[1]) <= np.pi / 2
    assert -np.pi < euler[0] <= np.pi
    assert -np.pi < euler[2] <= np.pi
    assert angle_between(quat_by_hand(euler), q) < 1e-14


@compiling
@given(st.tuples(st.floats(-PI, PI), st.floats(-1.5, 1.5), st.floats(-PI, PI)))
def test_euler_angles_come_back(euler):
    there = rotation.from_euler(np.array(euler))
    assert rotation.to_euler(there) == pytest.approx(euler, rel=0, abs=1e-13)
    assert rotation.euler_from_quat(there.as_quat()) == pytest.approx(euler, rel=0, abs=1e-13)


def test_euler_angles_turn_as_named():
    """Heading from north to east, pitch nose up, roll right wing down; tables row by row."""
    forward, right = np.array([1.0, 0, 0]), np.array([0, 1.0, 0])
    table = rotation.from_euler(np.array([[0, 0, np.pi / 2], [0, np.pi / 2, 0], [np.pi / 2, 0, 0]]))
    np.testing.assert_allclose(table[0].apply(forward), [0, 1, 0], atol=EPS)
    np.testing.assert_allclose(table[1].apply(forward), [0, 0, -1], atol=EPS)
    np.testing.assert_allclose(table[2].apply(right), [0, 0, 1], atol=EPS)


@pytest.mark.parametrize("below", [0.0, 1e-12, 1e-9, 1e-6])
@pytest.mark.parametrize("sign", [-1, 1])
def test_angles_near_the_vertical_make_the_rotation_again(sign, below):
    pitch = sign * (np.pi / 2 - below)
    there = rotation.from_euler(np.array([0.3, pitch, 1.0])).as_quat()
    euler = rotation.euler_from_quat(there)
    assert euler[1] == pytest.approx(pitch, rel=0, abs=4 * EPS)
    assert angle_between(quat_by_hand(euler), there) < 1e-14


@compiling
@given(vectors)
def test_rotation_vector_is_that_of_scipy(rotvec):
    expected = Rotation.from_rotvec(rotvec).as_quat()
    assert angle_between(rotation.quat_from_rotvec(rotvec), expected) < 1e-14


@compiling
@given(angles)
def test_sine_and_cosine_of_the_half_angle_make_a_unit(angle):
    sine, cosine = rotation.half_angle(angle * angle)
    assert (angle * sine) ** 2 + cosine**2 == pytest.approx(1, rel=0, abs=4 * EPS)


def exact(angle: float) -> tuple[Fraction, Fraction, Fraction]:
    """sin(x/2)/x, cos(x/2), (x - sin x)/x^3 in rational arithmetic; 40 terms leave less than 1e-40 below 8 rad."""
    square = Fraction(angle) ** 2
    sine = sum(Fraction(-1) ** k * square**k / (2 * 4**k * factorial(2 * k + 1)) for k in range(40))
    cosine = sum(Fraction(-1) ** k * square**k / (4**k * factorial(2 * k)) for k in range(40))
    defect = sum(Fraction(-1) ** k * square**k / factorial(2 * k + 3) for k in range(40))
    return sine, cosine, defect


@pytest.mark.parametrize("angle", [1e-200, 1e-9, 1e-3, 0.3, 0.8, 1 - 1e-12, 1.0, 1 + 1e-12, 1.3, 2.0, 3.1])
def test_series_and_closed_forms_are_exact_to_rounding(angle):
    """Two roundings below the switch; above it cancellation may cost (x - sin x)/x^3 up to 3 bits."""
    sine, cosine, defect = exact(angle)
    found = *rotation.half_angle(angle * angle), rotation.sine_defect(angle * angle)
    for value, true, roundings in zip(found, (sine, cosine, defect), (2, 2, 2 if angle < 1 else 8), strict=True):
        assert abs(Fraction(value) - true) <= roundings * Fraction(EPS) * max(abs(true), Fraction(1, 4))


@compiling
@given(vectors, vectors)
def test_mean_over_a_turn_is_the_quadrature_of_the_turn(direction, vector):
    rotvec = 0.3 * np.array(direction)
    nodes, weights = np.polynomial.legendre.leggauss(20)
    turned = Rotation.from_rotvec(np.outer((nodes + 1) / 2, rotvec)).apply(vector)
    expected = 0.5 * weights @ turned
    assert rotation.mean_over_turn(tuple(rotvec), vector) == pytest.approx(expected, rel=0, abs=1e-12)


@compiling
@given(quats, st.floats(-1e-4, 1e-4))
def test_renormalising_squares_the_deviation(q, deviation):
    length = np.linalg.norm(rotation.renormalise(tuple((1 + deviation) * x for x in q)))
    assert length - 1 == pytest.approx(-1.5 * deviation**2, rel=1e-3, abs=4 * EPS)


def test_not_a_number_stays_one():
    assert np.isnan(rotation.quat_from_rotvec((np.nan, 0.0, 0.0))).all()
    assert np.isnan(rotation.mean_over_turn((0.0, 0.1, 0.0), (0.0, np.nan, 0.0))).any()

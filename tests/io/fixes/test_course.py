import numpy as np
import pytest

from imugap.io.fixes.course import fast_course_rate
from imugap.io.gnss import from_local
from imugap.kinematics.strapdown import Ellipsoid


def circle(speed, rate, count=60, velocities=True):
    """Fixes on a circle of the given speed [m/s] and course rate [rad/s], once per second."""
    time = np.arange(float(count))
    course = rate * time
    place = speed / rate * np.column_stack([np.sin(course), -np.cos(course), 0 * time])
    velocity = speed * np.column_stack([np.cos(course), np.sin(course), 0 * time])
    measured = np.hstack([place, velocity if velocities else np.full_like(velocity, np.nan)])
    return from_local(time, measured, np.ones((count, 6)), Ellipsoid(0.8, 0.2, 500.0))


@pytest.mark.parametrize("velocities", [True, False])
@pytest.mark.parametrize("rate", [0.2, -0.4])
def test_the_course_of_a_circle_turns_at_its_rate(rate, velocities):
    assert fast_course_rate(circle(10.0, rate, velocities=velocities)) == pytest.approx(abs(rate), rel=0.05)


def test_a_vehicle_that_hardly_moves_has_no_course():
    assert fast_course_rate(circle(1.0, 0.2)) is None

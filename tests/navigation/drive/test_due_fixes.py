"""Positions at the time of late velocities: exact on smooth motion, no change of the noise of the velocities."""

import numpy as np
import pytest

from imugap.navigation.drive.due_fixes import DueFixes

TIME = np.arange(0, 60, 0.2)


def circle(time):
    """Position and velocity of a circle of 30 m in 20 s, shape (n, 6)."""
    phase = 2 * np.pi * time / 20
    place = 30 * np.column_stack([np.cos(phase), np.sin(phase), 0.1 * phase])
    return np.hstack(
        [place, np.pi / 10 * 30 * np.column_stack([-np.sin(phase), np.cos(phase), np.full(len(time), 0.1)])]
    )


@pytest.mark.parametrize("delay", [0.13, -0.3])
def test_positions_are_those_at_the_time_of_the_velocities(delay):
    late = np.hstack([circle(TIME)[:, :3], circle(TIME - delay)[:, 3:]])
    found = DueFixes(TIME, late, np.full((len(TIME), 6), 0.1)).with_timely_positions(delay)
    inside = slice(2, -2)
    np.testing.assert_allclose(found.due, TIME - delay)
    np.testing.assert_allclose(found.seen[inside], circle(found.due)[inside], atol=5e-3)
    np.testing.assert_array_equal(found.seen[:, 3:], late[:, 3:])
    np.testing.assert_allclose(found.std[:, :3], np.hypot(0.1, delay * 0.1))
    np.testing.assert_array_equal(found.std[:, 3:], 0.1)


def test_without_a_delay_or_velocities_nothing_changes():
    plain = DueFixes(TIME, circle(TIME), np.ones((len(TIME), 6)))
    assert plain.with_timely_positions(0.0) is plain
    places = plain._replace(seen=np.hstack([plain.seen[:, :3], np.full((len(TIME), 3), np.nan)]))
    assert places.with_timely_positions(0.2) is places

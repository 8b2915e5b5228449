import numpy as np
import pytest

from imugap.numerics.fitting.damped_steps import Damping, optimise

DAMPING = Damping(first=1e-3, floor=1e-2, least=1e-6, most=1e6)


def rosenbrock(x):
    return np.array([10 * (x[1] - x[0] ** 2), 1 - x[0]])


def propose(path, damping):
    x = path[-1]
    jacobian = np.array([[-20 * x[0], 10.0], [-1.0, 0.0]])
    curvature = jacobian.T @ jacobian
    step = np.linalg.solve(curvature + damping * np.diag(np.diag(curvature)), -jacobian.T @ rosenbrock(x))
    return None if np.abs(step).max() < 1e-10 else x + step


def better(one, other):
    return np.sum(rosenbrock(one) ** 2) < np.sum(rosenbrock(other) ** 2)


def test_steps_lead_down_a_curved_valley_to_its_end():
    path, converged = optimise(np.array([-1.2, 1.0]), propose, better, DAMPING, 100)
    assert converged
    np.testing.assert_allclose(path[-1], 1.0, atol=1e-9)
    distances = [np.sum(rosenbrock(x) ** 2) for x in path]
    assert np.all(np.diff(distances) < 0)


def test_steps_end_where_there_are_too_many():
    path, converged = optimise(np.array([-1.2, 1.0]), propose, better, DAMPING, 3)
    assert not converged
    assert 1 < len(path) <= 4


@pytest.mark.parametrize(
    ("value", "improved", "after"),
    [(1e-3, True, 1e-4), (1e-6, True, 1e-6), (1e-4, False, 1e-2), (1.0, False, 10.0), (1e6, False, 1e6)],
)
def test_damping_keeps_its_limits(value, improved, after):
    assert DAMPING.after(value, improved) == pytest.approx(after)

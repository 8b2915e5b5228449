import numpy as np
import pytest
from tests.chance import as_often_as
from tests.effects.simulated import draws

from imugap.effects import Conditions, RandomTelegraph
from imugap.stream import stream


def test_telegraph_has_two_values_and_starts_at_either():
    sequences = draws(RandomTelegraph(1.4, 2.5), 4000, 3, "values")
    assert set(np.unique(sequences)) == {-0.7, 0.7}
    assert as_often_as(sequences[:, 0] > 0, 0.5)


def test_telegraph_switches_between_uneven_stamps_as_a_poisson_process_does():
    time = np.array([0.0, 0.01, 0.3, 0.5, 4.0])
    at = Conditions(time, 0.01)
    process = RandomTelegraph(2.0, 2.5)
    signs = np.array([process.sample(at, stream(11, "uneven", run)) for run in range(8000)])
    for k, gap in enumerate(np.diff(time)):
        assert as_often_as(signs[:, k] != signs[:, k + 1], (1 - np.exp(-2 * 2.5 * gap)) / 2), gap


def test_telegraph_of_any_rate_has_either_value_between_samples():
    signs = draws(RandomTelegraph(2.0, 1e30), 4000, 2, "fast")
    assert as_often_as(signs[:, 0] != signs[:, 1], 0.5)


def test_telegraph_is_no_gaussian_process_and_has_no_state_space():
    with pytest.raises(ValueError, match="random_telegraph: expected a process with a state space"):
        RandomTelegraph(1.0, 1.0).state_space()

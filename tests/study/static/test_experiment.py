import numpy as np
import pytest

from imugap.effects import GaussMarkov, RandomWalk, WhiteNoise
from imugap.study.static.experiment import Experiment


@pytest.fixture
def experiment():
    return Experiment.read("data/indirect.yaml")


def test_recipe_of_the_source(experiment):
    assert experiment.count == 108_000
    assert experiment.count * experiment.interval == 3 * 3600
    assert experiment.kinds == (WhiteNoise, GaussMarkov, RandomWalk)


def test_another_correlation_time_leaves_the_rest(experiment):
    other, truth = experiment.at(200).truth(), experiment.truth()
    changed = other.index[other != truth].get_level_values("parameter")
    assert set(changed) == {"correlation_time", "driving_psd"}
    assert other["gauss_markov", 1, "correlation_time"] == 200
    assert other["gauss_markov", 1, "driving_psd"] == pytest.approx(2 * truth["gauss_markov", 1, "std"] ** 2 / 200)


def test_a_run_has_its_own_stream(experiment):
    one, again, other = (experiment.simulate(1, "run", run) for run in (0, 0, 1))
    np.testing.assert_array_equal(one, again)
    assert abs(np.corrcoef(np.diff(one), np.diff(other))[0, 1]) < 5 / np.sqrt(len(one))

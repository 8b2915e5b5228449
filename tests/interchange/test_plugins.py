"""Effects of one's own: the example of the notebook joins the catalogue and is what it says."""

from pathlib import Path

import numpy as np
import pytest

from imugap.effects import CATALOGUE, Conditions
from imugap.interchange.plugins import catalogue
from imugap.model import ErrorModel

ROOT = Path(__file__).parents[2]


@pytest.fixture
def kinds(monkeypatch):
    """The catalogue with the example of the notebook, which is named from the top of the project."""
    monkeypatch.chdir(ROOT)
    return catalogue("notebooks.heater")


def test_the_example_joins_the_catalogue_which_stays_as_it_is(kinds):
    assert set(kinds) - set(CATALOGUE) == {"heater"}
    assert "heater" not in catalogue(None)


def test_the_model_of_the_example_is_read_with_it_and_not_without(kinds):
    model = ErrorModel.read("notebooks/heater.yaml", kinds)
    assert [effect.name for effect in model.axes["gyro_y"]] == ["white_noise", "bias", "heater"]
    with pytest.raises(ValueError, match="heater"):
        ErrorModel.read("notebooks/heater.yaml", catalogue(None))


def test_the_example_is_on_for_half_of_each_period_and_linear_in_its_amplitude(kinds):
    at = Conditions(np.arange(4000) * 0.1, 0.1)
    heater = kinds["heater"](2e-4, 40.0)
    shift = heater.sample(at, np.random.default_rng(0))
    assert set(shift) == {0.0, 2e-4}
    assert shift.mean() == pytest.approx(1e-4)
    assert shift == pytest.approx(2e-4 * heater.slopes(at)["amplitude"])

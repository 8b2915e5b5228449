"""A recipe without a part, or with a misspelt one, is named with its file."""

from pathlib import Path

import pytest

from imugap.simulation.drive import Drive
from imugap.simulation.flight import Flight
from imugap.simulation.gnss_faults import Faults
from imugap.simulation.walk import Walk

FLIGHT = (Path(__file__).parents[2] / "data" / "flight.yaml").read_text()


@pytest.mark.parametrize(
    ("kind", "text", "message"),
    [
        (Drive, "course: {}", "expected a recipe with course, axle, model, receiver, site"),
        (Faults, "course: {}", "expected a recipe with faults"),
        (Walk, "gait: {stride_s: 1}\n", "expected a recipe with gait, course, model, site; found 'course'"),
        (Flight, FLIGHT.replace("launch_s", "lunch_s"), "expected a recipe with course.*lunch_s"),
    ],
)
def test_a_recipe_that_is_none_is_named(tmp_path, kind, text, message):
    path = tmp_path / "recipe.yaml"
    path.write_text(text)
    with pytest.raises(ValueError, match=rf"recipe\.yaml: {message}"):
        kind.read(path)

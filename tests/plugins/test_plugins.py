"""Effects in a file outside of the library: simulated, found, placed and named by the same search as its own."""

from pathlib import Path

import numpy as np
import pytest

from imugap.discovery.device import Settings, discover
from imugap.effects import Bias, WhiteNoise
from imugap.effects.effect import AxisModel
from imugap.interchange.plugins import catalogue
from imugap.log import from_samples
from imugap.model import ErrorModel

INTERVAL, COUNT = 0.02, 20_000
KNOWN = 1e-4 / np.sqrt(INTERVAL) * np.sqrt(2 / COUNT)
"""Standard deviation with which the amplitude of a line can be known."""


@pytest.fixture(scope="module")
def kinds():
    """The catalogue with the effects of the file in place of those that they rename."""
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(Path(__file__).parents[2])
        found = catalogue("tests.plugins.renamed")
    return {name: kind for name, kind in found.items() if name not in ("chirp", "dead_zone")}


def test_effects_of_a_file_are_found_placed_and_named(kinds):
    hidden = {
        "gyro_y": kinds["sweep"](1.0, 3.0 / (INTERVAL * COUNT), 60 * KNOWN, 1.0),
        "gyro_z": kinds["dead_band"](1e-3),
    }
    model = ErrorModel({axis: AxisModel((WhiteNoise(1e-4), Bias(2e-4), effect)) for axis, effect in hidden.items()})
    still = from_samples({axis: np.zeros(COUNT) for axis in model.axes}, INTERVAL)
    settings = Settings(catalogue=tuple(kinds.values()), replicates=20, simulations=10)
    discovery = discover([model.simulate(still, 1, "plug-in")], settings)
    assert {(one.name, one.axes) for one in discovery.findings} == {("sweep", ("gyro_y",)), ("dead_band", ("gyro_z",))}
    assert {place.axis for place in discovery.discrepancies} == set(hidden)
    assert discovery.unexplained == ()
    for axis, effect in hidden.items():
        assert any(isinstance(one, type(effect)) for one in discovery.final[axis])

"""The plug-in of Gazebo, compiled against a stand-in for its headers (gazebo.hpp), and run."""

import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from tests.interchange.code.running import FLAGS, run

from imugap import log
from imugap.effects import Bias, GaussMarkov, SampleLoss, WhiteNoise
from imugap.effects.effect import AxisModel
from imugap.interchange.code.program import Language, program
from imugap.model import ErrorModel

RATE, PHYSICS = 100.0, 1000
MAIN = """
int main() {
  gz::sim::EntityComponentManager world;
  gz::sim::EventManager events;
  g_plugin.Configure(1, std::make_shared<const sdf::Element>(), world, events);
  gz::sim::UpdateInfo info;
  info.paused = false;
  info.dt = std::chrono::milliseconds(1);
  for (int k = 0; k < 1000; ++k) {
    info.simTime = std::chrono::milliseconds(k);
    g_plugin.PostUpdate(info, world);
  }
}
"""


def test_the_plugin_publishes_the_stream_of_the_model(tmp_path):
    compiler = shutil.which("g++")
    if compiler is None:
        pytest.skip("no g++ on this machine")
    noise = AxisModel((WhiteNoise(1e-3), GaussMarkov(1e-3, 1.0), Bias(0.1)))
    model = ErrorModel({"gyro_x": noise, "accel_z": noise, log.TIME: AxisModel((SampleLoss(0.1, 2.0),))})
    text = program(model, Language.GAZEBO_PLUGIN, RATE)
    stand_in = Path(__file__).with_name("gazebo.hpp")
    for name in re.findall(r"#include <((?:gz|sdf)/[^>]*)>", text):
        header = tmp_path / name
        header.parent.mkdir(parents=True, exist_ok=True)
        header.write_text(f'#include "{stand_in}"\n')
    (tmp_path / "plugin.cc").write_text(text + MAIN)
    command = [compiler, *FLAGS, "-I", tmp_path, tmp_path / "plugin.cc", "-o", tmp_path / "plugin"]
    subprocess.run(command, check=True)
    lines = subprocess.run([tmp_path / "plugin"], capture_output=True, text=True, check=True).stdout.splitlines()
    published = np.array([list(map(float, line.split())) for line in lines])
    still = {name: np.full(100, 9.8 if name == "accel_z" else 0.0) for name in log.AXES}
    expected = run(model, RATE, log.from_samples(still, 1 / RATE), 0)
    expected = expected[~expected["lost"].to_numpy(bool)]
    assert 50 < len(expected) < 100
    np.testing.assert_array_equal(published[:, 1:], expected[["gyro_x", "accel_z"]])
    np.testing.assert_allclose(published[:, 0], expected[log.TIME], atol=1e-9)

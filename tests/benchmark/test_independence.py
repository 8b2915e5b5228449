"""The benchmark and the library stand without each other."""

import ast
import subprocess
import sys
from pathlib import Path

import yaml

from imu_benchmark import start_model
from imu_benchmark.stream import stream as stream_of_benchmark
from imugap.stream import stream

BENCHMARK = Path(__file__).parents[2] / "benchmark/src/imu_benchmark"
COMMANDS_WITHOUT_BENCHMARK = """
import sys
sys.modules["imu_benchmark"] = None
import pkgutil, importlib, imugap.cli, imugap.commands
for one in pkgutil.walk_packages(imugap.commands.__path__, "imugap.commands."):
    importlib.import_module(one.name)
"""


def test_the_benchmark_imports_nothing_of_the_library():
    nodes = [node for path in BENCHMARK.rglob("*.py") for node in ast.walk(ast.parse(path.read_text()))]
    names = {alias.name for node in nodes if isinstance(node, ast.Import) for alias in node.names}
    names |= {node.module for node in nodes if isinstance(node, ast.ImportFrom)}
    assert "numpy" in names
    assert not [name for name in names if name.split(".")[0] == "imugap"]


def test_the_commands_do_not_need_the_benchmark():
    found = subprocess.run([sys.executable, "-c", COMMANDS_WITHOUT_BENCHMARK], capture_output=True, text=True)
    assert found.returncode == 0, found.stderr


def test_both_have_the_same_random_streams():
    for labels in ((), ("a",), ("seal", "c0001", 2), ("é", "")):
        assert stream(7, *labels).random(3).tolist() == stream_of_benchmark(7, *labels).random(3).tolist()


def test_a_start_model_is_written_as_yaml_that_has_the_same_numbers(tmp_path):
    model = {
        "gyro_x": [{"bias": {"value": -1e-05}}, {"sinusoid": {"amplitude": 1.5e-7, "frequency": 12.0}}],
        "accel_z": [{"white_noise": {"density": 1e22}}],
    }
    text = start_model.text(model)
    (tmp_path / "model.yaml").write_text(text)
    assert start_model.read(tmp_path / "model.yaml") == model
    assert yaml.safe_load(text) == model
    assert text == yaml.safe_dump(model, sort_keys=False)

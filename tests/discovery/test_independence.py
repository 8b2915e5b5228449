"""Discovery knows effects by what they say of themselves, and names none but those that others are weighed against."""

import ast
from pathlib import Path

import pytest

import imugap.discovery
from imugap.effects import CATALOGUE

ROOT = Path(imugap.discovery.__file__).parent
CLASSES = {kind.__name__ for kind in CATALOGUE.values()}
MODULES = {f"imugap.effects.{name}" for name in CATALOGUE}
NAMED = {
    "fit/telegraph_likelihood.py": {"GaussMarkov", "RandomTelegraph"},
    "search/telegraph.py": {"RandomTelegraph"},
    "search/telegraph_in_noise.py": {"RandomTelegraph"},
    "noise/common_noise.py": {"CommonMode", "WhiteNoise"},
    "checks/spectrum.py": {"PowerLaw"},
    "noise/nameless_noise.py": {"BandNoise", "NoiseDistribution"},
}
"""Modules that have the likelihood of one effect as their subject, and the noise without a name."""


def effects_named(path):
    """Return the classes of effects that a module imports."""
    imports = [node for node in ast.walk(ast.parse(path.read_text())) if isinstance(node, ast.ImportFrom)]
    concrete = [node for node in imports if node.module == "imugap.effects" or node.module in MODULES]
    return {alias.name for node in concrete for alias in node.names} & CLASSES


@pytest.mark.parametrize("path", sorted(ROOT.rglob("*.py")), ids=lambda path: str(path.relative_to(ROOT)))
def test_a_module_of_discovery_names_no_effect_that_is_not_its_subject(path):
    assert effects_named(path) == NAMED.get(str(path.relative_to(ROOT)), set())

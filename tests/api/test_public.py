"""The public names: light to import, documented by an example that runs, typed as they are."""

import ast
import doctest
import subprocess
import sys
from pathlib import Path

import pytest

import imugap

STUB = Path(imugap.__file__).with_name("__init__.pyi")


def test_the_example_of_the_package_runs():
    failed, tried = doctest.testmod(imugap)
    assert tried >= 5
    assert failed == 0


def test_the_import_loads_no_numerical_library():
    code = "import sys, imugap; print(sorted({'numpy', 'scipy', 'pandas', 'matplotlib'} & set(sys.modules)))"
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert found.stdout.strip() == "[]"


def test_every_public_name_is_there_and_in_the_stub():
    typed = {
        alias.asname
        for node in ast.parse(STUB.read_text()).body if isinstance(node, ast.ImportFrom) for alias in node.names
    }  # fmt: skip
    assert typed | {"__version__"} == set(imugap.__all__) == set(dir(imugap))
    for name in typed:
        found = getattr(imugap, name)
        assert found.__name__ == name
        assert found.__doc__


def test_an_unknown_name_is_no_attribute():
    with pytest.raises(AttributeError, match="has no attribute 'diskover'"):
        _ = imugap.diskover

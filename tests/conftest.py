"""Keep compiled kernels of different versions of the library apart (see :func:`imugap.workflow.dependencies.digest`).

Property tests draw the same examples every time, and take the time that they take: the first call of a kernel compiles.
"""

import json
import os
from pathlib import Path
from types import SimpleNamespace

import pytest
import yaml
from hypothesis import settings
from jsonschema import Draft202012Validator

from imugap.estimation import goodness_of_fit
from imugap.workflow.dependencies import digest

ROOT = Path(__file__).parents[1]
os.environ.setdefault("NUMBA_CACHE_DIR", str(ROOT / ".pytest_cache" / "numba" / digest()))
settings.register_profile("derandomised", derandomize=True, deadline=None)
settings.load_profile("derandomised")


@pytest.fixture
def judge(monkeypatch):
    """A goodness of fit that finds every model good; gives the sentence that it says."""
    sentence = "Nothing speaks against the model"
    monkeypatch.setattr(goodness_of_fit, "of", lambda *_: SimpleNamespace(verdict=f"{sentence}."))
    return sentence


@pytest.fixture
def validated():
    """Read what ``imugap estimate`` writes: JSON that has neither NaN nor Infinity and keeps its schema."""
    schema = yaml.safe_load((ROOT / "workflow/schemas/estimates.schema.yaml").read_text())

    def refuse(constant):
        raise AssertionError(f"{constant} is no JSON")

    def read(text):
        records = json.loads(text, parse_constant=refuse)
        Draft202012Validator(schema).validate(records)
        return records

    return read

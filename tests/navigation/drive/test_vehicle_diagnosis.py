"""Names of what a filter is not told: the right one where something is hidden, none where nothing is."""

from pathlib import Path

import numpy as np
import pytest
from scipy.stats import binom

from imugap.filters.innovation_gate import InnovationRecord
from imugap.navigation.drive.vehicle_diagnosis import CANDIDATES, diagnose, whiteness
from imugap.stream import stream
from imugap.study.drive.fault_ablation import Ablation, hide_effect

ROOT = Path(__file__).parents[3]
RECIPE = ROOT / "data" / "drive.yaml"
SEED = 81


@pytest.fixture(scope="module")
def study():
    return Ablation.read(RECIPE)


def recorded(white):
    """Return a record that has these whitened innovations."""
    record = InnovationRecord.empty(*white.shape)
    record.whitened[:], record.statistic[:], record.freedom[:] = white, np.sum(white**2, axis=1), white.shape[1]
    return record


@pytest.mark.parametrize("test", ["mean", "white", "size"])
def test_innovations_that_are_right_fail_as_often_as_they_should(test):
    found = [whiteness(recorded(stream(SEED, "white", run).standard_normal((300, 6))))[test] for run in range(400)]
    for alpha in (0.05, 0.5):
        share = np.mean(np.array(found) < alpha)
        assert abs(share - alpha) < 4.5 * np.sqrt(alpha * (1 - alpha) / len(found))


@pytest.mark.parametrize(("test", "spoil"), [
    ("mean", lambda white: white + 0.3), ("size", lambda white: 1.2 * white), ("size", lambda white: 0.8 * white),
    ("white", lambda white: (white + 0.5 * np.roll(white, 1, axis=0)) / np.sqrt(1.25)),
])  # fmt: skip
def test_innovations_that_are_wrong_fail(test, spoil):
    white = stream(SEED, "spoilt").standard_normal((300, 6))
    assert whiteness(recorded(spoil(white)))[test] < 1e-4


@pytest.mark.slow
@pytest.mark.parametrize("what", CANDIDATES)
def test_what_is_hidden_is_named_and_estimated(study, what):
    for run in range(3):
        names, told = diagnose(hide_effect(study, RECIPE, what, run, SEED), 0.01)
        assert names == [what]
        first = told[told["round"] == 1].set_index("candidate")
        assert first.loc[what, "gain"] == first["gain"].max() > 0
    if what == "time offset":
        assert float(first.loc[what, "estimates"].removeprefix("offset ")) == pytest.approx(0.1, abs=0.02)


@pytest.mark.slow
def test_nothing_is_named_where_nothing_is_hidden(study):
    runs, alpha = 25, 0.05
    named = sum(bool(diagnose(hide_effect(study, RECIPE, None, run, SEED), alpha)[0]) for run in range(runs))
    assert binom.sf(named - 1, runs, alpha) > 0.001

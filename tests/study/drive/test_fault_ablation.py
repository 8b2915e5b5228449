"""The study of the quality control: what is scored is what happened, and each scheme does what it is for."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from imugap.filters.consistency import nees_band
from imugap.filters.innovation_gate import SCHEMES
from imugap.kinematics.strapdown import POSITION
from imugap.simulation.gnss_faults import OUTAGE, OUTLIER, RAMP, STRETCH, FaultEvent
from imugap.study.drive.fault_ablation import (
    ALONE,
    CLEAN,
    CONTAMINATED,
    ERRORS,
    LOST,
    ORACLE,
    PARTS,
    PLAIN,
    SMOOTHED,
    WHEELS,
    WHOLE,
    Ablation,
    in_lasting_fault,
    recovery,
    scores,
)  # fmt: skip

ROOT = Path(__file__).parents[3]
SEED, RUNS = 71, 8


@pytest.fixture(scope="module")
def study():
    """Two laps, and of each kind one."""
    whole = Ablation.read(ROOT / "data" / "drive.yaml")
    faults = replace(whole.faults, outliers=replace(whole.faults.outliers, number=6, size=(30.0, 100.0)))
    return Ablation(replace(whole.drive, laps=2), replace(faults, stretches=replace(faults.stretches, number=1)))


@pytest.fixture(scope="module")
def found(study):
    rows = []
    for run in range(RUNS):
        for case, scheme, one in study.runs(run, SEED):
            errors = study.errors(one)
            rows.append({"run": run, "case": case, "scheme": scheme} | scores(errors).to_dict()
                        | study.verdicts(one))  # fmt: skip
    return pd.DataFrame(rows)


def middle(found, case, scheme, score):
    return found[(found["case"] == case) & (found["scheme"] == scheme)][score].mean()


@pytest.mark.long
@pytest.mark.slow
def test_every_case_has_every_scheme(found):
    counts = found.groupby(["case", "scheme"]).size()
    every = {(case, name) for case in (CLEAN, CONTAMINATED) for name in (*SCHEMES, SMOOTHED)}
    some = {(case, name) for case, names in PARTS.items() for name in names}
    rolling = {(case, WHEELS[name]) for case in (CLEAN, CONTAMINATED) for name in (WHOLE, SMOOTHED)}
    rolling |= {(case, WHEELS[WHOLE]) for case in PARTS} | {(CLEAN, WHEELS[PLAIN]), (CONTAMINATED, WHEELS[ORACLE])}
    assert set(counts.index) == every | some | rolling | {(CONTAMINATED, ORACLE)}
    assert (counts == RUNS).all()


@pytest.mark.long
@pytest.mark.slow
def test_without_gross_errors_the_plain_filter_is_consistent_and_control_costs_little(found):
    low, high = nees_band(9, RUNS * 10, 0.9999)  # a drive has some ten independent pieces
    assert low / 9 < middle(found, CLEAN, "none", "nees") < high / 9
    assert 0.97 < middle(found, CLEAN, "none", "nis") < 1.03
    for name in SCHEMES:
        assert middle(found, CLEAN, name, "horizontal_95") < 1.1 * middle(found, CLEAN, "none", "horizontal_95")
        assert middle(found, CLEAN, name, "false") < 0.006
    assert 0.001 < middle(found, CLEAN, "robust", "false") < 0.006
    both = [middle(found, CLEAN, name, "horizontal_95") for name in (SMOOTHED, "none")]
    assert 0.4 < both[0] / both[1] < 0.8


@pytest.mark.long
@pytest.mark.slow
def test_control_helps_and_an_oracle_helps_most(found):
    plain = middle(found, CONTAMINATED, "none", "horizontal_95")
    for name in ("remove", "robust", "gated", "reset"):
        assert middle(found, CONTAMINATED, name, "horizontal_95") < 0.7 * plain
    assert middle(found, CONTAMINATED, ORACLE, "horizontal_95") < middle(found, CONTAMINATED, "robust", "horizontal_95")
    assert 0.8 < middle(found, CONTAMINATED, ORACLE, "nis") < 1.2


@pytest.mark.long
@pytest.mark.slow
def test_separation_is_for_errors_that_stay_and_comes_near_the_oracle(found):
    """It leaves outliers and outages as they are, and the covariance goes on telling how far the filter is off."""
    worse, oracle = (middle(found, CONTAMINATED, name, "horizontal_95") for name in ("reset", ORACLE))
    near = middle(found, CONTAMINATED, "separation", "horizontal_95")
    assert 0.6 * oracle < near < 1.3 * oracle
    assert near < 0.6 * worse
    for kind, low, high in ((OUTLIER, 0.95, 1.05), (OUTAGE, 0.9, 1.1), (STRETCH, 0.0, 0.7), (RAMP, 0.0, 0.9)):
        both = [middle(found, ALONE[kind], name, "horizontal_95") for name in ("separation", "reset")]
        assert low < both[0] / both[1] < high
    assert middle(found, CONTAMINATED, "separation", "nees") < 0.5 * middle(found, CONTAMINATED, "reset", "nees")
    low, high = nees_band(9, RUNS * 10, 0.9999)
    assert low / 9 < middle(found, CONTAMINATED, "separation", "nees") < 1.5 * high / 9
    assert middle(found, CLEAN, "separation", "doubts") < 0.5 < middle(found, CONTAMINATED, "separation", "doubts")


@pytest.mark.long
@pytest.mark.slow
def test_wheels_hold_the_filter_where_fixes_do_not(found):
    """Most in outages, little with good fixes; the filter that is told of them knows itself."""
    for case, low, high in ((CLEAN, 0.8, 1.0), (CONTAMINATED, 0.5, 0.95), (ALONE[OUTAGE], 0.3, 0.95)):
        both = [middle(found, case, name, "horizontal_95") for name in (WHEELS[WHOLE], WHOLE)]
        assert low < both[0] / both[1] < high
    assert 0.4 < middle(found, CONTAMINATED, WHEELS[ORACLE], "horizontal_95") / middle(
        found, CONTAMINATED, ORACLE, "horizontal_95"
    ) < 0.95  # fmt: skip
    low, high = nees_band(9, RUNS * 10, 0.9999)
    assert 0.9 * low / 9 < middle(found, CLEAN, WHEELS[PLAIN], "nees") < high / 9
    assert 0.97 < middle(found, CLEAN, WHEELS[PLAIN], "nis") < 1.03


@pytest.mark.long
@pytest.mark.slow
def test_a_drive_that_begins_in_a_stretch_needs_a_soft_reset(found):
    assert middle(found, LOST, "gated", "resets") == 0
    assert 0.5 < middle(found, LOST, "separation", "resets") < 2
    assert middle(found, CLEAN, "separation", "resets") == 0


@pytest.mark.long
@pytest.mark.slow
def test_what_is_missed_is_less_with_a_test_and_all_without(found):
    assert middle(found, CONTAMINATED, "none", "missed") == 1
    assert middle(found, CONTAMINATED, "gate", "missed") == 1
    assert middle(found, CONTAMINATED, "remove", "missed") < 0.5
    assert middle(found, CONTAMINATED, "gated", "closed") > middle(found, CLEAN, "gated", "closed")


def test_errors_are_lengths_of_what_solution_and_truth_differ_by(study):
    case, scheme, one = next(study.runs(3, SEED))
    assert (case, scheme) == (CLEAN, "none")
    table = study.errors(one)
    assert list(table.columns) == ["time", *ERRORS, "event"]
    assert np.diff(table["time"]) == pytest.approx(1)
    at = table.iloc[200]
    truth = study.drive.path[0].loc[at["time"]]
    row = np.flatnonzero(np.abs(one.solution.time - at["time"]) < 1e-6)[0]
    off = one.solution.history.navigation[row, :3] - truth[list(POSITION)].to_numpy(float)
    assert at["horizontal"] == pytest.approx(np.hypot(*off[:2]))
    assert at["vertical"] == pytest.approx(abs(off[2]))
    assert (table["event"] == "").all()


def test_scores_are_over_what_they_say():
    errors = pd.DataFrame({name: [1.0, 2.0, 3.0, 100.0] for name in ERRORS})
    found = scores(errors.assign(event=["", STRETCH, RAMP, OUTAGE]))
    assert found["gyro_bad"] == pytest.approx(np.sqrt(6.5))
    assert found["aided_95"] == pytest.approx(2.9)
    assert found["horizontal_95"] > 80
    assert scores(errors.assign(event=""))[["gyro_bad", "accel_bad"]].isna().all()


def test_lasting_errors_are_stretches_and_ramps():
    assert in_lasting_fault(np.array(["", OUTLIER, STRETCH, RAMP, OUTAGE], dtype=object)).tolist() == [False] * 2 + [
        True
    ] * 2 + [False]


def test_recovery_is_the_time_until_the_error_stays_small():
    horizontal = [0, 9, 9, 9, 5, 0, 5, 0, 0, 0, 0, 9]
    errors = pd.DataFrame({"time": np.arange(12.0), "horizontal": horizontal})
    events = (
        FaultEvent(STRETCH, 1.0, 3.0, (9, 0, 0)),
        FaultEvent(OUTLIER, 2.0, 2.0, (9, 0, 0)),
        FaultEvent(RAMP, 10.5, 11.0, (1, 0, 0)),
    )
    found = recovery(errors, events, 1.0)
    assert found["kind"].tolist() == [STRETCH, RAMP]
    assert found["recovery"].tolist() == [4.0, np.inf]

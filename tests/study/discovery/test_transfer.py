import numpy as np
import pandas as pd
import pytest

from imugap import log
from imugap.effects import Bias, LeverArm, Misalignment, ScaleFactor, WhiteNoise
from imugap.effects.effect import AxisModel
from imugap.figures import discovery
from imugap.model import ErrorModel
from imugap.stream import stream
from imugap.study.discovery.transfer import explained_variance, motion_effects, parameter_agreement

INTERVAL, COUNT = 0.05, 2000


def motion(seed):
    """Return the error-free log of an oscillating device."""
    time, rng = INTERVAL * np.arange(COUNT), stream(seed, "motion")
    phase = rng.uniform(0, 2 * np.pi, 6)
    pulse = 2 * np.pi * np.array([0.3, 0.41, 0.53, 0.23, 0.37, 0.61])
    return log.from_samples(dict(zip(log.AXES, np.sin(np.outer(pulse, time) + phase[:, None]), strict=True)), INTERVAL)


def device(noise=1e-3):
    own = {"gyro_x": (ScaleFactor(0.02), Misalignment(y=0.01)), "accel_y": (LeverArm(0.02, 0.0, -0.03),)}
    return ErrorModel({
        axis: AxisModel((Bias(0.1), *own.get(axis, ()), WhiteNoise(noise * np.sqrt(INTERVAL)))) for axis in log.AXES
    })  # fmt: skip


def test_the_true_model_explains_all_of_another_run_but_its_noise():
    ideal = motion(1)
    table = explained_variance(device(), device().simulate(ideal, 3), ideal, stream(4, "carried"))
    assert table.loc[["gyro_x", "accel_y"], "share"].tolist() == pytest.approx([1, 1], abs=0.02)
    assert table["rms"]["gyro_z"] == pytest.approx(1e-3, rel=0.1)
    assert table["share"].drop(["gyro_x", "accel_y"]).tolist() == pytest.approx([0, 0, 0, 0], abs=1e-12)


def test_a_wrong_model_has_a_negative_explained_share():
    ideal, wrong = motion(1), ErrorModel({"gyro_x": AxisModel((ScaleFactor(-0.02),))})
    table = explained_variance(wrong, device().simulate(ideal, 3), ideal, stream(4, "carried"))
    assert table.loc["gyro_x", "high"] < 0


@pytest.mark.slow
def test_the_interval_of_the_explained_share_covers_that_of_a_long_run():
    """Half of the scale factor explains three quarters of its variance, which is half of the total."""
    half = ErrorModel({"gyro_x": AxisModel((ScaleFactor(0.01),))})
    true = ErrorModel({"gyro_x": AxisModel((ScaleFactor(0.02), WhiteNoise(0.02 / np.sqrt(2) * np.sqrt(INTERVAL))))})
    inside = []
    for seed in range(100):
        ideal = motion(seed)
        measured = true.simulate(ideal, seed)[["gyro_x"]]
        found = explained_variance(half, measured, ideal, stream(seed, "carried")).loc["gyro_x"]
        inside.append(found["low"] <= 0.375 <= found["high"])
    assert 0.85 <= np.mean(inside) <= 1.0


def test_only_motion_dependent_effects_are_kept():
    kept = motion_effects(device())
    assert [effect.name for effect in kept["gyro_x"]] == ["scale_factor", "misalignment"]
    assert [effect.name for effect in kept["accel_y"]] == ["lever_arm"]
    assert list(kept["gyro_z"]) == []


def found(trial, value, half, parameter="x"):
    return {"trial": trial, "name": "lever_arm", "axis": "accel_x", "parameter": parameter, "value": value,
            "low": value - half, "high": value + half, "unit": "m"}  # fmt: skip


def test_consistent_trials_have_a_birge_ratio_of_one():
    rng, half = stream(5, "agreement"), 0.1
    rows = [
        found(trial, 1 + half / 1.96 * rng.standard_normal(), half, f"p{number}")
        for number in range(400) for trial in range(4)
    ]  # fmt: skip
    table = parameter_agreement(pd.DataFrame(rows))
    assert len(table) == 400
    assert np.mean(table["factor"] ** 2) == pytest.approx(1, abs=4 * np.sqrt(2 / 3 / 400))
    assert table["same_sign"].all()


def test_the_mean_is_weighted_by_precision_and_needs_two_trials():
    rows = [found(1, 1.0, 0.1), found(2, -2.0, 0.3), found(1, 5.0, 0.1, "y")]
    table = parameter_agreement(pd.DataFrame(rows))
    assert table["parameter"].tolist() == ["x"]
    assert table["middle"].tolist() == pytest.approx([(9 * 1.0 - 2.0) / 10])
    assert not table["same_sign"].any()


def test_a_parameter_without_an_interval_is_left_out():
    rows = pd.DataFrame([found(1, 1.0, 0.1), found(2, 1.0, 0.1) | {"low": None, "high": None}])
    assert parameter_agreement(rows).empty


def test_a_point_for_each_trial_that_gives_a_parameter():
    data = pd.DataFrame([found(1, 1.0, 0.1), found(2, 1.1, 0.3), found(1, 0.5, 0.1, "y"), found(2, 0.6, 0.1, "y")])
    (panel,) = discovery.repeated(data, {"m": ("mm", 1e3)}).axes
    assert [line.get_xdata().tolist() for line in panel.lines[:2]] == [[1000.0, 500.0], [1100.0, 600.0]]
    assert panel.get_xlabel() == "mm"

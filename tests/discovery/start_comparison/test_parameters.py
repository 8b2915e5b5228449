"""Each number of a start file is compared with the log in its own words; a right one passes without a word."""

import re
from math import sqrt
from pathlib import Path

import numpy as np
import pytest

from imugap import log
from imugap.discovery.device import Settings
from imugap.discovery.inputs import DiscoveryInputs, discover_recordings
from imugap.discovery.start_comparison.parameters import Comparison
from imugap.discovery.start_comparison.wording import sentences, table
from imugap.effects import (
    CATALOGUE,
    Bias,
    GaussMarkov,
    RandomWalk,
    Resolution,
    Saturation,
    ScaleFactor,
    TurnOnBias,
    WhiteNoise,
)
from imugap.effects.effect import AxisModel
from imugap.interchange.conventions import Rule
from imugap.interchange.export import Target, export
from imugap.interchange.start_models.catalogue import ModelFile
from imugap.io.recording import Recording
from imugap.model import ErrorModel

RATE, COUNT = 20.0, 6000
DEVICE = (Bias(0.01), WhiteNoise(2e-3), GaussMarkov(8e-3, 3.0))
QUICK = Settings(replicates=20, simulations=10)


def run_of(*effects, seed=1, axis="gyro_x"):
    still = log.from_samples({axis: np.zeros(COUNT)}, 1 / RATE)
    return ErrorModel({axis: AxisModel(effects)}).simulate(still, seed, "start")


def compared(model, *runs):
    """Compare start model and logs: the row of each parameter, and what is said."""
    opened = model if isinstance(model, ModelFile) else ModelFile(Path("model"), model)
    recordings = tuple(Recording(Path(f"run{k}"), one) for k, one in enumerate(runs))
    found = discover_recordings(DiscoveryInputs(recordings, model=opened), QUICK)
    return {row.name: row for row in found.against}, "\n".join(sentences(found.against)), found


def start(*effects, axis="gyro_x"):
    return ErrorModel({axis: AxisModel(effects)})


def file_of(tmp_path, target, *effects):
    every = ErrorModel(dict.fromkeys(log.AXES, AxisModel(effects)))
    path = tmp_path / "file"
    path.write_text(export(every, target, Rule(RATE)))
    return ModelFile.open(path, CATALOGUE)


def test_the_right_model_agrees_in_every_parameter():
    rows, said, found = compared(start(*DEVICE), run_of(*DEVICE))
    assert {row.agreement for row in rows.values()} == {Comparison.AGREES}
    assert said == "Of 4 parameters of the start model 4 agree with the log."
    for row in rows.values():
        assert row.log.low < row.start < row.log.high
    assert list(table(found.against)["within"]) == 4 * ["yes"]


def test_wrong_numbers_are_named_in_the_words_of_gazebo(tmp_path):
    wrong = file_of(tmp_path, Target.GAZEBO, Bias(0.5), WhiteNoise(1e-3), GaussMarkov(8e-3 * sqrt(100), 300.0))
    rows, said, _ = compared(wrong, run_of(*DEVICE))
    stddev = rows["<stddev> of <angular_velocity>"]
    assert stddev.agreement is Comparison.DIFFERS
    assert stddev.unit == "rad/s"
    assert stddev.start == pytest.approx(1e-3 * sqrt(RATE))
    assert stddev.log.low < 2e-3 * sqrt(RATE) < stddev.log.high
    time = rows["<dynamic_bias_correlation_time> of <angular_velocity>"]
    assert time.agreement is Comparison.DIFFERS
    assert time.log.low < 3 < time.log.high < 300
    drive = rows["<dynamic_bias_stddev> of <angular_velocity>"]
    assert drive.agreement is Comparison.AGREES
    assert "<stddev> of <angular_velocity> is 0.004472 rad/s in the start model; the log has 0.008" in said
    assert re.search(r"rad/s \(with its interval 0\.00\d+ to 0\.00\d+\)", str(said))
    assert "Of 4 parameters" in said


def test_what_the_file_lacks_is_given_by_its_own_keys(tmp_path):
    bare = file_of(tmp_path, Target.GAZEBO, Bias(0.01), WhiteNoise(2e-3))
    rows, said, _ = compared(bare, run_of(Bias(0.01), WhiteNoise(2e-3), GaussMarkov(8e-3, 3.0)))
    missing = rows["<dynamic_bias_stddev> of <angular_velocity>"]
    assert missing.agreement is Comparison.MISSING
    assert missing.start is None
    assert missing.log.low < 8e-3 * sqrt(2 / 3) < missing.log.high
    assert "<dynamic_bias_stddev> of <angular_velocity> is missing; the log has" in said


def test_a_bias_that_was_never_added_is_none_in_the_log():
    rows, said, _ = compared(start(Bias(0.05), *DEVICE[1:]), run_of(WhiteNoise(2e-3)))
    assert rows["bias.value"].agreement is Comparison.DIFFERS
    assert rows["gauss_markov.std"].agreement is Comparison.DIFFERS
    assert rows["gauss_markov.std"].log.high < 1e-3
    assert rows["gauss_markov.correlation_time"].agreement is Comparison.OPEN
    assert "gyro_x: gauss_markov.std is 0.008 rad/s in the start model; the log shows none (at most" in said
    rows, _, _ = compared(start(WhiteNoise(2e-3)), run_of(WhiteNoise(2e-3), Bias(0.05)))
    assert rows["bias.value"].agreement is Comparison.MISSING


def test_parameters_that_agree_one_by_one_but_not_together_differ():
    slow = GaussMarkov(0.1, 1000.0)
    rows, said, _ = compared(start(WhiteNoise(2e-3), slow), run_of(WhiteNoise(2e-3), RandomWalk(1.5e-3)))
    std = rows["gauss_markov.std"]
    assert std.agreement is Comparison.DIFFERS
    assert std.log.low < 1.5e-3 / sqrt(2 / 1000.0) < std.log.high
    assert "with correlation_time of the start model" in said


def test_a_file_that_has_no_bias_is_not_asked_for_one(tmp_path):
    kalibr = file_of(tmp_path, Target.KALIBR, WhiteNoise(2e-3), RandomWalk(1e-3))
    rows, said, _ = compared(kalibr, run_of(Bias(0.3), WhiteNoise(2e-3), RandomWalk(1e-3)))
    assert set(rows) == {"gyroscope_noise_density", "gyroscope_random_walk"}
    assert said == "Of 2 parameters of the start model 2 agree with the log."


def test_the_earth_turns_a_device_at_rest():
    rows, _, _ = compared(start(WhiteNoise(1e-6)), run_of(Bias(7e-5), WhiteNoise(1e-6)))
    assert set(rows) == {"white_noise.density"}


def test_the_output_shows_its_own_parameters():
    coarse = (WhiteNoise(2e-3), Resolution(0.004), Saturation(0.02))
    rows, _, _ = compared(start(WhiteNoise(2e-3), Resolution(0.002), Saturation(0.01)), run_of(*coarse))
    assert rows["white_noise.density"].agreement is Comparison.AGREES
    assert rows["resolution.step"].agreement is Comparison.DIFFERS
    assert rows["resolution.step"].log.value == pytest.approx(0.004)
    assert rows["saturation.limit"].agreement is Comparison.DIFFERS
    rows, _, _ = compared(start(*coarse), run_of(*coarse))
    assert {row.agreement for row in rows.values()} <= {Comparison.AGREES, Comparison.OPEN}


def test_what_takes_other_logs_is_not_determined():
    rows, said, _ = compared(start(*DEVICE, TurnOnBias(0.1), ScaleFactor(0.01)), run_of(*DEVICE))
    assert rows["turn_on_bias.std"].remark == "it takes several runs of the device"
    assert rows["scale_factor.error"].remark == "it takes a known motion or temperature"
    assert "the log cannot tell 4." in said


def test_several_runs_show_the_turn_on_bias():
    device = (WhiteNoise(2e-3), TurnOnBias(0.05))
    runs = [run_of(*device, seed=seed) for seed in range(5)]
    rows, _, _ = compared(start(*device), *runs)
    assert {row.agreement for row in rows.values()} == {Comparison.AGREES}
    rows, _, _ = compared(start(WhiteNoise(2e-3), TurnOnBias(5.0)), *runs)
    assert rows["turn_on_bias.std"].agreement is Comparison.DIFFERS

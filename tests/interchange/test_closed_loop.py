"""A model goes to a simulator and comes back from its log: nothing is missing; a fault of a simulator is named.

The logs are those of the algorithms of the simulators (:mod:`tests.interchange.simulators`).
"""

from pathlib import Path

import numpy as np
import pytest
from tests.interchange import simulators
from tests.interchange.simulators import Defect

from imugap import log
from imugap.discovery.device import Settings
from imugap.discovery.inputs import DiscoveryInputs, discover_recordings
from imugap.discovery.start_comparison.parameters import Comparison
from imugap.discovery.start_comparison.wording import sentences
from imugap.discovery.verdict import verdict
from imugap.effects import CATALOGUE, Bias, GaussMarkov, RandomWalk, Resolution, WhiteNoise
from imugap.effects.effect import AxisModel
from imugap.interchange.conventions import Rule
from imugap.interchange.export import Target, export, omitted
from imugap.interchange.start_models.catalogue import ModelFile
from imugap.io.recording import Recording
from imugap.model import ErrorModel
from imugap.stream import stream

QUICK = Settings(replicates=20, simulations=10)
AXIS = "gyro_y"
WALK = (WhiteNoise(2e-3), RandomWalk(1e-3))
DRIFT = (WhiteNoise(2e-3), GaussMarkov(8e-3, 5.0))
LOOPS = {
    Target.GAZEBO: (simulators.gazebo, (*DRIFT, Resolution(1e-3))),
    Target.AIRSIM: (simulators.airsim, WALK),
    Target.GNSS_INS_SIM: (simulators.gnss_ins_sim, (Bias(0.02), *DRIFT)),
    Target.PEGASUS: (simulators.pegasus, DRIFT),
    Target.GENESIS: (simulators.genesis, (Bias(0.02), *WALK, Resolution(1e-3))),
    Target.MATLAB: (simulators.matlab, (Bias(0.02), *WALK)),
}
"""Algorithm of each simulator, and a model that it holds whole."""


def closed(folder, target, effects, simulate, rate=20.0, count=6000, **fault):
    """Export a model, let the simulator make a log of the file, and discover on it with the file as start model."""
    model, rule = ErrorModel(dict.fromkeys(log.AXES, AxisModel(effects))), Rule(rate)
    assert not omitted(model, target, rule)
    text = export(model, target, rule)
    path = folder / "exported.py"
    path.write_text(text)
    values = simulate(text, AXIS, rate, count, stream(3, str(target)), **fault)
    return discovered(path, log.from_samples({AXIS: values}, 1 / rate))


def discovered(path, table, reference=None):
    recordings = [None if one is None else Recording(Path(name), one)
                  for name, one in (("log", table), ("reference", reference))]  # fmt: skip
    inputs = DiscoveryInputs((recordings[0],), reference=recordings[1], model=ModelFile.open(path, CATALOGUE))
    return discover_recordings(inputs, QUICK)


def said(result):
    return "\n".join((verdict(result.found), *sentences(result.against)))


@pytest.mark.parametrize(
    "target",
    [
        one if one in (Target.GAZEBO, Target.AIRSIM) else pytest.param(one, marks=(pytest.mark.slow, pytest.mark.each))
        for one in LOOPS
    ],
)
def test_nothing_is_missing_of_what_the_target_holds(tmp_path, target):
    simulate, effects = LOOPS[target]
    result = closed(tmp_path, target, effects, simulate)
    assert not result.found.findings
    assert not result.found.withheld
    assert not result.found.shapes
    assert {row.agreement for row in result.against} <= {Comparison.AGREES, Comparison.OPEN}
    assert sum(row.agreement is Comparison.AGREES for row in result.against) >= 2


@pytest.mark.slow
def test_the_correlation_time_of_the_other_sensor_is_named(tmp_path):
    """Reported of Pegasus: the gyroscopes take 300 s, that of the accelerometers, for 1000 s."""
    own = (WhiteNoise(2e-3), GaussMarkov(0.02, 1000.0))
    other = (WhiteNoise(2e-3), GaussMarkov(0.02 * np.sqrt(0.3), 300.0))
    model = {axis: AxisModel(own if axis in log.GYRO else other) for axis in log.AXES}
    path = tmp_path / "exported.py"
    path.write_text(export(ErrorModel(model), Target.PEGASUS, Rule(1.0)))
    values = simulators.pegasus(path.read_text(), AXIS, 1.0, 30_000, stream(3, "other"), Defect.OTHER_TIME)
    result = discovered(path, log.from_samples({AXIS: values}, 1.0))
    rows = {row.name: row for row in result.against}
    time = rows["gyroscope bias_correlation_time"]
    assert time.agreement is Comparison.DIFFERS
    assert time.log.low < 300 < time.log.high < 1000
    assert rows["gyroscope random_walk"].agreement is Comparison.AGREES
    assert f"{AXIS}: gyroscope bias_correlation_time is 1000 s in the start model; the log has" in said(result)


def test_uniform_numbers_are_named(tmp_path):
    result = closed(tmp_path, Target.AIRSIM, WALK, simulators.airsim, defect=Defect.UNIFORM)
    (found,) = result.found.findings
    assert found.name == "uniform_noise"
    assert found.parameters["share"].high > 0.99
    rows = {one.name: one.agreement for one in result.against}
    assert rows["AngularRandomWalk"] is Comparison.AGREES
    assert rows["uniform_noise.share"] is Comparison.MISSING


@pytest.mark.slow
def test_a_bias_that_is_not_added_is_named(tmp_path):
    """Reported of Pegasus: the bias is propagated, and not added to the output."""
    result = closed(tmp_path, Target.PEGASUS, DRIFT, simulators.pegasus, defect=Defect.NO_BIAS)
    assert f"{AXIS}: gyroscope random_walk is 0.00506 rad/s^2/sqrt(Hz) in the start model; the log shows none" in said(
        result
    )


def test_a_density_that_is_not_scaled_by_the_rate_is_named(tmp_path):
    result = closed(tmp_path, Target.AIRSIM, WALK, simulators.airsim, defect=Defect.NOT_SCALED)
    (row,) = (one for one in result.against if one.name == "AngularRandomWalk")
    assert row.agreement is Comparison.DIFFERS
    assert row.start / row.log.value == pytest.approx(np.sqrt(20.0), rel=0.05)
    assert "AngularRandomWalk is 6.875 deg/sqrt(h) in the start model; the log has 1.5" in said(result)


@pytest.mark.slow
def test_a_delay_of_one_step_is_named(tmp_path):
    rate, count = 50.0, 6000
    time = np.arange(-40, count + 40) / rate
    rng = stream(3, "delay")
    motion = sum(rng.normal() * np.sin(2 * np.pi * f * time + rng.uniform(0, 6)) for f in np.linspace(0.1, 4.0, 30))
    ideal = log.from_samples({AXIS: motion}, 1 / rate)
    model = ErrorModel(dict.fromkeys(log.AXES, AxisModel(WALK)))
    path = tmp_path / "settings.json"
    path.write_text(export(model, Target.AIRSIM, Rule(rate)))
    error = simulators.airsim(path.read_text(), AXIS, rate, len(time), rng)
    late = log.from_samples({AXIS: np.roll(motion, 1) + error}, 1 / rate).iloc[40:-40]
    result = discovered(path, late, ideal)
    (found,) = (one for one in result.found.findings if one.name == "time_offset")
    delay = found.parameters["offset"]
    assert delay.low - 1e-4 < 1 / rate < delay.high + 1e-4
    assert f"{AXIS}: time_offset" in said(result)

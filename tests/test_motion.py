"""Names of what answers the motion, and what else may go with it."""

import numpy as np
import pytest
from scipy.signal import butter, lfilter

from imugap import log
from imugap.discovery.hysteresis import play
from imugap.discovery.sequence import Sequence
from imugap.discovery.story import concluded, told
from imugap.effects import (
    CATALOGUE,
    GaussMarkov,
    GSensitivity,
    Misalignment,
    OutputFilter,
    ScaleFactor,
    VibrationRectification,
    WhiteNoise,
)
from imugap.effects.effect import Conditions
from imugap.model import AxisModel
from imugap.stream import stream

COUNT, INTERVAL = 20_000, 0.02
LOG_ALPHA = np.log(0.01 / 6 / 28)


def turning(coupled=0.9):
    """Return the error-free log of a vehicle: its turns are felt sideways, more or less."""
    slow = lfilter(*butter(2, 0.02), stream(5, "turning").standard_normal((6, COUNT)))
    slow[4] = coupled * slow[2] + np.sqrt(1 - coupled**2) * slow[4]
    return log.from_samples(dict(zip(log.AXES, 8 * slow, strict=True)), INTERVAL)


def story(axis, ideal, *effects, added=0.0):
    conditions = Conditions(ideal.index.to_numpy(), INTERVAL, None, axis, ideal)
    noise = AxisModel((WhiteNoise(1e-3), *effects)).simulate(np.zeros(COUNT), conditions, 1, "motion")
    sequence = Sequence(noise + added, conditions, np.zeros(COUNT, bool))
    return concluded(told(sequence, (), tuple(CATALOGUE.values()), LOG_ALPHA, int(0.8 * COUNT)))


@pytest.mark.parametrize(
    ("axis", "effect"),
    [
        ("accel_z", Misalignment(0.0, 1e-3, 0.0)),
        ("gyro_x", GSensitivity(0.0, 1e-3, 0.0)),
        ("gyro_z", ScaleFactor(1e-3)),
        ("gyro_z", ScaleFactor(1e-2)),
    ],
)
@pytest.mark.parametrize("beside", [(), (GaussMarkov(5e-3, 5.0),), (OutputFilter(5.0, 2),)])
def test_what_answers_the_motion_keeps_its_name(axis, effect, beside):
    found = story(axis, turning(), effect, *beside)
    assert sorted(finding.name for finding in found.findings) == sorted(one.name for one in (effect, *beside))
    assert not found.withheld


@pytest.mark.parametrize("coupled", [0.8, 0.95])
def test_an_accelerometer_that_answers_the_rate_leans_to_no_axis(coupled):
    ideal = turning(coupled)
    found = story("accel_z", ideal, added=2e-3 * ideal["gyro_z"].to_numpy())
    assert not found.findings
    assert "another function of the motion explains it better" in {one.reason for one in found.withheld}


@pytest.mark.parametrize("half", [0.003, 0.03])
def test_a_play_is_neither_what_it_looks_like_nor_the_noise_that_takes_it_up(half):
    """A delay, a filter, outliers: each of them explains some of it."""
    ideal = turning()
    own = np.ascontiguousarray(ideal["gyro_y"])
    found = story("gyro_y", ideal, added=play(own, half * own.std()) - own)
    assert not found.findings
    assert found.withheld


@pytest.mark.parametrize("late", [0.12, 0.37])
def test_what_comes_late_from_another_axis_leans_to_none(late):
    ideal = turning()
    lag = round(late / INTERVAL)
    other = ideal["gyro_x"].to_numpy()
    found = story("gyro_y", ideal, added=3e-3 * np.r_[np.full(lag, other[0]), other[:-lag]])
    assert not found.findings
    assert found.withheld


@pytest.mark.parametrize("own", [0, 1])
def test_vibration_is_told_from_the_motion_beneath_it(own):
    rng, ideal = stream(5, "vibration"), turning()
    power = np.repeat(rng.uniform(0.0, 3.0, 20), COUNT // 20)
    fast = lfilter(*butter(2, 0.4, "high"), rng.standard_normal((3, COUNT))) * power
    shaken = ideal.assign(**{axis: ideal[axis] + more for axis, more in zip(log.ACCEL, fast, strict=True)})
    found = story("accel_y", shaken, VibrationRectification(5e-4, 0.1, own))
    assert [finding.name for finding in found.findings] == ["vibration_rectification"]
    assert found.findings[0].effects["accel_y"].own == own
    assert found.findings[0].parameters["coefficient"].value == pytest.approx(5e-4, rel=0.25)

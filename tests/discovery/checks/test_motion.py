"""Effects that depend on the motion, against unnamed functions of it."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.signal import butter, lfilter
from scipy.stats import binom
from tests.discovery import simulated
from tests.discovery.simulated import LOG_ALPHA, WHITE, moved

from imugap import log
from imugap.discovery.axis import conclude
from imugap.discovery.checks.motion import outliers_against_motion
from imugap.discovery.fit.axis_fit import fit
from imugap.discovery.fit.description import Description, Entry
from imugap.discovery.preparation.sequence import AxisSequence
from imugap.discovery.search.search import Trial, noise_shows_filter
from imugap.discovery.unnamed.hysteresis import play
from imugap.effects import (
    CATALOGUE,
    GaussMarkov,
    GSensitivity,
    Misalignment,
    Outliers,
    OutputFilter,
    ScaleFactor,
    TimeOffset,
    VarianceChange,
    VibrationRectification,
    WhiteNoise,
)
from imugap.effects.conditions import Conditions
from imugap.effects.effect import AxisModel, Role
from imugap.stream import stream

COUNT, INTERVAL = 20_000, 0.02
FEW = (*(kind for kind in CATALOGUE.values() if kind.of_motion), GaussMarkov, Outliers, OutputFilter, VarianceChange)
"""Kinds that may answer the motion, or be taken for an answer to it: those of a search that has to be quick."""
sought = pytest.mark.parametrize("kinds", [FEW, simulated.KINDS], ids=["few kinds", "all kinds"])


def turning(coupled=0.9):
    """Return the error-free log of a vehicle, with a correlation ``coupled`` of lateral acceleration and yaw rate."""
    slow = lfilter(*butter(2, 0.02), stream(5, "turning").standard_normal((6, COUNT)))
    slow[4] = coupled * slow[2] + np.sqrt(1 - coupled**2) * slow[4]
    return log.from_samples(dict(zip(log.AXES, 8 * slow, strict=True)), INTERVAL)


def conditions_of(axis, ideal):
    return Conditions(ideal.index.to_numpy(), INTERVAL, None, axis, ideal)


def sequence(axis, ideal, effects, seed, label):
    """Return the error sequence of effects under a motion."""
    conditions = conditions_of(axis, ideal)
    own = conditions.error_free
    return AxisSequence(AxisModel(effects).simulate(own, conditions, seed, label) - own, conditions)


def searched(kinds, axis, ideal, *effects, added=0.0):
    return simulated.searched(moved(sequence(axis, ideal, (WHITE, *effects), 1, "motion"), added), *kinds)


def result(kinds, axis, ideal, *effects, added=0.0):
    return conclude(searched(kinds, axis, ideal, *effects, added=added))


@pytest.mark.slow
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
@sought
def test_motion_dependent_effects_keep_their_names(kinds, axis, effect, beside):
    found = result(kinds, axis, turning(), effect, *beside)
    assert sorted(finding.name for finding in found.findings) == sorted(one.name for one in (effect, *beside))
    assert not found.withheld


@pytest.mark.slow
@pytest.mark.parametrize("coupled", [0.8, 0.95])
@sought
def test_rate_sensitivity_of_an_accelerometer_is_not_named_misalignment(kinds, coupled):
    ideal = turning(coupled)
    found = result(kinds, "accel_z", ideal, added=2e-3 * ideal["gyro_z"].to_numpy())
    assert not found.findings
    assert "another function of the motion explains it better" in {one.reason for one in found.withheld}


@pytest.mark.long
@pytest.mark.slow
@pytest.mark.parametrize("waves", [2.5, 6.0])
@sought
def test_a_periodic_nonlinearity_is_not_named_noise(kinds, waves):
    """An interpolation error is periodic in the input, and has the spectrum of slow noise over a varying input."""
    ideal = turning()
    rate = ideal["gyro_z"].to_numpy()
    found = result(kinds, "gyro_z", ideal, added=4e-3 * np.sin(2 * np.pi * waves * rate / np.ptp(rate)))
    assert not found.findings
    assert "another function of the motion explains it better" in {one.reason for one in found.withheld}


@pytest.mark.slow
def test_the_cutoff_of_a_filter_in_motion_scatters_by_its_standard_error():
    """The motion that the filter removes determines its cutoff, jointly with a scale factor."""
    ideal, log_cutoff, seen = turning().iloc[:3000], np.log(5.0), []
    scatter = []
    for number in range(60):
        effects = (WhiteNoise(0.02), ScaleFactor(0.01), OutputFilter(5.0, 2))
        data = sequence("gyro_z", ideal, effects, number, "cutoff")
        terms = (Entry(ScaleFactor(0.0), ("error",)),)
        found = fit(data, Description.known(WhiteNoise(0.02)).adding(*terms, OutputFilter(4.0, 2)))
        seen.append(np.log(found.description.noise.output_filter.cutoff) - log_cutoff)
        scatter.append(np.sqrt(found.noise.covariance[-1, -1]))
    z = np.array(seen) / scatter
    assert abs(z.mean()) < 4 / np.sqrt(60)
    assert 0.7 < z.std() < 1.35
    free = fit(replace(data, conditions=replace(data.conditions, ideal=None)), found.description.exchanging(Role.MEAN))
    assert scatter[-1] < 0.5 * np.sqrt(free.noise.covariance[-1, -1])


@pytest.mark.parametrize(("effect", "shown"), [(TimeOffset(5e-5), False), (OutputFilter(15.0, 1), True)])
def test_a_delay_is_not_named_filter_without_evidence_in_the_noise(effect, shown):
    """A filter with a cutoff near half the rate is equivalent to a small delay of the motion."""
    data = sequence("gyro_z", turning(), (WhiteNoise(1e-4), effect), 1, "delay")
    plain = fit(data, Description.known(WhiteNoise(1e-4)))
    near = OutputFilter(15.0 if shown else 24.9, 1)
    filtered = fit(data, Description.known(WhiteNoise(1e-4)).adding(near))
    gain = filtered.log_likelihood - plain.log_likelihood
    assert gain > 100
    assert noise_shows_filter(Trial(near, filtered, gain, 1, 10.0), LOG_ALPHA) == shown


@pytest.mark.slow
@pytest.mark.parametrize("gravity", [0.0, -9.8])
@sought
def test_a_cubic_nonlinearity_about_the_mean_input_is_not_named_scale_factor(kinds, gravity):
    ideal = turning()
    moved = ideal["accel_z"].to_numpy()
    ideal["accel_z"] += gravity
    found = result(kinds, "accel_z", ideal, added=3e-3 * moved**3)
    assert not found.findings
    assert "another function of the motion explains it better" in {one.reason for one in found.withheld}


@pytest.mark.long
@pytest.mark.slow
@pytest.mark.parametrize("waves", [1, 2])
@sought
def test_a_heading_dependent_error_is_not_named_noise(kinds, waves):
    """As of hard and soft iron of a vehicle, the error is a function of the heading."""
    ideal = turning()
    heading = INTERVAL * np.cumsum(0.2 * ideal["gyro_z"].to_numpy())
    ideal["gyro_z"] *= 0.2
    found = result(kinds, "gyro_x", ideal, added=2e-3 * np.sin(waves * heading + 1))
    assert not found.findings
    assert {one.reason for one in found.withheld} == {"another function of the motion explains it better"}


@pytest.mark.slow
@pytest.mark.parametrize("half", [0.003, 0.03])
@sought
def test_play_of_the_input_is_not_named(kinds, half):
    """A delay, a filter, and outliers each explain a part of it."""
    ideal = turning()
    own = np.ascontiguousarray(ideal["gyro_y"])
    found = result(kinds, "gyro_y", ideal, added=play(own, half * own.std()) - own)
    assert not found.findings
    assert found.withheld


@pytest.mark.slow
@sought
def test_the_search_stops_at_an_unnamed_function_of_the_motion_in_the_whole_log(kinds):
    """The function explains more than all effects that a longer search would add."""
    ideal = turning()
    rate = ideal["gyro_x"].to_numpy()
    found = searched(kinds, "gyro_x", ideal, added=np.where(np.abs(rate) < 0.1 * rate.std(), -rate, 0.0))
    early, whole = ([type(one) for one in part.description.effects()] for part in (found.training_fit, found.whole_fit))
    assert whole == early != [WhiteNoise]
    told_of = conclude(found)
    assert not told_of.findings
    assert {one.reason for one in told_of.withheld} == {"another function of the motion explains it better"}


@pytest.mark.slow
@pytest.mark.parametrize(("axis", "size"), [("gyro_y", 0.8), ("gyro_y", 2.0), ("accel_x", 0.8)])
@sought
def test_noise_that_grows_with_the_motion_is_withheld(kinds, axis, size):
    ideal = turning()
    change = np.gradient(ideal[axis].to_numpy())
    noise = size * stream(9, "grows").standard_normal(COUNT) * change / change.std()
    found = result(kinds, "gyro_y", ideal, added=1e-3 / np.sqrt(INTERVAL) * noise)
    assert not found.findings
    assert found.withheld


@pytest.mark.slow
@sought
def test_noise_that_differs_at_rest_is_withheld(kinds):
    """As with coarse rounding, whose noise differs at rest."""
    moving = INTERVAL * np.arange(COUNT) > 20
    ideal = turning().mul(moving, axis=0)
    noise = stream(6, "rest").standard_normal(COUNT) * moving
    found = result(kinds, "gyro_y", ideal, added=1e-3 / np.sqrt(INTERVAL) * noise)
    assert not found.findings
    assert "the variance goes with the motion" in {one.reason for one in found.withheld}


@pytest.mark.slow
@pytest.mark.parametrize("effect", [Outliers(1e-3, 0.05), VarianceChange(100.0, 150.0, 1.6)])
@sought
def test_outliers_and_variance_changes_independent_of_the_motion_keep_their_names(kinds, effect):
    found = result(kinds, "gyro_y", turning(), effect)
    assert [finding.name for finding in found.findings] == [effect.name]
    assert not found.withheld


@pytest.mark.slow
def test_the_p_value_of_outliers_independent_of_the_motion_is_near_uniform():
    ideal = turning()
    fitted = SimpleNamespace(sequence=SimpleNamespace(conditions=conditions_of("gyro_y", ideal)))
    rng = stream(3, "by chance")
    log_ps = [outliers_against_motion(fitted, rng.random(COUNT) < 5e-3) for _ in range(100)]
    assert binom.ppf(0.001, 100, 0.02) <= np.sum(np.array(log_ps) < np.log(0.1)) <= binom.ppf(0.999, 100, 0.1)


@pytest.mark.slow
@pytest.mark.parametrize("own", [0, 1])
@sought
def test_vibration_rectification_is_separated_from_slow_motion(kinds, own):
    rng, ideal = stream(5, "vibration"), turning()
    power = np.repeat(rng.uniform(0.0, 3.0, 20), COUNT // 20)
    fast = lfilter(*butter(2, 0.4, "high"), rng.standard_normal((3, COUNT))) * power
    shaken = ideal.assign(**{axis: ideal[axis] + more for axis, more in zip(log.ACCEL, fast, strict=True)})
    found = result(kinds, "accel_y", shaken, VibrationRectification(5e-4, 0.1, own))
    assert [finding.name for finding in found.findings] == ["vibration_rectification"]
    assert found.findings[0].effects["accel_y"].own == own
    assert found.findings[0].parameters["coefficient"].value == pytest.approx(5e-4, rel=0.25)

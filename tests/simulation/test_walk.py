from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from imugap.effects import Bias, TurnOnBias, WhiteNoise
from imugap.io.references import reference
from imugap.kinematics import strapdown
from imugap.kinematics.strapdown import ATTITUDE, POSITION, VELOCITY, Local, NavigationState
from imugap.log import ACCEL, AXES, GYRO
from imugap.numerics.rotation import from_euler
from imugap.simulation.walk import Gait, Walk, WalkCourse, WalkLeg

ROOT = Path(__file__).parents[2]
SEED = 11


@pytest.fixture(scope="module")
def recipe():
    return Walk.read(ROOT / "data" / "walk.yaml")


@pytest.fixture(scope="module")
def short(recipe):
    return replace(recipe, course=WalkCourse.out_and_back(6), gait=replace(recipe.gait, drift_m_per_s=0.0))


def contact(walk, truth):
    """Return where the point on the ground is, shape (n, 3)."""
    return truth[list(POSITION)].to_numpy() + reference.rotations(truth).apply(walk.contact_m)


def test_the_walk_of_the_study_lasts_189_seconds_and_closes(recipe):
    assert recipe.duration_s == pytest.approx(189)
    still = replace(recipe, gait=replace(recipe.gait, drift_m_per_s=0.0), rate_hz=20)
    truth = still.truth(1, SEED)
    np.testing.assert_allclose(truth[list(POSITION)].iloc[-1].to_numpy(float), 0, atol=1e-6)
    assert truth["heading"].iloc[-1] == pytest.approx(0, abs=1e-9)
    assert truth["north"].max() == pytest.approx(80 * recipe.gait.length_m, abs=0.15)


@pytest.mark.parametrize("rate", [200, 400])
def test_navigating_the_ideal_log_gives_the_truth_back(short, rate):
    """What is left is the error of the integration at an impact; it falls with the rate by the square and more."""
    walk = replace(short, rate_hz=rate)
    truth, ideal = walk.truth(0, SEED), walk.ideal(0, SEED)
    state = NavigationState(*(tuple(truth[list(names)].iloc[0]) for names in (POSITION, VELOCITY, ATTITUDE)))
    path = strapdown.trajectory(ideal, state, Local(walk.site.gravity))
    missed = (from_euler(path[list(ATTITUDE)].to_numpy()) * reference.rotations(truth).inv()).magnitude()
    scale = (200 / rate) ** 2
    assert missed.max() < 1e-5 * scale
    assert np.abs(path[list(VELOCITY)] - truth[list(VELOCITY)]).to_numpy().max() < 2e-3 * scale
    assert np.abs(path[list(POSITION)] - truth[list(POSITION)]).to_numpy().max() < 5e-3 * scale


def test_the_point_on_the_ground_rests_at_stance_while_the_foot_rolls_over_it(short):
    """Between the end of the impact and the next push the contact stays within 1 um, the device goes up by its arm."""
    gait, truth = short.gait, short.truth(0, SEED)
    place = contact(short, truth)
    begin = short.course.stand_s + gait.stride_s * gait.swing_share + 2 / gait.impact_hz
    rows = (truth.index > begin + 0.01) & (truth.index < short.course.stand_s + gait.stride_s - 0.01)
    assert np.ptp(place[rows], axis=0).max() < 1e-6
    assert np.ptp(truth["pitch"].to_numpy()[rows]) > np.radians(0.9 * gait.roll_deg)
    assert np.ptp(truth["north"].to_numpy()[rows]) > 0.5 * np.radians(gait.roll_deg) * short.contact_m[2]


def test_a_stride_has_the_length_the_lift_the_pitch_and_the_impact_of_its_gait(short):
    gait, truth = short.gait, short.truth(0, SEED)
    first = truth[truth.index < short.course.stand_s + gait.stride_s]
    place = contact(short, first)
    np.testing.assert_allclose(place[-1] - place[0], [gait.length_m, 0, 0], atol=1e-4)
    assert place[0, 2] - place[:, 2].min() == pytest.approx(gait.clearance_m, rel=1e-2)
    assert np.degrees(first["pitch"].min()) == pytest.approx(-gait.push_deg, rel=0.05)
    assert np.degrees(first["pitch"].max()) == pytest.approx(gait.strike_deg, rel=0.05)
    calm = replace(short, gait=replace(gait, impact_m_per_s2=0.0))
    apart = (short.ideal(0, SEED) - calm.ideal(0, SEED))[list(ACCEL)]
    assert 0.5 * gait.impact_m_per_s2 < np.linalg.norm(apart, axis=1).max() < 1.5 * gait.impact_m_per_s2
    assert np.abs(short.ideal(0, SEED) - calm.ideal(0, SEED))[list(GYRO)].to_numpy().max() < 1e-9


def test_stairs_rise_and_a_loop_closes(short):
    stairs = replace(short, course=WalkCourse(1.0, (WalkLeg(5, rise_m=0.17),), 1.0), rate_hz=50)
    assert stairs.truth(0, SEED)["down"].iloc[-1] == pytest.approx(-0.85, abs=1e-4)
    loop = replace(short, course=WalkCourse.loop(24), rate_hz=50)
    truth = loop.truth(0, SEED)
    np.testing.assert_allclose(truth[list(POSITION)].iloc[-1].to_numpy(float), 0, atol=1e-6)
    assert np.ptp(truth["north"]) == pytest.approx(24 * short.gait.length_m / np.pi, rel=0.05)
    assert np.degrees(np.unwrap(truth["heading"])[-1]) == pytest.approx(360)


def test_the_drift_at_stance_has_its_size_differs_between_runs_and_is_named_by_the_seed(recipe):
    walk = replace(recipe, course=WalkCourse(1.0, (WalkLeg(100),), 1.0), gait=replace(recipe.gait, drift_m_per_s=0.02))
    walk = replace(walk, rate_hz=50)
    ends = np.array([contact(walk, walk.truth(run, SEED))[-1] for run in range(8)]) - [100 * 1.35, 0, 0]
    ends -= contact(walk, walk.truth(0, SEED))[0]
    std = 0.02 * walk.gait.stride_s * (1 - walk.gait.swing_share) * np.sqrt(100)
    assert 0.6 * std < np.sqrt(np.mean(ends**2)) < 1.4 * std
    np.testing.assert_array_equal(walk.truth(3, SEED), walk.truth(3, SEED))
    assert not np.allclose(walk.truth(3, SEED)["north"], walk.truth(3, SEED + 1)["north"])


def test_the_record_is_the_ideal_with_the_errors_of_the_device(short):
    error = short.record(1, SEED) - short.ideal(1, SEED)
    again = short.record(1, SEED) - short.ideal(1, SEED)
    np.testing.assert_array_equal(error, again)
    stds = error.diff().std() / np.sqrt(2) * np.sqrt(1 / short.rate_hz)
    densities = [next(one.density for one in short.model[axis] if isinstance(one, WhiteNoise)) for axis in AXES]
    np.testing.assert_allclose(stds, densities, rtol=0.1)


def test_a_static_log_is_the_site_with_the_errors_of_the_device(short):
    """Another switch-on than that of the walk: each run has biases of its own about those of the device."""
    logs = [short.static(run, 30, SEED) for run in range(40)]
    error = np.array([one.mean() for one in logs]) - short.site.ideal().to_numpy()
    fixed, turned = (
        np.array([next(getattr(one, name) for one in short.model[axis] if isinstance(one, kind)) for axis in AXES])
        for kind, name in ((Bias, "value"), (TurnOnBias, "std"))
    )
    assert len(logs[0]) == round(30 * short.rate_hz)
    assert (np.abs(error.mean(axis=0) - fixed) < 4 * turned / np.sqrt(40)).all()
    np.testing.assert_allclose(error.std(axis=0, ddof=1), turned, rtol=0.5)


def test_a_usual_stride_has_a_swing_and_a_stance():
    assert Gait().stride_s > Gait().stride_s * Gait().swing_share > 0

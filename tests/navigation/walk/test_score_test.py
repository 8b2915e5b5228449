from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from imugap.effects import Misalignment, ScaleFactor
from imugap.kinematics.strapdown import POSITION
from imugap.model import ErrorModel
from imugap.navigation.walk.pedestrian import PositionAiding, align, innovations, navigate
from imugap.navigation.walk.score_test import BlockScores, block_scores, score_test
from imugap.navigation.walk.stance_innovations import candidate_errors, foot_sinkage
from imugap.simulation.camera_track import closed_loop_aiding
from imugap.simulation.walk import Walk, WalkCourse
from imugap.study.walk.walk_compensation import known_assumptions

ROOT = Path(__file__).parents[3]
SEED = 72
BlockScores.__test__ = False  # no class of tests, whatever its name
SUSPECTS = (*candidate_errors(), foot_sinkage())


@pytest.fixture(scope="module")
def loop():
    walk = Walk.read(ROOT / "data" / "walk.yaml")
    return replace(walk, rate_hz=100, course=WalkCourse.loop(40), gait=replace(walk.gait, drift_m_per_s=0.01))


def number(name, axis, parameter):
    return next(
        i for i, one in enumerate(SUSPECTS) if (one.name, one.axes[0], one.parameter) == (name, axis, parameter)
    )


def scores_of(loop, model, run, aiding=closed_loop_aiding):
    log, assumptions = model.simulate(loop.ideal(run, SEED), SEED, "told", run), known_assumptions(loop)
    solution = navigate(log, loop.model, assumptions)
    return block_scores(log, aiding(solution), SUSPECTS, loop.model, assumptions)


def seen(loop, run):
    """Cameras that see the device twice a second, the true heading and origin included."""
    position = loop.truth(run, SEED)[list(POSITION)].to_numpy(float)
    position[np.arange(len(position)) % 50 != 0] = np.nan
    return PositionAiding(position, 0.01)


def test_positions_are_innovations_too(loop):
    log, aiding, assumptions = loop.record(1, SEED), seen(loop, 1), known_assumptions(loop)
    solution = navigate(log, loop.model, assumptions)
    residual, variance = innovations(align(log, loop.model, assumptions, aiding=aiding))
    assert np.array_equal(np.isfinite(residual[1:, 6]), np.isfinite(aiding.position[1:, 0]))
    own = np.nansum(residual[:, :6] ** 2 / variance[:, :6], axis=1)
    blind = innovations(align(log, loop.model, assumptions))
    alone = np.nansum(blind[0] ** 2 / blind[1], axis=1)
    assert np.allclose(alone[1:][~np.isnan(solution.nis[1:])], solution.nis[1:][~np.isnan(solution.nis[1:])])
    assert not np.allclose(own, alone)


def test_positions_hold_the_walk(loop):
    """With cameras the innovations of position are as large as the filter says, and smaller than the walk's error."""
    aiding, assumptions = seen(loop, 1), known_assumptions(loop)
    log = loop.record(1, SEED)
    residual, variance = innovations(align(log, loop.model, assumptions, aiding=aiding))
    end = navigate(log, loop.model, assumptions).trajectory[list(POSITION)].iloc[-1]
    off = np.linalg.norm(end - loop.truth(1, SEED)[list(POSITION)].iloc[-1])
    assert np.linalg.norm(residual[np.flatnonzero(np.isfinite(residual[:, 6]))[-1], 6:9]) < off
    assert np.nanmean(residual[:, 6:9] ** 2 / variance[:, 6:9]) < 3


HIDDEN = [
    ("misalignment", "accel_x", "z", Misalignment(z=0.02)),
    ("scale_factor", "gyro_y", "error", ScaleFactor(error=0.01)),
    ("misalignment", "gyro_z", "x", Misalignment(x=0.01)),
]


@pytest.fixture(scope="module")
def plain(loop):
    return scores_of(loop, loop.model, 1) + scores_of(loop, loop.model, 2) + scores_of(loop, loop.model, 3)


@pytest.mark.slow
@pytest.mark.parametrize(("name", "axis", "parameter", "effect"), HIDDEN)
def test_an_effect_on_all_walks_is_named_and_its_size_is_right(loop, plain, name, axis, parameter, effect):
    """What a filter does not know of the gait is in the sizes with and without the effect, and not in the gap."""
    device = ErrorModel(dict(loop.model.axes) | {axis: loop.model[axis] + effect})
    hidden = number(name, axis, parameter)
    said = scores_of(loop, device, 1) + scores_of(loop, device, 2) + scores_of(loop, device, 3)
    verdict = score_test(said, 0.01, np.random.default_rng(1))
    assert hidden in [found.number for found in verdict.named]
    difference = said.of([hidden]).sizes()[0][0] - plain.of([hidden]).sizes()[0][0]
    assert difference == pytest.approx(getattr(effect, parameter), rel=0.15)


@pytest.mark.slow
def test_a_device_as_its_model_has_it_gets_no_name(plain):
    assert not score_test(plain, 0.01, np.random.default_rng(1)).named


@pytest.mark.slow
def test_cameras_know_the_turn_of_a_stride_better_than_the_return_to_the_begin(loop):
    """Over four walks, by the true errors and by the stated ones."""
    turning = ErrorModel(dict(loop.model.axes) | {"gyro_z": loop.model["gyro_z"] + Misalignment(x=0.01)})
    hidden = [number("misalignment", "gyro_z", "x")]
    found = {"closing": [], "cameras": []}
    for run in (1, 2, 3, 4):
        for name, aiding in (("closing", closed_loop_aiding), ("cameras", lambda _, run=run: seen(loop, run))):
            found[name].append(np.ravel(scores_of(loop, turning, run, aiding).of(hidden).sizes()))
    error, std = ({name: np.array(one)[:, part] for name, one in found.items()} for part in (0, 1))
    off = {name: np.sqrt(np.mean((one - 0.01) ** 2)) for name, one in error.items()}
    assert off["cameras"] < 0.5 * off["closing"]
    assert np.median(std["cameras"]) < np.median(std["closing"])
    for name, stated in std.items():
        assert (np.abs(error[name] - 0.01) < 4 * stated).all()
        assert 0.4 < np.sqrt(np.mean(((error[name] - 0.01) / stated) ** 2)) < 2.5


def test_the_weights_are_those_of_the_original_log(loop):
    """The innovations are linear in a small error: half of it moves them half as far."""
    log, assumptions = loop.record(1, SEED), known_assumptions(loop)
    aligned = align(log, loop.model, assumptions)
    plain, _ = innovations(aligned)
    scaled = SUSPECTS[number("scale_factor", "gyro_y", "error")].model.simulate(log, 0) - log
    whole, half = (plain - innovations(aligned.with_samples(log - share * scaled))[0] for share in (1.0, 0.5))
    known = np.isfinite(plain)
    assert np.linalg.norm((whole - 2 * half)[known]) < 0.02 * np.linalg.norm(whole[known])


def noise(rng, blocks=24, count=10, effect=None, size=0.0):
    """Testimony of candidate_errors that are alike in pairs, with scatter that no filter knows; one may be there."""
    score, information = [], []
    for _ in range(blocks):
        slope = rng.standard_normal((40, count))
        slope[:, 1::2] = slope[:, ::2] + 0.5 * slope[:, 1::2]
        first = 3 * rng.standard_normal(40) * rng.exponential() + (size * slope[:, effect] if effect is not None else 0)
        score.append(slope.T @ first)
        information.append((slope**2).sum(axis=0))
    return BlockScores(np.array(score), np.array(information))


def test_nothing_is_named_more_often_than_the_level_allows():
    """Two-sided: 200 questions at 10 %, scatter unknown to the filter and candidate_errors alike."""
    rng = np.random.default_rng(7)
    wrong = sum(bool(score_test(noise(rng), 0.1, rng).named) for _ in range(200))
    assert 7 <= wrong <= 34  # 20 +- 3.2 standard deviations


def test_few_blocks_are_no_evidence():
    """With five blocks no draw of signs is rarer than one in sixteen: nothing can be named at a hundredth."""
    rng = np.random.default_rng(11)
    verdict = score_test(noise(rng, blocks=5, effect=4, size=30.0), 0.01, rng)
    assert not verdict.named
    assert verdict.p_value > 1 / 17


def test_sizes_lie_in_their_intervals():
    rng, inside = np.random.default_rng(8), 0
    for _ in range(300):
        size, std = noise(rng, effect=4, size=0.5).of([4]).sizes()
        inside += abs(size[0] - 0.5) < 2.07 * std[0]
    assert 0.87 < inside / 300 < 0.985


def test_one_block_that_outweighs_the_others_does_not_make_a_size_certain():
    """The jackknife holds the size as often as it says; the scatter about the size itself would not."""
    rng, inside = np.random.default_rng(12), 0
    for _ in range(400):
        information = np.append(np.full(11, 1.0), 20.0)
        score = 0.5 * information + 3 * np.sqrt(information) * rng.standard_normal(12)
        size, std = BlockScores(score[:, None], information[:, None]).sizes()
        inside += abs(size[0] - 0.5) < 2.2 * std[0]
    assert 0.9 < inside / 400 < 0.99


def test_what_is_there_is_named_first_and_what_is_alike_is_told():
    rng = np.random.default_rng(9)
    verdict = score_test(noise(rng, effect=4, size=3.0), 0.01, rng)
    one = verdict.named[0]
    assert one.number == verdict.most_significant == 4
    assert one.low < 3.0 < one.high
    weak = [score_test(noise(rng, effect=4, size=0.7), 0.05, rng).named for _ in range(20)]
    assert any({4, 5} <= {one.number for one in named} for named in weak)
    assert score_test(noise(rng, effect=4, size=3.0), 0.01, rng, among=[0, 1]).most_significant in (0, 1)


def test_walks_add_up():
    rng = np.random.default_rng(10)
    first, second = noise(rng), noise(rng)
    both = first + second
    assert len(both.score) == len(first.score) + len(second.score)
    assert np.allclose(both.sizes()[0], both.score.sum(axis=0) / both.information.sum(axis=0))
    signs = np.ones((1, len(both.score)))
    assert np.allclose(both.sizes(signs), np.array(both.sizes())[:, None])

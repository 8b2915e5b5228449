"""Scores of models on a run that they have not seen."""

import numpy as np
import pytest

from imugap import log
from imugap.discovery.evaluation.distance import HeldOutComparison
from imugap.discovery.preparation.prepare import prepare
from imugap.effects import RandomWalk, StabilityRestoration, WhiteNoise
from imugap.effects.effect import AxisModel
from imugap.kinematics.site import Site
from imugap.model import ErrorModel
from imugap.study.discovery.unseen_runs import log_scores, scores, width

TRUE = (WhiteNoise(1e-3), RandomWalk(1e-4))
SCALED = (WhiteNoise(4e-3), StabilityRestoration(1e-3, 1.0))


def model(*effects, axes=("gyro_x",)):
    return ErrorModel({axis: AxisModel(effects) for axis in axes})


def run(of, count=4000, axes=("gyro_x",), level=0.0):
    still = log.from_samples({axis: np.full(count, level) for axis in axes}, 0.1)
    return of.simulate(still, 3, "unseen")


@pytest.mark.parametrize("effects", [TRUE, SCALED], ids=["noise", "scaled"])
def test_no_other_size_scores_higher_than_the_true_one(effects):
    """Restoration scales white noise: its score is that of the noise that it makes."""
    sequences = prepare(run(model(*effects), count=40_000)).sequences
    (true,) = log_scores(model(*effects), sequences).values()
    for factor in (0.5, 0.9, 1.1, 2.0):
        white = WhiteNoise(1e-3 * factor)
        (other,) = log_scores(model(white, *effects[1:] if effects is TRUE else ()), sequences).values()
        assert other < true


def test_a_wide_model_is_near_and_scores_worse():
    """The drift of a model of much more noise is scored worse, and its band is wider."""
    axes, still = log.AXES, np.array([0, 0, 0, 0, 0, -Site(np.pi / 4, 0.0).gravity])
    truth = model(*TRUE, axes=axes)
    ideal = log.from_samples(dict(zip(axes, np.tile(still, (3000, 1)).T, strict=True)), 0.1)
    compared = HeldOutComparison(truth.simulate(ideal, 3, "drift"), 60.0, truth, truth)
    wide = model(WhiteNoise(1e-3), RandomWalk(1e-3), axes=axes)
    own, other = (scores(compared, one, 1, 40) for one in (truth, wide))
    assert own["distance"] < own["floor"] * 1.5
    (horizon,) = [name for name in own if name.startswith("drift")][-1:]
    assert own[horizon] < other[horizon]


def test_the_width_is_the_ratio_of_the_ends_of_the_band():
    truth = model(*TRUE)
    compared = HeldOutComparison(run(truth), 80.0, truth, truth)
    ensemble = compared.simulate("after", 1, range(60))
    doubled = compared.simulate("after", 2, range(60))
    assert 1 < width(ensemble) < 3
    assert width(ensemble) == pytest.approx(width(doubled), rel=0.1)

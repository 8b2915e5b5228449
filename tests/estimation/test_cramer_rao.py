from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from tests.estimation.simulated import INTERVAL, MODELS, contrasts, covariance, models, ramps, simulate

from imugap.effects import GaussMarkov, RandomWalk, WhiteNoise
from imugap.estimation.cramer_rao import bound, fisher
from imugap.estimation.likelihood import Cosines, Grid, parameters, value_and_gradient

REFERENCE = pd.read_csv(Path(__file__).parents[1] / "reference" / "cramer_rao.csv", comment="#")


@models
@ramps
def test_information_is_the_trace_formula_of_the_dense_covariance(model, ramp):
    count, step = 80, 1e-5
    composition, theta = parameters(model)
    basis, grid = contrasts(count, ramp), Grid.of(count, INTERVAL)

    def projected(point):
        return basis.T @ covariance(composition.model(point), count) @ basis

    steps = step * np.eye(len(theta))
    inverse = np.linalg.inv(projected(theta))
    relative = [inverse @ (projected(theta + h) - projected(theta - h)) / (2 * step) for h in steps]
    expected = np.einsum("iab,jba->ij", relative, relative) / 2
    information = fisher(theta, composition.shapes(grid), grid, ramp)
    np.testing.assert_allclose(information, expected, atol=1e-6 * np.abs(expected).max())


@pytest.mark.slow
def test_information_is_the_covariance_of_the_gradient():
    model, runs = MODELS["white and gauss-markov"] + RandomWalk(0.1), 2000
    composition, theta = parameters(model)
    grid = Grid.of(400, INTERVAL)
    shapes = composition.shapes(grid)
    logs = [Cosines.of(simulate(model, 400, "score", run), INTERVAL) for run in range(runs)]
    scores = np.array([value_and_gradient(theta, shapes, cosines)[1] for cosines in logs])
    white = np.linalg.solve(np.linalg.cholesky(fisher(theta, shapes, grid)), scores.T)
    assert np.abs(white.mean(axis=1)).max() < 4 / np.sqrt(runs)
    assert np.abs(np.cov(white) - np.eye(len(theta))).max() < 6 / np.sqrt(runs)


@pytest.mark.parametrize(("time", "walk"), REFERENCE[["correlation_time", "walk"]].drop_duplicates().to_numpy())
def test_bound_is_that_of_the_reference(time, walk):
    model = WhiteNoise(5e-3) + GaussMarkov(1 / 180, time)
    model = model + RandomWalk(1 / 21600) if walk else model
    found = bound(model, 0.1, 108_000)
    for row in REFERENCE[(REFERENCE["correlation_time"] == time) & (REFERENCE["walk"] == walk)].itertuples():
        assert found[row.effect, 1, row.parameter] == pytest.approx(row.bound, rel=0.015)


def test_longer_logs_tell_more_and_white_noise_as_much_as_its_samples():
    model = WhiteNoise(0.3) + GaussMarkov(0.5, 20.0)
    bounds = pd.DataFrame({count: bound(model, INTERVAL, count) for count in (1000, 4000, 16_000, 64_000)})
    assert (bounds.diff(axis=1).iloc[:, 1:] < 0).all().all()
    alone = bound(MODELS["white"], INTERVAL, 5001)
    assert alone.item() == pytest.approx(1 / np.sqrt(2 * 5000))


def test_unknown_ramp_costs_information():
    model = WhiteNoise(0.3) + RandomWalk(0.02)
    assert (bound(model, INTERVAL, 5000, ramp=True) > bound(model, INTERVAL, 5000)).all()

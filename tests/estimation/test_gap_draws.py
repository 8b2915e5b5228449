import numpy as np
import pytest

from imugap.effects import Conditions, GaussMarkov, RandomWalk, WhiteNoise
from imugap.effects.effect import AxisModel
from imugap.estimation.gap_draws import draw_gaps, drawn, with_gaps_drawn
from imugap.estimation.maximum_likelihood import fit
from imugap.estimation.screening import screen
from imugap.stream import stream

COUNT, INTERVAL = 3000, 0.1


def simulate(of, *labels, count=COUNT):
    return of.simulate(np.zeros(count), Conditions(np.arange(count) * INTERVAL, INTERVAL), 51, *labels)


def test_draws_have_the_conditional_mean_and_variance():
    """Of a walk between two noisy ends: a bridge, whose variance is largest in the middle."""
    model, count = WhiteNoise(1e-3) + RandomWalk(0.1), 101
    values, missing = np.linspace(0.0, 1.0, count), np.zeros(count, bool)
    missing[1:-1] = True
    draws = np.array([drawn(model, values, missing, INTERVAL, stream(1, "bridge", run)) for run in range(400)])
    time = INTERVAL * np.arange(1, count - 1)
    variance = 0.1**2 * time * (10 - time) / 10 + 1e-6 / INTERVAL
    np.testing.assert_allclose(draws[:, 1:-1].mean(axis=0), values[1:-1], atol=4 * np.sqrt(variance.max() / 400))
    assert np.mean(draws[:, 1:-1].var(axis=0) / variance) == pytest.approx(1, abs=0.1)
    np.testing.assert_array_equal(draws[:, [0, -1]], np.tile(values[[0, -1]], (400, 1)))


@pytest.mark.parametrize(
    "of",
    [AxisModel((WhiteNoise(1e-2),)), WhiteNoise(1e-2) + RandomWalk(1e-2), WhiteNoise(1e-2) + GaussMarkov(3e-2, 10)],
)
def test_estimates_from_a_log_with_a_gap_are_unbiased(of):
    """Of a third of the log; the tolerance is four standard errors of 12 runs, 0.3 each at most."""
    kinds, ratios = tuple(map(type, of)), []
    for run in range(12):
        values, missing = simulate(of, "gap", run), np.zeros(COUNT, bool)
        missing[1000:1900] = True
        filled = draw_gaps(np.where(missing, 0.0, values), missing, INTERVAL, stream(2, "gap", run))
        np.testing.assert_array_equal(filled[~missing], values[~missing])
        found = fit(filled, INTERVAL, kinds, share=0.7).model
        truth, estimates = ([v for effect in model for v in effect.parameters().values()] for model in (of, found))
        ratios.append(np.divide(estimates, truth))
    logs = np.log(np.maximum(ratios, 1e-3))
    assert (np.abs(logs.mean(axis=0)) < 4 * logs.std(axis=0, ddof=1) / np.sqrt(12) + 0.01).all()
    assert logs[:, 0].std() < 0.05


def test_short_gaps_stay_as_they_are():
    values = simulate(AxisModel((WhiteNoise(1.0),)), "short")
    values[500] = 1e4
    screened = screen(values, stream(3, "short"))
    assert screened.replaced.any()
    np.testing.assert_array_equal(with_gaps_drawn(screened, INTERVAL, stream(4, "short")), screened.values)

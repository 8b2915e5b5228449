import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from imugap.effects import Bias, GaussMarkov, RandomWalk, TurnOnBias, WhiteNoise
from imugap.effects.effect import AxisModel
from imugap.interchange.augmentation import Chain, augmentation, residual

FREQUENCY = np.logspace(-4, 1, 20)
densities = st.floats(1e-3, 10.0)
intervals = st.floats(1e-2, 2.0)


def test_white_noise_and_a_known_bias_add_no_state():
    model = augmentation(WhiteNoise(0.3) + Bias(2.0))
    assert model.output.shape == (0,)
    assert model.output_psd == pytest.approx(0.09)


@given(densities, densities)
def test_a_turn_on_bias_is_a_state_that_nothing_drives(density, std):
    model = augmentation(WhiteNoise(density) + TurnOnBias(std))
    transition, noise = model.discretise(3.0)
    assert transition == pytest.approx(1.0)
    assert noise == pytest.approx(0.0)
    assert model.initial_covariance[0, 0] == pytest.approx(std**2)


@pytest.mark.parametrize("order", [1, -1])
def test_turn_on_bias_and_random_walk_share_a_state_wherever_they_stand(order):
    effects = (GaussMarkov(0.5, 20.0), RandomWalk(0.1), TurnOnBias(2.0), WhiteNoise(0.3))[::order]
    model = augmentation(AxisModel(effects))
    assert len(model.output) == 2
    assert sorted(np.diag(model.initial_covariance)) == pytest.approx([0.25, 4.0])
    np.testing.assert_allclose(model.psd(FREQUENCY), AxisModel(effects).psd(FREQUENCY), rtol=1e-12)


@given(densities, densities, intervals)
def test_integrals_of_white_noise_and_of_a_walk_have_their_closed_forms(density, walk, interval):
    """The n-fold integral of white noise of density N has N^2 t^(2n - 1)/((2n - 1) (n - 1)!^2)."""
    chain = Chain.of([augmentation(AxisModel((WhiteNoise(density),))), RandomWalk(walk).state_space()], interval)
    white = [density**2 * interval ** (2 * n - 1) / ((2 * n - 1) * f**2) for n, f in ((1, 1), (2, 1), (3, 2))]
    walked = [walk**2 * interval ** (2 * n - 1) / ((2 * n - 1) * f**2) for n, f in ((2, 1), (3, 2), (4, 6))]
    variance = np.diag(chain.noise)
    rounding = 1e-14 * variance.max()  # of a matrix exponential: some tens of eps of its largest entry
    np.testing.assert_allclose(variance[[4, 2, 0]], white, rtol=1e-9, atol=rounding)
    np.testing.assert_allclose(variance[[5, 3, 1]], walked, rtol=1e-9, atol=rounding)
    assert variance[6] == pytest.approx(walk**2 * interval, rel=1e-9)


@given(intervals)
def test_two_half_steps_of_a_chain_are_one_step(interval):
    sensors = [(WhiteNoise(0.3) + GaussMarkov(1.0, 0.7)).state_space(), RandomWalk(0.2).state_space()]
    half, whole = Chain.of(sensors, interval / 2), Chain.of(sensors, interval)
    np.testing.assert_allclose(half.transition @ half.transition, whole.transition, atol=1e-10)
    twice = half.transition @ half.noise @ half.transition.T + half.noise
    np.testing.assert_allclose(twice, whole.noise, atol=1e-10 * np.abs(whole.noise).max())


def test_residual_without_an_update_is_the_error_itself():
    """The filter's estimates start at zero and stay there, so what it leaves is all there is."""
    truth, modelled = (WhiteNoise(0.3) + RandomWalk(0.1)).state_space(), GaussMarkov(0.5, 20.0).state_space()
    left = residual(truth, modelled)
    np.testing.assert_allclose(left.psd(FREQUENCY), truth.psd(FREQUENCY), rtol=1e-12)
    assert not left.initial_covariance[1:, 1:].any()


@given(st.floats(-3, 3), st.floats(1e-2, 5.0))
def test_a_perfect_estimate_leaves_nothing_but_noise(state, interval):
    model = (WhiteNoise(0.3) + GaussMarkov(0.5, 20.0)).state_space()
    left = residual(model, model)
    transition, _ = left.discretise(interval)
    assert left.output @ transition @ np.array([state, state]) == pytest.approx(0.0, abs=1e-12)

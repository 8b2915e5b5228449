import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import chi2
from tests.chance import mean_is

from imugap.effects import BiasInstability, Conditions, GaussMarkov, RandomWalk, WhiteNoise
from imugap.estimation.variances import allan
from imugap.numerics.state_space import StateSpace
from imugap.stream import stream

EFFECTS = (WhiteNoise(0.3), RandomWalk(0.2), GaussMarkov(0.7, 0.2), GaussMarkov(0.5, 30.0))
FREQUENCY = np.logspace(-4, 2, 25)
intervals = st.floats(1e-3, 2.0)


def damped(*labels, states=3):
    """A stable coupled system that no effect of the catalogue makes."""
    rng = stream(21, *labels)
    mixing, driving = rng.standard_normal((2, states, states))
    dynamics = mixing - mixing.T - np.diag(rng.uniform(0.2, 2, states))
    return StateSpace(dynamics, driving @ driving.T, rng.standard_normal(states), 0.1, np.zeros((states, states)))


def stationary(decay_time, std, interval):
    transition, covariance = GaussMarkov(std, decay_time).state_space().discretise(interval)
    return transition @ np.array([[std**2]]) @ transition.T + covariance


@given(st.floats(0.05, 1e4), st.floats(1e-6, 1e3), intervals)
def test_stationary_covariance_solves_the_lyapunov_identity(decay_time, std, interval):
    assert stationary(decay_time, std, interval)[0, 0] == pytest.approx(std**2, rel=1e-9)


@given(st.integers(0, 1000), intervals)
def test_stationary_covariance_of_a_coupled_system_solves_both_lyapunov_identities(label, interval):
    model = damped(label)
    rate = np.kron(model.dynamics, np.eye(3)) + np.kron(np.eye(3), model.dynamics)
    continuous = np.linalg.solve(rate, -model.process_psd.ravel()).reshape(3, 3)
    transition, covariance = model.discretise(interval)
    propagated = transition @ continuous @ transition.T + covariance
    np.testing.assert_allclose(propagated, continuous, atol=1e-9 * np.abs(continuous).max())


@given(st.integers(0, 1000), intervals)
def test_two_half_steps_are_one_step(label, interval):
    model = damped(label)
    whole, noise = model.discretise(interval)
    half, half_noise = model.discretise(interval / 2)
    np.testing.assert_allclose(half @ half, whole, atol=1e-10)
    scale = np.abs(noise).max()
    np.testing.assert_allclose(half @ half_noise @ half.T + half_noise, noise, atol=1e-10 * scale)


@given(st.integers(0, 1000))
def test_process_noise_is_a_covariance(label):
    noise = damped(label).discretise(0.1)[1]
    np.testing.assert_array_equal(noise, noise.T)
    assert np.linalg.eigvalsh(noise).min() > -1e-12


def test_integrator_keeps_its_state_and_gains_the_driving_density_each_second():
    transition, covariance = RandomWalk(0.2).state_space().discretise(0.25)
    assert transition == pytest.approx(1.0, abs=1e-15)
    assert covariance == pytest.approx(0.04 * 0.25, rel=1e-12)


def test_a_state_much_faster_than_the_interval_forgets_all():
    assert stationary(1e-3, 1.0, 1.0)[0, 0] == pytest.approx(1.0, rel=1e-9)


@pytest.mark.parametrize("effect", EFFECTS, ids=lambda effect: effect.name)
def test_spectrum_is_that_of_the_effect(effect):
    np.testing.assert_allclose(effect.state_space().psd(FREQUENCY), effect.psd(FREQUENCY), rtol=1e-10)


def test_spectrum_of_a_sum_is_the_sum_of_the_spectra():
    total = sum((effect.state_space() for effect in EFFECTS), StateSpace.white(0.0))
    np.testing.assert_allclose(total.psd(FREQUENCY), sum(effect.psd(FREQUENCY) for effect in EFFECTS), rtol=1e-10)


def test_spectrum_of_two_coupled_states_is_that_of_the_oscillator():
    natural, damping = 3.0, 0.4
    model = StateSpace(
        np.array([[0.0, 1.0], [-(natural**2), -damping]]), np.diag([0.0, 2.0]), np.array([1.0, 0.0]), 0.0, np.eye(2)
    )
    omega = 2 * np.pi * FREQUENCY
    expected = 2.0 / np.abs(natural**2 - omega**2 + 1j * omega * damping) ** 2
    np.testing.assert_allclose(model.psd(FREQUENCY), expected, rtol=1e-10)


@pytest.mark.parametrize("shape", [(), (3,), (2, 3)])
def test_spectrum_has_the_shape_of_the_frequency(shape):
    for model in (WhiteNoise(2.0).state_space(), GaussMarkov(1.0, 2.0).state_space()):
        assert np.shape(model.psd(np.full(shape, 0.5))) == shape


@pytest.mark.slow
def test_simulated_sum_has_the_allan_variance_of_the_effects():
    effects, averaging, interval = EFFECTS[:3], np.array([16, 64, 250]), 0.01
    model = sum((effect.state_space() for effect in effects), StateSpace.white(0.0))
    found = [allan.variance(model.simulate(4000, interval, stream(22, "sum", run)), averaging) for run in range(300)]
    assert mean_is(found, sum(effect.allan_variance(averaging * interval) for effect in effects), share=0.03)


@pytest.mark.slow
@pytest.mark.parametrize("effect", EFFECTS, ids=lambda effect: effect.name)
def test_simulation_and_effect_have_the_same_law_at_a_lag(effect):
    runs, lag, interval = 1000, 30, 0.01
    at, model = Conditions(interval * np.arange(lag + 1), interval), effect.state_space()
    state = [model.simulate(lag + 1, interval, stream(23, effect, "state", run)) for run in range(runs)]
    sample = [effect.sample(at, stream(23, effect, "sample", run)) for run in range(runs)]
    variances = [np.var([sequence[-1] - sequence[0] for sequence in kind]) for kind in (state, sample)]
    assert abs(np.log(variances[0] / variances[1])) < 4 * np.sqrt(2 * 2 / runs)


def test_simulation_starts_with_its_initial_covariance():
    model, runs = GaussMarkov(0.7, 5.0).state_space(), 3000
    first = np.array([model.simulate(1, 0.01, stream(24, run))[0] for run in range(runs)])
    low, high = chi2.ppf([5e-5, 1 - 5e-5], runs)
    assert low < np.sum(first**2) / 0.49 < high


def test_random_walk_starts_alike_in_state_space_and_as_effect():
    at, effect = Conditions(np.zeros(1), 0.01), RandomWalk(1.0)
    drawn = np.var([effect.sample(at, stream(25, run))[0] for run in range(500)])
    state = np.var([effect.state_space().simulate(1, 0.01, stream(25, run))[0] for run in range(500)])
    assert drawn == pytest.approx(state, rel=0.3)


def test_flicker_without_a_state_space_says_so():
    with pytest.raises(ValueError, match="bias_instability"):
        BiasInstability(1.0).state_space()

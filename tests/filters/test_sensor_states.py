import numpy as np
import pytest

from imugap.effects import (
    Bias,
    BiasInstability,
    GaussMarkov,
    PowerLaw,
    Quantization,
    RandomWalk,
    TurnOnBias,
    WhiteNoise,
)
from imugap.effects.effect import AxisModel
from imugap.filters.sensor_states import FLICKER_S, FLICKER_STATES, SensorStates
from imugap.model import ErrorModel


def test_each_process_is_a_state_of_its_axis_and_the_numbers_are_those_of_the_model():
    model = ErrorModel(
        {
            "gyro_y": AxisModel((WhiteNoise(0.1), RandomWalk(0.2), TurnOnBias(3.0), Bias(0.5))),
            "accel_z": AxisModel((GaussMarkov(2.0, 50.0), GaussMarkov(1.0, 5.0), WhiteNoise(0.3), WhiteNoise(0.4))),
            "time": AxisModel(),
        }
    )
    states = SensorStates.of(model)
    assert len(states) == 3
    assert states.names == ["gyro_y", "accel_z", "accel_z_2"]
    np.testing.assert_allclose(states.decay, [0, 1 / 50, 1 / 5])
    np.testing.assert_allclose(states.driving_psd, [0.04, 2 * 4 / 50, 2 / 5])
    np.testing.assert_allclose(states.variance, [9, 4, 1])
    np.testing.assert_allclose(states.white, [0, 0.01, 0, 0, 0, 0.25])
    np.testing.assert_allclose(states.fixed, [0, 0.5, 0, 0, 0, 0])


def test_scale_factors_are_states_where_they_are_asked_for():
    model = ErrorModel({"gyro_x": AxisModel((TurnOnBias(1.0),))})
    states = SensorStates.of(model, scale_std=(0.0, 0.02))
    assert states.names == ["gyro_x", "accel_x_scale", "accel_y_scale", "accel_z_scale"]
    np.testing.assert_array_equal(states.scale, [False, True, True, True])
    np.testing.assert_allclose(states.variance, [1, 4e-4, 4e-4, 4e-4])


def test_a_model_without_states_leaves_none():
    states = SensorStates.of(ErrorModel({"gyro_x": AxisModel((WhiteNoise(0.1), Quantization(0.1)))}))
    assert len(states) == 0


def test_flicker_noise_has_the_allan_deviation_that_it_should_over_the_range_that_is_stated():
    states = SensorStates.of(ErrorModel({"accel_x": AxisModel((BiasInstability(0.7),))}))
    assert len(states) == FLICKER_STATES
    tau = np.geomspace(*FLICKER_S, 30)
    bank = AxisModel(tuple(GaussMarkov(np.sqrt(v), 1 / d) for v, d in zip(states.variance, states.decay, strict=True)))
    ratio = np.sqrt(bank.allan_variance(tau) / BiasInstability(0.7).allan_variance(tau))
    assert np.abs(ratio - 1).max() < 0.04
    assert np.abs(ratio - 1).max() > 0.01
    np.testing.assert_allclose(states.driving_psd, 2 * states.variance * states.decay)


@pytest.mark.parametrize("correlation", [200.0, np.inf])
def test_scale_factors_keep_their_variance_whatever_their_correlation_time(correlation):
    """Gauss-Markov: what decays is driven back; a constant has neither."""
    states = SensorStates.of(ErrorModel({}), (1e-3, 2e-3), correlation)
    assert states.scale.all()
    np.testing.assert_allclose(states.variance, np.repeat([1e-6, 4e-6], 3))
    np.testing.assert_allclose(states.decay, 1 / correlation)
    np.testing.assert_allclose(states.driving_psd, 2 * states.decay * states.variance)


@pytest.mark.parametrize(("exponent", "like"), [(1.0, BiasInstability(0.7)), (2.0, RandomWalk(0.7))])
def test_noise_of_the_slope_of_a_name_has_the_states_of_that(exponent, like):
    """In other cases the nearer one, of the same Allan variance in the middle of the range."""
    found, expected = (
        SensorStates.of(ErrorModel({"accel_x": AxisModel((one,))})) for one in (PowerLaw(0.7, exponent), like)
    )
    for name in ("decay", "driving_psd", "variance"):
        np.testing.assert_allclose(getattr(found, name), getattr(expected, name), rtol=1e-6)


@pytest.mark.parametrize(("exponent", "states"), [(1.3, FLICKER_STATES), (1.7, 1)])
def test_noise_of_any_slope_has_states(exponent, states):
    assert len(SensorStates.of(ErrorModel({"accel_x": AxisModel((PowerLaw(0.7, exponent),))}))) == states

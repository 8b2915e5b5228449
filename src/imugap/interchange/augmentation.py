"""State augmentation: the states of a filter for the errors of its sensors (Farrell et al. 2022, eq. 5)."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import block_diag

from imugap.effects import TurnOnBias
from imugap.effects.effect import AxisModel
from imugap.numerics.state_space import StateSpace


def augmentation(model: AxisModel) -> StateSpace:
    """Return the states of one axis: those of its random processes and a constant one for its turn-on bias.

    A random walk and an unknown constant bias are not separately observable: where the model has both, they share a
    state. The fixed bias is taken as compensated; effects of the signal chain are not modelled.
    """
    random = model.state_space()
    variance = sum(effect.std**2 for effect in model if isinstance(effect, TurnOnBias))
    if not variance:
        return random
    integrators = np.flatnonzero(~random.dynamics.any(axis=1))
    if not len(integrators):
        return random + StateSpace.first_order(decay=0.0, driving_psd=0.0, variance=variance)
    start = random.initial_covariance.copy()
    start[integrators[0], integrators[0]] += variance
    return replace(random, initial_covariance=start)


def residual(truth: StateSpace, modelled: StateSpace) -> StateSpace:
    """Return the residual error of a sensor of model ``truth`` compensated by a filter of model ``modelled``.

    The states are those of the truth, then the filter's estimates, which move between updates as the filter predicts
    them: without noise, from zero. It is the dual state of a suboptimal filter (Maybeck 1979, sec. 6.8).
    """
    still = np.zeros_like(modelled.process_psd)
    estimate = StateSpace(modelled.dynamics, still, -modelled.output, 0.0, still)
    return truth + estimate


@dataclass(frozen=True, eq=False)
class Chain:
    """Sensor errors and their first three integrals over one interval, exactly discretised.

    The states are the third, the second and the first integral of each sensor's error, then the states of the sensors.

    Attributes
    ----------
    transition, noise
        Phi and Qd over the interval, shape (3 sensors + states, 3 sensors + states).
    output
        Error of each sensor from the states, shape (sensors, states).
    initial_covariance
        Covariance of the states at power-on, shape (states, states).
    """

    transition: np.ndarray
    noise: np.ndarray
    output: np.ndarray
    initial_covariance: np.ndarray

    @classmethod
    def of(cls, sensors: Sequence[StateSpace], interval: float) -> "Chain":
        """Discretise the sensors side by side over ``interval`` [s] (Van Loan 1978)."""
        count, states = len(sensors), sum(len(one.output) for one in sensors)
        output = block_diag(*(one.output[None] for one in sensors))
        dynamics, psd = np.zeros((2, 3 * count + states, 3 * count + states))
        dynamics[: 2 * count, count : 3 * count] = np.eye(2 * count)
        dynamics[2 * count : 3 * count, 3 * count :] = output
        dynamics[3 * count :, 3 * count :] = block_diag(*(one.dynamics for one in sensors))
        psd[2 * count : 3 * count, 2 * count : 3 * count] = np.diag([one.output_psd for one in sensors])
        psd[3 * count :, 3 * count :] = block_diag(*(one.process_psd for one in sensors))
        start = np.zeros_like(dynamics)
        transition, noise = StateSpace(dynamics, psd, np.zeros(len(dynamics)), 0.0, start).discretise(interval)
        initial = block_diag(*(one.initial_covariance for one in sensors))
        return cls(transition, noise, output, initial)

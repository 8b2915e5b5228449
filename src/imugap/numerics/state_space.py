"""Continuous-time linear models driven by white noise, their exact discretisation, spectrum and simulation."""

from dataclasses import dataclass
from math import ceil, log2

import numpy as np
from numba import njit
from scipy.linalg import block_diag, expm


@dataclass(frozen=True, eq=False)
class StateSpace:
    """The model zdot = A z + w_z, y = C z + w_y (Farrell et al. 2022, eqs. 20-21).

    Attributes
    ----------
    dynamics
        A, shape (s, s).
    process_psd
        Two-sided PSD of w_z, shape (s, s).
    output
        C, shape (s,).
    output_psd
        Two-sided PSD of w_y.
    initial_covariance
        Covariance of z at power-on, shape (s, s); its mean is zero.
    """

    dynamics: np.ndarray
    process_psd: np.ndarray
    output: np.ndarray
    output_psd: float
    initial_covariance: np.ndarray

    @classmethod
    def white(cls, psd: float) -> "StateSpace":
        """Return white noise: no state."""
        empty = np.zeros((0, 0))
        return cls(empty, empty, np.zeros(0), psd, empty)

    @classmethod
    def first_order(cls, decay: float, driving_psd: float, variance: float) -> "StateSpace":
        """Return one state zdot = -decay z + w that starts with ``variance``."""
        return cls(np.array([[-decay]]), np.array([[driving_psd]]), np.ones(1), 0.0, np.array([[variance]]))

    def __add__(self, other: "StateSpace") -> "StateSpace":
        """Return the model of the sum of two independent processes."""
        return StateSpace(
            block_diag(self.dynamics, other.dynamics),
            block_diag(self.process_psd, other.process_psd),
            np.concatenate([self.output, other.output]),
            self.output_psd + other.output_psd,
            block_diag(self.initial_covariance, other.initial_covariance),
        )

    def psd(self, frequency: np.ndarray) -> np.ndarray:
        """Return the two-sided PSD of y [unit^2/Hz] at ``frequency`` [Hz]: C (jw - A)^-1 S (jw - A)^-H C' + S_y."""
        omega = 2 * np.pi * np.asarray(frequency, float)[..., None, None]
        transposed = 1j * omega * np.eye(len(self.output)) - self.dynamics.T
        output = np.broadcast_to(self.output[:, None], (*transposed.shape[:-1], 1))
        gain = np.linalg.solve(transposed, output)[..., 0]
        return np.einsum("...i,ij,...j->...", gain, self.process_psd, gain.conj()).real + self.output_psd

    def discretise(self, interval: float) -> tuple[np.ndarray, np.ndarray]:
        """Return (Phi, Qd) over ``interval`` [s], exactly (Van Loan 1978, eqs. 2.8-2.10).

        The exponential grows with interval x dynamics: it is taken over a fraction 2^-k of the interval and doubled.
        """
        states = len(self.output)
        doublings = max(0, ceil(log2(max(np.abs(self.dynamics).sum(initial=0.0) * interval, 1.0))))
        block = np.zeros((2 * states, 2 * states))
        block[:states, :states] = -self.dynamics
        block[:states, states:] = self.process_psd
        block[states:, states:] = self.dynamics.T
        exponential = expm(block * interval / 2**doublings)
        transition = np.ascontiguousarray(exponential[states:, states:].T)
        noise = transition @ exponential[:states, states:]
        for _ in range(doublings):
            noise = transition @ noise @ transition.T + noise
            transition = transition @ transition
        return transition, (noise + noise.T) / 2

    def simulate(self, count: int, interval: float, rng: np.random.Generator) -> np.ndarray:
        """Draw ``count`` samples, shape (count,): states at the sample times plus interval means of the white part."""
        white = np.sqrt(self.output_psd / interval) * rng.standard_normal(count)
        states = len(self.output)
        if not states:
            return white
        transition, covariance = self.discretise(interval)
        start = _root(self.initial_covariance) @ rng.standard_normal(states)
        noise = rng.standard_normal((count, states)) @ _root(covariance).T
        return white + _propagate(transition, self.output, start, noise)


def _root(covariance: np.ndarray) -> np.ndarray:
    """Return a matrix R with R R' = covariance, for a positive semidefinite matrix."""
    values, vectors = np.linalg.eigh(covariance)
    return vectors * np.sqrt(np.maximum(values, 0))


@njit(cache=True)
def _propagate(transition, output, start, noise):
    state = start.copy()
    result = np.empty(len(noise))
    for k in range(len(noise)):
        result[k] = output @ state
        state = transition @ state + noise[k]
    return result

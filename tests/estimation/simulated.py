"""Simulate sums of white noise, random walks and Gauss-Markov processes, and write down their covariance."""

import numpy as np
import pytest
from scipy.linalg import null_space, toeplitz

from imugap.effects import Conditions, GaussMarkov, RandomWalk, WhiteNoise
from imugap.effects.effect import AxisModel

INTERVAL = 0.1
MODELS = {
    "white": AxisModel((WhiteNoise(0.3),)),
    "white and walk": WhiteNoise(0.3) + RandomWalk(0.2),
    "gauss-markov": AxisModel((GaussMarkov(1.0, 0.7),)),
    "white and gauss-markov": WhiteNoise(0.3) + GaussMarkov(1.0, 2.0),
    "slow": WhiteNoise(0.3) + GaussMarkov(1.0, 1e4),
    "fast": WhiteNoise(0.3) + GaussMarkov(1.0, 0.02) + RandomWalk(0.05),
    "all": WhiteNoise(0.3) + RandomWalk(0.2) + GaussMarkov(1.0, 0.5) + GaussMarkov(0.5, 5.0) + GaussMarkov(2.0, 70.0),
}
models = pytest.mark.parametrize("model", MODELS.values(), ids=MODELS)
ramps = pytest.mark.parametrize("ramp", [False, True])


def simulate(model, count, *labels):
    return model.simulate(np.zeros(count), Conditions(np.arange(count) * INTERVAL, INTERVAL), 3, *labels)


def covariance(model, count):
    """The covariance of the samples, written down from the definition of each process."""
    total, steps = np.zeros((count, count)), np.arange(1, count + 1)
    for effect in model:
        match effect:
            case WhiteNoise(density):
                total += density**2 / INTERVAL * np.eye(count)
            case RandomWalk(density):
                total += density**2 * INTERVAL * np.minimum.outer(steps, steps)
            case GaussMarkov(std, time):
                total += std**2 * toeplitz(np.exp(-INTERVAL / time * np.arange(count)))
    return total


def contrasts(count, ramp):
    return null_space(np.vander(np.arange(count), 1 + ramp).T.astype(float))

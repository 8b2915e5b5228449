"""The setting of Liu, Ren and Li 2016 (montecarlo_settings.json): 3 h at 10 Hz, and the model with its parameters."""

import numpy as np
import pandas as pd

from imugap.effects import Conditions, GaussMarkov, RandomWalk, WhiteNoise

INTERVAL, COUNT = 0.1, 108_000


def model(time, walk=True):
    """Return the model with this correlation time [s], with or without its random walk."""
    effects = WhiteNoise(5e-3) + GaussMarkov(1 / 180, time)
    return effects + RandomWalk(1 / 21600) if walk else effects


def simulate(of, count, seed, *labels):
    return of.simulate(np.zeros(count), Conditions(np.arange(count) * INTERVAL, INTERVAL), seed, *labels)


def kinds(of):
    return tuple(map(type, of))


def truth(of):
    """Return the parameters of a model, by effect, ordinal and name, the density that drives its process included."""
    values = {(effect.name, 1, key): value for effect in of for key, value in effect.parameters().items()}
    markov = next(effect for effect in of if isinstance(effect, GaussMarkov))
    return pd.Series(values | {("gauss_markov", 1, "driving_psd"): markov.driving_psd})

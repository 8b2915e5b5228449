"""The catalogue of effects: one effect per file, one line here."""

from imugap.effects.bias import Bias
from imugap.effects.bias_instability import BiasInstability
from imugap.effects.effect import AdditiveEffect, AllanEffect, Conditions, Effect, Stage, StochasticEffect
from imugap.effects.gauss_markov import GaussMarkov
from imugap.effects.quantization import Quantization
from imugap.effects.random_walk import RandomWalk
from imugap.effects.rate_ramp import RateRamp
from imugap.effects.resolution import Resolution
from imugap.effects.stability_restoration import StabilityRestoration
from imugap.effects.temperature import Temperature
from imugap.effects.turn_on_bias import TurnOnBias
from imugap.effects.white_noise import WhiteNoise

CATALOGUE: dict[str, type[Effect]] = {
    effect.name: effect
    for effect in (
        Bias,
        BiasInstability,
        GaussMarkov,
        Quantization,
        RandomWalk,
        RateRamp,
        Resolution,
        StabilityRestoration,
        Temperature,
        TurnOnBias,
        WhiteNoise,
    )
}

__all__ = ["CATALOGUE", "AdditiveEffect", "AllanEffect", "Conditions", "Effect", "Stage", "StochasticEffect"]
__all__ += [effect.__name__ for effect in CATALOGUE.values()]

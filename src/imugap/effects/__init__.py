"""Catalogue of effects: one effect per file, one line here.

May import integrity, log, numerics, units and stream.
"""

from imugap.effects.band_noise import BandNoise
from imugap.effects.bias import Bias
from imugap.effects.bias_instability import BiasInstability
from imugap.effects.bias_step import BiasStep
from imugap.effects.chirp import Chirp
from imugap.effects.clock_scale import ClockScale
from imugap.effects.comb import Comb
from imugap.effects.common_mode import CommonMode
from imugap.effects.dead_zone import DeadZone
from imugap.effects.echo import Echo
from imugap.effects.effect import AdditiveEffect, AllanEffect, ClockEffect, Conditions, Effect, Stage, StochasticEffect
from imugap.effects.g_sensitivity import GSensitivity
from imugap.effects.gauss_markov import GaussMarkov
from imugap.effects.held_samples import HeldSamples
from imugap.effects.lever_arm import LeverArm
from imugap.effects.misalignment import Misalignment
from imugap.effects.noise_distribution import NoiseDistribution
from imugap.effects.outliers import Outliers
from imugap.effects.output_filter import OutputFilter
from imugap.effects.power_law import PowerLaw
from imugap.effects.quantization import Quantization
from imugap.effects.random_telegraph import RandomTelegraph
from imugap.effects.random_walk import RandomWalk
from imugap.effects.rate_ramp import RateRamp
from imugap.effects.resolution import Resolution
from imugap.effects.sample_loss import SampleLoss
from imugap.effects.saturation import Saturation
from imugap.effects.scale_factor import ScaleFactor
from imugap.effects.sinusoid import Sinusoid
from imugap.effects.skewed_noise import SkewedNoise
from imugap.effects.stability_restoration import StabilityRestoration
from imugap.effects.stance_motion import StanceMotion
from imugap.effects.stuck_samples import StuckSamples
from imugap.effects.temperature import Temperature
from imugap.effects.time_offset import TimeOffset
from imugap.effects.timestamp_jitter import TimestampJitter
from imugap.effects.torn_words import TornWords
from imugap.effects.turn_on_bias import TurnOnBias
from imugap.effects.uniform_noise import UniformNoise
from imugap.effects.variance_change import VarianceChange
from imugap.effects.vibration_rectification import VibrationRectification
from imugap.effects.warm_up import WarmUp
from imugap.effects.white_noise import WhiteNoise

CATALOGUE: dict[str, type[Effect]] = {
    kind.name: kind
    for kind in list(globals().values())
    if isinstance(kind, type) and issubclass(kind, Effect) and "name" in vars(kind)
}
"""Kinds of effects by name: all that are imported here."""


def title_of(name: str) -> str:
    """Return the name of an effect in words, of the catalogue or not."""
    return (CATALOGUE[name].title if name in CATALOGUE else "") or name.replace("_", " ")

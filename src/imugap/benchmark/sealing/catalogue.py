"""Everything that can be hidden: the names of the controlled vocabulary, and what is in no vocabulary."""

from imugap.benchmark.sealing import additive, output
from imugap.benchmark.sealing.hidden_effect import Kind
from imugap.benchmark.sealing.inertial import INERTIAL
from imugap.benchmark.sealing.unnamed import UNKNOWN

NAMED: dict[str, type[Kind]] = {
    kind.name: kind
    for kind in (
        additive.WhiteNoise,
        additive.BiasInstability,
        additive.RandomWalk,
        additive.Quantization,
        additive.RateRamp,
        additive.GaussMarkov,
        additive.Sinusoid,
        additive.RandomTelegraph,
        additive.Outliers,
        additive.BiasStep,
        additive.WarmUp,
        additive.Temperature,
        output.VarianceChange,
        additive.CommonMode,
        output.Resolution,
        output.OutputFilter,
        output.StuckSamples,
        output.SampleLoss,
        output.TimestampJitter,
        additive.TurnOnBias,
        output.ClockScale,
        output.Saturation,
        *INERTIAL,
    )
}
UNNAMED: dict[str, type[Kind]] = {kind.name: kind for kind in UNKNOWN}
EVERY = NAMED | UNNAMED
